//! The error of every simulation method against its step size and its CPU time.

use hangtime::simulation::{InitialValueProblem, SimulationStatus};

use super::drawn::Chart;
use super::sweep::{Group, Sweep, sweeps};
use crate::arguments::{Method, MethodArguments};
use crate::bounds::{Bounds, Ending};
use crate::failure::BadInput;
use crate::figure::{Curve, log_log};
use crate::method::ChosenMethod;
use crate::page::Section;
use crate::progress::Progress;
use crate::settings::ChosenScene;
use crate::simulate::diagnosis_line;
use crate::spreadsheet::csv_text;
use crate::table::{seconds, table};
use crate::timing::{EXACT_TOLERANCE, fastest};

/// Errors whose price in CPU time is listed.
const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Errors below this share of the largest coordinate are rounding, and say nothing of an order.
const ROUNDING: f64 = 1e-12;
/// Points whose slope is the measured order: the finest ones above rounding.
const SLOPE_POINTS: usize = 3;

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

/// Measures every method on the simulation that the scene declares.
pub(super) fn chart(
    chosen: &ChosenScene,
    problem: &InitialValueProblem,
    bounds: &Bounds,
) -> Result<Chart, BadInput> {
    let exact = MethodArguments {
        method: Method::Event,
        tolerance: Some(EXACT_TOLERANCE),
        ..MethodArguments::default()
    };
    let exact = ChosenMethod::from_arguments(&exact)?
        .simulate(chosen.model.as_ref(), problem, &mut |_| {
            bounds.asked().is_none()
        })
        .map_err(|error| chosen.refuse(&error))?;
    let (SimulationStatus::Solved, Some(reference)) = (&exact.status, exact.trajectory.q.last())
    else {
        let ending = Ending::of_whole(&exact);
        // What asked a run to end is told once for all of them.
        let diagnosis =
            diagnosis_line(chosen, &exact, &ending).filter(|_| bounds.asked().is_none());
        return Ok(Chart {
            text: String::new(),
            section: None,
            files: Vec::new(),
            diagnoses: diagnosis.into_iter().collect(),
        });
    };

    let measured = measure_all(chosen, problem, reference, bounds)?;
    let name = chosen.scene.name;
    let error = format!("largest error of a coordinate at {} s", problem.horizon);
    let header = header();
    let rows: Vec<Vec<String>> = measured.iter().map(Measured::row).collect();
    let text = format!(
        "{name}: {error}, measured against event-driven integration at {EXACT_TOLERANCE:e}\n\n{}\n",
        table(header.clone(), rows.clone())
    );
    let figures = figures(&error, &measured);
    let mut files = vec![(format!("chart-{name}.csv"), csv(&error, &measured))];
    let section = Section {
        heading: "Simulation".to_owned(),
        text: format!(
            "The {error}, measured against event-driven integration at a tolerance of {EXACT_TOLERANCE:e}. \
             FESD Radau-3 is FESD with Radau IIA and 3 stages; dashed lines and `no exit` mean: without the \
             condition that ends a contact where its force vanishes. Controlled: the elements get the length that \
             a tolerance allows. Fixed steps are Runge-Kutta steps without switch detection; the order of the \
             smoothed method is that in the width of its step functions. The order is the slope over the finest \
             points above rounding; the prices are the CPU times of the first run with an error of at most the \
             value above the column."
        ),
        animation: None,
        figures: figures.iter().map(|(_, svg)| svg.clone()).collect(),
        header,
        rows,
        files: vec![(
            format!("chart-{name}.csv"),
            "all measured points".to_owned(),
        )],
    };
    files.extend(
        figures
            .into_iter()
            .map(|(kind, svg)| (format!("chart-{name}-{kind}.svg"), svg)),
    );
    Ok(Chart {
        text,
        section: Some(section),
        files,
        diagnoses: Vec::new(),
    })
}

/// Runs every method over its settings, until `bounds` ask to end.
fn measure_all(
    chosen: &ChosenScene,
    problem: &InitialValueProblem,
    reference: &[f64],
    bounds: &Bounds,
) -> Result<Vec<Measured>, BadInput> {
    let sweeps = sweeps();
    let mut progress = Progress::new(chosen.scene.name, sweeps.len() as f64);
    let mut measured = Vec::with_capacity(sweeps.len());
    for (done, sweep) in sweeps.into_iter().enumerate() {
        let mut points = Vec::with_capacity(sweep.settings.len());
        for arguments in &sweep.settings {
            if bounds.asked().is_some() {
                break;
            }
            let point = measure(chosen, problem, arguments, (reference, bounds))?;
            points.push(point);
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
    Ok(measured)
}

fn measure(
    chosen: &ChosenScene,
    problem: &InitialValueProblem,
    arguments: &MethodArguments,
    (reference, bounds): (&[f64], &Bounds),
) -> Result<Point, BadInput> {
    let method = ChosenMethod::from_arguments(arguments)?;
    let settings = &method.settings;
    let step = settings.steps().map(|steps| problem.horizon / steps as f64);
    let grain = settings.width().or(settings.tolerance()).or(step);
    let point = |error, seconds, status| Point {
        arguments: settings.to_string(),
        grain: grain.unwrap_or(f64::NAN),
        error,
        seconds,
        status,
    };
    let simulation = match fastest(chosen, &method, problem, &|| bounds.asked().is_none()) {
        Ok(simulation) => simulation,
        // A method that does not know restitution or friction is left out, not a mistake of the user.
        Err(error) if error.is_unsupported() => {
            return Ok(point(f64::NAN, f64::NAN, "not_applicable"));
        }
        Err(error) => return Err(chosen.refuse(&error)),
    };
    let solved = simulation.status == SimulationStatus::Solved;
    let last = simulation.trajectory.q.last().filter(|_| solved);
    let error = last.map_or(f64::NAN, |q| {
        let errors = q.iter().zip(reference).map(|(a, b)| (a - b).abs());
        errors.fold(0.0, f64::max)
    });
    let name = simulation.status.name();
    Ok(point(error, simulation.seconds.total, name))
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
