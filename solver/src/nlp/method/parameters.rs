//! From one barrier problem to the next.

use super::barrier::{Level, PathStep};
use super::state::State;
use crate::nlp::Status;

/// Moves along the path while the current problem is solved.
pub(super) fn update_barrier(state: &mut State<'_, '_, '_, '_>) -> Option<Status> {
    let mut forced = state.level.tiny_steps >= 2;
    if state.level.tiny_steps >= 2 {
        state.level.tiny_steps = 0;
    }
    loop {
        let level = Level {
            mu: state.mu,
            sigma: state.sigma,
            solved: forced || state.error(state.mu).scaled() <= 10.0 * state.mu,
            iterations: state.level.iterations,
            jams: state.level.jams,
        };
        match state.path.update(&level) {
            PathStep::Stay if forced => return Some(Status::StepTooSmall),
            PathStep::Stay => {
                state.level.iterations += 1;
                return None;
            }
            PathStep::Advance { mu, sigma } => {
                state.level.kept.copy_from(&state.point.iterate);
                if change_parameters(state, mu, sigma) {
                    return None;
                }
            }
            PathStep::Return { mu, sigma } => {
                state.point.iterate.copy_from(&state.level.kept);
                state.evaluate_iterate();
                state.evaluate_first_derivatives();
                state.update_lagrangian();
                state.sigma = f64::INFINITY;
                change_parameters(state, mu, sigma);
                return None;
            }
        }
        forced = false;
    }
}

/// Sets new parameters; `true` if `sigma` changed, which moves the slacks of products.
fn change_parameters(state: &mut State<'_, '_, '_, '_>, mu: f64, sigma: f64) -> bool {
    state.mu = mu;
    state.globalization.filter.clear();
    state.level.iterations = 0;
    state.progress.still_steps = 0;
    state.progress.least_error = f64::INFINITY;
    state.level.jams = 0;
    let changed = sigma != state.sigma;
    if changed {
        state.sigma = sigma;
        for k in 0..state.problem.slacks.len() {
            if !state.problem.is_product_slack(k) {
                continue;
            }
            let row = state.problem.slacks[k].row;
            let (i, j) = state.problem.products[row - state.problem.m];
            let product = state.point.iterate.v[i] * state.point.iterate.v[j];
            let index = state.problem.n + k;
            let s = (sigma - product).max((0.1 * sigma).min(state.point.iterate.v[index]));
            state.point.iterate.v[index] = s;
            let z = state.point.iterate.z_lower[index]
                .min(1e4 * mu / s)
                .max(mu / (1e4 * s));
            state.point.iterate.z_lower[index] = z;
            state.point.iterate.y[row] = z;
        }
        state.update_lagrangian();
    }
    // also the weight of the proximity term of the restoration phase depends on mu
    if changed || state.is_restoration {
        state.evaluate_iterate();
        state.problem.gradient(
            &mut state.core.formulation,
            &state.point.iterate.v,
            state.mu,
            &mut state.point.gradient,
        );
        state.update_lagrangian();
    }
    changed
}
