//! The error of every simulation method against its step size and its CPU time.

use hangtime::simulation::Counts;

use super::drawn::Chart;
use super::measure::{Measured, Order, Point};
use super::peers::Peers;
use super::reading::reading;
use super::study::{Reference, Study};
use super::sweep::{CONTROLLED, Group, SHOWN, Sweep, sweeps};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::figure::{Curve, Dot, LogLog};
use crate::page::{Block, Figure, Section};
use crate::progress::Progress;
use crate::spreadsheet::csv_text;
use crate::table::{seconds, table};

/// Errors whose price is listed: in CPU time, and in counts for the middle one.
const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Most letters of a number on a page.
const LONGEST_NUMBER: usize = 8;
/// What the shade of a figure means.
const UNCERTAIN: &str = "below the uncertainty of the reference";

/// Measures every method on one simulation.
pub(super) fn chart(
    study: &Study,
    peers: &Peers,
    bounds: &Bounds,
    of_many: &str,
) -> Result<Chart, BadInput> {
    let reference = match Reference::of(study, bounds)? {
        Ok(reference) => reference,
        Err(diagnosis) => {
            return Ok(Chart {
                diagnoses: diagnosis.into_iter().collect(),
                ..Chart::default()
            });
        }
    };
    let title = study.title();
    let mut measured = measure_all(study, &reference, sweeps(), bounds, of_many)?;
    measured.extend(peers.measured(&title, &reference));
    // Those that are drawn first, then the schemes one by one.
    measured.sort_by_key(|line| !line.sweep.charted);
    let error = study.error();
    let against = format!(
        "measured against {}, known to {:.0e}",
        reference.what, reference.uncertainty
    );
    let reading = reading(&measured, reference.uncertainty, study.unit());
    let beside = origin(peers, &title);
    let text = format!(
        "{title}: {error}, {against}\n\n{}{reading}{beside}\n",
        table(HEADER, measured.iter().map(Measured::row))
    );
    let about = format!(
        "{}. The {error}, {against}. Parameters: {}.{}{beside}",
        study.chosen.scene.title,
        study.chosen.parameters().join(", "),
        absent(&measured)
    );
    let drawings = Drawings {
        title: &title,
        error: &error,
        uncertainty: reference.uncertainty,
        measured: &measured,
    };
    let (section, files) = drawings.section(reading, about, &study.stem());
    Ok(Chart {
        text,
        section: Some(section),
        files,
        diagnoses: Vec::new(),
        overview: Some(overview_row(&title, &reference, &measured)),
    })
}

/// The chart of one simulation that a page opens with, and what to read off it: the methods and other programs, over CPU time.
pub(crate) fn opening(
    study: &Study,
    peers: &Peers,
    bounds: &Bounds,
) -> Result<Option<(String, Figure)>, BadInput> {
    let Ok(reference) = Reference::of(study, bounds)? else {
        return Ok(None);
    };
    let charted = sweeps().into_iter().filter(|sweep| sweep.charted);
    let mut measured = measure_all(study, &reference, charted.collect(), bounds, "")?;
    let title = study.title();
    measured.extend(peers.measured(&title, &reference));
    let reading = reading(&measured, reference.uncertainty, study.unit());
    let drawings = Drawings {
        title: &title,
        error: &study.error(),
        uncertainty: reference.uncertainty,
        measured: &measured,
    };
    Ok(Some((reading, drawings.opening())))
}

/// Where the runs of other programs are from; empty without any.
fn origin(peers: &Peers, study: &str) -> String {
    let origin = peers.origin(study);
    if origin.is_empty() {
        return origin;
    }
    format!(" Other programs: {origin}.")
}

/// Which methods have no line in the figures, and why.
fn absent(measured: &[Measured]) -> String {
    let absent: Vec<String> = measured
        .iter()
        .filter(|measured| measured.solved().next().is_none())
        .filter_map(|measured| {
            let last = measured.points.last()?;
            let status = last.status.replace('_', " ");
            Some(format!("{} ({status})", measured.sweep.name))
        })
        .collect();
    if absent.is_empty() {
        return String::new();
    }
    format!(
        " Without a line, because no run solved: {}.",
        absent.join(", ")
    )
}

/// Runs methods over their settings, until `bounds` ask to end.
fn measure_all(
    study: &Study,
    reference: &Reference,
    sweeps: Vec<Sweep>,
    bounds: &Bounds,
    of_many: &str,
) -> Result<Vec<Measured>, BadInput> {
    let title = format!("{of_many}{}", study.title());
    let mut progress = Progress::new(&title, sweeps.len() as f64);
    let mut measured = Vec::with_capacity(sweeps.len());
    for (done, sweep) in sweeps.into_iter().enumerate() {
        progress.say(&format!("{title}: {}", sweep.name));
        measured.push(Measured::of(study, sweep, reference, bounds)?);
        progress.reach((done + 1) as f64);
    }
    Ok(measured)
}

