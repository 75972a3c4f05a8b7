//! Quantities over time, one panel each.

use super::axis::Axis;
use super::{Area, GREY, LETTER, SIZE, drawing, line, mark, sample, shortened, stroke};

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
/// Free space above and below the values, as a share of their range.
const MARGIN: f64 = 0.06;
/// What stands beside a panel [px]: left, right, above, below; above all of them, and beside them for a legend.
const BESIDE: [f64; 4] = [76.0, 14.0, 30.0, 46.0];
const ABOVE: f64 = 40.0;
const LEGEND: f64 = 0.25 * SIZE.0;
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
    /// The least and the largest value that is drawn.
    range: [f64; 2],
}

impl Scale {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let values = values.filter(|value| value.is_finite());
        let least = values.clone().fold(f64::INFINITY, f64::min);
        let most = values.fold(f64::NEG_INFINITY, f64::max);
        let size = least.abs().max(most.abs());
        let span = most - least;
        let flat = match () {
            // No values, or rounding.
            () if least > most || size < ROUNDING => Some(0.0),
            () if span <= SAME * size => Some(least),
            () => None,
        };
        if let Some(value) = flat {
            let around = AROUND * if value == 0.0 { 1.0 } else { value.abs() };
            return Self {
                offset: 0.0,
                flat,
                range: [value - around, value + around],
            };
        }
        let offset = if span < SHARED * size { least } else { 0.0 };
        let margin = MARGIN * span;
        Self {
            offset,
            flat,
            range: [least - offset - margin, most - offset + margin],
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
}

impl Panel {
    /// Draws it into an area.
    fn draw(&self, svg: &mut String, area: &Area) {
        let lines = self
            .series
            .iter()
            .flat_map(|s| s.line.iter().chain(&s.dots));
        let values = lines.map(|point| point.1);
        let scale = Scale::of(values.chain(self.bounds.iter().copied()));
        let times = self
            .series
            .iter()
            .flat_map(|s| &s.line)
            .map(|point| point.0);
        let times = times.filter(|time| time.is_finite());
        let from = times.clone().fold(f64::INFINITY, f64::min);
        let to = times.fold(f64::NEG_INFINITY, f64::max);
        let span = if from < to { [from, to] } else { [0.0, 1.0] };
        let across = Axis::linear(span, (area.left, area.right));
        let up = Axis::linear(scale.range, (area.bottom, area.top));
        let title = crate::markup::escape(&shortened(&self.title, LONGEST_TITLE));
        let middle = f64::midpoint(area.left, area.right);
        *svg += &format!(
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{title}</text>",
            area.top - 10.0
        );
        area.frame(svg, [&across, &up], ["t [s]", &scale.label(&self.label)]);
        let place =
            |&(time, value): &(f64, f64)| [across.place(time), up.place(scale.shown(value))];
        for &bound in self.bounds.iter().filter(|_| from < to) {
            let ends = span.map(|time| place(&(time, bound)));
            line(svg, ends.into_iter(), &stroke(GREY, 1.0, "6 4"));
        }
        for series in &self.series {
            line(svg, series.line.iter().map(place), &series.style());
            for dot in &series.dots {
                *svg += &mark(place(dot), 0, series.colour, 0.44);
            }
        }
    }
}

impl Series {
    fn style(&self) -> String {
        stroke(self.colour, 1.6, if self.dashed { "6 4" } else { "" })
    }
}

/// All panels in one figure.
pub(crate) fn over_time(title: &str, panels: &[Panel]) -> String {
    let [left, right, above, below] = BESIDE;
    let width = SIZE.0 / COLUMNS as f64;
    let mut svg = String::new();
    let mut legend: Vec<(String, String)> = Vec::new();
    for (index, panel) in panels.iter().enumerate() {
        let (row, column) = (index / COLUMNS, index % COLUMNS);
        let (x, y) = (width * column as f64, ABOVE + ROW * row as f64);
        panel.draw(
            &mut svg,
            &Area {
                left: x + left,
                right: x + width - right,
                top: y + above,
                bottom: y + ROW - below,
                letter: LETTER,
                side: x + LETTER,
            },
        );
        for series in &panel.series {
            if let Some(name) = &series.name
                && !legend.iter().any(|(_, known)| known == name)
            {
                legend.push((sample(&series.style()), name.clone()));
            }
        }
    }
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let all = Area {
        left: 0.0,
        right: SIZE.0,
        top: ABOVE,
        bottom: 0.0,
        letter: LETTER,
        side: 0.0,
    };
    all.legend(&mut svg, &legend);
    let beside = if legend.is_empty() { 0.0 } else { LEGEND };
    let size = (SIZE.0 + beside, ABOVE + ROW * rows as f64);
    drawing(size, &shortened(title, 2 * LONGEST_TITLE), &svg)
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
        let figure = |size: f64| drawn("s [m]", |t| size * (t % 2.0));
        assert_eq!(figure(1e-31), figure(0.0));
        assert_ne!(figure(1e-9), figure(0.0));
    }
}
