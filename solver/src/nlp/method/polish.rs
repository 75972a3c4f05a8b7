//! Newton's method without a line search, where rounding hides what the objective gains.
//!
//! Near a solution the objective changes by the square of the distance, the gradient by the distance itself. Where the
//! objective is a difference of large numbers its changes drown in rounding while the gradient still has digits, and
//! the line search shortens steps at random. There the error of the optimality conditions decides alone.

use super::acceptance::{Acceptance, Search};
use super::direction::find_direction;
use super::state::{Outcome, State};
use super::step::accept;
use super::stop::{is_solution, record};
use super::trial::take_trial;
use crate::nlp::Status;
use crate::nlp::program::iterate::Iterate;

/// Steps in a row that may miss a lower error.
const MISSES: usize = 3;

/// What counts as a lower error.
const LOWER: f64 = 0.5;

/// Length of a Newton step, relative to the point, that says that the point is the solution but for rounding.
const CLOSE: f64 = 1e-8;

/// Full steps as long as the error falls, the point of the least error where that passes no test.
pub(super) fn polish(state: &mut State<'_, '_, '_, '_>) -> Option<Outcome> {
    if state.mu > state.core.settings.tolerance {
        return None;
    }
    state.shifts.floor = 0.0;
    let mut best = state.point.iterate.clone();
    let mut least = state.error(0.0).scaled();
    let mut misses = 0;
    while misses < MISSES && state.core.iterations < state.core.settings.maximum_iterations {
        if !step(state) {
            break;
        }
        let error = state.error(0.0);
        if !record(state, &error) {
            return Some(state.outcome(Status::Interrupted));
        }
        if is_solution(state, &error) {
            return Some(state.outcome(Status::Solved));
        }
        misses = if error.scaled() <= LOWER * least {
            0
        } else {
            misses + 1
        };
        if error.scaled() < least {
            least = error.scaled();
            best.copy_from(&state.point.iterate);
        }
    }
    restore(state, &best);
    state.core.is_close = find_direction(state) && is_close(state);
    None
}

/// Whether the Newton step is that of a convex neighbourhood and nearly none.
fn is_close(state: &State<'_, '_, '_, '_>) -> bool {
    let steps = state.work.direction.v.iter().zip(&state.point.iterate.v);
    state.shifts.inertia.delta_w == 0.0
        && steps.fold(true, |close, (d, v)| {
            close && d.abs() <= CLOSE * v.abs().max(1.0)
        })
}

/// Goes back to an iterate.
pub(super) fn restore(state: &mut State<'_, '_, '_, '_>, before: &Iterate) {
    state.point.iterate.copy_from(before);
    state.evaluate_iterate();
    state.evaluate_first_derivatives();
    state.update_lagrangian();
}

/// The longest step inside the bounds; `false` if there is none, or functions have no value there.
fn step(state: &mut State<'_, '_, '_, '_>) -> bool {
    let count = state.core.kkt.factorizations;
    let found = find_direction(state);
    state.info.factorizations = state.core.kkt.factorizations - count;
    if !found {
        return false;
    }
    let alpha = state.longest_step(&state.work.direction);
    if !take_trial(state, alpha, false) {
        return false;
    }
    let search = Search {
        acceptance: Acceptance::Untested,
        alpha,
        alpha_max: alpha,
        ..Search::failed(1)
    };
    accept(state, &search);
    state.core.iterations += 1;
    state.evaluate_first_derivatives();
    state.update_lagrangian();
    state.core.kkt.is_finite() && state.error(0.0).scaled().is_finite()
}