/// What the columns of tables and figures mean.
pub(super) const LEGEND: &str = "\
    Radau-3 is FESD with Radau IIA and 3 stages: every switch is located, and ends an element. Time-freezing solves the same \
    elements in numerical time; `no exit`, dashed, means: without the condition that ends a contact where its force vanishes. Controlled: the \
    elements get the length that a tolerance allows. A method has the same colour everywhere, and its variants a mark each; lines of other programs are dashed. Fixed steps are Runge-Kutta steps without switch detection; the order of \
    the smoothed method is that in the width of its step functions. An order is the slope over the five finest points whose errors \
    are more than ten times the uncertainty of the reference; `exact` means that no error is, and a slope may be off by some tenths where switches fall differently into the steps. The prices are those of the \
    cheapest run with an error of at most the value in the column's name: counts, which are the same on every computer, and CPU \
    time. Not solved: runs that ended with another status, or were given up after 2 s.";

const HEADER: [&str; 11] = [
    "method",
    "order",
    "in theory",
    "least error",
    "1e-6: steps",
    "Newton",
    "evaluations",
    "CPU",
    "CPU for 1e-3",
    "CPU for 1e-9",
    "not solved",
];

/// The columns of the overview.
pub(super) fn overview_header() -> Vec<String> {
    let mut header = vec!["scene".to_owned(), "reference known to".to_owned()];
    header.extend(SHOWN.map(|name| format!("order, {name}")));
    header.extend(compared_names());
    header
}

/// The methods whose prices the overview shows.
fn compared_names() -> Vec<String> {
    let of_prices = sweeps()
        .into_iter()
        .filter(|sweep| sweep.compared && (sweep.group != Group::Radau || sweep.name == SHOWN[0]));
    of_prices.map(|sweep| sweep.name).collect()
}

/// One line about a study: orders, and CPU times for the middle one of the errors.
fn overview_row(title: &str, reference: &Reference, measured: &[Measured]) -> Vec<String> {
    let named = |name: &str| measured.iter().find(|measured| measured.sweep.name == name);
    let order = |name: &str| named(name).map_or(Order::Unknown, |measured| measured.order);
    let price = |name: &str| {
        let point = named(name).and_then(|measured| measured.cheapest(TARGETS[1]));
        point.map_or_else(|| "-".to_owned(), |point| seconds(point.seconds))
    };
    let mut row = vec![title.to_owned(), format!("{:.0e}", reference.uncertainty)];
    row.extend(SHOWN.map(|name| order(name).cell()));
    row.extend(compared_names().iter().map(|name| price(name)));
    row
}

/// The columns of all runs.
const RUNS: [&str; 9] = [
    "method",
    "settings",
    "step size [s], tolerance or width",
    "error",
    "steps",
    "Newton iterations",
    "evaluations",
    "CPU time [s]",
    "status",
];

/// How a measured method is shown.
trait Shown {
    /// Its line in the table.
    fn row(&self) -> Vec<String>;
    /// All runs, as text.
    fn runs(&self) -> Vec<Vec<String>>;
    /// Its line in a figure.
    fn curve(&self, x: &dyn Fn(&Point) -> f64) -> Curve;
}

impl Shown for Measured {
    fn row(&self) -> Vec<String> {
        let none = || "-".to_owned();
        let best = self.solved().min_by(|a, b| a.error.total_cmp(&b.error));
        let price = |target: f64| {
            self.cheapest(target)
                .map_or_else(none, |point| seconds(point.seconds))
        };
        let counts = self.cheapest(TARGETS[1]).and_then(|point| point.counts);
        let count = |count: &dyn Fn(Counts) -> usize| {
            counts.map_or_else(none, |counts| count(counts).to_string())
        };
        vec![
            self.sweep.name.clone(),
            self.order.cell(),
            self.sweep.theory.clone(),
            best.map_or_else(none, |point| format!("{:.1e}", point.error)),
            count(&|counts| counts.elements),
            count(&|counts| counts.newton),
            count(&|counts| counts.evaluations),
            price(TARGETS[1]),
            price(TARGETS[0]),
            price(TARGETS[2]),
            self.unsolved().to_string(),
        ]
    }

    fn runs(&self) -> Vec<Vec<String>> {
        let runs = self.points.iter().map(|point| {
            let known = |value: f64, text: String| {
                if value.is_finite() {
                    text
                } else {
                    String::new()
                }
            };
            let count = |count: &dyn Fn(Counts) -> usize| {
                let counts = point.counts;
                counts.map_or_else(String::new, |counts| count(counts).to_string())
            };
            vec![
                self.sweep.name.clone(),
                point.arguments.clone(),
                known(point.grain, point.grain.to_string()),
                known(point.error, format!("{:e}", point.error)),
                count(&|counts| counts.elements),
                count(&|counts| counts.newton),
                count(&|counts| counts.evaluations),
                known(point.seconds, point.seconds.to_string()),
                point.status.to_owned(),
            ]
        });
        runs.collect()
    }

    fn curve(&self, x: &dyn Fn(&Point) -> f64) -> Curve {
        let name = match self.order {
            Order::Slope(order) => format!("{}: order {order:.1}", self.sweep.name),
            Order::Exact => format!("{}: exact", self.sweep.name),
            Order::Unknown => self.sweep.name.clone(),
        };
        let dots = self.points.iter().map(|point| Dot {
            x: x(point),
            y: point.error,
            half: None,
            note: point.note(),
        });
        Curve {
            name,
            look: self.sweep.look,
            steps: false,
            points: dots.collect(),
        }
    }
}

