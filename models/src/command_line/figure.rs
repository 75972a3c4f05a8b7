//! Figures as SVG, readable on light and on dark pages.

use std::sync::Arc;

use hangtime_models::{GroundLine, PublishedMarker};
use kuva::prelude::{
    Layout, LegendPosition, LinePlot, LineStyle, MarkerShape, Plot, ScatterPlot, Theme, TickFormat,
    render_to_svg,
};

/// Colours with enough contrast on white and on near-black.
pub(crate) const COLOURS: [&str; 9] = [
    "#2f7ed8", "#d9601a", "#2a9d5c", "#9a63d8", "#d6409f", "#0e9aa7", "#a67c2d", "#7c8594",
    "#c2483d",
];
/// Ground and reference lines.
const GREY: &str = "#8a919e";
/// Width and height of a figure [px].
const SIZE: (f64, f64) = (900.0, 520.0);

/// Colours of text and page for a figure that is opened by itself or shown on a page.
const STYLE: &str = "<style>svg{color:#1f2430;background:#ffffff}\
    @media (prefers-color-scheme:dark){svg{color:#dfe3ea;background:#14171c}}</style>";

fn theme() -> Theme {
    let text = || "currentColor".to_owned();
    Theme {
        background: "none".into(),
        axis_color: text(),
        tick_color: text(),
        text_color: text(),
        grid_color: "#8a919e44".into(),
        legend_bg: "none".into(),
        legend_border: "none".into(),
        ..Theme::light()
    }
}

fn layout(plots: &[Plot], title: &str, x: &str, y: &str) -> Layout {
    Layout::auto_from_plots(plots)
        .with_theme(theme())
        .with_width(SIZE.0)
        .with_height(SIZE.1)
        .with_title(title)
        .with_x_label(x)
        .with_y_label(y)
}

/// The drawing with a view box, so that it scales, and with colours that follow the page.
fn svg(plots: Vec<Plot>, layout: Layout) -> String {
    let drawing = render_to_svg(plots, layout);
    let length = |name: &str| {
        let rest = drawing.split_once(name)?.1;
        rest.split_once('"').map(|(length, _)| length.to_owned())
    };
    let view = match (length(" width=\""), length(" height=\"")) {
        (Some(width), Some(height)) => format!(" viewBox=\"0 0 {width} {height}\""),
        _ => String::new(),
    };
    drawing.replacen('>', &format!("{view}>{STYLE}"), 1)
}

