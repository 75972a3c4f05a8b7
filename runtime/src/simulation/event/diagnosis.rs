//! Why a run ends before its horizon, in words.

use super::dynamics::{Dynamics, Switch};
use super::here::Undetermined;
use crate::contact::touching::jammed;
use crate::simulation::problem::vanishing_inertia;
use crate::simulation::sentences::{has_pole, leaps, unbounded, zero_parameters};
use crate::simulation::{Diagnosis, SimulationStatus};

/// Gain of a sliding contact below which steps that shrink to nothing approach a pole of its force.
const JAMMING: f64 = 1e-2;

/// Where a run has come to.
#[derive(Clone, Copy)]
pub(super) struct Place<'p, 'a> {
    pub(super) dynamics: &'p Dynamics<'a>,
    pub(super) time: f64,
    pub(super) step: usize,
}

impl Place<'_, '_> {
    fn diagnosis(self, contact: Option<usize>, message: String) -> Diagnosis {
        Diagnosis {
            time: self.time,
            step: self.step,
            contact,
            message,
        }
    }

    fn contact_name(self, contact: usize) -> &'static str {
        self.dynamics.model.declaration().contacts[contact].name
    }

    fn coordinate_name(self, coordinate: usize) -> &'static str {
        self.dynamics.model.declaration().coordinates[coordinate].name
    }

    /// As many `steps` as are allowed have been taken, the last of length `h`.
    pub(super) fn step_limit(self, steps: usize, h: f64) -> SimulationStatus {
        let message =
            format!("{steps} steps taken, the last of {h:.1e} s; raise the limit or the tolerance");
        SimulationStatus::StepLimit(self.diagnosis(None, message))
    }

    /// Steps shrink to nothing at the events of a contact.
    pub(super) fn events_too_close(self, contact: usize) -> SimulationStatus {
        let message = "the events of this contact cannot be told apart; lower the tolerance";
        SimulationStatus::StepFailed(self.diagnosis(Some(contact), message.into()))
    }

    /// Steps shrink to `h` where nothing jams, with this `error` of the last one; `start` is the input vector there, and `slope` the
    /// derivative of the state.
    pub(super) fn step_too_short(
        self,
        (h, tolerance, error): (f64, f64, f64),
        start: &[f64],
        slope: &[f64],
    ) -> SimulationStatus {
        let here = self.dynamics.input();
        if let Some(why) = vanishing_inertia(self.dynamics.model, start, here) {
            return SimulationStatus::NotFinite(self.diagnosis(None, why));
        }
        if !error.is_finite() {
            return self.not_finite(slope);
        }
        let contact = self.dynamics.mode.active.first().copied();
        let message = format!(
            "steps of {h:.1e} s do not meet the tolerance {tolerance:e}; the motion is not smooth here, \
             or the tolerance too small"
        );
        SimulationStatus::StepFailed(self.diagnosis(contact, message))
    }

    /// Steps shrink to nothing without an event; `slope` is the derivative of the state.
    pub(super) fn unbounded(self, slope: &[f64]) -> SimulationStatus {
        let n = self.dynamics.n;
        let slope = &slope[n..2 * n];
        let fastest = (0..n).max_by(|&a, &b| slope[a].abs().total_cmp(&slope[b].abs()));
        let name = fastest.map_or("", |k| self.coordinate_name(k));
        SimulationStatus::NotFinite(self.diagnosis(None, unbounded(name)))
    }

    /// A switching function changes its sign through infinity, or a gap by a jump, after `h` more.
    pub(super) fn pole(mut self, switch: Switch, h: f64) -> SimulationStatus {
        self.time += h;
        let contact = switch.contact();
        let name = self.contact_name(contact);
        let message = match switch {
            Switch::Gap(_) => leaps(name),
            _ if self.dynamics.switch_of(contact).is_some() => has_pole(name),
            _ => format!(
                "{} of `{name}` changes its sign through infinity; check divisions and poles of the scene",
                switch.words()
            ),
        };
        SimulationStatus::NotFinite(self.diagnosis(Some(contact), message))
    }

    /// The derivative `slope` of the state, or what a contact needs, is not finite.
    pub(super) fn not_finite(self, slope: &[f64]) -> SimulationStatus {
        let n = self.dynamics.n;
        let contact = self.dynamics.switching.undefined;
        let what = match (0..n).find(|&k| !slope[n + k].is_finite()) {
            Some(k) => format!("the acceleration of `{}`", self.coordinate_name(k)),
            None => match contact {
                Some(i) => format!("the contact `{}`", self.contact_name(i)),
                None => "the acceleration a moment later".into(),
            },
        };
        let message = format!(
            "{what} is not a finite number; check roots, divisions and parameters of the scene{}",
            zero_parameters(self.dynamics.model)
        );
        SimulationStatus::NotFinite(self.diagnosis(contact, message))
    }

    /// The force of a sliding contact grows beyond all bounds, if it does at the last evaluation.
    pub(super) fn jamming(self) -> Option<SimulationStatus> {
        let (contact, gain) = self.dynamics.smallest_gain()?;
        (gain < JAMMING).then(|| {
            let message = jammed(self.dynamics, contact, gain);
            SimulationStatus::AmbiguousContact(self.diagnosis(Some(contact), message))
        })
    }

    /// Impact law or contact mode have no solution, or several.
    pub(super) fn undetermined(self, problem: Undetermined) -> SimulationStatus {
        SimulationStatus::AmbiguousContact(self.diagnosis(Some(problem.contact), problem.message))
    }

    /// That many `events` at one instant, the last of them that of `switch`.
    pub(super) fn unsettled(self, switch: Switch, events: usize) -> SimulationStatus {
        let contact = switch.contact();
        let message = format!(
            "{events} events at one instant, the last where {} of `{}` vanishes; start from a slightly different \
             state",
            switch.words(),
            self.contact_name(contact)
        );
        SimulationStatus::AmbiguousContact(self.diagnosis(Some(contact), message))
    }

    /// More events than are allowed, `count`, of which the last is one of this contact.
    pub(super) fn too_many_events(self, count: usize, last: Option<usize>) -> SimulationStatus {
        let message = format!(
            "{count} switches of the contact mode until here; shorten the horizon, or raise the limit on events unless they \
             accumulate"
        );
        SimulationStatus::EventLimit(self.diagnosis(last, message))
    }
}
