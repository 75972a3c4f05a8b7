//! Pictures of a motion in a plane.

use crate::PublishedPoint;
use crate::drawing::GroundLine;
use kuva::prelude::{LegendPosition, LinePlot, LineStyle, MarkerShape, Plot, ScatterPlot};

use super::{COLOURS, GREY, SIZE, layout, shortened, svg};

/// Free space around the motion, as a share of its larger extent.
const MARGIN: f64 = 0.06;
/// What axes, labels, title and legend take of a figure's width and height [px].
const FRAME: (f64, f64) = (280.0, 110.0);
/// Least height of a figure [px], for the legend beside it.
const LEAST_HEIGHT: f64 = 280.0;
/// Most characters of a name, and of the title above a picture that may be narrow.
const LONGEST_NAME: usize = 24;
const LONGEST_TITLE: usize = 40;
/// Colours of published positions, of the start and of impacts.
const PUBLISHED: &str = COLOURS[7];
const START: &str = COLOURS[2];
const IMPACT: &str = COLOURS[4];

/// What a picture of a motion in a plane shows.
pub(crate) struct Motion {
    /// Title of the figure.
    pub(crate) title: String,
    /// Labels of the axes.
    pub(crate) axes: [String; 2],
    /// Least and largest horizontal and vertical position that is seen.
    pub(crate) frame: [[f64; 2]; 2],
    /// Curves and surfaces.
    pub(crate) ground: Vec<GroundLine>,
    /// Path of each body.
    pub(crate) paths: Vec<Path>,
    /// Links and springs at the time-lapse instants.
    pub(crate) lines: Vec<Vec<[f64; 2]>>,
    /// Where the motion starts, a point for each body.
    pub(crate) start: Vec<[f64; 2]>,
    /// Impacts, a point for each.
    pub(crate) impacts: Vec<[f64; 2]>,
    /// Published positions.
    pub(crate) published: Vec<PublishedPoint>,
    /// What the legend says about the instants of the time lapse.
    pub(crate) lapse: String,
}

/// The path of one body.
pub(crate) struct Path {
    /// Name of the body.
    pub(crate) name: &'static str,
    /// The path.
    pub(crate) points: Vec<[f64; 2]>,
    /// Positions at the time-lapse instants.
    pub(crate) time_lapse: Vec<[f64; 2]>,
    /// Outlines at these instants, closed; none of a point.
    pub(crate) outlines: Vec<Vec<[f64; 2]>>,
}

/// The points that can be drawn.
fn pairs(points: &[[f64; 2]]) -> Vec<(f64, f64)> {
    let points = points
        .iter()
        .filter(|[y, z]| y.is_finite() && z.is_finite());
    points.map(|&[y, z]| (y, z)).collect()
}

fn marks(positions: &[[f64; 2]], shape: MarkerShape, colour: &str, size: f64) -> ScatterPlot {
    ScatterPlot::new()
        .with_data(pairs(positions))
        .with_marker(shape)
        .with_color(colour)
        .with_size(size)
}

fn line(points: &[[f64; 2]], colour: &str, width: f64) -> LinePlot {
    LinePlot::new()
        .with_data(pairs(points))
        .with_color(colour)
        .with_stroke_width(width)
}

impl Motion {
    /// The picture, with equal scales on both axes.
    pub(crate) fn svg(&self) -> String {
        let mut plots: Vec<Plot> = Vec::new();
        let mut named: Vec<&str> = Vec::new();
        for ground in &self.ground {
            let known = named.iter().position(|name| *name == ground.name);
            let index = known.unwrap_or(named.len());
            let style = match index % 2 {
                0 => LineStyle::Dashed,
                _ => LineStyle::Dotted,
            };
            let mut line = line(&ground.points, GREY, 1.5).with_line_style(style);
            if known.is_none() {
                named.push(ground.name);
                line = line.with_legend(shortened(ground.name, LONGEST_NAME));
            }
            plots.push(line.into());
        }
        for points in &self.lines {
            plots.push(line(points, GREY, 1.2).into());
        }
        for (path, colour) in self.paths.iter().zip(COLOURS.iter().cycle()) {
            let name = shortened(path.name, LONGEST_NAME);
            let whole = line(&path.points, colour, 2.0).with_legend(name.as_str());
            plots.push(whole.into());
            for outline in &path.outlines {
                plots.push(line(outline, colour, 1.2).into());
            }
            let legend = name + &self.lapse;
            let lapse = marks(&path.time_lapse, MarkerShape::Circle, colour, 3.5);
            plots.push(lapse.with_legend(legend).into());
        }
        plots.extend(self.published_marks());
        let start = marks(&self.start, MarkerShape::Square, START, 4.5);
        plots.push(start.with_legend("start").into());
        if !self.impacts.is_empty() {
            let impacts = marks(&self.impacts, MarkerShape::Diamond, IMPACT, 5.0);
            plots.push(impacts.with_legend("impact").into());
        }
        let [[left, right], [bottom, top]] = self.frame;
        let aspect = (top - bottom) / (right - left);
        let height = FRAME.1 + (SIZE.0 - FRAME.0) * aspect;
        let title = shortened(&self.title, LONGEST_TITLE);
        let [across, up] = [0, 1].map(|i| shortened(&self.axes[i], LONGEST_NAME));
        let layout = layout(&plots, &title, &across, &up)
            .with_height(height.clamp(LEAST_HEIGHT, SIZE.1))
            .with_equal_aspect()
            .with_clamp_axis()
            .with_x_axis_min(left)
            .with_x_axis_max(right)
            .with_y_axis_min(bottom)
            .with_y_axis_max(top)
            .with_legend_position(LegendPosition::OutsideRightTop);
        svg(plots, layout)
    }

