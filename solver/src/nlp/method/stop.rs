//! When a run ends, and the log.

use super::state::State;
use crate::linalg::norms::norm_inf;
use crate::nlp::Status;
use crate::nlp::cone::{Cone, OFF_CONE};
use crate::nlp::program::residuals::OptimalityError;
use crate::nlp::program::scaling::GRADIENT;

/// Multipliers of the scaled problem, whose gradients are at most 100, beyond which none seem to exist.
pub(super) const LARGEST_MULTIPLIER: f64 = 1e8;

/// Size of a point beyond which the objective seems unbounded where this many steps in a row lower it below this value, and
/// the size beyond which it seems so in any case. Rows of size 1 have no digits left where their terms are beyond 1e16.
const FAR: f64 = 1e12;
const FAR_STEPS: usize = 15;
const VERY_NEGATIVE: f64 = 1e10;
pub(super) const FARTHEST: f64 = 1e20;

/// Writes the line of the log; `false` if the observer asks to stop.
pub(super) fn record(state: &mut State<'_, '_, '_, '_>, error: &OptimalityError) -> bool {
    state.info.iteration = state.core.iterations;
    state.info.restoration = state.is_restoration;
    state.info.objective = if state.is_restoration {
        state.point.values.objective
    } else {
        state.point.values.objective / state.core.formulation.objective_scale
    };
    state.info.primal_infeasibility = error.primal;
    state.info.dual_infeasibility = error.dual;
    state.info.complementarity = error.complementarity;
    state.info.barrier_parameter = state.mu;
    state.info.relaxation_parameter = state.sigma;
    state.core.history.push(state.info);
    match state.core.observer.as_mut() {
        Some(observer) => observer(&state.info),
        None => true,
    }
}

/// How a run far from the origin ends, if it does.
fn divergence(state: &mut State<'_, '_, '_, '_>) -> Option<Status> {
    let size = norm_inf(&state.point.iterate.v);
    if size <= FAR {
        state.progress.far_steps = 0;
        return None;
    }
    if !state.problem.products.is_empty() {
        return (size > FARTHEST).then_some(Status::Diverging);
    }
    // the violation may fall from any distance
    if state.is_restoration {
        return None;
    }
    let formulation = &state.core.formulation;
    let factor = formulation.objective_scale * formulation.objective_unit;
    let objective = state.point.values.objective / factor;
    let falls = objective < -VERY_NEGATIVE && objective < state.progress.far_objective;
    state.progress.far_steps = if falls {
        state.progress.far_steps + 1
    } else {
        0
    };
    state.progress.far_objective = objective;
    let ends = size > FARTHEST || state.progress.far_steps >= FAR_STEPS;
    (ends && state.is_feasible_to_rounding()).then_some(Status::Diverging)
}

/// Whether the scaled error and the violation in the user's units are within their tolerances.
fn passes(state: &State<'_, '_, '_, '_>, error: &OptimalityError) -> bool {
    let settings = &state.core.settings;
    error.scaled() <= settings.tolerance
        && state.sigma <= state.path.final_sigma()
        && (state.is_restoration || state.unscaled_infeasibility() <= settings.constraint_tolerance)
}

/// Whether the test of the error means something: huge multipliers scale any residual away.
fn has_meaning(state: &State<'_, '_, '_, '_>, error: &OptimalityError) -> bool {
    let absolute = 100.0 * state.core.settings.tolerance;
    let largest = norm_inf(&state.point.iterate.y);
    let exist = largest <= largest_multiplier(state) || !state.problem.products.is_empty();
    exist && error.dual <= absolute && error.complementarity <= absolute
}

/// Whether the gradient of the Lagrangian vanishes without the multipliers that have no business there, as [`Cone`] tells them.
pub(super) fn is_in_cone(state: &State<'_, '_, '_, '_>) -> bool {
    // runs for complementarity problems weigh their objectives, and are judged by their certificates
    if !state.core.settings.persistent {
        return true;
    }
    let (n, m) = (state.problem.n, state.problem.m);
    let iterate = &state.point.iterate;
    let mut distances = vec![0.0; m];
    for (k, slack) in state.problem.slacks.iter().enumerate() {
        if slack.row < m {
            let v = iterate.v[n + k];
            distances[slack.row] = if slack.sign * iterate.y[slack.row] > 0.0 {
                v - state.problem.lower[n + k]
            } else {
                state.problem.upper[n + k] - v
            };
        }
    }
    let cone = Cone {
        x: &iterate.v[..n],
        lagrangian: &state.point.lagrangian[..n],
        y: &iterate.y[..m],
        distances: &distances,
        none: OFF_CONE,
    };
    let values = state.core.kkt.jacobian_values.iter().copied();
    let entries = state.core.formulation.jacobian_entries().zip(values);
    let Some(astray) = cone.astray(entries.clone()) else {
        return true;
    };
    let size = norm_inf(&state.point.gradient[..n]).max(1.0);
    cone.left_without(&astray, entries) <= OFF_CONE * size
}

/// Whether the point is a solution by what is seen at it alone.
pub(super) fn is_solution(state: &State<'_, '_, '_, '_>, error: &OptimalityError) -> bool {
    passes(state, error) && has_meaning(state, error) && is_in_cone(state)
}

/// Multiplier beyond which none seem to exist: gradients that have grown since the start call for larger ones.
pub(super) fn largest_multiplier(state: &State<'_, '_, '_, '_>) -> f64 {
    LARGEST_MULTIPLIER * (norm_inf(&state.point.gradient) / GRADIENT).max(1.0)
}

/// The status that a point with this error ends the run with, if it does.
pub(super) fn stop_test(
    state: &mut State<'_, '_, '_, '_>,
    error: &OptimalityError,
) -> Option<Status> {
    if passes(state, error) {
        if state.is_restoration || is_solution(state, error) {
            return Some(Status::Solved);
        }
        if !has_meaning(state, error) {
            state.progress.degenerate += 1;
        }
        if state.progress.degenerate > 10 {
            return Some(Status::Degenerate);
        }
    }
    let settings = &state.core.settings;
    let at_end = state.sigma <= state.path.final_sigma();
    if error.scaled() <= settings.acceptable_tolerance && at_end {
        state.progress.acceptable += 1;
    } else {
        state.progress.acceptable = 0;
    }
    if settings.acceptable_iterations > 0
        && state.progress.acceptable >= settings.acceptable_iterations
    {
        return Some(Status::Acceptable);
    }
    if let Some(status) = divergence(state) {
        return Some(status);
    }
    let settings = &state.core.settings;
    if state.core.iterations >= settings.maximum_iterations {
        return Some(Status::IterationLimit);
    }
    state.core.is_over()
}
