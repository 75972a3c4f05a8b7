//! Whether forces and gaps kept their sign, measured along a run after its events have been found.

use super::dop853::{Dop853, System};
use super::dynamics::{Dynamics, Switch, motion, switching};
use crate::run::remarks::Remarks;
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::{Diagnosis, SimulationStatus};

/// A violation above this share of the size of a function, or this multiple of the tolerance, is no error of
/// integration.
const LARGEST_SHARE: f64 = 1e-9;
const TOLERANCES: f64 = 100.0;

/// Where inside a step the signs of forces and gaps are measured.
const AUDITED: [f64; 3] = [0.25, 0.5, 0.75];

/// The largest violations seen.
#[derive(Debug, Clone)]
pub(super) struct Audit {
    limit: f64,
    /// Largest share of the size of a function by which it was below zero, if above the limit: with what to say.
    worst: Option<(f64, Diagnosis)>,
    /// Largest violation of a sign, in the unit of its function.
    pub(super) largest: f64,
}

/// What is looked at during the run, and said after it.
pub(super) struct Checks<'a> {
    pub(super) remarks: Remarks,
    pub(super) audit: Audit,
    /// How fast what acts depends on time, where it does.
    pub(super) explicit_time: Option<ExplicitTime<'a>>,
}

impl Audit {
    /// For runs with this tolerance.
    pub(super) fn new(tolerance: f64) -> Self {
        Self {
            limit: LARGEST_SHARE.max(TOLERANCES * tolerance),
            worst: None,
            largest: 0.0,
        }
    }

    /// Looks at values of the switching functions at `time`, in step `step`.
    pub(super) fn look(&mut self, dynamics: &Dynamics<'_>, values: &[f64], time: f64, step: usize) {
        for (function, &value) in values.iter().enumerate() {
            // Written so that NaN is looked at.
            if value >= 0.0 {
                continue;
            }
            let switch = dynamics.switch(function);
            self.largest = self.largest.max(-value);
            let share = -value / switching::size(dynamics, function);
            let known = self.worst.as_ref().map_or(self.limit, |(worst, _)| *worst);
            // The range of a gap that has always been closed is rounding error.
            let closed = matches!(switch, Switch::Gap(_))
                && -value <= switching::zero_value(dynamics, function);
            if !closed && (share > known || share.is_nan()) {
                let contact = switch.contact();
                let name = dynamics.model.declaration().contacts[contact].name;
                let diagnosis = Diagnosis {
                    time,
                    step,
                    contact: Some(contact),
                    message: format!(
                        "{} of `{name}` is {value:.1e} where it must not be negative: its event was missed; \
                         lower the tolerance, or `max_step` in Rust",
                        switch.words()
                    ),
                };
                self.worst = Some((share, diagnosis));
            }
        }
    }

    /// Looks at forces and gaps inside the first `until` of a step of length `h` from `t` on, whose continuous extension is ready; the
    /// memory is for a state and its derivative.
    pub(super) fn look_inside(
        &mut self,
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
                self.look(dynamics, &dynamics.switching.values, time, step);
            }
        }
    }

    /// Why the run does not count as solved, if it does not.
    pub(super) fn verdict(self) -> Option<SimulationStatus> {
        self.worst
            .map(|(_, diagnosis)| SimulationStatus::StepFailed(diagnosis))
    }
}
