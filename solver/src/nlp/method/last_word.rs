//! What a run that gave up says of a feasible point whose multipliers are huge.
//!
//! Where rows depend on each other multipliers are not unique, and those of the iterates may grow along the directions that
//! cancel until they drown the residual. Where a constraint qualification fails there are none. Either way Newton's
//! method ends without a step that means anything, at a point that may well be the solution.

use super::main_loop;
use super::polish::{polish, restore};
use super::state::{Outcome, State};
use super::stop::{LARGEST_MULTIPLIER, is_in_cone, is_solution, largest_multiplier};
use crate::linalg::norms::norm_inf;
use crate::nlp::Status;
use crate::nlp::program::residuals::SCALE_MAX;

/// Average multiplier, in units of the one that the error is not scaled by, beyond which the test of the error says nothing.
const LARGEST_SCALE: f64 = 1e4 / SCALE_MAX;

/// Hessian of rows with larger multipliers than that, beyond which these do not exist: that of `x^2 = 0` is the inverse of the
/// distance to the solution.
pub(crate) const LARGEST_CURVATURE: f64 = 100.0;

/// Change of the objective by a violation within the tolerance, relative to its gradient, from which on multipliers are suspect.
const SENSITIVE: f64 = 1e-2;

/// The outcome of a run, judged once more where it gave up at a feasible point: solved with the smallest multipliers that fit,
/// or degenerate where multipliers diverged.
pub(super) fn last_word(state: &mut State<'_, '_, '_, '_>, outcome: Outcome) -> Outcome {
    if outcome.status == Status::Solved && !outcome.left && grows_with_curvature(state) {
        return state.outcome(Status::Degenerate);
    }
    let gave_up = matches!(
        outcome.status,
        Status::StepTooSmall
            | Status::Acceptable
            | Status::Degenerate
            | Status::FactorizationFailed
            | Status::RestorationFailed
    );
    if !gave_up || !state.problem.products.is_empty() {
        return outcome;
    }
    let settings = &state.core.settings;
    let (tolerance, acceptable) = (settings.tolerance, settings.acceptable_tolerance);
    // not a number is not feasible
    let feasible = state.unscaled_infeasibility() <= settings.constraint_tolerance
        && state.point.values.infeasibility() <= acceptable;
    if !feasible {
        return outcome;
    }
    let diverged = diverged(state);
    if diverged && is_solved(state, 100.0 * tolerance) {
        return state.outcome(Status::Solved);
    }
    if diverged && let Some(outcome) = go_on_with_smallest(state) {
        return outcome;
    }
    if state.core.settings.persistent
        && let Some(outcome) = take_fitting(state)
    {
        return outcome;
    }
    // an error in the scale of multipliers that grow falls without end
    if state.core.settings.persistent
        && !diverged
        && let Some(outcome) = polish(state)
    {
        return outcome;
    }
    match outcome.status {
        Status::RestorationFailed if state.error(0.0).scaled() <= acceptable => {
            state.outcome(Status::Acceptable)
        }
        _ if !diverged => outcome,
        // without huge multipliers in the measure it would be as good
        Status::Acceptable if is_small(state, 100.0 * acceptable) => outcome,
        _ => state.outcome(Status::Degenerate),
    }
}

/// Solved with the multipliers that fit the gradient best, at the point or on the bounds near it, where these pass the test.
fn take_fitting(state: &mut State<'_, '_, '_, '_>) -> Option<Outcome> {
    let before = state.point.iterate.clone();
    let bounds = (state.problem.lower.clone(), state.problem.upper.clone());
    for snap in [false, true] {
        if snap && !state.snap_to_bounds() {
            break;
        }
        state.fit_multipliers();
        if is_solution(state, &state.error(0.0)) {
            return Some(state.outcome(Status::Solved));
        }
    }
    (state.problem.lower, state.problem.upper) = bounds;
    restore(state, &before);
    None
}

