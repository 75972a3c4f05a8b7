//! Whether trial points are acceptable, and why.

use super::filter::{is_armijo, is_sufficient, is_switching};
use super::state::State;

/// Why a trial point was accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Acceptance {
    None,
    /// Descent of the objective (Armijo).
    Objective,
    /// Progress in violation or objective; the point left behind enters the filter.
    Filter,
    /// The step is below the resolution of the numbers.
    Tiny,
    /// The error of the optimality conditions decides later, or nothing does.
    Untested,
}

impl Acceptance {
    /// Letter of the log.
    pub(super) fn letter(self, corrected: bool) -> char {
        match (self, corrected) {
            (Self::None, _) => ' ',
            (Self::Objective, false) => 'f',
            (Self::Objective, true) => 'F',
            (Self::Filter, false) => 'h',
            (Self::Filter, true) => 'H',
            (Self::Tiny, _) => 't',
            (Self::Untested, _) => 'n',
        }
    }
}

/// Result of a line search; the accepted point is in `trial`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    pub(super) acceptance: Acceptance,
    pub(super) alpha: f64,
    pub(super) alpha_max: f64,
    pub(super) trials: usize,
    /// Whether the step is the second-order correction.
    pub(super) corrected: bool,
    /// Whether the filter was what rejected the last trial before acceptance.
    pub(super) filter_rejected: bool,
}

impl Search {
    pub(super) fn failed(trials: usize) -> Self {
        Self {
            acceptance: Acceptance::None,
            alpha: 0.0,
            alpha_max: 0.0,
            trials,
            corrected: false,
            filter_rejected: false,
        }
    }
}

/// Quantities of the current point that trial points are compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference {
    pub(super) theta: f64,
    pub(super) phi: f64,
    pub(super) slope: f64,
}

/// Judges the trial point; `alpha_test` is the step length that Armijo and switching use.
pub(super) fn judge(
    state: &mut State<'_, '_, '_, '_>,
    reference: &Reference,
    alpha: f64,
    alpha_test: f64,
) -> (Acceptance, bool) {
    let theta = state.work.trial_values.theta;
    let phi =
        state
            .problem
            .barrier_function(&state.work.trial, &mut state.work.trial_values, state.mu);
    if !phi.is_finite() || theta > state.globalization.filter.theta_max {
        return (Acceptance::None, false);
    }
    let switching = reference.theta <= state.globalization.theta_min
        && is_switching(reference.slope, alpha, reference.theta);
    let acceptance = if switching {
        if is_armijo(phi, reference.phi, alpha_test, reference.slope) {
            Acceptance::Objective
        } else {
            Acceptance::None
        }
    } else if is_sufficient(theta, phi, reference.theta, reference.phi)
        && !increases_too_much(phi, reference.phi)
    {
        if is_switching(reference.slope, alpha, reference.theta)
            && is_armijo(phi, reference.phi, alpha_test, reference.slope)
        {
            Acceptance::Objective
        } else {
            Acceptance::Filter
        }
    } else {
        Acceptance::None
    };
    if acceptance == Acceptance::None {
        return (Acceptance::None, false);
    }
    if state.globalization.filter.accepts(theta, phi) {
        (acceptance, false)
    } else {
        (Acceptance::None, true)
    }
}

/// Lets the point left behind enter the filter where that is what the acceptance rests on.
pub(super) fn augment_filter(
    state: &mut State<'_, '_, '_, '_>,
    acceptance: Acceptance,
    reference: &Reference,
) {
    if acceptance == Acceptance::Filter {
        state
            .globalization
            .filter
            .add(reference.theta, reference.phi);
    }
}

/// Increase of the objective by more than five orders of magnitude.
fn increases_too_much(trial: f64, phi: f64) -> bool {
    trial > phi && (trial - phi).log10() > 5.0 + phi.abs().log10().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increases_too_much_compares_orders_of_magnitude() {
        assert!(!increases_too_much(1e5, 1.0));
        assert!(increases_too_much(1e7, 1.0));
        assert!(!increases_too_much(1e9, 1e5));
        assert!(!increases_too_much(-1.0, 1.0));
    }
}
