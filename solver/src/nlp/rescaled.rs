//! Runs again where the scale that the objective got at the start hides what is left at the end.
//!
//! The objective is measured by its slopes at the start. Where these are far steeper than at the solution, as for `exp(x) - x`
//! from `x = 30`, any point on the way that is flat enough passes the test in that unit, though the gradient of the
//! objective is far from what is zero there. Such a run goes on in the unit of the point where it stopped, until unit and point
//! belong together.
//!
//! The same goes for the units of variables. Where `1e-9 x + 1e9 y` is least on `x y >= 1`, a residual of 1e-3 is nothing beside the gradient
//! of 1e9, but times `x = 1e10` it is more than the objective itself. What a residual times the size of its variable, and a multiplier
//! times the distance of its bound, leave of the objective has no unit: where that is much, the run goes on with the
//! variables in units of their own size.

use super::method::barrier::Monotone;
use super::objective_unit::{Slopes, objective_unit, unit_of};
use super::program::scaling::row_scaling;
use super::run::{Ended, Start, run_after};
use super::{
    NlpProblem, Observer, Products, Residuals, Settings, Solution, Status, Variant, WarmStart,
};
use crate::linalg::norms::norm_inf;

/// How much larger the scale at the end has to be for another run, and most runs. What a smaller ratio hides is of the size of the tolerance.
const RATIO: f64 = 10.0;
const MOST_RUNS: usize = 8;

/// Residuals that may stay hidden, relative to the tolerance: as large as a run with large multipliers may leave them; of
/// complementarity also this part of the objective, which it bounds the error of.
const ABSOLUTE: f64 = 100.0;
const GAP: f64 = 0.1;

/// Share of the terms of the objective that may be left of it by residuals times the sizes of their variables: far above what the
/// tolerance leaves where variables are of size one, and the least that anybody reads off an objective.
const LEFT: f64 = 1e-4;
/// Sizes of variables that need no unit of their own.
const ORDINARY: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// Least distance from bounds of the point that a run goes on from.
const BOUND_PUSH: f64 = 1e-9;

/// The solution of the last of the runs that follow `first`, a run and the scale of its objective; it is not called solved
/// if the scale still hides a residual.
pub(super) fn rescaled(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    first: (Solution, Ended),
) -> Solution {
    let (mut solution, mut ended) = first;
    let mut went_on = false;
    // of an objective that vanishes no digits are left to ask for
    let least = settings.tolerance * settings.tolerance / ended.scale;
    for _ in 0..MOST_RUNS {
        let Some((units, needed)) = hidden(problem, settings, &solution, (ended.scale, least))
        else {
            break;
        };
        let complementarity = needed * solution.residuals.complementarity;
        let warm = WarmStart {
            barrier_parameter: complementarity
                .min(settings.initial_barrier_parameter)
                .max(settings.tolerance),
            ..WarmStart::from_solution(&solution)
        };
        let near = Settings {
            bound_push: BOUND_PUSH,
            bound_fraction: BOUND_PUSH,
            objective_unit: settings.objective_unit.or(Some(1.0 / needed)),
            ..settings.clone()
        };
        let mut path = Monotone {
            mu: warm.barrier_parameter,
            sigma: 0.0,
            tolerance: settings.tolerance,
        };
        let tied = (&mut Products::default(), &mut path as &mut _);
        let mut see = |info: &super::IterationInfo| observer(info);
        let mut variant = Variant {
            units,
            ..Variant::of(&mut *problem)
        };
        let warm = in_units(&variant, warm);
        let next = run_after(
            &mut variant,
            &near,
            tied,
            Start::Warm(&warm),
            Some(&mut see),
            Some(solution.clone()),
        );
        match next {
            // what goes up from there leads to another solution, if to any
            Ok((next, _)) if rises(&variant, &next, &solution) => {
                solution.status = Status::StepTooSmall;
                add_work(&mut solution, &next);
                return solution;
            }
            Ok((next, its)) => {
                (solution, ended) = (in_problem(&mut variant, next), its);
                went_on = true;
            }
            // the functions have no value that near
            Err(_) => break,
        }
    }
    // a residual that no step lowers is rounding, and nothing is hidden
    if went_on && ended.is_close {
        solution.status = Status::Solved;
    } else if hidden(problem, settings, &solution, (ended.scale, least)).is_some() {
        solution.status = Status::StepTooSmall;
    }
    solution
}

/// Whether a run with variables in other units ended at a higher objective than the one before.
fn rises(of: &Variant<'_, dyn NlpProblem + '_>, next: &Solution, before: &Solution) -> bool {
    !of.units.is_empty()
        && next.objective > before.objective + LEFT * before.objective.abs().max(1.0)
}

