//! Charts with logarithmic axes: lines that carry their names, in colours that stay apart for colour-blind eyes.

use std::fmt::Write as _;

use super::axis::{Axis, tick_label};
use crate::markup::escape;

/// Width and height of a chart [px]; text is drawn at 17 px of these.
const SIZE: (f64, f64) = (1100.0, 620.0);
/// Where the plot begins and ends.
const LEFT: f64 = 104.0;
const RIGHT: f64 = SIZE.0 - 350.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = SIZE.1 - 76.0;
/// Least distance of the names of two lines [px].
const LABEL_HEIGHT: f64 = 22.0;
/// Widths of the lines [px]: of the first one, how much thinner each is than the one before, and of the last ones.
const WIDEST: f64 = 5.6;
const THINNER: f64 = 0.8;
const THINNEST: f64 = 1.8;
/// Errors beyond this say nothing but that they are large.
const LARGEST: f64 = 1e3;

/// Colours on light and on dark pages: those of Okabe and Ito, moved apart until any two differ for normal and for
/// colour-blind eyes.
pub(super) const LINES: [(&str, &str); 7] = [
    ("#009bdc", "#4e7cff"),
    ("#e86b00", "#ec713b"),
    ("#007b42", "#06f99c"),
    ("#952788", "#c873c2"),
    ("#1f2430", "#ffdbf6"),
    ("#8a0000", "#b3f81b"),
    ("#8f9495", "#7d7b6c"),
];

/// A point of a line.
pub(crate) struct Dot {
    /// Where it is; what is not finite is left out, an error of zero stands at a line of its own, below the others.
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// What a pointer over it tells.
    pub(crate) note: String,
}

/// One line of a chart.
pub(crate) struct Curve {
    /// Its name, at the end of the line.
    pub(crate) name: String,
    /// Index into the colours.
    pub(crate) colour: usize,
    /// Dashed with open marks, instead of solid.
    pub(crate) dashed: bool,
    /// Its points, in the order in which they are joined.
    pub(crate) points: Vec<Dot>,
}

/// A chart with logarithmic axes.
pub(crate) struct LogLog<'a> {
    /// Title.
    pub(crate) title: &'a str,
    /// Labels of the axes.
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    /// Whether the horizontal axis runs from large to small, so that effort grows to the right.
    pub(crate) falling: bool,
    /// Errors below this say nothing, and why.
    pub(crate) floor: Option<(f64, &'a str)>,
    /// Its lines.
    pub(crate) curves: Vec<Curve>,
}

/// What is drawn of a line: its points on the chart.
struct Drawn<'a> {
    curve: &'a Curve,
    points: Vec<(f64, f64, &'a str)>,
}

