//! Why a run stopped, in words.

use super::driver::{Driver, MAX_SWITCHES, Stop};
use crate::fesd::active_contact::find;
use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::ElementError;
use crate::simulation::{Diagnosis, EventKind, SimulationStatus};

/// Normal acceleration for a unit force of a sliding contact, 1 without friction, below which the failure of
/// short elements is that of the contact law.
const NEARLY_JAMMED: f64 = 1e-2;

impl Driver<'_> {
    pub(super) fn note(&mut self, text: &str) {
        if !self.notes.iter().any(|note| note == text) {
            self.notes.push(text.into());
        }
    }

    pub(super) fn diagnosis(
        &self,
        step: usize,
        contact: Option<usize>,
        message: String,
    ) -> Diagnosis {
        Diagnosis {
            time: self.state.time,
            step,
            contact,
            message,
        }
    }

    /// Whether the friction of a sliding contact presses nearly as much as its force lifts, so that the forces
    /// grow without bound.
    pub(super) fn nearly_jams(&self) -> bool {
        self.active.iter().any(|held| {
            let sense = held.tangential.sense();
            sense != 0.0 && self.contacts.lift_in_slip(held.contact, sense) < NEARLY_JAMMED
        })
    }

    /// The status of a run whose elements become ever shorter, the last of them up to `end`.
    pub(super) fn too_short(&self, step: usize, end: f64) -> SimulationStatus {
        if self.nearly_jams() {
            return self.stopped(step, &Stop::Mode(ModeError::Jammed));
        }
        if self.not_finite {
            return self.stopped(step, &Stop::Mode(ModeError::NotFinite));
        }
        SimulationStatus::StepLimit(self.diagnosis(
            step,
            self.active.first().map(|held| held.contact),
            format!(
                "too many elements, the last of {:.1e} s: forces grow without bound here, or the tolerance \
                 is below what the model's functions resolve; raise the tolerance",
                end - self.state.time
            ),
        ))
    }

    /// The status of a run that takes more elements than allowed.
    pub(super) fn too_many(&self, step: usize) -> SimulationStatus {
        SimulationStatus::StepLimit(self.diagnosis(
            step,
            None,
            format!(
                "{} elements do not reach the horizon; shorten it, raise the tolerance, or raise \
                 `most_elements`",
                self.settings.most_elements
            ),
        ))
    }

    /// The status of a run whose contact mode switches without end.
    pub(super) fn unsettled(&self, step: usize) -> SimulationStatus {
        let last = self.events.last();
        let contact = last.map(|event| event.contact);
        let why = match last {
            Some(event)
                if event.kind == EventKind::Impact && self.restitution[event.contact] > 0.0 =>
            {
                format!(
                    "`{}` bounces too often before it rests: raise the rest velocity, {:.1e} now, or \
                     lower the restitution",
                    self.model.declaration().contacts[event.contact].name,
                    self.rest_velocity(event.contact)
                )
            }
            _ => "the contact mode does not settle: look at the surfaces that meet here, or take more steps"
                .into(),
        };
        SimulationStatus::AmbiguousContact(self.diagnosis(
            step,
            contact,
            format!(
                "more than {MAX_SWITCHES} switches within {} s; {why}",
                0.01 * self.horizon
            ),
        ))
    }

    /// Contacts that touch at the present state.
    fn touching(&self) -> impl Iterator<Item = usize> {
        self.all_contacts.iter().copied().filter(|&i| {
            find(&self.active, i).is_some()
                || self.contacts.gap(i) <= self.contacts.size(i, self.state.time).touching_gap()
        })
    }

    /// Why no force satisfies the contact law, and the contact to blame: friction that presses more than the
    /// contact force lifts, or else the directions.
    fn jamming(&self) -> (Option<usize>, String) {
        let pressed = self
            .touching()
            .filter(|&i| self.contacts.friction(i) > 0.0)
            .flat_map(|i| [(i, 1.0), (i, -1.0)])
            .map(|(i, sense)| (i, sense, self.contacts.lift_in_slip(i, sense)))
            .min_by(|a, b| a.2.total_cmp(&b.2));
        let first = self.touching().next();
        match pressed {
            Some((i, sense, lift)) if lift < NEARLY_JAMMED => (
                Some(i),
                format!(
                    "no impulse or force satisfies the contact law (jamming): when `{}` slides {} its \
                     friction presses as much as the contact force lifts, or more (1 -+ mu n'e = {lift:.1e}, \
                     Painleve's paradox); lower the friction or keep away from this position",
                    self.model.declaration().contacts[i].name,
                    if sense > 0.0 { "forward" } else { "backward" },
                ),
            ),
            _ if self.several_bounce() => (
                first,
                "no impulse satisfies the contact law: restitution sends several \
                 contacts back at once, and their friction does not let them go; lower either"
                    .into(),
            ),
            _ => (
                first,
                "no impulse or force satisfies the contact law (jamming): the forces of the contacts \
                 that touch push each other into the ground; look at their surfaces and impact laws"
                    .into(),
            ),
        }
    }

    /// Whether several contacts with friction and restitution touch and close.
    fn several_bounce(&self) -> bool {
        let bounces = |&i: &usize| {
            self.contacts.friction(i) > 0.0
                && self.restitution[i] > 0.0
                && self.contacts.normal_velocity(i) < 0.0
        };
        self.touching().filter(bounces).count() > 1
    }

    pub(super) fn stopped(&self, step: usize, stop: &Stop) -> SimulationStatus {
        let names = |contacts: &mut dyn Iterator<Item = usize>| {
            let declared = self.model.declaration().contacts;
            let names: Vec<&str> = contacts.map(|i| declared[i].name).collect();
            names.join(", ")
        };
        let held = names(&mut self.active.iter().map(|held| held.contact));
        let touched = names(&mut self.touching());
        let mode = match (held.as_str(), touched.as_str()) {
            ("", "") => "in free motion".to_string(),
            ("", touched) => format!("touching {touched}"),
            (held, _) => format!("in contact with {held}"),
        };
        let contact = self.active.first().map(|held| held.contact);
        let contact = contact.or_else(|| self.touching().next());
        let describe =
            |what: &str| format!("step {step} at t = {} s {mode}: {what}", self.state.time);
        match stop {
            Stop::Element(ElementError::NotFinite) | Stop::Mode(ModeError::NotFinite) => {
                SimulationStatus::NotFinite(self.diagnosis(
                    step,
                    contact,
                    describe(
                        "the model is infinite or not a number here; look for a division by zero \
                         or a root of a negative number",
                    ),
                ))
            }
            Stop::Mode(ModeError::Jammed) => {
                let (contact, why) = self.jamming();
                SimulationStatus::AmbiguousContact(self.diagnosis(step, contact, describe(&why)))
            }
            Stop::Mode(ModeError::Dependent) => SimulationStatus::AmbiguousContact(self.diagnosis(
                step,
                contact,
                describe("the normals of the active contacts are dependent"),
            )),
            Stop::Element(ElementError::Singular) => SimulationStatus::StepFailed(self.diagnosis(
                step,
                contact,
                describe("singular element matrix; the active contacts may be dependent"),
            )),
            Stop::Element(ElementError::NotConverged) => {
                SimulationStatus::StepFailed(self.diagnosis(
                    step,
                    contact,
                    describe("Newton's method did not converge; take more steps"),
                ))
            }
            Stop::Program(what) => {
                SimulationStatus::StepFailed(self.diagnosis(step, contact, describe(what)))
            }
            Stop::Unresolved => SimulationStatus::StepFailed(self.diagnosis(
                step,
                contact,
                describe("a gap varies too fast for the elements; take more steps"),
            )),
            Stop::Location => SimulationStatus::StepFailed(self.diagnosis(
                step,
                contact,
                describe("a switch could not be located; take more steps"),
            )),
        }
    }
}
