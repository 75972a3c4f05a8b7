//! What is tried where a run ends without a solution.
//!
//! A point that no direction lowers the violation from proves nothing about other points, unless all rows are linear. Such a run
//! is tried again with first steps that no test shortens, as the line search may have led there; then from points where
//! the sum of the squares of the violation vanishes, which is minimized from the first start and from points beside it, as its
//! ways differ from those of the sum of the violations that the restoration phase minimizes. A run that gave up is tried
//! once more with rows that give way a little: where they depend on each other, or all but do, the Newton matrix
//! is regular then, and multipliers stay bounded; and with a smaller first barrier parameter, which keeps nearer to the start.

use super::least_squares::{LeastSquares, violation};
use super::method::LARGEST_CURVATURE;
use super::method::barrier::Monotone;
use super::objective_unit::measured;
use super::rescaled::{add_work, rescaled};
use super::run::{Start, run_after};
use super::{IterationInfo, NlpProblem, Observer, Products, Settings, Solution, Status};
use crate::linalg::norms::norm_inf;

/// First steps without a test.
const UNTESTED: usize = 20;

/// Shift of the dual rows, relative to `mu^0.25`, that lets rows give way.
const YIELDING: f64 = 1e-5;

/// Points beside the first start that the least squares are minimized from, and how far they may lie, relative to the size of
/// the first start.
const BESIDE: usize = 12;

const DISTANCES: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// Most iterations of a further run.
const ITERATIONS: usize = 500;

/// The first solution that other runs lead to after `first`, which is the result where there is none; the work of all is added.
pub(super) fn second_round(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    mut first: Solution,
) -> Solution {
    match first.status {
        Status::Infeasible if !has_linear_rows(problem, &first.x) => {
            let untested = Settings {
                untested_steps: UNTESTED,
                ..settings.clone()
            };
            attempt(problem, &untested, Start::Own, observer, &mut first)
                .or_else(|| from_least_squares(problem, settings, observer, &mut first))
        }
        Status::StepTooSmall
        | Status::Acceptable
        | Status::Degenerate
        | Status::RestorationFailed
        | Status::FactorizationFailed
            if problem.constraints() > 0 =>
        {
            let yielding = Settings {
                permanent_dual_shift: YIELDING,
                ..settings.clone()
            };
            let near = Settings {
                initial_barrier_parameter: 1e-2 * settings.initial_barrier_parameter,
                ..settings.clone()
            };
            let diverged = first.status == Status::Degenerate;
            [yielding, near].iter().find_map(|settings| {
                let found = attempt(problem, settings, Start::Own, observer, &mut first)?;
                if diverged && is_curved(problem, &found) {
                    add_work(&mut first, &found);
                    return None;
                }
                Some(found)
            })
        }
        _ => None,
    }
    .unwrap_or(first)
}

/// The run from the first point found where the least squares of the violation, minimized from several starts, vanish.
fn from_least_squares(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    first: &mut Solution,
) -> Option<Solution> {
    let mut own = vec![0.0; problem.variables()];
    problem.initial_point(&mut own);
    let mut starts = vec![own.clone()];
    starts.extend((0..BESIDE).map(|k| beside(problem, &own, k)));
    starts.into_iter().find_map(|start| {
        let feasible = feasible_point(problem, settings, observer, &start, first)?;
        attempt(problem, settings, Start::Point(&feasible), observer, first)
    })
}

/// A point within the bounds at some distance from `x`, another one for each `k`.
fn beside(problem: &dyn NlpProblem, x: &[f64], k: usize) -> Vec<f64> {
    let n = x.len();
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let distance = DISTANCES[k % DISTANCES.len()];
    let bounds = lower.iter().zip(&upper);
    let values = x.iter().zip(bounds).enumerate();
    values
        .map(|(i, (x, (&lower, &upper)))| {
            let step = distance * x.abs().max(1.0) * (2.0 * fill(k * n + i + 1) - 1.0);
            (x + step).max(lower).min(upper)
        })
        .collect()
}