impl LogLog<'_> {
    /// The drawing.
    pub(crate) fn svg(&self) -> String {
        let dots = || {
            let points = self.curves.iter().flat_map(|curve| &curve.points);
            points.filter(|dot| is_drawn(dot))
        };
        let ys = dots().map(|dot| dot.y).filter(|y| *y > 0.0);
        let floor = self.floor.map(|floor| floor.0).filter(|y| *y > 0.0);
        let across = Axis::around(dots().map(|dot| dot.x), (LEFT, RIGHT), self.falling);
        let zero = dots().any(|dot| dot.y == 0.0);
        let up = Axis::decades(ys.chain(floor), (BOTTOM, TOP), zero);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" role=\"img\" width=\"{}\" height=\"{}\" \
             viewBox=\"0 0 {} {}\" font-family=\"system-ui,sans-serif\" font-size=\"17\" fill=\"currentColor\">{}",
            SIZE.0,
            SIZE.1,
            SIZE.0,
            SIZE.1,
            style()
        );
        let _ = write!(
            svg,
            "<title>{}</title><text x=\"{LEFT}\" y=\"30\" font-size=\"21\" font-weight=\"600\">{}</text>",
            escape(self.title),
            escape(self.title)
        );
        if let (Some(across), Some(up)) = (across, up) {
            self.frame(&mut svg, &across, &up);
            self.lines(&mut svg, &across, &up);
        } else {
            let _ = write!(
                svg,
                "<text x=\"{LEFT}\" y=\"{TOP}\" dy=\"30\">Nothing was measured.</text>"
            );
        }
        svg + "</svg>"
    }

    /// Axes, grid, and the range of errors that say nothing.
    fn frame(&self, svg: &mut String, across: &Axis, up: &Axis) {
        if let Some((floor, why)) = self.floor {
            let y = up.place(floor).clamp(TOP, BOTTOM);
            let _ = write!(
                svg,
                "<rect class=\"shade\" x=\"{LEFT}\" y=\"{y:.1}\" width=\"{}\" height=\"{:.1}\"/>",
                RIGHT - LEFT,
                BOTTOM - y
            );
            if BOTTOM - y > 20.0 {
                let _ = write!(
                    svg,
                    "<text x=\"{}\" y=\"{:.1}\" font-size=\"15\">{}</text>",
                    LEFT + 8.0,
                    BOTTOM - 8.0,
                    escape(why)
                );
            }
        }
        for value in across.ticks() {
            let x = across.place(value);
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{x:.1} {TOP}V{BOTTOM}\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                BOTTOM + 24.0,
                tick_label(value)
            );
        }
        let labels = up
            .ticks()
            .into_iter()
            .map(|value| (value, tick_label(value)));
        let zero = up.zero.then(|| (0.0, "0".to_owned()));
        for (value, label) in labels.chain(zero) {
            let y = up.place(value);
            let _ = write!(
                svg,
                "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{RIGHT}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 10.0,
                y + 6.0,
                label
            );
        }
        let middle = f64::midpoint(TOP, BOTTOM);
        let _ = write!(
            svg,
            "<path class=\"axis\" d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\"/>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(24 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            f64::midpoint(LEFT, RIGHT),
            SIZE.1 - 20.0,
            escape(self.x),
            escape(self.y)
        );
    }

    /// Lines, marks and names. Earlier lines are wider, so that a later one on top of them hides nothing.
    fn lines(&self, svg: &mut String, across: &Axis, up: &Axis) {
        let drawn: Vec<Drawn<'_>> = self
            .curves
            .iter()
            .map(|curve| Drawn {
                curve,
                points: curve
                    .points
                    .iter()
                    .filter(|dot| is_drawn(dot))
                    .map(|dot| {
                        let y = up.place(dot.y.min(LARGEST)).clamp(TOP, BOTTOM);
                        (across.place(dot.x), y, dot.note.as_str())
                    })
                    .collect(),
            })
            .filter(|drawn| !drawn.points.is_empty())
            .collect();
        for (index, drawn) in drawn.iter().enumerate() {
            drawn.line(svg, (WIDEST - THINNER * index as f64).max(THINNEST));
        }
        for (place, drawn) in places(&drawn).into_iter().zip(&drawn) {
            drawn.name(svg, place);
        }
    }
}

fn is_drawn(dot: &Dot) -> bool {
    dot.x > 0.0 && dot.x.is_finite() && dot.y >= 0.0 && dot.y.is_finite()
}

