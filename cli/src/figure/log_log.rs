//! Charts with logarithmic axes: lines that carry their names, in colours that stay apart for colour-blind eyes.

use std::fmt::Write as _;

use super::axis::Axis;
use super::colours::{LINES, Look, style};
use super::{Area, MARKS};
use crate::markup::escape;

/// Least distance of the names of two lines [px].
const LABEL_HEIGHT: f64 = 22.0;
/// Widths of the lines [px]: of the first one, how much thinner each is than the one before, and of the last ones.
const WIDEST: f64 = 4.4;
const THINNER: f64 = 0.5;
const THINNEST: f64 = 1.8;
/// Errors beyond this say nothing but that they are large.
const LARGEST: f64 = 1e3;

/// Where things are on a chart [px].
#[derive(Clone, Copy)]
struct Layout {
    /// Class of the drawing, by which a page chooses among layouts.
    class: &'static str,
    width: f64,
    area: Area,
    /// Size of the title; without one there is none.
    title: Option<f64>,
    /// Whether names stand below the plot instead of beside it, at the ends of their lines.
    below: bool,
}

/// For screens that are as wide as a table.
const WIDE: Layout = Layout {
    class: "chart",
    width: 1100.0,
    area: Area {
        left: 104.0,
        right: 750.0,
        top: 48.0,
        bottom: 474.0,
        letter: 17.0,
        side: 20.4,
    },
    title: Some(20.0),
    below: false,
};
/// For those of telephones.
const NARROW: Layout = Layout {
    class: "slim",
    width: 358.0,
    area: Area {
        left: 58.0,
        right: 350.0,
        top: 10.0,
        bottom: 316.0,
        letter: 13.0,
        side: 15.6,
    },
    title: None,
    below: true,
};

impl Layout {
    /// Height of a chart with so many lines.
    fn height(&self, names: usize) -> f64 {
        self.row(if self.below { names } else { 0 }) - 0.4 * LABEL_HEIGHT
    }

    /// Where the name of a line stands that has this place in their list.
    fn row(&self, index: usize) -> f64 {
        self.area.bottom + 4.1 * self.area.letter + LABEL_HEIGHT * (index as f64 + 0.4)
    }
}

/// A point of a line.
#[derive(Debug, Default)]
pub(crate) struct Dot {
    /// Where it is; what is not finite is left out, an error of zero stands at a line of its own, below the others.
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Where half of all repetitions are, if it was measured several times; it stands at the least of them.
    pub(crate) half: Option<f64>,
    /// What a pointer over it tells.
    pub(crate) note: String,
}

/// One line of a chart.
pub(crate) struct Curve {
    /// Its name, at the end of the line.
    pub(crate) name: String,
    /// Its colour, and its mark.
    pub(crate) look: Look,
    /// Whether it keeps its height up to the next point.
    pub(crate) steps: bool,
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
    points: Vec<Place<'a>>,
}

/// A point on the chart.
struct Place<'a> {
    x: f64,
    y: f64,
    half: Option<f64>,
    note: &'a str,
}

