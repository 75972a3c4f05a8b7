//! Runs again where the scale that the objective got at the start hides what is left at the end.
//!
//! The objective is scaled by its gradient at the start. Where that is far steeper than the solution is, as for `exp(x)`
//! from `x = 30`, any point on the way that is flat enough passes the test in that scale, though the gradient of the
//! user's objective is far from zero. Such a run goes on in the scale of the point where it stopped, until scale and point
//! belong together.

use super::method::barrier::Monotone;
use super::program::scaling::row_scaling;
use super::run::{Ended, Start, run_after};
use super::{NlpProblem, Observer, Products, Residuals, Settings, Solution, Status, WarmStart};

/// How much larger the scale at the end has to be for another run. What a smaller ratio hides is of the size of the tolerance;
/// scales lie between 1e-8 and 1, so that there are at most eight runs.
const RATIO: f64 = 10.0;
const MOST_RUNS: usize = 8;

/// Residuals that may stay hidden, relative to the tolerance: as large as a run with large multipliers may leave them; of
/// complementarity also this part of the objective, which it bounds the error of.
const ABSOLUTE: f64 = 100.0;
const GAP: f64 = 0.1;

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
    for _ in 0..MOST_RUNS {
        let Some(needed) = hidden(problem, settings, &solution, ended.scale) else {
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
            ..settings.clone()
        };
        let mut path = Monotone {
            mu: warm.barrier_parameter,
            sigma: 0.0,
            tolerance: settings.tolerance,
        };
        let tied = (&mut Products::default(), &mut path as &mut _);
        let mut see = |info: &super::IterationInfo| observer(info);
        let next = run_after(
            problem,
            &near,
            tied,
            Start::Warm(&warm),
            Some(&mut see),
            Some(solution.clone()),
        );
        match next {
            Ok(next) => {
                (solution, ended) = next;
                went_on = true;
            }
            // the functions have no value that near
            Err(_) => break,
        }
    }
    // a residual that no step lowers is rounding, and nothing is hidden
    if went_on && ended.is_close {
        solution.status = Status::Solved;
    } else if hidden(problem, settings, &solution, ended.scale).is_some() {
        solution.status = Status::StepTooSmall;
    }
    solution
}

/// The scale that the objective would get at a solution, if in that one residuals are left that the scale of its run hides.
fn hidden(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    solution: &Solution,
    scale: f64,
) -> Option<f64> {
    // nothing is hidden by a scale of 1
    if solution.status != Status::Solved || RATIO * scale > 1.0 {
        return None;
    }
    let n = solution.x.len();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let mut gradient = vec![0.0; n];
    problem.gradient(&solution.x, &mut gradient);
    let free = (0..n).filter(|&i| lower[i] != upper[i]);
    let largest = free.map(|i| gradient[i].abs()).fold(0.0, f64::max);
    let needed = row_scaling(largest);
    let Residuals {
        dual,
        complementarity,
        ..
    } = solution.residuals;
    let gap = GAP * settings.tolerance * needed * solution.objective.abs();
    let absolute = ABSOLUTE * settings.tolerance;
    let is_large = needed * dual > absolute || needed * complementarity > absolute.max(gap);
    let hides = needed >= RATIO * scale && is_large;
    hides.then_some(needed)
}