/// Numbers that fill the interval from 0 to 1 evenly.
fn fill(k: usize) -> f64 {
    const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
    (k as f64 * GOLDEN_RATIO).fract()
}

/// Where the least squares of the violation from `start` vanish.
fn feasible_point(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    observer: &mut Observer<'_>,
    start: &[f64],
    first: &mut Solution,
) -> Option<Vec<f64>> {
    let lines = first.history.len();
    let mut squares = LeastSquares::new(problem, start);
    let mut see = |info: &IterationInfo| {
        observer(&IterationInfo {
            restoration: true,
            ..*info
        })
    };
    // gradients of squares are small where the violation is
    let settings = &Settings {
        tolerance: settings.tolerance * settings.tolerance.sqrt(),
        ..settings.clone()
    };
    let mut least = run(&mut squares, settings, Start::Own, &mut see, first)?;
    add_work(first, &least);
    for info in &mut first.history[lines..] {
        info.restoration = true;
    }
    least.x.truncate(start.len());
    let weights = vec![1.0; problem.constraints()];
    let violation = violation(problem, &least.x, &weights);
    let largest = violation.iter().fold(0.0, |a: f64, r| a.max(r.abs()));
    (largest <= settings.constraint_tolerance).then_some(least.x)
}

/// Whether no row has a second derivative, at a point and beside it.
fn has_linear_rows(problem: &mut dyn NlpProblem, x: &[f64]) -> bool {
    let multipliers: Vec<f64> = (1..=problem.constraints()).map(|i| fill(i) + 1.0).collect();
    let mut hessian = vec![0.0; problem.hessian_pattern().len()];
    let points = [x.to_vec(), beside(problem, x, 0)];
    points.into_iter().all(|point| {
        problem.hessian_values(&point, 0.0, &multipliers, &mut hessian);
        norm_inf(&hessian) == 0.0
    })
}

/// Whether the rows' part of the Hessian of the Lagrangian is huge beside the gradient of the objective. Where multipliers diverge
/// since the gradient of a row vanishes at the solution, its curvature does not, and a row that gives way hides that only.
fn is_curved(problem: &mut dyn NlpProblem, solution: &Solution) -> bool {
    let mut hessian = vec![0.0; problem.hessian_pattern().len()];
    let mut gradient = vec![0.0; problem.variables()];
    problem.hessian_values(&solution.x, 0.0, &solution.multipliers, &mut hessian);
    problem.gradient(&solution.x, &mut gradient);
    norm_inf(&hessian) > LARGEST_CURVATURE * norm_inf(&gradient).max(1.0)
}

/// A run after `first`, if it ends with a solution; otherwise its work is added to that of `first`.
fn attempt(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    start: Start<'_>,
    observer: &mut Observer<'_>,
    first: &mut Solution,
) -> Option<Solution> {
    let found = run(problem, settings, start, observer, first)?;
    if found.status == Status::Solved {
        return Some(found);
    }
    add_work(first, &found);
    None
}

/// A run that goes on counting after `first`; `None` where functions have no value at its start.
fn run(
    problem: &mut dyn NlpProblem,
    settings: &Settings,
    start: Start<'_>,
    observer: &mut Observer<'_>,
    first: &Solution,
) -> Option<Solution> {
    let mut path = Monotone {
        mu: settings.initial_barrier_parameter,
        sigma: 0.0,
        tolerance: settings.tolerance,
    };
    let mut see = |info: &IterationInfo| observer(info);
    let tied = (&mut Products::default(), &mut path as &mut _);
    let earlier = Some(first.clone());
    let limit = first.counts.iterations + ITERATIONS;
    let settings = &Settings {
        maximum_iterations: settings.maximum_iterations.min(limit),
        ..settings.clone()
    };
    let in_unit = measured(problem, settings, None);
    let run = run_after(problem, &in_unit, tied, start, Some(&mut see), earlier).ok()?;
    Some(rescaled(problem, settings, observer, run))
}