/// What the figures of a study show.
struct Drawings<'a> {
    title: &'a str,
    error: &'a str,
    uncertainty: f64,
    measured: &'a [Measured],
}

impl Drawings<'_> {
    /// The lines that are kept, with what they stand over.
    fn curves(&self, x: &dyn Fn(&Point) -> f64, keep: &dyn Fn(&Measured) -> bool) -> Vec<Curve> {
        let kept = self.measured.iter().filter(|measured| keep(measured));
        kept.map(|measured| measured.curve(x)).collect()
    }

    /// Errors over CPU time of all methods and programs, with the spread of repetitions.
    fn opening(&self) -> Figure {
        let mut curves = Vec::new();
        for measured in self.measured.iter().filter(|line| line.sweep.charted) {
            let mut curve = measured.curve(&|point| point.seconds);
            curve.name.clone_from(&measured.sweep.name);
            for (dot, point) in curve.points.iter_mut().zip(&measured.points) {
                dot.half = Some(point.half).filter(|half| half.is_finite());
            }
            curves.push(curve);
        }
        Figure::chart(&LogLog {
            title: &format!("{}: error over CPU time", self.title),
            x: "CPU time [s]; bars: up to what half of the repetitions take",
            y: self.error,
            falling: false,
            floor: Some((self.uncertainty, UNCERTAIN)),
            curves,
        })
    }

    /// Errors over step sizes.
    fn over_steps(&self, what: &str, keep: &dyn Fn(&Measured) -> bool) -> String {
        LogLog {
            title: &format!("{}: {what}", self.title),
            x: "step size [s], smaller to the right",
            y: self.error,
            falling: true,
            floor: Some((self.uncertainty, UNCERTAIN)),
            curves: self.curves(&|point| point.grain, keep),
        }
        .svg()
    }

    /// All figures and tables, and the files that hold them; `stem` begins the names of the files.
    fn section(
        &self,
        reading: String,
        about: String,
        stem: &str,
    ) -> (Section, Vec<(String, String)>) {
        let opening = self.opening();
        let stepped = |measured: &Measured| measured.sweep.compared && measured.sweep.stepped();
        let sizes = self.over_steps("error against step size", &stepped);
        let schemes = self.schemes();
        let data = format!("chart-{stem}.csv");
        let mut files = vec![(data.clone(), csv(self.error, self.measured))];
        let drawn = [
            ("cpu-time", opening.svg().to_owned()),
            ("step-size", sizes.clone()),
        ];
        let drawn = drawn.into_iter().chain(schemes.clone());
        files.extend(drawn.map(|(kind, svg)| (format!("chart-{stem}-{kind}.svg"), svg)));
        let rows = self.measured.iter().map(Measured::row).collect();
        let runs = self.measured.iter().flat_map(Measured::runs);
        let runs = Block::table(RUNS, runs.map(shortened).collect());
        let schemes = schemes.into_iter().map(|(_, svg)| Block::figure(svg));
        let section = Section {
            heading: self.title.to_owned(),
            blocks: vec![
                Block::Text(reading),
                Block::Figure(opening),
                Block::table(HEADER, rows),
                Block::figure(sizes),
                Block::Fold("The schemes, one by one".to_owned(), schemes.collect()),
                Block::folded("Every run", runs),
                Block::Text(about),
            ],
            files: vec![(data, "all runs".to_owned())],
        };
        (section, files)
    }

    /// The schemes one by one, as (kind, SVG).
    fn schemes(&self) -> Vec<(&'static str, String)> {
        let of = |group: Group, what: &str| {
            let keep = |measured: &Measured| measured.sweep.group == group;
            self.over_steps(what, &keep)
        };
        vec![
            ("radau-iia", of(Group::Radau, "FESD, Radau IIA")),
            ("gauss-legendre", of(Group::Gauss, "FESD, Gauss-Legendre")),
            ("time-freezing", of(Group::TimeFreezing, "time-freezing")),
        ]
    }
}

/// A row with numbers of four digits; all digits are in the data.
fn shortened(row: Vec<String>) -> Vec<String> {
    let short = |cell: String| match cell.parse::<f64>() {
        Ok(value) if cell.len() > LONGEST_NUMBER => format!("{value:.3e}"),
        _ => cell,
    };
    row.into_iter().map(short).collect()
}

fn csv(error: &str, measured: &[Measured]) -> String {
    let mut header = RUNS;
    header[3] = error;
    csv_text(&header, measured.iter().flat_map(Measured::runs))
}

/// What the overview says about the default simulation.
pub(super) fn overview_text(studies: usize) -> String {
    format!(
        "{studies} simulations. Orders measured through impacts, take-offs and stick, beside 5 in theory, and the CPU time of each \
         method for an error of {:.0e}; a dash means that no run reached it. {CONTROLLED} is what `simulate` does by default.",
        TARGETS[1]
    )
}
