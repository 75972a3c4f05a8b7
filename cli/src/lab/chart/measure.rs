//! Runs of a method over its settings, and the order that their errors show.

use hangtime::simulation::{Counts, SimulationStatus};

use super::study::{Reference, Study, distance, reached, size};
use super::sweep::{SLOPE_POINTS, Sweep};
use crate::arguments::MethodArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::method::ChosenMethod;
use crate::table::seconds;
use crate::timing::{patience, repeated};

/// Errors below this share of the largest coordinate are rounding, and say nothing of an order.
const ROUNDING: f64 = 1e-12;
/// Errors have to be this many times the uncertainty of what they are measured against, to say something of an order.
const CERTAIN: f64 = 10.0;
/// CPU time after which a run is given up [s], and with it the finer ones of its method.
const PATIENCE: f64 = 2.0;

/// One measured run.
pub(super) struct Point {
    pub(super) arguments: String,
    /// Width, tolerance or step size.
    pub(super) grain: f64,
    pub(super) error: f64,
    /// CPU time of the fastest repetition [s].
    pub(super) seconds: f64,
    /// What half of the repetitions took at most [s]; not a number where that is not known.
    pub(super) half: f64,
    /// What it took, where that is known.
    pub(super) counts: Option<Counts>,
    pub(super) status: &'static str,
}

impl Point {
    /// What a pointer over it tells.
    pub(super) fn note(&self) -> String {
        let counts = self.counts.map_or_else(String::new, |counts| {
            format!(
                ", {} steps, {} Newton iterations, {} evaluations",
                counts.elements, counts.newton, counts.evaluations
            )
        });
        format!(
            "{}: error {:.1e}, {}{counts}",
            self.arguments,
            self.error,
            seconds(self.seconds)
        )
    }
}

/// What the errors of a method over step sizes show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    /// The slope of the errors.
    Slope(f64),
    /// All errors are rounding.
    Exact,
    /// Too few runs, or a method without an order.
    Unknown,
}

impl Order {
    /// For a table.
    pub(super) fn cell(self) -> String {
        match self {
            Self::Slope(order) => format!("{order:.2}"),
            Self::Exact => "exact".to_owned(),
            Self::Unknown => "-".to_owned(),
        }
    }
}

/// What a sweep measured.
pub(super) struct Measured {
    pub(super) sweep: Sweep,
    pub(super) points: Vec<Point>,
    pub(super) order: Order,
}

impl Measured {
    /// Runs a method over its settings, until `bounds` ask to end.
    pub(super) fn of(
        study: &Study,
        sweep: Sweep,
        reference: &Reference,
        bounds: &Bounds,
    ) -> Result<Self, BadInput> {
        let coordinates = if sweep.event_driven() {
            &reference.confirming
        } else {
            &reference.coordinates
        };
        let mut points = Vec::with_capacity(sweep.settings.len());
        for arguments in &sweep.settings {
            if bounds.asked().is_some() {
                break;
            }
            let point = measure(study, arguments, coordinates, bounds)?;
            let given_up = point.status == GIVEN_UP;
            points.push(point);
            if given_up {
                break;
            }
        }
        let floor = (ROUNDING * size(coordinates)).max(CERTAIN * reference.uncertainty);
        let order = if sweep.ordered() {
            order(&points, floor)
        } else {
            Order::Unknown
        };
        Ok(Self {
            sweep,
            points,
            order,
        })
    }

    /// The runs that solved.
    pub(super) fn solved(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| point.error.is_finite())
    }

    /// How many of its settings led to no error: runs that stopped, or were not begun after one that was given up.
    pub(super) fn unsolved(&self) -> usize {
        let asked = self.sweep.settings.len().max(self.points.len());
        asked - self.solved().count()
    }

    /// The cheapest run with an error of at most `target`.
    pub(super) fn cheapest(&self, target: f64) -> Option<&Point> {
        self.solved()
            .filter(|point| point.error <= target)
            .min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }
}

/// The status of a run that took too long.
const GIVEN_UP: &str = "given_up";

