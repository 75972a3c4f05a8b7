//! `hangtime chart`: error against step size and against CPU time, for every method.

use std::fmt::Write as _;

use hangtime::simulation::{InitialValueProblem, SimulationStatus};
use hangtime_models::scenes;

use super::Report;
use super::arguments::{ChartArguments, Method, MethodArguments, SchemeName};
use super::failure::BadInput;
use super::figure::{Curve, log_log};
use super::method::ChosenMethod;
use super::output::OutputDirectory;
use super::page::{Page, Section};
use super::progress::Progress;
use super::settings::ChosenScene;
use super::simulate::diagnosis_line;
use super::spreadsheet::csv_text;
use super::table::{seconds, table};
use super::timing::{EXACT_TOLERANCE, fastest};

/// Steps of the methods of high order.
const FINITE_ELEMENTS: [usize; 8] = [10, 15, 20, 30, 40, 80, 160, 320];
/// Steps of the methods of low order.
const TIME_STEPS: [usize; 7] = [50, 100, 200, 400, 1600, 6400, 25600];
/// Widths of the smoothed step functions.
const WIDTHS: [f64; 5] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3];
/// Tolerance of a smoothed run, as a share of its width: the width is what its error comes from.
const SMOOTHED_TOLERANCE: f64 = 1e-3;
/// Tolerances of the methods that control their steps.
const TOLERANCES: [f64; 6] = [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];
/// Errors whose price in CPU time is listed.
const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Errors below this share of the largest coordinate are rounding, and say nothing of an order.
const ROUNDING: f64 = 1e-12;
/// Points whose slope is the measured order: the finest ones above rounding.
const SLOPE_POINTS: usize = 3;

/// One method over its range of settings.
struct Sweep {
    name: String,
    colour: usize,
    dashed: bool,
    group: Group,
    settings: Vec<MethodArguments>,
}

impl Sweep {
    /// Whether the runs differ in their step size, and not in a tolerance.
    fn stepped(&self) -> bool {
        let tolerance = |settings: &MethodArguments| settings.tolerance.is_some();
        !self.settings.iter().any(tolerance)
    }

    /// Whether the error is expected to follow a power of what the runs differ in.
    fn ordered(&self) -> bool {
        let width = |settings: &MethodArguments| settings.width.is_some();
        self.stepped() || self.settings.iter().all(width)
    }
}

/// The figure in which a sweep appears beside its likes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Group {
    Radau,
    Gauss,
    Others,
}

/// One measured run.
struct Point {
    arguments: String,
    /// Width, tolerance or step size.
    grain: f64,
    error: f64,
    seconds: f64,
    status: &'static str,
}

/// What a sweep measured.
struct Measured {
    sweep: Sweep,
    points: Vec<Point>,
    order: Option<f64>,
}

