//! The filter line search.

use super::acceptance::{Acceptance, Reference, Search, augment_filter, judge};
use super::filter::smallest_step;
use super::second_order_correction::second_order_correction;
use super::state::State;
use super::trial::take_trial;

/// Directional derivative of the barrier function along `d`.
fn slope(state: &State<'_, '_, '_, '_>, d: &[f64]) -> f64 {
    let problem = &state.problem;
    let mut slope = 0.0;
    for (i, d) in d.iter().enumerate() {
        let mut g = state.point.gradient[i] + state.mu * problem.damping(i);
        if problem.lower[i].is_finite() {
            g -= state.mu / (state.point.iterate.v[i] - problem.lower[i]);
        }
        if problem.upper[i].is_finite() {
            g += state.mu / (problem.upper[i] - state.point.iterate.v[i]);
        }
        slope += g * d;
    }
    slope
}

/// Whether no component of the step exceeds ten units of rounding.
fn is_tiny(state: &State<'_, '_, '_, '_>) -> bool {
    state.point.values.infeasibility() <= 1e-4
        && state
            .work
            .direction
            .v
            .iter()
            .zip(&state.point.iterate.v)
            .all(|(d, v)| d.abs() <= 10.0 * f64::EPSILON * (1.0 + v.abs()))
}

/// Looks for an acceptable point along the direction.
pub(super) fn line_search(state: &mut State<'_, '_, '_, '_>) -> Search {
    let alpha_max = state.longest_step(&state.work.direction);
    let reference = Reference {
        theta: state.point.values.theta,
        phi: state.barrier_function(),
        slope: slope(state, &state.work.direction.v),
    };
    if is_tiny(state) && take_trial(state, alpha_max, false) {
        return Search {
            acceptance: Acceptance::Tiny,
            alpha: alpha_max,
            alpha_max,
            trials: 0,
            corrected: false,
            filter_rejected: false,
        };
    }
    if state.progress.untested > 0 {
        state.progress.untested -= 1;
        if take_trial(state, alpha_max, false) {
            return Search {
                acceptance: Acceptance::Untested,
                alpha: alpha_max,
                alpha_max,
                ..Search::failed(1)
            };
        }
    }
    backtrack(state, &reference, alpha_max)
}

/// Halves the step until the point is acceptable; a second-order correction belongs to the longest step only.
fn backtrack(state: &mut State<'_, '_, '_, '_>, reference: &Reference, alpha_max: f64) -> Search {
    let mut search = Search::failed(0);
    search.alpha_max = alpha_max;
    let alpha_min = smallest_step(
        reference.theta,
        reference.slope,
        state.globalization.theta_min,
    );
    let mut alpha = alpha_max;
    loop {
        search.trials += 1;
        if take_trial(state, alpha, false) {
            let (acceptance, filter_rejected) = judge(state, reference, alpha, alpha);
            if acceptance != Acceptance::None {
                augment_filter(state, acceptance, reference);
                search.acceptance = acceptance;
                search.alpha = alpha;
                return search;
            }
            search.filter_rejected = filter_rejected;
            if alpha == alpha_max && state.work.trial_values.theta >= reference.theta {
                let acceptance = second_order_correction(state, reference, alpha);
                if acceptance != Acceptance::None {
                    augment_filter(state, acceptance, reference);
                    search.acceptance = acceptance;
                    search.alpha = state.longest_step(&state.work.correction);
                    search.corrected = true;
                    return search;
                }
            }
        }
        alpha *= 0.5;
        if alpha < alpha_min || alpha < 1e-16 || state.core.is_over().is_some() {
            return Search::failed(search.trials);
        }
    }
}