fn measure(
    study: &Study,
    arguments: &MethodArguments,
    reference: &[f64],
    bounds: &Bounds,
) -> Result<Point, BadInput> {
    let (chosen, problem) = (&study.chosen, &study.problem);
    let method = ChosenMethod::from_arguments(arguments)?;
    let settings = &method.settings;
    let elements = settings.elements.unwrap_or(1);
    let step = settings
        .steps
        .map(|steps| problem.horizon / (steps * elements) as f64);
    let grain = settings.width.or(settings.tolerance).or(step);
    let point = |error, [seconds, half]: [f64; 2], counts, status| Point {
        arguments: settings.to_string(),
        grain: grain.unwrap_or(f64::NAN),
        error,
        seconds,
        half,
        counts,
        status,
    };
    let patient = patience(PATIENCE);
    let runs = match repeated(chosen, &method, problem, &|| {
        bounds.asked().is_none() && patient()
    }) {
        Ok(runs) => runs,
        // A method that does not know restitution or friction is left out, not a mistake of the user.
        Err(error) if error.is_unsupported() => {
            return Ok(point(f64::NAN, [f64::NAN; 2], None, "not_applicable"));
        }
        Err(error) => return Err(chosen.refuse(&error)),
    };
    let simulation = runs.fastest;
    let error = reached(&simulation).map_or(f64::NAN, |end| distance(&end, reference));
    let status = match simulation.status {
        SimulationStatus::Interrupted(_) if bounds.asked().is_none() => GIVEN_UP,
        _ => simulation.status.name(),
    };
    Ok(point(
        error,
        [simulation.seconds.total, runs.half],
        Some(simulation.counts),
        status,
    ))
}

/// Slope of the logarithms of error and step size over the finest points above `floor`.
fn order(points: &[Point], floor: f64) -> Order {
    let solved = || points.iter().filter(|point| point.error.is_finite());
    let above: Vec<(f64, f64)> = solved()
        .filter(|point| point.error > floor)
        .map(|point| (point.grain.ln(), point.error.ln()))
        .collect();
    if above.is_empty() && solved().count() >= SLOPE_POINTS {
        return Order::Exact;
    }
    let Some(first) = above.len().checked_sub(SLOPE_POINTS) else {
        return Order::Unknown;
    };
    let finest = &above[first..];
    let mean = |values: &dyn Fn(&(f64, f64)) -> f64| {
        finest.iter().map(values).sum::<f64>() / finest.len() as f64
    };
    let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
    let covariance: f64 = finest
        .iter()
        .map(|point| (point.0 - x) * (point.1 - y))
        .sum();
    let variance: f64 = finest.iter().map(|point| (point.0 - x).powi(2)).sum();
    Order::Slope(covariance / variance)
}

#[cfg(test)]
mod tests {
    use super::{Order, Point, order};

    fn point(grain: f64, error: f64) -> Point {
        Point {
            arguments: String::new(),
            grain,
            error,
            seconds: 1.0,
            half: 1.0,
            counts: None,
            status: "solved",
        }
    }

    #[test]
    fn order_of_a_cubic_error_is_three_and_rounding_is_left_out() {
        let cubic = |grain: f64| point(grain, 0.5 * grain.powi(3));
        let points = [
            point(0.2, 1.0),
            cubic(0.1),
            cubic(0.05),
            cubic(0.03),
            cubic(0.02),
            cubic(0.01),
            point(0.001, 1e-13),
            point(0.0001, f64::NAN),
        ];
        let Order::Slope(order) = order(&points, 1e-12) else {
            panic!("five points have a slope");
        };
        // Exact powers: the slope is three up to rounding of the logarithms.
        assert!((order - 3.0).abs() < 1e-12, "{order}");
        assert_eq!(super::order(&points[2..], 1e-12), Order::Unknown);
    }

    #[test]
    fn errors_that_are_all_rounding_are_exact() {
        let points = [0.1, 0.05, 0.03, 0.02, 0.01].map(|grain| point(grain, 1e-14));
        assert_eq!(order(&points, 1e-12), Order::Exact);
    }
}