impl LogLog<'_> {
    /// The drawing, for screens as wide as a table.
    pub(crate) fn svg(&self) -> String {
        self.laid_out(&WIDE)
    }

    /// The drawing for narrow screens; a page shows this or the wide one.
    pub(crate) fn narrow_svg(&self) -> String {
        self.laid_out(&NARROW)
    }

    fn laid_out(&self, layout: &Layout) -> String {
        let dots = || {
            let points = self.curves.iter().flat_map(|curve| &curve.points);
            points.filter(|dot| is_drawn(dot))
        };
        let ys = dots().map(|dot| dot.y).filter(|y| *y > 0.0);
        let floor = self.floor.map(|floor| floor.0).filter(|y| *y > 0.0);
        let area = &layout.area;
        let ends = (area.left, area.right);
        let across = Axis::around(dots().map(|dot| dot.x), ends, self.falling);
        let zero = dots().any(|dot| dot.y == 0.0);
        let up = Axis::decades(ys.chain(floor), (area.bottom, area.top), zero);
        let (width, height) = (layout.width, layout.height(self.curves.len()));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"{}\" role=\"img\" width=\"{width}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width} {height:.0}\" font-family=\"system-ui,sans-serif\" font-size=\"{}\" \
             fill=\"currentColor\">{}<title>{}</title>",
            layout.class,
            area.letter,
            style(layout.class),
            escape(self.title)
        );
        if let Some(size) = layout.title {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" font-size=\"{size}\" font-weight=\"600\">{}</text>",
                area.left,
                area.top - 20.0,
                escape(self.title)
            );
        }
        if let (Some(across), Some(up)) = (across, up) {
            self.frame(&mut svg, layout, &across, &up);
            self.lines(&mut svg, layout, &across, &up);
        } else {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" dy=\"30\">Nothing was measured.</text>",
                area.left, area.top
            );
        }
        svg + "</svg>"
    }

    /// Axes, grid, and the range of errors that say nothing.
    fn frame(&self, svg: &mut String, layout: &Layout, across: &Axis, up: &Axis) {
        let area = &layout.area;
        let (left, bottom) = (area.left, area.bottom);
        if let Some((floor, why)) = self.floor {
            let y = up.place(floor).clamp(area.top, bottom);
            let _ = write!(
                svg,
                "<rect class=\"shade\" x=\"{left}\" y=\"{y:.1}\" width=\"{}\" height=\"{:.1}\"/>",
                area.right - left,
                bottom - y
            );
            if bottom - y > 20.0 {
                let _ = write!(
                    svg,
                    "<text x=\"{}\" y=\"{:.1}\" font-size=\"{}\">{}</text>",
                    left + 8.0,
                    bottom - 8.0,
                    area.letter - 2.0,
                    escape(why)
                );
            }
        }
        // What stands behind a semicolon is said where there is space.
        let short = self.x.split(';').next().unwrap_or(self.x);
        let label = if layout.below { short } else { self.x };
        area.frame(svg, [across, up], [label, self.y]);
    }

    /// Lines, marks and names. Earlier lines are wider, so that a later one on top of them hides nothing.
    fn lines(&self, svg: &mut String, layout: &Layout, across: &Axis, up: &Axis) {
        let place = |dot: &'_ Dot| {
            let y = up.place(dot.y.min(LARGEST));
            (
                across.place(dot.x),
                y.clamp(layout.area.top, layout.area.bottom),
            )
        };
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
                        let (x, y) = place(dot);
                        let half = dot.half.filter(|half| half.is_finite() && *half > dot.x);
                        Place {
                            x,
                            y,
                            half: half.map(|half| across.place(half)),
                            note: &dot.note,
                        }
                    })
                    .collect(),
            })
            .filter(|drawn| !drawn.points.is_empty())
            .collect();
        for (index, drawn) in drawn.iter().enumerate() {
            drawn.line(svg, (WIDEST - THINNER * index as f64).max(THINNEST));
        }
        if layout.below {
            for (index, drawn) in drawn.iter().enumerate() {
                drawn.listed(svg, layout, layout.row(index));
            }
        } else {
            for (place, drawn) in places(&drawn, layout).into_iter().zip(&drawn) {
                drawn.name(svg, layout, place);
            }
        }
    }
}

fn is_drawn(dot: &Dot) -> bool {
    dot.x > 0.0 && dot.x.is_finite() && dot.y >= 0.0 && dot.y.is_finite()
}

