//! Quantities over time, one panel each.

use std::sync::Arc;

use kuva::prelude::{Figure, Layout, LinePlot, Plot, ScatterPlot, TickFormat};

use super::{GREY, SIZE, layout, shortened, styled};

/// Panels side by side.
const COLUMNS: usize = 2;
/// Height of a row of panels [px].
const ROW: f64 = 260.0;
/// A quantity that stays below this is zero up to rounding, whose digits are not worth an axis.
const ROUNDING: f64 = 1e-12;
/// Values that differ by less than this share of their size are one value up to rounding.
const SAME: f64 = 1e-9;
/// Values that differ by less than this share have digits in common that would fill the axis.
const SHARED: f64 = 1e-3;
/// Half the height of an axis around one value, as a share of it; the same around zero.
const AROUND: f64 = 0.1;
/// Sizes of values that are written without a power of ten.
const PLAIN: (f64, f64) = (1e-2, 1e5);
/// Most characters of a title and of a label.
const LONGEST_TITLE: usize = 46;
const LONGEST_LABEL: usize = 24;

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

/// How the values of a panel are drawn.
struct Scale {
    /// What is taken off every value: the digits that all of them share.
    offset: f64,
    /// The one value of all, up to rounding.
    flat: Option<f64>,
    /// The largest magnitude that is drawn.
    size: f64,
}

impl Scale {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let values = values.filter(|value| value.is_finite());
        let least = values.clone().fold(f64::INFINITY, f64::min);
        let most = values.fold(f64::NEG_INFINITY, f64::max);
        let size = least.abs().max(most.abs());
        let span = most - least;
        // Without values, or without a difference of two of them that is a number, there is nothing to scale.
        if !(span.is_finite() && size >= ROUNDING) {
            let flat = (least > most || size < ROUNDING).then_some(0.0);
            return Self {
                offset: 0.0,
                flat,
                size: if flat.is_some() { 0.0 } else { size },
            };
        }
        if span <= SAME * size {
            return Self {
                offset: 0.0,
                flat: Some(least),
                size,
            };
        }
        let offset = if span < SHARED * size { least } else { 0.0 };
        Self {
            offset,
            flat: None,
            size: if offset == 0.0 { size } else { span },
        }
    }

    fn shown(&self, value: f64) -> f64 {
        self.flat.unwrap_or(value - self.offset)
    }

    /// The label of the axis, from which the offset is taken off.
    fn label(&self, label: &str) -> String {
        let label = shortened(label, LONGEST_LABEL);
        if self.offset == 0.0 {
            return label;
        }
        let (name, unit) = label.split_once(" [").unwrap_or((&label, ""));
        let sign = if self.offset < 0.0 { '+' } else { '-' };
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" [{unit}")
        };
        format!("{name} {sign} {}{unit}", self.offset.abs())
    }

    /// The axis: around a constant, and with powers of ten for what is large or small.
    fn axis(&self, mut layout: Layout) -> Layout {
        layout = match self.flat {
            None => layout,
            Some(value) => {
                let around = if value == 0.0 {
                    AROUND
                } else {
                    AROUND * value.abs()
                };
                // The space for numbers is that of this range.
                layout.y_range = (value - around, value + around);
                layout
                    .with_y_axis_min(value - around)
                    .with_y_axis_max(value + around)
            }
        };
        if self.size == 0.0 || (PLAIN.0..PLAIN.1).contains(&self.size) {
            return layout;
        }
        let power = |value: f64| {
            if value == 0.0 {
                return "0".to_owned();
            }
            let text = format!("{value:.3e}");
            let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
            let digits = digits.trim_end_matches('0').trim_end_matches('.');
            format!("{digits}e{power}")
        };
        layout.with_y_tick_format(TickFormat::Custom(Arc::new(power)))
    }
}

impl Panel {
    fn scale(&self) -> Scale {
        let points = self.series.iter();
        let points = points.flat_map(|s| s.line.iter().chain(&s.dots));
        let values = points.map(|point| point.1);
        Scale::of(values.chain(self.bounds.iter().copied()))
    }

    fn plots(&self, scale: &Scale) -> Vec<Plot> {
        let mut plots: Vec<Plot> = Vec::new();
        let shown = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().map(|&(t, v)| (t, scale.shown(v))).collect()
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
            let line = LinePlot::new().with_data(shown(&[(from, bound), (to, bound)]));
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
    let scales: Vec<Scale> = panels.iter().map(Panel::scale).collect();
    let scaled = || panels.iter().zip(&scales);
    let plots: Vec<Vec<Plot>> = scaled().map(|(panel, scale)| panel.plots(scale)).collect();
    let layouts = scaled().zip(&plots).map(|((panel, scale), plots)| {
        let title = shortened(&panel.title, LONGEST_TITLE);
        scale
            .axis(layout(plots, &title, "t [s]", &scale.label(&panel.label)))
            .with_title_size(14)
    });
    let mut figure = Figure::new(rows, COLUMNS)
        .with_title(shortened(title, 2 * LONGEST_TITLE))
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

    /// A figure of one panel with this line.
    fn drawn(label: &str, value: impl Fn(f64) -> f64) -> String {
        let line = (0..5).map(|k| (f64::from(k), value(f64::from(k))));
        let series = Series {
            name: None,
            colour: "blue",
            dashed: false,
            line: line.collect(),
            dots: Vec::new(),
        };
        let panel = Panel {
            title: label.to_owned(),
            label: label.to_owned(),
            series: vec![series],
            bounds: Vec::new(),
        };
        over_time("", &[panel])
    }

    #[test]
    fn axes_of_constants_and_of_common_digits_show_few_digits() {
        let flat = drawn("force [N]", |_| 123_456_789.123);
        assert!(
            flat.contains(">1.2e8<") && flat.contains(">1.3e8<"),
            "{flat}"
        );
        let huge = drawn("force [N]", |_| 1e300);
        assert!(huge.contains(">1e300<"), "{huge}");
        let common = drawn("s [m]", |t| 1e6 + 1e-2 * t);
        assert!(
            common.contains(">s - 1000000 [m]<") && common.contains(">0.03<"),
            "{common}"
        );
        let noise = drawn("s [m]", |t| 1e6 + 1e-10 * t);
        assert!(
            noise.contains(">1e6<") && noise.contains(">s [m]<"),
            "{noise}"
        );
    }

    #[test]
    fn long_names_lose_their_middle_and_keep_their_units() {
        let name = format!("{} [m/s^2]", "a_long_name_".repeat(20));
        let figure = drawn(&name, |t| t);
        assert!(
            figure.contains("a_long_name_a_l\u{2026} [m/s^2]<"),
            "{figure}"
        );
        assert!(!figure.contains(&"a_long_name_".repeat(5)));
        assert!(drawn("v [m/s^2]", f64::sin).contains(">v [m/s^2]<"));
    }

    #[test]
    fn rounding_errors_around_zero_are_drawn_as_zero() {
        let figure = |size: f64| {
            // Clip paths are numbered through all figures of a program.
            let text = drawn("s [m]", |t| size * (t % 2.0));
            let (head, rest) = text.split_once("kuva-clip-").unwrap();
            let (id, _) = rest.split_once('"').unwrap();
            head.to_owned() + &rest.replace(&format!("kuva-clip-{id}"), "")[id.len()..]
        };
        assert_eq!(figure(1e-31), figure(0.0));
        assert_ne!(figure(1e-9), figure(0.0));
    }
}