/// Heights of the names: where the lines end, moved apart as far as they need.
fn places(drawn: &[Drawn<'_>]) -> Vec<f64> {
    let mut ends: Vec<(f64, usize)> = drawn
        .iter()
        .enumerate()
        .map(|(index, drawn)| (drawn.end().1, index))
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lowest = TOP + 4.0;
    for end in &mut ends {
        end.0 = end.0.max(lowest);
        lowest = end.0 + LABEL_HEIGHT;
    }
    let mut highest = BOTTOM;
    for end in ends.iter_mut().rev() {
        end.0 = end.0.min(highest);
        highest = end.0 - LABEL_HEIGHT;
    }
    let mut places = vec![0.0; drawn.len()];
    for (y, index) in ends {
        places[index] = y;
    }
    places
}

impl Drawn<'_> {
    /// The point where its name belongs: the rightmost one.
    fn end(&self) -> (f64, f64) {
        let points = self.points.iter().map(|&(x, y, _)| (x, y));
        points
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((RIGHT, BOTTOM))
    }

    fn line(&self, svg: &mut String, width: f64) {
        let colour = self.curve.colour % LINES.len();
        let path: Vec<String> = self
            .points
            .iter()
            .map(|(x, y, _)| format!("{x:.1} {y:.1}"))
            .collect();
        let dashes = if self.curve.dashed {
            " stroke-dasharray=\"9 6\""
        } else {
            ""
        };
        let _ = write!(
            svg,
            "<g class=\"k{colour}\" stroke=\"currentColor\" stroke-width=\"{width:.1}\">\
             <path fill=\"none\" stroke-linejoin=\"round\"{dashes} d=\"M{}\"/>",
            path.join("L")
        );
        let fill = if self.curve.dashed {
            "class=\"open\""
        } else {
            "fill=\"currentColor\""
        };
        for (x, y, note) in &self.points {
            let _ = write!(
                svg,
                "<path {fill} stroke-width=\"1.6\" transform=\"translate({x:.1} {y:.1})\" d=\"{}\"><title>{}</title></path>",
                mark(colour),
                escape(note)
            );
        }
        svg.push_str("</g>");
    }

    fn name(&self, svg: &mut String, place: f64) {
        let (x, y) = self.end();
        let colour = self.curve.colour % LINES.len();
        let _ = write!(
            svg,
            "<path class=\"leader k{colour}\" d=\"M{:.1} {y:.1}L{} {place:.1}\"/>\
             <text class=\"k{colour}\" fill=\"currentColor\" x=\"{}\" y=\"{:.1}\">{}</text>",
            x + 7.0,
            RIGHT + 18.0,
            RIGHT + 22.0,
            place + 6.0,
            escape(&self.curve.name)
        );
    }
}

/// The outline of a mark, another one for each colour.
fn mark(colour: usize) -> &'static str {
    match colour {
        0 => "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0z",
        1 => "M-5-5H5V5H-5z",
        2 => "M0-6L6 5H-6z",
        3 => "M0-7L7 0L0 7L-7 0z",
        4 => "M0 6L6-5H-6z",
        5 => "M-6-2H-2V-6H2V-2H6V2H2V6H-2V2H-6z",
        _ => "M-3-6H3L6 0L3 6H-3L-6 0z",
    }
}

/// Colours of a chart that is opened by itself or shown on a page.
fn style() -> String {
    let colours = |dark: bool| -> String {
        let lines = LINES.iter().enumerate();
        lines
            .map(|(index, (light, on_dark))| {
                format!(
                    ".chart .k{index}{{color:{}}}",
                    if dark { on_dark } else { light }
                )
            })
            .collect()
    };
    format!(
        "<style>.chart{{color:#1f2430;background:#ffffff}}.chart .open{{fill:#ffffff}}\
         .chart .grid{{stroke:#8a919e;stroke-opacity:.35;fill:none}}\
         .chart .leader{{stroke:currentColor;stroke-dasharray:1 4;fill:none}}.chart .axis{{stroke:currentColor;fill:none}}\
         .chart .shade{{fill:#8a919e;fill-opacity:.2}}{}@media (prefers-color-scheme:dark){{\
         .chart{{color:#dfe3ea;background:#14171c}}.chart .open{{fill:#14171c}}{}}}</style>",
        colours(false),
        colours(true)
    )
}

#[cfg(test)]
mod tests {
    use super::{Curve, Dot, LABEL_HEIGHT, LINES, LogLog};

    fn curve(name: &str, points: &[(f64, f64)]) -> Curve {
        Curve {
            name: name.to_owned(),
            colour: 0,
            dashed: false,
            points: points
                .iter()
                .map(|&(x, y)| Dot {
                    x,
                    y,
                    note: String::new(),
                })
                .collect(),
        }
    }

    fn drawn(curves: Vec<Curve>) -> String {
        LogLog {
            title: "a < b",
            x: "x",
            y: "y",
            falling: true,
            floor: Some((1e-12, "rounding")),
            curves,
        }
        .svg()
    }

