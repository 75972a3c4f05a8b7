//! The main loop, which the restoration phase runs too.

use super::acceptance::{Acceptance, Search};
use super::direction::find_direction;
use super::line_search::line_search;
use super::parameters::update_barrier;
use super::rescue::{Rescue, rescue};
use super::restoration::{Leave, PENALTY, Restored, begin, enter, take_over};
use super::state::{Outcome, State};
use super::step::{Before, accept, is_drifting, is_jammed, stands_still};
use super::stop::{record, stop_test};
use crate::nlp::Status;

/// Runs until a status is reached or, in the restoration phase, `leave` accepts a point.
pub(super) fn run(state: &mut State<'_, '_, '_, '_>, mut leave: Option<&mut Leave>) -> Outcome {
    loop {
        state.evaluate_first_derivatives();
        state.update_lagrangian();
        let error = state.error(0.0);
        if !error.scaled().is_finite() {
            return state.outcome(Status::NotFinite);
        }
        if !record(state, &error) {
            return state.outcome(Status::Interrupted);
        }
        if let Some(status) = stop_test(state, &error) {
            return state.outcome(status);
        }
        if let Some(status) = update_barrier(state) {
            return state.outcome(status);
        }
        let count = state.core.kkt.factorizations;
        let found = find_direction(state);
        state.info.factorizations = state.core.kkt.factorizations - count;
        if !state.core.kkt.is_finite() {
            return state.outcome(Status::NotFinite);
        }
        let search = if found {
            line_search(state)
        } else {
            Search::failed(0)
        };
        // the step under way is left, and the point before it is the end
        if let Some(status) = state.core.is_over() {
            return state.outcome(status);
        }
        state.core.iterations += 1;
        if state.is_restoration {
            state.core.restoration_iterations += 1;
        }
        if let Some(outcome) = take_step(state, &search, found) {
            return outcome;
        }
        if let Some(leave) = leave.as_mut()
            && leave.accepts(&mut state.core.formulation, &state.point.iterate)
        {
            return Outcome {
                status: Status::Solved,
                error: f64::NAN,
                left: true,
            };
        }
    }
}

/// Takes the step that was found, or what there is in place of one. `Some` ends the run.
fn take_step(
    state: &mut State<'_, '_, '_, '_>,
    search: &Search,
    had_direction: bool,
) -> Option<Outcome> {
    let factor = if search.acceptance == Acceptance::None {
        match rescue(state, had_direction) {
            Rescue::GoOn => None,
            Rescue::Restore(factor) => Some(factor),
            Rescue::End(outcome) => return Some(outcome),
        }
    } else {
        let before = Before {
            theta: state.point.values.theta,
            phi: state.barrier_function(),
            error: state.error(0.0).scaled(),
        };
        accept(state, search);
        if stands_still(state, &before) {
            state.evaluate_first_derivatives();
            state.update_lagrangian();
            return Some(state.outcome(Status::StepTooSmall));
        }
        if is_jammed(state, search) {
            Some(if state.problem.products.is_empty() {
                0.9
            } else {
                0.1
            })
        } else if is_drifting(state) {
            Some(0.9)
        } else {
            None
        }
    };
    restore(state, factor?)
}

/// Runs the restoration phase until the violation has fallen by `factor`.
fn restore(state: &mut State<'_, '_, '_, '_>, factor: f64) -> Option<Outcome> {
    if state.is_restoration {
        return None;
    }
    if state.point.values.infeasibility() <= 1e-2 * state.core.settings.tolerance {
        return None;
    }
    if state.globalization.last_restoration == Some(state.core.iterations) {
        return Some(state.outcome(Status::RestorationFailed));
    }
    let theta = state.point.values.theta;
    let (problem, mut path, mut leave) = begin(state, factor);
    let (outcome, found, gradient) = {
        let mut inner = State::new(&mut *state.core, problem, &mut path, true);
        enter(&mut inner, &state.problem, &state.point);
        let outcome = run(&mut inner, Some(&mut leave));
        let gradient = inner.error(0.0).dual / PENALTY;
        (outcome, inner.point.iterate, gradient)
    };
    let restored = take_over(state, &outcome, &found, theta);
    // where the violation came back, it may not grow again: the phases to come end at a feasible point, or at the
    // least violation there is
    let reached = state.point.values.theta;
    if state.problem.products.is_empty() && reached >= state.globalization.restored_theta {
        state.globalization.filter.theta_max = state.globalization.filter.theta_max.min(reached);
    }
    state.globalization.restored_theta = state.globalization.restored_theta.min(reached);
    state.globalization.last_restoration = Some(state.core.iterations);
    state.info.acceptance = 'R';
    match restored {
        Restored::Continue => None,
        Restored::Ended(status) => {
            if status == Status::Infeasible {
                state.core.violation_stationarity = Some(gradient);
            }
            state.evaluate_first_derivatives();
            state.update_lagrangian();
            Some(state.outcome(status))
        }
    }
}
