//! Figures as SVG, readable on light and on dark pages: axes, lines, marks and legends of all of them are drawn here.

mod axis;
mod colours;
mod log_log;
mod plane;
mod time;

use std::fmt::Write as _;

use axis::Axis;
use colours::GREY;
pub(crate) use colours::{COLOURS, Look};
pub(crate) use log_log::{Curve, Dot, LogLog};
pub(crate) use plane::{Motion, Path};
pub(crate) use time::{Panel, Series, over_time};

use crate::markup::escape;

/// Width and height of a figure [px].
const SIZE: (f64, f64) = (900.0, 520.0);
/// Height of letters, and of those of a title [px].
const LETTER: f64 = 13.0;
const TITLE: f64 = 17.0;
/// Distance of the lines of a legend [px].
const LEGEND: f64 = 20.0;

/// Colours of text and page for a figure that is opened by itself or shown on a page.
const STYLE: &str = "<style>svg{color:#1f2430;background:#ffffff}\
    svg .grid{stroke:#8a919e;stroke-opacity:.35;fill:none}svg .axis{stroke:currentColor;fill:none}\
    @media (prefers-color-scheme:dark){svg{color:#dfe3ea;background:#14171c}}</style>";

/// Outlines of marks: disc, square, triangle, diamond and others.
const MARKS: [&str; 12] = [
    "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0z",
    "M-5-5H5V5H-5z",
    "M0-6L6 5H-6z",
    "M0-7L7 0L0 7L-7 0z",
    "M0 6L6-5H-6z",
    "M-6-2H-2V-6H2V-2H6V2H2V6H-2V2H-6z",
    "M-3-6H3L6 0L3 6H-3L-6 0z",
    "M-6 0L5-6V6z",
    "M6 0L-5-6V6z",
    "M0-7L2-2L7 0L2 2L0 7L-2 2L-7 0L-2-2z",
    "M-7-3H7V3H-7z",
    "M-3-7H3V7H-3z",
];

/// Where a plot is on a drawing [px].
#[derive(Debug, Clone, Copy)]
struct Area {
    /// Its edges.
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    /// Height of its letters.
    letter: f64,
    /// Where the label of the vertical axis stands.
    side: f64,
}

impl Area {
    /// Grid, numbers and labels of both axes.
    fn frame(&self, svg: &mut String, [across, up]: [&Axis; 2], [x, y]: [&str; 2]) {
        let Self {
            left,
            right,
            top,
            bottom,
            letter,
            side,
        } = *self;
        for (x, label) in across.labels() {
            let below = bottom + 1.4 * letter;
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{x:.1} {top}V{bottom}\"/>\
                 <text x=\"{x:.1}\" y=\"{below}\" text-anchor=\"middle\">{label}</text>"
            );
        }
        for (y, label) in up.labels() {
            let (beside, base) = (left - 8.0, y + 0.35 * letter);
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{left} {y:.1}H{right}\"/>\
                 <text x=\"{beside}\" y=\"{base:.1}\" text-anchor=\"end\">{label}</text>"
            );
        }
        let [middle, height] = [f64::midpoint(left, right), f64::midpoint(top, bottom)];
        let _ = write!(
            svg,
            "<path class=\"axis\" d=\"M{left} {top}V{bottom}H{right}\"/>\
             <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate({side} {height}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            bottom + 3.0 * letter,
            escape(x),
            escape(y)
        );
    }

    /// The names of lines and marks beside it, each behind a piece of what it names.
    fn legend(&self, svg: &mut String, entries: &[(String, String)]) {
        for (row, (sample, name)) in entries.iter().enumerate() {
            let y = self.top + LEGEND * (row as f64 + 0.5);
            let _ = write!(
                svg,
                "<g transform=\"translate({} {y})\">{sample}<text x=\"34\" y=\"{}\">{}</text></g>",
                self.right + 16.0,
                0.35 * self.letter,
                escape(name)
            );
        }
    }
}

/// A drawing with what is inside, which has a title.
fn drawing((width, height): (f64, f64), title: &str, inside: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height:.0}\" viewBox=\"0 0 {width} {height:.0}\" \
         font-family=\"system-ui,sans-serif\" font-size=\"{LETTER}\" fill=\"currentColor\">{STYLE}\
         <text x=\"{}\" y=\"{}\" font-size=\"{TITLE}\" text-anchor=\"middle\">{}</text>{inside}</svg>",
        0.5 * width,
        1.4 * TITLE,
        escape(title)
    )
}

/// A line through the points that are numbers.
pub(crate) fn line(svg: &mut String, points: impl Iterator<Item = [f64; 2]>, style: &str) {
    let finite = points.filter(|[x, y]| x.is_finite() && y.is_finite());
    let mut path = String::new();
    for [x, y] in finite {
        let pen = if path.is_empty() { 'M' } else { 'L' };
        // Writing to a string cannot fail.
        let _ = write!(path, "{pen}{x:.1} {y:.1}");
    }
    if path.contains('L') {
        let _ = writeln!(svg, "<path d=\"{path}\" {style}/>");
    }
}

/// The style of a line of a colour and a width, with dashes where there are any.
fn stroke(colour: &str, width: f64, dashes: &str) -> String {
    let dashes = match dashes {
        "" => String::new(),
        dashes => format!(" stroke-dasharray=\"{dashes}\""),
    };
    format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dashes}")
}

/// A mark of a colour at a place, so many times as large as its outline.
fn mark([x, y]: [f64; 2], which: usize, colour: &str, size: f64) -> String {
    if !(x.is_finite() && y.is_finite()) {
        return String::new();
    }
    let outline = MARKS[which % MARKS.len()];
    format!(
        "<path fill=\"{colour}\" transform=\"translate({x:.1} {y:.1}) scale({size})\" d=\"{outline}\"/>"
    )
}

/// What a legend shows of a line.
fn sample(style: &str) -> String {
    format!("<path d=\"M0 0H28\" {style}/>")
}

/// A text without its middle, if it has more than `most` characters: names begin and units end it.
fn shortened(text: &str, most: usize) -> String {
    let length = text.chars().count();
    if length <= most {
        return text.to_owned();
    }
    let tail = most / 3;
    let start: String = text.chars().take(most - tail - 1).collect();
    let end: String = text.chars().skip(length - tail).collect();
    format!("{start}\u{2026}{end}")
}