    /// Crosses where the time lapse was published, dots along the published path.
    fn published_marks(&self) -> Vec<Plot> {
        let of = |time_lapse: bool| -> Vec<[f64; 2]> {
            let points = self.published.iter();
            let kept = points.filter(|point| point.time_lapse == time_lapse);
            kept.flat_map(|point| point.positions.iter().copied())
                .collect()
        };
        let (lapse, path) = (of(true), of(false));
        let mut plots: Vec<Plot> = Vec::new();
        if !path.is_empty() {
            let dots = marks(&path, MarkerShape::Circle, PUBLISHED, 1.8);
            plots.push(dots.with_legend("published path").into());
        }
        if !lapse.is_empty() {
            let crosses = marks(&lapse, MarkerShape::Cross, PUBLISHED, 5.0);
            plots.push(crosses.with_legend("published time lapse").into());
        }
        plots
    }
}

/// What the axes show: all these points and a margin around them.
pub(crate) fn frame<'p>(points: impl Iterator<Item = &'p [f64; 2]>) -> [[f64; 2]; 2] {
    let mut frame = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for position in points {
        for (range, x) in frame.iter_mut().zip(position) {
            if x.is_finite() {
                *range = [range[0].min(*x), range[1].max(*x)];
            }
        }
    }
    let extents = frame.iter().map(|range| range[1] - range[0]);
    let extent = extents.fold(0.0, f64::max);
    // Nothing moved, or nothing is known: a frame that can be drawn all the same.
    let margin = if extent.is_finite() && extent > 0.0 {
        MARGIN * extent
    } else {
        1.0
    };
    frame.map(|[from, to]| {
        if from <= to {
            [from - margin, to + margin]
        } else {
            [-margin, margin]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{Motion, Path, frame};

    #[test]
    fn picture_of_any_numbers_is_drawn() {
        let extremes = [
            0.0,
            5e-324,
            1e17,
            f64::MAX,
            -f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ];
        for a in extremes {
            for b in extremes {
                let motion = Motion {
                    title: String::new(),
                    axes: ["y [m]", "z [m]"].map(str::to_owned),
                    frame: frame([[a, 1.0], [b, a], [1.0, b]].iter()),
                    ground: Vec::new(),
                    paths: vec![Path {
                        name: "mass",
                        points: vec![[a, 1.0], [b, a], [1.0, b]],
                        time_lapse: vec![[a, b]],
                        outlines: vec![vec![[a, b], [b, b], [a, a]]],
                    }],
                    lines: vec![vec![[a, b], [b, a]]],
                    start: vec![[a, b]],
                    impacts: vec![[b, a]],
                    published: Vec::new(),
                    lapse: String::new(),
                };
                let svg = motion.svg();
                assert!(svg.starts_with("<svg") && svg.len() < 1_000_000, "{a} {b}");
            }
        }
        let empty = Motion {
            title: String::new(),
            axes: [String::new(), String::new()],
            frame: frame([].iter()),
            ground: Vec::new(),
            paths: Vec::new(),
            lines: Vec::new(),
            start: Vec::new(),
            impacts: Vec::new(),
            published: Vec::new(),
            lapse: String::new(),
        };
        assert!(empty.svg().starts_with("<svg"));
    }
}