/// Goes on with the smallest multipliers that fit, where these are moderate and all but pass the test: the others may have
/// kept the point from its last digits. `None` leaves everything as it was.
fn go_on_with_smallest(state: &mut State<'_, '_, '_, '_>) -> Option<Outcome> {
    let before = state.point.iterate.clone();
    state.estimate_dependent_multipliers(LARGEST_MULTIPLIER);
    state.update_lagrangian();
    let settings = &state.core.settings;
    let left = settings.maximum_iterations > state.core.iterations;
    if left && is_small(state, settings.acceptable_tolerance) && !diverged(state) {
        state.progress.stalls = 0;
        state.progress.degenerate = 0;
        state.progress.acceptable = 0;
        state.level.tiny_steps = 0;
        state.shifts.floor = 0.0;
        state.globalization.filter.clear();
        // the same point is about to be recorded with its new multipliers
        state.core.history.pop();
        let outcome = main_loop::run(state, None);
        if matches!(
            outcome.status,
            Status::Solved | Status::Interrupted | Status::TimeLimit | Status::IterationLimit
        ) {
            return Some(outcome);
        }
    }
    restore(state, &before);
    None
}

/// Whether the point passes the test with the present multipliers, which exist, by its unscaled residuals too.
fn is_solved(state: &mut State<'_, '_, '_, '_>, absolute: f64) -> bool {
    state.error(0.0).scaled() <= state.core.settings.tolerance
        && is_small(state, absolute)
        && is_in_cone(state)
        && multipliers_exist(state)
}

/// Whether a point that passes the test owes that to multipliers that grow as it nears the solution: they are so large that a
/// violation within the tolerance changes the objective by a hundredth of its gradient, and with them the curvature of the rows
/// drowns that of the objective. Multipliers that are large because a row has tiny derivatives bring no such curvature.
fn grows_with_curvature(state: &mut State<'_, '_, '_, '_>) -> bool {
    // runs for complementarity problems weigh their objectives, and judge multipliers themselves
    if !state.core.settings.persistent {
        return false;
    }
    let size = norm_inf(&state.point.gradient).max(1.0);
    let large = SENSITIVE / state.core.settings.tolerance;
    if norm_inf(&state.point.iterate.y) <= large * size || !state.problem.products.is_empty() {
        return false;
    }
    let core = &mut *state.core;
    let iterate = &state.point.iterate;
    let curvature = core.kkt.row_curvature(&mut core.formulation, iterate);
    curvature > LARGEST_CURVATURE * size
}

/// Whether the multipliers of the rows are those of a solution. Huge ones are where they only make up for a row of tiny
/// derivatives, so that neither what a row adds to the gradient of the Lagrangian nor what all rows add to its Hessian
/// is huge. Where multipliers diverge since the gradient of a row vanishes at the solution, its curvature does not.
fn multipliers_exist(state: &mut State<'_, '_, '_, '_>) -> bool {
    let y = &state.point.iterate.y;
    if norm_inf(y) <= largest_multiplier(state) || !state.problem.products.is_empty() {
        return true;
    }
    let core = &mut *state.core;
    let values = core.kkt.jacobian_values.iter();
    let entries = core.formulation.jacobian_entries().zip(values);
    let largest = entries.fold(0.0, |largest: f64, ((row, _), a)| {
        largest.max((a * y[row]).abs())
    });
    if largest > LARGEST_MULTIPLIER {
        return false;
    }
    let curvature = core
        .kkt
        .row_curvature(&mut core.formulation, &state.point.iterate);
    curvature <= LARGEST_CURVATURE
}

/// Whether multipliers are beyond what scaled gradients of at most 100 call for.
fn diverged(state: &State<'_, '_, '_, '_>) -> bool {
    let iterate = &state.point.iterate;
    let multipliers = [&iterate.y, &iterate.z_lower, &iterate.z_upper];
    let largest = multipliers
        .map(|of| norm_inf(of))
        .into_iter()
        .fold(0.0, f64::max);
    largest > largest_multiplier(state) || state.error(0.0).dual_scale > LARGEST_SCALE
}

/// Whether the unscaled residuals of the optimality conditions are below `limit`.
fn is_small(state: &State<'_, '_, '_, '_>, limit: f64) -> bool {
    let error = state.error(0.0);
    error.dual <= limit && error.complementarity <= limit
}
