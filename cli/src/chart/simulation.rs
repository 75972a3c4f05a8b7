//! The error of every simulation method against its step size and its CPU time.

use hangtime::simulation::Counts;

use super::drawn::Chart;
use super::measure::{Measured, Order, Point};
use super::peers::Peers;
use super::study::{Reference, Study};
use super::sweep::{CONTROLLED, EVENT_DRIVEN, Group, SHOWN, sweeps};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::figure::{Curve, Dot, LogLog};
use crate::page::{Fold, Section};
use crate::progress::Progress;
use crate::spreadsheet::csv_text;
use crate::table::{seconds, table};

/// Errors whose price is listed: in CPU time, and in counts for the middle one.
const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-9];
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
    let mut measured = measure_all(study, &reference, bounds, of_many)?;
    let title = study.title();
    measured.extend(peers.measured(&title, &reference));
    let error = format!(
        "largest error of a coordinate at {} s",
        study.problem.horizon
    );
    let against = format!(
        "measured against {}, known to {:.0e}",
        reference.what, reference.uncertainty
    );
    let beside = beside_peers(&measured, &peers.origin(&title));
    let text = format!(
        "{title}: {error}, {against}\n\n{}{beside}\n",
        table(header(), measured.iter().map(Measured::row))
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
    let (section, files) = drawings.section(about, &study.stem());
    Ok(Chart {
        text,
        section: Some(section),
        files,
        diagnoses: Vec::new(),
        overview: Some(overview_row(&title, &reference, &measured)),
    })
}

/// The methods that are drawn beside other programs.
const BESIDE_PEERS: [&str; 2] = [CONTROLLED, EVENT_DRIVEN];
/// The error for which they are compared in words.
const EQUAL: f64 = 1e-8;