    #[test]
    fn chart_of_any_numbers_is_drawn_without_numbers_that_are_none() {
        let extremes = [
            0.0,
            5e-324,
            1e-17,
            1.0,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
            -1.0,
        ];
        for a in extremes {
            for b in extremes {
                let svg = drawn(vec![curve("one", &[(a, b), (1.0, a), (b, 1.0)])]);
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{a} {b}");
                assert!(svg.len() < 100_000, "{a} {b}");
            }
        }
        assert!(drawn(Vec::new()).contains("Nothing was measured"));
    }

    #[test]
    fn error_of_zero_stands_at_the_lower_edge_and_names_keep_their_distance() {
        let names = ["one", "two", "three"];
        let svg = drawn(
            names
                .map(|name| curve(name, &[(1.0, 1e-3), (0.1, 0.0)]))
                .into(),
        );
        assert_eq!(svg.matches("translate(").count(), 1 + 2 * names.len());
        let place = |name: &str| -> f64 {
            let (before, _) = svg.split_once(&format!(">{name}</text>")).unwrap();
            let (_, y) = before.rsplit_once("y=\"").unwrap();
            y.trim_end_matches('"').parse().unwrap()
        };
        let mut places = names.map(place);
        places.sort_by(f64::total_cmp);
        // Places are written with one decimal.
        assert!(
            places
                .windows(2)
                .all(|pair| pair[1] - pair[0] > LABEL_HEIGHT - 0.11)
        );
    }

    /// Red, green and blue of light, from a colour as in CSS.
    fn linear(colour: &str) -> [f64; 3] {
        [1, 3, 5].map(|at| {
            let share = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if share <= 0.04045 {
                share / 12.92
            } else {
                ((share + 0.055) / 1.055).powf(2.4)
            }
        })
    }

    fn product(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum::<f64>())
    }

    /// Lightness and two opponent colours (CIE 1976 L*a*b*).
    fn lab(light: [f64; 3]) -> [f64; 3] {
        let xyz = product(
            [
                [0.4124, 0.3576, 0.1805],
                [0.2126, 0.7152, 0.0722],
                [0.0193, 0.1192, 0.9505],
            ],
            light,
        );
        let white = [0.9505, 1.0, 1.089];
        let f = |i: usize| {
            let share = (xyz[i] / white[i]).max(0.0);
            if share > 0.008_856 {
                share.cbrt()
            } else {
                7.787 * share + 16.0 / 116.0
            }
        };
        [
            116.0 * f(1) - 16.0,
            500.0 * (f(0) - f(1)),
            200.0 * (f(1) - f(2)),
        ]
    }

    #[test]
    fn colours_stay_apart_for_colour_blind_eyes_and_from_the_page() {
        // Machado, Oliveira, Fernandes (2009), severity 1: protanopia, deuteranopia, tritanopia; and normal sight.
        let eyes = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
            [
                [1.255_528, -0.076_749, -0.178_779],
                [-0.078_411, 0.930_809, 0.147_602],
                [0.004_733, 0.691_367, 0.303_900],
            ],
        ];
        let luminance = |colour: &str| {
            let [r, g, b] = linear(colour);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for (page, colours) in [
            ("#ffffff", LINES.map(|line| line.0)),
            ("#14171c", LINES.map(|line| line.1)),
        ] {
            for (index, one) in colours.iter().enumerate() {
                let (a, b) = (luminance(page) + 0.05, luminance(one) + 0.05);
                // WCAG 2.1 asks for 3 between graphics and what is behind them.
                assert!(
                    a.max(b) / a.min(b) >= 3.0,
                    "{one} on {page}: {}",
                    a.max(b) / a.min(b)
                );
                for other in &colours[..index] {
                    for eye in eyes {
                        let [a, b] = [one, other].map(|colour| lab(product(eye, linear(colour))));
                        let distance = a
                            .iter()
                            .zip(b)
                            .map(|(a, b)| (a - b).powi(2))
                            .sum::<f64>()
                            .sqrt();
                        // More than ten just noticeable differences of 2.3; marks differ as well.
                        assert!(distance > 25.0, "{one} and {other}: {distance}");
                    }
                }
            }
        }
    }
}