/// Heights of the names: where the lines end, moved apart as far as they need.
fn places(drawn: &[Drawn<'_>], layout: &Layout) -> Vec<f64> {
    let mut ends: Vec<(f64, usize)> = drawn
        .iter()
        .enumerate()
        .map(|(index, drawn)| (drawn.end().1, index))
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lowest = layout.area.top + 4.0;
    for end in &mut ends {
        end.0 = end.0.max(lowest);
        lowest = end.0 + LABEL_HEIGHT;
    }
    let mut highest = layout.area.bottom;
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
        let points = self.points.iter().map(|place| (place.x, place.y));
        points
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((WIDE.area.right, WIDE.area.bottom))
    }

    /// Its path: straight from point to point, or level up to each of them.
    fn path(&self) -> String {
        let mut path = String::new();
        for (index, Place { x, y, .. }) in self.points.iter().enumerate() {
            let _ = match (index, self.curve.steps) {
                (0, _) => write!(path, "M{x:.1} {y:.1}"),
                (_, true) => write!(path, "H{x:.1}V{y:.1}"),
                (_, false) => write!(path, "L{x:.1} {y:.1}"),
            };
        }
        path
    }

    fn dashes(&self) -> &'static str {
        if self.curve.look.dashed {
            " stroke-dasharray=\"9 6\""
        } else {
            ""
        }
    }

    fn line(&self, svg: &mut String, width: f64) {
        let colour = self.curve.look.colour % LINES.len();
        let _ = write!(
            svg,
            "<g class=\"k{colour}\" stroke=\"currentColor\" stroke-width=\"{width:.1}\">\
             <path fill=\"none\" stroke-linejoin=\"round\"{} d=\"{}\"/>",
            self.dashes(),
            self.path()
        );
        for place in &self.points {
            if let Some(half) = place.half {
                let _ = write!(
                    svg,
                    "<path class=\"half\" stroke-width=\"1.6\" d=\"M{:.1} {:.1}H{half:.1}\"/>",
                    place.x, place.y
                );
            }
            self.mark(svg, (place.x, place.y), place.note);
        }
        svg.push_str("</g>");
    }

    fn mark(&self, svg: &mut String, (x, y): (f64, f64), note: &str) {
        let fill = if self.curve.look.dashed {
            "class=\"open\""
        } else {
            "fill=\"currentColor\""
        };
        let _ = write!(
            svg,
            "<path {fill} stroke-width=\"1.6\" transform=\"translate({x:.1} {y:.1})\" d=\"{}\"><title>{}</title></path>",
            MARKS[self.curve.look.mark % MARKS.len()],
            escape(note)
        );
    }

    /// Its name beside the plot.
    fn name(&self, svg: &mut String, layout: &Layout, place: f64) {
        let (x, y) = self.end();
        let colour = self.curve.look.colour % LINES.len();
        let _ = write!(
            svg,
            "<path class=\"leader k{colour}\" d=\"M{:.1} {y:.1}L{} {place:.1}\"/>\
             <text class=\"k{colour}\" fill=\"currentColor\" x=\"{}\" y=\"{:.1}\">{}</text>",
            x + 7.0,
            layout.area.right + 18.0,
            layout.area.right + 22.0,
            place + 6.0,
            escape(&self.curve.name)
        );
    }

    /// Its name in a list below the plot, behind a piece of the line.
    fn listed(&self, svg: &mut String, layout: &Layout, row: f64) {
        let colour = self.curve.look.colour % LINES.len();
        let _ = write!(
            svg,
            "<g class=\"k{colour}\" stroke=\"currentColor\"><path fill=\"none\" stroke-width=\"2.4\"{} d=\"M6 {row:.1}H42\"/>",
            self.dashes()
        );
        self.mark(svg, (24.0, row), "");
        let _ = write!(
            svg,
            "</g><text x=\"50\" y=\"{:.1}\">{}</text>",
            row + 0.35 * layout.area.letter,
            escape(&self.curve.name)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{Curve, Dot, LABEL_HEIGHT, LogLog};
    use crate::figure::Look;

    fn curve(name: &str, points: &[(f64, f64)]) -> Curve {
        Curve {
            name: name.to_owned(),
            look: Look::of("phases"),
            steps: false,
            points: points
                .iter()
                .map(|&(x, y)| Dot {
                    x,
                    y,
                    half: Some(2.0 * x),
                    note: String::new(),
                })
                .collect(),
        }
    }

    fn chart(curves: Vec<Curve>) -> LogLog<'static> {
        LogLog {
            title: "a < b",
            x: "x",
            y: "y",
            falling: true,
            floor: Some((1e-12, "rounding")),
            curves,
        }
    }

    fn drawn(curves: Vec<Curve>) -> String {
        chart(curves).svg()
    }

    #[test]
    fn narrow_chart_lists_its_names_below_and_steps_are_level() {
        let line = |steps| Curve {
            steps,
            ..curve("one", &[(1.0, 1e-1), (0.1, 1e-2)])
        };
        let svg = chart(vec![line(true), line(false)]).narrow_svg();
        // A telephone is 390 px wide.
        assert!(svg.contains("class=\"slim\"") && svg.contains("width=\"358\""));
        let heights: Vec<f64> = svg
            .split("<text x=\"50\" y=\"")
            .filter_map(|rest| rest.split_once("\">one</text>"))
            .filter_map(|(height, _)| height.parse().ok())
            .collect();
        assert_eq!(heights.len(), 2);
        assert!(heights[1] - heights[0] >= LABEL_HEIGHT - 0.11);
        assert_eq!(svg.matches("class=\"half\"").count(), 4);
        let path = |from: &str| -> String {
            let (_, rest) = svg.split_once(from).unwrap();
            rest.split('"').next().unwrap().to_owned()
        };
        let level = path("stroke-linejoin=\"round\" d=\"");
        assert!(
            level.contains('H') && level.contains('V') && !level.contains('L'),
            "{level}"
        );
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
}
