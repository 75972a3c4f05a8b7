//! The unit in which an objective is measured, so that a program and its copy with the objective multiplied by any positive number are one.
//!
//! The method compares slopes, multipliers and products with numbers: the first barrier parameter, tolerances, what is huge. All of them
//! belong to an objective whose slopes have one size at the start; a constant that is added to it has no part in that.

use super::{NlpProblem, Settings};

/// Size of the slopes of an objective in its unit. Measured on the 155 problems of Hock and Schittkowski with a constraint qualification: from 0.5 to 1
/// between 1996 and 2076 iterations, and with less the last barrier is larger than a millionth of the optimum.
const SLOPE: f64 = 0.7;

/// Slope, relative to the largest one, that is rounding.
const ROUNDING: f64 = 1e-10;

/// Multiples of it fill the interval from 0 to 1 evenly.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// Which slopes count.
pub(crate) struct Slopes {
    /// Distances of the points where they are taken, each from the one before, relative to the point and at least absolute, and weights there.
    points: &'static [(f64, f64)],
    /// Share of the variables whose slopes are no larger than the one that counts.
    quantile: f64,
}

impl Slopes {
    /// Those at the start of a run: there, where they may vanish; as far as runs stay away from bounds at first; and far away, for a start where
    /// the objective is flat. Single steep variables leave the others their digits. Chosen: the upper quartile, and a weight that a slope
    /// elsewhere exceeds unless it is a ten thousandth.
    pub(crate) const START: Self = Self {
        points: &[(0.0, 1.0), (1e-2, 1.0), (1.0, 1e-4)],
        quantile: 0.75,
    };

    /// Those at its end, and around it, as they vanish where nothing else holds the point.
    pub(super) const END: Self = Self {
        points: &[(0.0, 1.0), (1.0, 1.0)],
        quantile: 1.0,
    };
}

/// The unit of the objective of a problem by its slopes from a point on, the start of the problem if `None`; 1 where it has none.
pub(crate) fn objective_unit(
    problem: &mut dyn NlpProblem,
    from: Option<&[f64]>,
    taken: &Slopes,
) -> f64 {
    let n = problem.variables();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let mut x = vec![0.0; n];
    match from {
        Some(from) if from.len() == n => x.copy_from_slice(from),
        Some(_) => return 1.0,
        None => problem.initial_point(&mut x),
    }
    let (mut slopes, mut gradient) = (vec![0.0_f64; n], vec![0.0; n]);
    for &(distance, weight) in taken.points {
        for (i, x) in x.iter_mut().enumerate() {
            let share = (i as f64 * GOLDEN_RATIO).fract() - 0.5;
            let moved = *x + distance * share * x.abs().max(1.0);
            *x = moved.max(lower[i]).min(upper[i]);
        }
        problem.gradient(&x, &mut gradient);
        if gradient.iter().all(|g| g.is_finite()) {
            for i in (0..n).filter(|&i| lower[i] < upper[i]) {
                slopes[i] = slopes[i].max(weight * gradient[i].abs());
            }
        }
    }
    let largest = slopes.iter().copied().fold(0.0, f64::max);
    slopes.retain(|slope| *slope > ROUNDING * largest);
    slopes.sort_by(f64::total_cmp);
    let last = slopes.len().saturating_sub(1) as f64;
    let slope = slopes.get((taken.quantile * last) as usize);
    unit_of(slope.copied().unwrap_or(0.0))
}

/// Settings with the unit of the objective of a problem, measured from a point on if nobody gave it.
pub(super) fn measured(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    from: Option<&[f64]>,
) -> Settings {
    let unit = settings.objective_unit;
    Settings {
        objective_unit: unit.or_else(|| Some(objective_unit(problem, from, &Slopes::START))),
        ..settings.clone()
    }
}

/// The unit of an objective with a slope; 1 for none.
pub(super) fn unit_of(slope: f64) -> f64 {
    let unit = slope / SLOPE;
    if unit.is_normal() && (1.0 / unit).is_normal() {
        unit
    } else {
        1.0
    }
}
