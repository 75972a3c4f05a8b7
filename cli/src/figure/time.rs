//! Quantities over time, one panel each.

use kuva::prelude::{Figure, LinePlot, Plot, ScatterPlot};

use super::{GREY, SIZE, layout, styled};

/// Panels side by side.
const COLUMNS: usize = 2;
/// Height of a row of panels [px].
const ROW: f64 = 260.0;
/// A quantity that stays below this is zero up to rounding, whose digits are not worth an axis.
const ROUNDING: f64 = 1e-12;

/// One panel: a quantity over time.
pub(crate) struct Panel {
    /// What it is, in words.
    pub(crate) title: String,
    /// Label of the vertical axis, with unit.
    pub(crate) label: String,
    /// Its lines and dots.
    pub(crate) series: Vec<Series>,
    /// Bounds of the quantity.
    pub(crate) bounds: Vec<f64>,
}

/// A computed line and the published dots that belong to it.
pub(crate) struct Series {
    /// Name in the legend, if it needs one.
    pub(crate) name: Option<String>,
    /// Colour.
    pub(crate) colour: &'static str,
    /// Dashed instead of solid.
    pub(crate) dashed: bool,
    /// The line, as (time, value).
    pub(crate) line: Vec<(f64, f64)>,
    /// The dots, as (time, value).
    pub(crate) dots: Vec<(f64, f64)>,
}

impl Panel {
    fn plots(&self) -> Vec<Plot> {
        let mut plots: Vec<Plot> = Vec::new();
        let mut points = self
            .series
            .iter()
            .flat_map(|s| s.line.iter().chain(&s.dots));
        let is_zero = points.all(|point| point.1.abs() < ROUNDING);
        let shown = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let value = |value: f64| if is_zero { 0.0 } else { value };
            points.iter().map(|&(t, v)| (t, value(v))).collect()
        };
        let times = || {
            self.series
                .iter()
                .flat_map(|s| &s.line)
                .map(|point| point.0)
        };
        let (from, to) = (
            times().fold(f64::INFINITY, f64::min),
            times().fold(f64::NEG_INFINITY, f64::max),
        );
        for &bound in self.bounds.iter().filter(|_| from < to) {
            let line = LinePlot::new().with_data([(from, bound), (to, bound)]);
            plots.push(line.with_color(GREY).with_dashed().into());
        }
        for series in &self.series {
            let mut line = LinePlot::new()
                .with_data(shown(&series.line))
                .with_color(series.colour)
                .with_stroke_width(1.6);
            if series.dashed {
                line = line.with_dashed();
            }
            if let Some(name) = &series.name {
                line = line.with_legend(name.as_str());
            }
            plots.push(line.into());
            if !series.dots.is_empty() {
                let dots = ScatterPlot::new()
                    .with_data(shown(&series.dots))
                    .with_color(series.colour)
                    .with_marker_opacity(0.6)
                    .with_size(2.2);
                plots.push(dots.into());
            }
        }
        plots
    }
}

/// All panels in one figure.
pub(crate) fn over_time(title: &str, panels: &[Panel]) -> String {
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let plots: Vec<Vec<Plot>> = panels.iter().map(Panel::plots).collect();
    let layouts = panels.iter().zip(&plots).map(|(panel, plots)| {
        layout(plots, &panel.title, "t [s]", &panel.label).with_title_size(14)
    });
    let mut figure = Figure::new(rows, COLUMNS)
        .with_title(title)
        .with_title_size(17)
        .with_layouts(layouts.collect());
    let named = |series: &Series| series.name.is_some();
    let mut width = SIZE.0;
    if panels.iter().flat_map(|panel| &panel.series).any(named) {
        figure = figure.with_shared_legend_right_middle();
        width *= 1.25;
    }
    let figure = figure
        .with_plots(plots)
        .with_figure_size(width, ROW * rows as f64 + 40.0);
    styled(&kuva::backend::svg::SvgBackend::new().render_scene(&figure.render()))
}

#[cfg(test)]
mod tests {
    use super::{Panel, Series, over_time};

    #[test]
    fn rounding_errors_around_zero_are_drawn_as_zero() {
        let figure = |size: f64| {
            let line = (0..5).map(|k| (f64::from(k), size * f64::from(k % 2)));
            let series = Series {
                name: None,
                colour: "blue",
                dashed: false,
                line: line.collect(),
                dots: Vec::new(),
            };
            let panel = Panel {
                title: "gap".to_owned(),
                label: "s [m]".to_owned(),
                series: vec![series],
                bounds: Vec::new(),
            };
            // Clip paths are numbered through all figures of a program.
            let text = over_time("", &[panel]);
            let (head, rest) = text.split_once("kuva-clip-").unwrap();
            let (id, _) = rest.split_once('"').unwrap();
            head.to_owned() + &rest.replace(&format!("kuva-clip-{id}"), "")[id.len()..]
        };
        assert_eq!(figure(1e-31), figure(0.0));
        assert_ne!(figure(1e-9), figure(0.0));
    }
}