fn sweeps() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for (scheme, group, title) in [
        (SchemeName::RadauIia, Group::Radau, "FESD Radau"),
        (SchemeName::GaussLegendre, Group::Gauss, "FESD Gauss"),
    ] {
        for no_exit_condition in [false, true] {
            for stages in 1..=4 {
                let exit = if no_exit_condition { ", no exit" } else { "" };
                sweeps.push(Sweep {
                    name: format!("{title}-{stages}{exit}"),
                    colour: stages - 1,
                    dashed: no_exit_condition,
                    group,
                    settings: FINITE_ELEMENTS
                        .iter()
                        .map(|&steps| MethodArguments {
                            scheme: Some(scheme),
                            stages: Some(stages),
                            steps: Some(steps),
                            elements: Some(1),
                            no_exit_condition,
                            ..MethodArguments::default()
                        })
                        .collect(),
                });
            }
        }
    }
    let controlled = [
        (
            "FESD Radau-6, controlled",
            MethodArguments {
                stages: Some(6),
                steps: Some(5),
                ..MethodArguments::default()
            },
        ),
        (
            "event-driven",
            MethodArguments {
                method: Method::Event,
                ..MethodArguments::default()
            },
        ),
    ];
    for (colour, (name, arguments)) in controlled.into_iter().enumerate() {
        let with_tolerance = |&tolerance| MethodArguments {
            tolerance: Some(tolerance),
            ..arguments.clone()
        };
        sweeps.push(Sweep {
            name: name.to_owned(),
            colour: 4 + colour,
            dashed: false,
            group: Group::Others,
            settings: TOLERANCES.iter().map(with_tolerance).collect(),
        });
    }
    for (colour, method, name) in [
        (6, Method::Moreau, "Moreau-Jean"),
        (7, Method::Fixed, "fixed steps"),
    ] {
        let with_steps = |&steps| MethodArguments {
            method,
            steps: Some(steps),
            ..MethodArguments::default()
        };
        sweeps.push(Sweep {
            name: name.to_owned(),
            colour,
            dashed: false,
            group: Group::Others,
            settings: TIME_STEPS.iter().map(with_steps).collect(),
        });
    }
    let with_width = |&width: &f64| MethodArguments {
        method: Method::Smooth,
        width: Some(width),
        tolerance: Some(width * SMOOTHED_TOLERANCE),
        ..MethodArguments::default()
    };
    sweeps.push(Sweep {
        name: "smoothed".to_owned(),
        colour: 8,
        dashed: false,
        group: Group::Others,
        settings: WIDTHS.iter().map(with_width).collect(),
    });
    sweeps
}