/// What a picture of a motion in a plane shows.
pub(crate) struct Motion {
    /// Title of the figure.
    pub(crate) title: String,
    /// Labels of the axes.
    pub(crate) axes: [&'static str; 2],
    /// Surfaces.
    pub(crate) ground: Vec<GroundLine>,
    /// Path of each body.
    pub(crate) paths: Vec<Path>,
    /// Where the motion starts, a point for each body.
    pub(crate) start: Vec<[f64; 2]>,
    /// Impacts, a point for each.
    pub(crate) impacts: Vec<[f64; 2]>,
    /// Published positions at the time-lapse instants.
    pub(crate) published: Vec<PublishedMarker>,
    /// Time between two time-lapse positions [s].
    pub(crate) interval: f64,
}

/// The path of one body.
pub(crate) struct Path {
    /// Name of the body.
    pub(crate) name: &'static str,
    /// The path.
    pub(crate) points: Vec<[f64; 2]>,
    /// Positions at the time-lapse instants.
    pub(crate) time_lapse: Vec<[f64; 2]>,
}

impl Motion {
    /// The picture, with equal scales on both axes.
    pub(crate) fn svg(&self) -> String {
        let points = |points: &[[f64; 2]]| points.iter().map(|&[y, z]| (y, z)).collect::<Vec<_>>();
        let marks = |positions: &[[f64; 2]], shape, colour: &str, size, legend: &str| -> Plot {
            ScatterPlot::new()
                .with_data(points(positions))
                .with_marker(shape)
                .with_color(colour)
                .with_size(size)
                .with_legend(legend)
                .into()
        };
        let mut plots: Vec<Plot> = Vec::new();
        for (ground, style) in self
            .ground
            .iter()
            .zip([LineStyle::Dashed, LineStyle::Dotted].into_iter().cycle())
        {
            plots.push(
                LinePlot::new()
                    .with_data(points(&ground.points))
                    .with_color(GREY)
                    .with_stroke_width(1.5)
                    .with_line_style(style)
                    .with_legend(ground.name)
                    .into(),
            );
        }
        for (path, colour) in self.paths.iter().zip(COLOURS) {
            plots.push(
                LinePlot::new()
                    .with_data(points(&path.points))
                    .with_color(colour)
                    .with_legend(path.name)
                    .into(),
            );
            let legend = format!("{} every {} s", path.name, self.interval);
            plots.push(marks(
                &path.time_lapse,
                MarkerShape::Circle,
                colour,
                3.5,
                &legend,
            ));
        }
        if !self.published.is_empty() {
            let positions: Vec<_> = self.published.iter().map(|m| m.position).collect();
            plots.push(marks(
                &positions,
                MarkerShape::Cross,
                COLOURS[1],
                5.0,
                "published",
            ));
        }
        plots.push(marks(
            &self.start,
            MarkerShape::Square,
            COLOURS[2],
            5.0,
            "start",
        ));
        if !self.impacts.is_empty() {
            plots.push(marks(
                &self.impacts,
                MarkerShape::Diamond,
                COLOURS[4],
                6.0,
                "impact",
            ));
        }
        let [(left, right), (bottom, top)] = self.frame();
        let layout = layout(&plots, &self.title, self.axes[0], self.axes[1])
            .with_equal_aspect()
            .with_clamp_axis()
            .with_x_axis_min(left)
            .with_x_axis_max(right)
            .with_y_axis_min(bottom)
            .with_y_axis_max(top)
            .with_legend_position(LegendPosition::InsideTopRight);
        svg(plots, layout)
    }
}

impl Motion {
    /// What the axes show: all that moves and some ground around it.
    fn frame(&self) -> [(f64, f64); 2] {
        /// Free space around the motion, as a share of its larger extent.
        const MARGIN: f64 = 0.06;
        let paths = self.paths.iter().flat_map(|path| &path.points);
        let published = self.published.iter().map(|marker| &marker.position);
        let mut frame = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for position in paths.chain(published) {
            for (range, x) in frame.iter_mut().zip(position) {
                *range = (range.0.min(*x), range.1.max(*x));
            }
        }
        let extent = frame
            .iter()
            .map(|range| range.1 - range.0)
            .fold(0.0, f64::max);
        let margin = if extent.is_finite() {
            MARGIN * extent
        } else {
            0.0
        };
        frame.map(|(from, to)| (from - margin, to + margin))
    }
}

/// One line of a chart with logarithmic axes.
pub(crate) struct Curve {
    /// Name in the legend.
    pub(crate) name: String,
    /// Index into the colours.
    pub(crate) colour: usize,
    /// Dashed instead of solid.
    pub(crate) dashed: bool,
    /// Points; those that are not positive are left out.
    pub(crate) points: Vec<(f64, f64)>,
}

/// A chart with logarithmic axes.
///
/// The logarithms of the errors are taken here: logarithmic axes of the drawing library stop at
/// 1e-10.
pub(crate) fn log_log(title: &str, x: &str, y: &str, curves: &[Curve]) -> String {
    let mut plots: Vec<Plot> = Vec::new();
    for curve in curves {
        let points: Vec<(f64, f64)> = curve
            .points
            .iter()
            .filter(|&&(x, y)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite())
            .map(|&(x, y)| (x, y.log10()))
            .collect();
        if points.is_empty() {
            continue;
        }
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let line = LinePlot::new()
            .with_data(points.clone())
            .with_color(colour)
            .with_legend(curve.name.as_str());
        plots.push(
            if curve.dashed {
                line.with_dashed()
            } else {
                line
            }
            .into(),
        );
        plots.push(
            ScatterPlot::new()
                .with_data(points)
                .with_color(colour)
                .with_size(2.5)
                .into(),
        );
    }
    let power = TickFormat::Custom(Arc::new(|exponent: f64| format!("1e{exponent:.0}")));
    let layout = layout(&plots, title, x, y)
        .with_log_x()
        .with_x_tick_format(TickFormat::Custom(Arc::new(|x: f64| {
            if x < 1e-2 {
                format!("{x:.0e}")
            } else {
                format!("{x}")
            }
        })))
        .with_y_tick_step(2.0)
        .with_y_tick_format(power)
        .with_legend_position(LegendPosition::OutsideRightTop);
    svg(plots, layout)
}
