//! Second-order corrections against the Maratos effect.

use super::acceptance::{Acceptance, Reference, judge};
use super::state::State;
use super::trial::take_trial;

/// Most corrections in an iteration.
const MAXIMUM: usize = 4;

/// Tries at most four steps with the residual
/// `c_soc <- alpha c_soc + c(trial)` (Waechter and Biegler 2006, section 2.4) while each lowers the
/// violation to 99 %. An accepted point is in `trial`, its step in `correction`.
pub(super) fn second_order_correction(
    state: &mut State<'_, '_, '_, '_>,
    reference: &Reference,
    alpha: f64,
) -> Acceptance {
    let mut previous = state.work.trial_values.theta;
    let mut factor = alpha;
    state
        .work
        .corrected_residual
        .copy_from_slice(&state.point.values.residual);
    for _ in 0..MAXIMUM {
        for (c, trial) in state
            .work
            .corrected_residual
            .iter_mut()
            .zip(&state.work.trial_values.residual)
        {
            *c = factor * *c + trial;
        }
        let residual = state.core.kkt.direction(
            &state.problem,
            &state.point.iterate,
            &state.point.lagrangian,
            &state.work.corrected_residual,
            state.mu,
            &mut state.work.correction,
        );
        if residual > 1e-5 {
            return Acceptance::None;
        }
        let step = state.longest_step(&state.work.correction);
        if !take_trial(state, step, true) {
            return Acceptance::None;
        }
        let (acceptance, _) = judge(state, reference, alpha, alpha);
        if acceptance != Acceptance::None {
            return acceptance;
        }
        let theta = state.work.trial_values.theta;
        if theta > 0.99 * previous {
            return Acceptance::None;
        }
        previous = theta;
        factor = step;
    }
    Acceptance::None
}
