//! What to do when no step is found: larger shifts, restoration, or the end.

use super::state::{Outcome, State};
use crate::nlp::Status;

/// What is left to do without a step.
pub(super) enum Rescue {
    /// The next iteration uses a larger shift.
    GoOn,
    /// The restoration phase, until the violation has fallen by this factor.
    Restore(f64),
    /// The run ends.
    End(Outcome),
}

/// After a failed line search or factorization: restoration, or a larger shift at points that are
/// feasible already.
pub(super) fn rescue(state: &mut State<'_, '_, '_, '_>, had_direction: bool) -> Rescue {
    state.info.acceptance = ' ';
    state.info.step_length_primal = 0.0;
    let settings = &state.core.settings;
    let error = state.error(0.0);
    let feasible = state.point.values.infeasibility() <= 1e-2 * settings.tolerance;
    if state.is_restoration || feasible {
        if state.progress.stalls < 6 {
            state.progress.stalls += 1;
            state.globalization.filter.clear();
            state.shifts.floor =
                (100.0 * state.shifts.floor.max(state.shifts.inertia.delta_w)).max(1e-4);
            return Rescue::GoOn;
        }
        let acceptable = error.scaled() <= settings.acceptable_tolerance
            && state.sigma <= state.path.final_sigma();
        let status = if acceptable {
            Status::Acceptable
        } else if !had_direction {
            Status::FactorizationFailed
        } else if state.is_restoration {
            Status::RestorationFailed
        } else {
            Status::StepTooSmall
        };
        return Rescue::End(state.outcome(status));
    }
    Rescue::Restore(0.9)
}