/// Counts, times and log of a later run, which hold those before it.
pub(super) fn add_work(first: &mut Solution, later: &Solution) {
    first.history.clone_from(&later.history);
    first.counts = later.counts;
    first.cpu = later.cpu;
    first.seconds = later.seconds;
}

/// The units of the variables, none where ordinary ones do, and the scale of the objective that a solution asks for, if residuals are left that those of its run hide.
fn hidden(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    solution: &Solution,
    (scale, least): (f64, f64),
) -> Option<(Vec<f64>, f64)> {
    if solution.status != Status::Solved {
        return None;
    }
    let x = &solution.x;
    let ends = Ends::new(problem, solution);
    let Residuals {
        dual,
        complementarity,
        ..
    } = solution.residuals;
    let absolute = ABSOLUTE * settings.tolerance;
    let largest = |of: &mut dyn FnMut(usize) -> f64| (0..x.len()).map(of).fold(0.0, f64::max);
    let terms = largest(&mut |i| (ends.gradient[i] * x[i]).abs()) + solution.objective.abs();
    let unit = |i: usize| {
        let size = x[i].abs();
        // a variable without a bound there may be that small by chance
        let means = size > *ORDINARY.end() || size > 0.0 && ends.is_bounded[i];
        if means && !ORDINARY.contains(&size) {
            size
        } else {
            1.0
        }
    };
    let units: Vec<f64> = (0..x.len()).map(unit).collect();
    let has_units = |i: usize| units[i] != 1.0;
    let of_residuals = largest(&mut |i| {
        if has_units(i) {
            (ends.left[i] * x[i]).abs()
        } else {
            0.0
        }
    });
    let of_bounds = if (0..x.len()).any(has_units) {
        complementarity
    } else {
        0.0
    };
    let left = of_residuals.max(of_bounds);
    let is_measured = settings.objective_unit.is_some();
    // nothing is hidden by a scale of 1 in a unit that was chosen with care
    let (of_units, of_gap) = if is_measured {
        (absolute, absolute)
    } else {
        (least, RATIO * settings.tolerance)
    };
    if left > of_units.max(LEFT * terms) {
        let steepest = largest(&mut |i| (ends.gradient[i] * units[i]).abs());
        let measured = if is_measured {
            row_scaling(steepest)
        } else {
            1.0 / unit_of(steepest)
        };
        return Some((units, measured));
    }
    let needed = if is_measured {
        row_scaling(largest(&mut |i| ends.gradient[i].abs()))
    } else {
        1.0 / objective_unit(problem, Some(x), &Slopes::END)
    };
    let gap = GAP * settings.tolerance * needed * solution.objective.abs();
    let is_large = needed * dual > absolute || needed * complementarity > of_gap.max(gap);
    let hides = needed >= RATIO * scale && is_large;
    hides.then(|| (Vec::new(), needed))
}

/// What belongs to the variables at the end of a run, zero where they are fixed.
struct Ends {
    gradient: Vec<f64>,
    /// The gradient of the Lagrangian.
    left: Vec<f64>,
    /// Whether a bound lies as near to zero as the variable.
    is_bounded: Vec<bool>,
}

impl Ends {
    fn new(problem: &mut dyn NlpProblem, solution: &Solution) -> Self {
        let n = solution.x.len();
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        let mut gradient = vec![0.0; n];
        problem.gradient(&solution.x, &mut gradient);
        let mut left = gradient.clone();
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.jacobian_values(&solution.x, &mut values);
        for (&(row, column), a) in pattern.iter().zip(&values) {
            left[column] += a * solution.multipliers[row];
        }
        for i in 0..n {
            left[i] += solution.multipliers_upper[i] - solution.multipliers_lower[i];
            if lower[i] == upper[i] {
                (gradient[i], left[i]) = (0.0, 0.0);
            }
        }
        let at_zero = |i: usize| lower[i].abs().min(upper[i].abs()) <= solution.x[i].abs();
        Self {
            gradient,
            left,
            is_bounded: (0..n).map(at_zero).collect(),
        }
    }
}

/// A start in the units of a problem.
fn in_units(of: &Variant<'_, dyn NlpProblem + '_>, mut start: WarmStart) -> WarmStart {
    of.to_units(&mut start.x);
    of.per_unit(&mut start.multipliers_lower);
    of.per_unit(&mut start.multipliers_upper);
    start
}

/// A solution in the variables of the problem.
fn in_problem(of: &mut Variant<'_, dyn NlpProblem + '_>, mut solution: Solution) -> Solution {
    of.per_unit(&mut solution.x);
    of.to_units(&mut solution.multipliers_lower);
    of.to_units(&mut solution.multipliers_upper);
    if !of.units.is_empty() {
        solution.residuals.dual = norm_inf(&Ends::new(of.problem, &solution).left);
    }
    solution
}