pub(super) fn run(arguments: &ChartArguments) -> Result<Report, BadInput> {
    let chosen: Vec<ChosenScene> = match &arguments.scene {
        Some(name) => vec![ChosenScene::new(name, &arguments.settings)?],
        None => scenes()
            .iter()
            .map(|scene| ChosenScene::new(scene.name, &[]))
            .collect::<Result<_, _>>()?,
    };
    let problems = chosen
        .iter()
        .map(|chosen| {
            let model = chosen.model.as_ref();
            InitialValueProblem::of(model, None)
                .and_then(|problem| problem.check(model).map(|()| problem))
                .map_err(|error| chosen.refuse(&error))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let directory = OutputDirectory::open(&arguments.out)?;
    let mut report = Report::default();
    let mut files = Vec::new();
    for (chosen, problem) in chosen.iter().zip(&problems) {
        chart(chosen, problem, &mut report, &mut files)?;
    }
    for path in directory.write(&files)? {
        let _ = writeln!(report.text, "wrote {}", path.display());
    }
    Ok(report)
}

fn chart(
    chosen: &ChosenScene,
    problem: &InitialValueProblem,
    report: &mut Report,
    files: &mut Vec<(String, String)>,
) -> Result<(), BadInput> {
    let exact = MethodArguments {
        method: Method::Event,
        tolerance: Some(EXACT_TOLERANCE),
        ..MethodArguments::default()
    };
    let exact = ChosenMethod::from_arguments(&exact)?
        .simulate(chosen.model.as_ref(), problem, &mut |_| {})
        .map_err(|error| chosen.refuse(&error))?;
    let (SimulationStatus::Solved, Some(reference)) = (&exact.status, exact.trajectory.q.last())
    else {
        report.diagnoses.extend(diagnosis_line(chosen, &exact));
        return Ok(());
    };

    let sweeps = sweeps();
    let mut progress = Progress::new(chosen.scene.name, sweeps.len() as f64);
    let mut measured = Vec::with_capacity(sweeps.len());
    for (done, sweep) in sweeps.into_iter().enumerate() {
        let mut points = Vec::with_capacity(sweep.settings.len());
        for arguments in &sweep.settings {
            points.push(measure(chosen, problem, arguments, reference)?);
        }
        let ordered = sweep.ordered();
        measured.push(Measured {
            order: if ordered {
                order(&points, reference)
            } else {
                None
            },
            sweep,
            points,
        });
        progress.reach((done + 1) as f64);
    }
    drop(progress);

    let name = chosen.scene.name;
    let error = format!("largest error of a coordinate at {} s", problem.horizon);
    let header = header();
    let rows: Vec<Vec<String>> = measured.iter().map(Measured::row).collect();
    let _ = writeln!(
        report.text,
        "{name}: {error}, measured against event-driven integration at {EXACT_TOLERANCE:e}\n\n{}",
        table(header.clone(), rows.clone())
    );
    let figures = figures(&error, &measured);
    let data = csv(&error, &measured);
    let title = format!("{name}: error of every method");
    let page = Page {
        title: title.clone(),
        introduction: format!(
            "The {error} (parameters: {}), measured against event-driven integration at a \
             tolerance of {EXACT_TOLERANCE:e}. FESD Radau-3 is FESD with Radau IIA and 3 stages; \
             dashed lines and `no exit` mean: without the condition that ends a contact where its \
             force vanishes. Controlled: the elements get the length that \
             a tolerance allows. Fixed steps are Runge-Kutta steps without switch detection; \
             the order of the smoothed method is that in the width of its step functions.",
            chosen.parameters().join(", ")
        ),
        sections: vec![Section {
            heading: "Orders and prices".to_owned(),
            text: "The order is the slope over the finest points above rounding; the prices are \
                the CPU times of the first run with an error of at most the value above the column."
                .to_owned(),
            animation: None,
            figures: figures.iter().map(|(_, svg)| svg.clone()).collect(),
            header,
            rows,
            files: vec![(
                format!("chart-{name}.csv"),
                "all measured points".to_owned(),
            )],
        }],
    };
    files.push((format!("chart-{name}.csv"), data));
    for (kind, svg) in figures {
        files.push((format!("chart-{name}-{kind}.svg"), svg));
    }
    files.push((format!("chart-{name}.html"), page.html()));
    Ok(())
}

fn measure(
    chosen: &ChosenScene,
    problem: &InitialValueProblem,
    arguments: &MethodArguments,
    reference: &[f64],
) -> Result<Point, BadInput> {
    let method = ChosenMethod::from_arguments(arguments)?;
    let simulation = fastest(chosen, &method, problem).map_err(|error| chosen.refuse(&error))?;
    let solved = simulation.status == SimulationStatus::Solved;
    let last = simulation.trajectory.q.last().filter(|_| solved);
    let error = last.map_or(f64::NAN, |q| {
        let errors = q.iter().zip(reference).map(|(a, b)| (a - b).abs());
        errors.fold(0.0, f64::max)
    });
    let settings = &method.settings;
    let step = settings.steps().map(|steps| problem.horizon / steps as f64);
    Ok(Point {
        arguments: settings.to_string(),
        grain: settings
            .width()
            .or(settings.tolerance())
            .or(step)
            .unwrap_or(f64::NAN),
        error,
        seconds: simulation.seconds.total,
        status: simulation.status.name(),
    })
}

/// Slope of the logarithms of error and step size over the finest points above rounding.
fn order(points: &[Point], reference: &[f64]) -> Option<f64> {
    let scale = reference
        .iter()
        .fold(1.0_f64, |scale, q| scale.max(q.abs()));
    let above: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point.error > ROUNDING * scale)
        .map(|point| (point.grain.ln(), point.error.ln()))
        .collect();
    let finest = &above[above.len().checked_sub(SLOPE_POINTS)?..];
    let mean = |values: &dyn Fn(&(f64, f64)) -> f64| {
        finest.iter().map(values).sum::<f64>() / finest.len() as f64
    };
    let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
    let covariance: f64 = finest
        .iter()
        .map(|point| (point.0 - x) * (point.1 - y))
        .sum();
    let variance: f64 = finest.iter().map(|point| (point.0 - x).powi(2)).sum();
    Some(covariance / variance)
}

fn header() -> Vec<String> {
    let mut header: Vec<String> = ["method", "order", "smallest error", "its CPU time"]
        .map(str::to_owned)
        .into();
    header.extend(TARGETS.map(|target| format!("CPU for {target:.0e}")));
    header.push("not solved".to_owned());
    header
}

impl Measured {
    fn row(&self) -> Vec<String> {
        let none = || "-".to_owned();
        let solved = || self.points.iter().filter(|point| point.error.is_finite());
        let best = solved().min_by(|a, b| a.error.total_cmp(&b.error));
        let price = |target: f64| {
            solved()
                .filter(|point| point.error <= target)
                .map(|point| point.seconds)
                .min_by(f64::total_cmp)
                .map_or_else(none, seconds)
        };
        let mut row = vec![
            self.sweep.name.clone(),
            self.order.map_or_else(none, |order| format!("{order:.2}")),
            best.map_or_else(none, |point| format!("{:.1e}", point.error)),
            best.map_or_else(none, |point| seconds(point.seconds)),
        ];
        row.extend(TARGETS.map(price));
        row.push((self.points.len() - solved().count()).to_string());
        row
    }

    fn curve(&self, x: impl Fn(&Point) -> f64) -> Curve {
        Curve {
            name: self.sweep.name.clone(),
            colour: self.sweep.colour,
            dashed: self.sweep.dashed,
            points: self
                .points
                .iter()
                .map(|point| (x(point), point.error))
                .collect(),
        }
    }
}

/// The figures, as (kind, SVG).
fn figures(error: &str, measured: &[Measured]) -> Vec<(&'static str, String)> {
    let of = |keep: &dyn Fn(&Sweep) -> bool, x: &dyn Fn(&Point) -> f64| -> Vec<Curve> {
        let kept = measured.iter().filter(|measured| keep(&measured.sweep));
        kept.map(|measured| measured.curve(x)).collect()
    };
    let step = |point: &Point| point.grain;
    vec![
        (
            "radau-iia",
            log_log(
                "FESD, Radau IIA",
                "step size [s]",
                error,
                &of(&|sweep| sweep.group == Group::Radau, &step),
            ),
        ),
        (
            "gauss-legendre",
            log_log(
                "FESD, Gauss-Legendre",
                "step size [s]",
                error,
                &of(&|sweep| sweep.group == Group::Gauss, &step),
            ),
        ),
        (
            "step-size",
            log_log(
                "Error against step size",
                "step size [s]",
                error,
                &of(
                    &|sweep| sweep.group != Group::Gauss && !sweep.dashed && sweep.stepped(),
                    &step,
                ),
            ),
        ),
        (
            "cpu-time",
            log_log(
                "Error against CPU time",
                "CPU time [s]",
                error,
                &of(
                    &|sweep| sweep.group != Group::Gauss && !sweep.dashed,
                    &|point| point.seconds,
                ),
            ),
        ),
    ]
}

fn csv(error: &str, measured: &[Measured]) -> String {
    let header = [
        "method",
        "settings",
        "step size [s], tolerance or width",
        error,
        "CPU time [s]",
        "status",
    ];
    csv_text(
        &header.map(str::to_owned),
        measured.iter().flat_map(|measured| {
            measured.points.iter().map(|point| {
                let error = if point.error.is_finite() {
                    point.error.to_string()
                } else {
                    String::new()
                };
                vec![
                    measured.sweep.name.clone(),
                    point.arguments.clone(),
                    point.grain.to_string(),
                    error,
                    point.seconds.to_string(),
                    point.status.to_owned(),
                ]
            })
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::{Point, order};

    #[test]
    fn order_of_a_cubic_error_is_three_and_rounding_is_left_out() {
        let point = |grain: f64, error: f64| Point {
            arguments: String::new(),
            grain,
            error,
            seconds: 1.0,
            status: "solved",
        };
        let cubic = |grain: f64| point(grain, 0.5 * grain.powi(3));
        let points = [
            cubic(0.1),
            cubic(0.05),
            cubic(0.01),
            point(0.001, 1e-13),
            point(0.0001, f64::NAN),
        ];
        let order = order(&points, &[1.0]).unwrap();
        // Three exact powers: the slope is three up to rounding of the logarithms.
        assert!((order - 3.0).abs() < 1e-12, "{order}");
        assert_eq!(super::order(&points[2..], &[1.0]), None);
    }
}
