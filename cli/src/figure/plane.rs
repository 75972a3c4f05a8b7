//! Pictures of a motion in a plane.

use crate::PublishedPoint;
use crate::drawing::GroundLine;

use super::axis::Axis;
use super::{Area, COLOURS, GREY, LETTER, SIZE, drawing, line, mark, sample, shortened, stroke};

/// What stands beside the plot [px]: left, right, above, below.
const BESIDE: [f64; 4] = [76.0, 230.0, 44.0, 52.0];
/// Least height of a plot [px], for the legend beside it.
const LEAST_HEIGHT: f64 = 170.0;
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

/// A picture while it is drawn.
struct Drawn {
    axes: [Axis; 2],
    svg: String,
    /// What the legend shows: a piece of a line or a mark, and its name.
    legend: Vec<(String, String)>,
}

impl Drawn {
    fn place(&self, [y, z]: [f64; 2]) -> [f64; 2] {
        [self.axes[0].place(y), self.axes[1].place(z)]
    }

    fn line(&mut self, points: &[[f64; 2]], style: &str) {
        let places: Vec<[f64; 2]> = points.iter().map(|&point| self.place(point)).collect();
        line(&mut self.svg, places.into_iter(), style);
    }

    fn marks(
        &mut self,
        points: &[[f64; 2]],
        (which, colour, size): (usize, &str, f64),
        name: &str,
    ) {
        for &point in points {
            self.svg += &mark(self.place(point), which, colour, size);
        }
        if !points.is_empty() {
            self.name(mark([14.0, 0.0], which, colour, size), name);
        }
    }

    fn name(&mut self, sample: String, name: &str) {
        self.legend.push((sample, name.to_owned()));
    }
}

impl Motion {
    /// The picture, with equal scales on both axes.
    pub(crate) fn svg(&self) -> String {
        let [left, right, above, below] = BESIDE;
        let width = SIZE.0 - left - right;
        let extents = self.frame.map(|[from, to]| to - from);
        let most = SIZE.1 - above - below;
        let height = (width * extents[1] / extents[0])
            .max(LEAST_HEIGHT)
            .min(most);
        let area = Area {
            left,
            right: left + width,
            top: above,
            bottom: above + height,
            letter: LETTER,
            side: LETTER,
        };
        // What a pixel is on either axis.
        let pixel = (extents[0] / width).max(extents[1] / height);
        let around = |axis: usize, length: f64| {
            let [from, to] = self.frame[axis];
            let (middle, half) = (0.5 * from + 0.5 * to, 0.5 * pixel * length);
            [middle - half, middle + half]
        };
        let axes = [
            Axis::linear(around(0, width), (area.left, area.right)),
            Axis::linear(around(1, height), (area.bottom, area.top)),
        ];
        let mut drawn = Drawn {
            axes,
            svg: String::new(),
            legend: Vec::new(),
        };
        let labels = [0, 1].map(|i| shortened(&self.axes[i], LONGEST_NAME));
        area.frame(
            &mut drawn.svg,
            [&axes[0], &axes[1]],
            [&labels[0], &labels[1]],
        );
        self.draw(&mut drawn);
        area.legend(&mut drawn.svg, &drawn.legend);
        let size = (SIZE.0, area.bottom + below);
        drawing(size, &shortened(&self.title, LONGEST_TITLE), &drawn.svg)
    }

    fn draw(&self, drawn: &mut Drawn) {
        let mut named: Vec<&str> = Vec::new();
        for ground in &self.ground {
            let known = named.iter().position(|name| *name == ground.name);
            let dashes = ["6 4", "2 3"][known.unwrap_or(named.len()) % 2];
            let style = stroke(GREY, 1.5, dashes);
            let inside = |[y, z]: &[f64; 2]| {
                let [across, up] = self.frame;
                (across[0]..=across[1]).contains(y) && (up[0]..=up[1]).contains(z)
            };
            for part in ground.points.split(|point| !inside(point)) {
                drawn.line(part, &style);
            }
            if known.is_none() {
                named.push(ground.name);
                drawn.name(sample(&style), &shortened(ground.name, LONGEST_NAME));
            }
        }
        for points in &self.lines {
            drawn.line(points, &stroke(GREY, 1.2, ""));
        }
        for (path, colour) in self.paths.iter().zip(COLOURS.iter().cycle()) {
            let name = shortened(path.name, LONGEST_NAME);
            let style = stroke(colour, 2.0, "");
            drawn.line(&path.points, &style);
            drawn.name(sample(&style), &name);
            for outline in &path.outlines {
                drawn.line(outline, &stroke(colour, 1.2, ""));
            }
            let legend = name + &self.lapse;
            drawn.marks(&path.time_lapse, (0, colour, 0.7), &legend);
        }
        for (time_lapse, look, name) in [
            (false, (0, PUBLISHED, 0.36), "published path"),
            (true, (5, PUBLISHED, 0.8), "published time lapse"),
        ] {
            let points = self.published.iter();
            let kept = points.filter(|point| point.time_lapse == time_lapse);
            let places = kept.flat_map(|point| point.positions.iter().copied());
            drawn.marks(&places.collect::<Vec<_>>(), look, name);
        }
        drawn.marks(&self.start, (1, START, 0.9), "start");
        drawn.marks(&self.impacts, (3, IMPACT, 0.75), "impact");
    }
}

#[cfg(test)]
mod tests {
    use super::{Motion, Path};
    use crate::drawing::frame;

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
                assert!(
                    !svg.contains("M NaN") && !svg.contains("inf"),
                    "{a} {b}: {svg}"
                );
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
