//! Whether forces and gaps kept their sign, measured along a run after its events have been found.

use super::dop853::{Dop853, System};
use super::dynamics::{Dynamics, Switch, motion, switching};
use crate::run::remarks::Remarks;
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::verdict::Verdict;
use crate::yardstick;

/// Violation of a function, in tolerances, that is no error of integration.
const TOLERANCES: f64 = 100.0;

/// Where inside a step the signs of forces and gaps are measured.
const AUDITED: [f64; 3] = [0.25, 0.5, 0.75];

/// What is looked at during the run, and said after it.
pub(super) struct Checks<'a> {
    pub(super) remarks: Remarks,
    pub(super) verdict: Verdict,
    /// How fast what acts depends on time, where it does.
    pub(super) explicit_time: Option<ExplicitTime<'a>>,
}

/// That of runs with this tolerance.
pub(super) fn verdict(tolerance: f64) -> Verdict {
    Verdict::within(yardstick::NOTHING.max(TOLERANCES * tolerance))
}

/// Looks at values of the switching functions at a place \[s, step\].
pub(super) fn look(
    verdict: &mut Verdict,
    dynamics: &Dynamics<'_>,
    values: &[f64],
    place: (f64, usize),
) {
    verdict.place = place;
    for (function, &value) in values.iter().enumerate() {
        let switch = dynamics.switch(function);
        // A gap that has always been closed is rounding error.
        let rounding = match switch {
            Switch::Gap(_) => switching::zero_value(dynamics, function),
            _ => 0.0,
        };
        let sizes = (rounding, switching::size(dynamics, function));
        verdict.is_positive((switch.words(), switch.contact()), value, sizes);
    }
}

/// Looks at forces and gaps inside the first `until` of a step of length `h` from `t` on, whose continuous extension is ready; the
/// memory is for a state and its derivative.
pub(super) fn look_inside(
    verdict: &mut Verdict,
    (dynamics, method): (&mut Dynamics<'_>, &Dop853),
    (state, slope): (&mut [f64], &mut [f64]),
    (t, h, until): (f64, f64, f64),
    step: usize,
) {
    for share in AUDITED {
        let time = t + share * until;
        method.interpolate(share * until / h, state);
        if motion::project(dynamics, time, state) {
            dynamics.derivative(time, state, slope);
            look(verdict, dynamics, &dynamics.switching.values, (time, step));
        }
    }
}