/// What other programs take for the same error as the default simulation; empty without `origin`.
fn beside_peers(measured: &[Measured], origin: &str) -> String {
    if origin.is_empty() {
        return String::new();
    }
    let default = measured.iter().find(|line| line.sweep.name == CONTROLLED);
    let own = default.and_then(|line| line.cheapest(EQUAL));
    let others = measured
        .iter()
        .filter(|line| line.sweep.group == Group::Peers);
    let words = others.map(|line| {
        let price = line.cheapest(EQUAL);
        let times = price
            .zip(own)
            .map(|(other, own)| other.seconds / own.seconds)
            .map(|ratio| format!(", {ratio:.*} times as long", usize::from(ratio < 100.0)));
        let name = &line.sweep.name;
        price.map_or_else(
            || format!("{name}: does not get there"),
            |point| {
                format!(
                    "{name}: {}{}",
                    seconds(point.seconds),
                    times.unwrap_or_default()
                )
            },
        )
    });
    let own = own.map_or_else(
        || "does not get there".to_owned(),
        |own| seconds(own.seconds),
    );
    format!(
        " For an error of {EQUAL:.0e}, {CONTROLLED}: {own}; {}. Other programs: {origin}.",
        words.collect::<Vec<_>>().join("; ")
    )
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

/// Runs every method over its settings, until `bounds` ask to end.
fn measure_all(
    study: &Study,
    reference: &Reference,
    bounds: &Bounds,
    of_many: &str,
) -> Result<Vec<Measured>, BadInput> {
    let sweeps = sweeps();
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
    elements in numerical time; complementarity is the time-freezing system as published, one complementarity problem a step \
    without a polish; `no exit` means: without the condition that ends a contact where its force vanishes. Controlled: the \
    elements get the length that a tolerance allows. Fixed steps are Runge-Kutta steps without switch detection; the order of \
    the smoothed method is that in the width of its step functions. An order is the slope over the five finest points whose errors \
    are more than ten times the uncertainty of the reference; `exact` means that no error is, and a slope may be off by some tenths where switches fall differently into the steps. The prices are those of the \
    cheapest run with an error of at most the value in the column's name: counts, which are the same on every computer, and CPU \
    time. Not solved: runs that ended with another status, or were given up after 2 s.";

fn header() -> Vec<String> {
    [
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
    ]
    .map(str::to_owned)
    .into()
}

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
            note: point.note(),
        });
        Curve {
            name,
            colour: self.sweep.colour,
            dashed: self.sweep.dashed,
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
    fn draw(
        &self,
        what: &str,
        over_time: bool,
        keep: &dyn Fn(&Measured) -> bool,
        colour: Option<&dyn Fn(&Measured) -> usize>,
    ) -> String {
        let x = |point: &Point| {
            if over_time {
                point.seconds
            } else {
                point.grain
            }
        };
        let kept = self.measured.iter().filter(|measured| keep(measured));
        let curves = kept.map(|measured| {
            let curve = measured.curve(&x);
            Curve {
                colour: colour.map_or(curve.colour, |colour| colour(measured)),
                ..curve
            }
        });
        LogLog {
            title: &format!("{}: {what}", self.title),
            x: if over_time {
                "CPU time [s]"
            } else {
                "step size [s], smaller to the right"
            },
            y: self.error,
            falling: !over_time,
            floor: Some((self.uncertainty, UNCERTAIN)),
            curves: curves.collect(),
        }
        .svg()
    }

    /// All figures and tables, and the files that hold them; `stem` begins the names of the files.
    fn section(&self, text: String, stem: &str) -> (Section, Vec<(String, String)>) {
        let mut figures = Vec::from(self.compared());
        let of_peers = |measured: &Measured| measured.sweep.group == Group::Peers;
        if self.measured.iter().any(of_peers) {
            figures.push(("peers", self.peers()));
        }
        let schemes = self.schemes();
        let data = format!("chart-{stem}.csv");
        let mut files = vec![(data.clone(), csv(self.error, self.measured))];
        let drawn = figures.iter().chain(&schemes);
        files.extend(drawn.map(|(kind, svg)| (format!("chart-{stem}-{kind}.svg"), svg.clone())));
        let folds = vec![
            Fold {
                title: "The schemes, one by one".to_owned(),
                figures: schemes.into_iter().map(|(_, svg)| svg).collect(),
                ..Fold::default()
            },
            Fold {
                title: "Every run".to_owned(),
                header: RUNS.map(str::to_owned).into(),
                rows: self.measured.iter().flat_map(Measured::runs).collect(),
                ..Fold::default()
            },
        ];
        let section = Section {
            heading: self.title.to_owned(),
            text,
            header: header(),
            rows: self.measured.iter().map(Measured::row).collect(),
            figures: figures.into_iter().map(|(_, svg)| svg).collect(),
            folds,
            files: vec![(data, "all runs".to_owned())],
            animation: None,
        };
        (section, files)
    }

    /// The families of methods, over step size and over CPU time.
    fn compared(&self) -> [(&'static str, String); 2] {
        let compared = |measured: &Measured| measured.sweep.compared;
        let priced = |measured: &Measured| {
            let sweep = &measured.sweep;
            // The controlled elements stand for those of two stages, whose colour they have.
            sweep.compared && (sweep.group != Group::Radau || sweep.name == SHOWN[0])
        };
        let stepped = |measured: &Measured| compared(measured) && measured.sweep.stepped();
        let sizes = self.draw("error against step size", false, &stepped, None);
        let times = self.draw("error against CPU time", true, &priced, None);
        [("step-size", sizes), ("cpu-time", times)]
    }

    /// The default simulation and its judge beside other programs, over CPU time.
    fn peers(&self) -> String {
        let kept = |measured: &Measured| {
            measured.sweep.group == Group::Peers || BESIDE_PEERS.contains(&&*measured.sweep.name)
        };
        let colour = |measured: &Measured| match measured.sweep.group {
            // Blue and grey are taken.
            Group::Peers => 1 + measured.sweep.colour,
            _ => measured.sweep.colour,
        };
        self.draw("beside other programs", true, &kept, Some(&colour))
    }

    /// The schemes one by one, as (kind, SVG).
    fn schemes(&self) -> Vec<(&'static str, String)> {
        let of = |group: Group, what: &str| {
            let stage = |measured: &Measured| {
                // Lines of one figure take the colours in their order.
                let likes = self.measured.iter().filter(|other| {
                    let alike = other.sweep.dashed == measured.sweep.dashed;
                    other.sweep.group == group && (alike || group == Group::TimeFreezing)
                });
                let before = likes.take_while(|other| other.sweep.name != measured.sweep.name);
                before.count()
                    + if group == Group::TimeFreezing && measured.sweep.dashed {
                        4
                    } else {
                        0
                    }
            };
            let keep = |measured: &Measured| measured.sweep.group == group;
            self.draw(what, false, &keep, Some(&stage))
        };
        vec![
            ("radau-iia", of(Group::Radau, "FESD, Radau IIA")),
            ("gauss-legendre", of(Group::Gauss, "FESD, Gauss-Legendre")),
            ("time-freezing", of(Group::TimeFreezing, "time-freezing")),
        ]
    }
}

fn csv(error: &str, measured: &[Measured]) -> String {
    let mut header = RUNS.map(str::to_owned);
    error.clone_into(&mut header[3]);
    csv_text(&header, measured.iter().flat_map(Measured::runs))
}

/// What the overview says about the default simulation.
pub(super) fn overview_text(studies: usize) -> String {
    format!(
        "{studies} simulations. Orders measured through impacts, take-offs and stick, beside 5 in theory, and the CPU time of each \
         method for an error of {:.0e}; `-` means that no run reached it. {CONTROLLED} is what `simulate` does by default. \
         Every table and figure stands below.",
        TARGETS[1]
    )
}
