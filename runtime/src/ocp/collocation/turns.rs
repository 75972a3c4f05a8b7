//! What happens to contacts with friction at the ends of an element.

use crate::model::Model;
use crate::ocp::motion::sequence::{Place, Switch};
use crate::simulation::{ContactMode, Direction};

/// What happens to contacts with friction at the ends of an element.
#[derive(Default, Clone)]
pub(in crate::ocp) struct Turns {
    /// Contacts that close in an impact right before the start, with friction or without.
    pub(in crate::ocp) landed: Vec<usize>,
    /// Contacts at rest that begin to slip at the start, pulled by a jump of the controls, an impact or the reversal of
    /// their own friction: with an acceleration.
    pub(in crate::ocp) pulled: Vec<usize>,
    /// Contacts that begin to slip at the start because their force has reached the edge of the cone: with the rate
    /// of the acceleration, so that the rows of their sliding velocities would have no interior. Its sign follows from
    /// the force before.
    pub(in crate::ocp) yielded: Vec<usize>,
    /// Contacts whose sliding velocity vanishes at the end.
    pub(in crate::ocp) stopping: Vec<usize>,
    /// Contacts that stop because they are parts of the body of another one that does.
    pub(in crate::ocp) stopped: Vec<usize>,
    /// Contacts whose force reaches the edge of the cone at the end.
    pub(in crate::ocp) yielding: Vec<(usize, Direction)>,
    /// Sticking contacts that open at the end: the cone has shrunk to a point.
    pub(in crate::ocp) opening: Vec<usize>,
    /// Whether the motion ends at the end.
    pub(in crate::ocp) finishing: bool,
}

impl Turns {
    /// What a switch asks for at the end of the element before it; `jumps` where the controls may jump between
    /// intervals.
    pub(in crate::ocp) fn end(&mut self, switch: &Switch, before: ContactMode, jumps: bool) {
        let inside = switch.place == Place::Inside || !jumps;
        match (before, switch.mode) {
            (ContactMode::Slip(_), ContactMode::Stick | ContactMode::Slip(_))
                if switch.accompanies =>
            {
                self.stopped.push(switch.contact);
            }
            (ContactMode::Slip(_), ContactMode::Stick | ContactMode::Slip(_)) => {
                self.stopping.push(switch.contact)
            }
            (ContactMode::Stick, ContactMode::Slip(direction)) if inside => {
                self.yielding.push((switch.contact, direction));
            }
            (ContactMode::Stick, ContactMode::Open) if inside => self.opening.push(switch.contact),
            _ => {}
        }
    }

    /// What a switch leaves at the start of the element after it; `impact` where it belongs to one, `jumps` where the
    /// controls may jump between intervals.
    pub(in crate::ocp) fn start(
        &mut self,
        switch: &Switch,
        before: ContactMode,
        impact: bool,
        jumps: bool,
    ) {
        let inside = switch.place == Place::Inside || !jumps;
        match (before, switch.mode) {
            (_, ContactMode::Slip(_)) if impact && switch.impulse != ContactMode::Stick => {}
            (ContactMode::Stick, ContactMode::Slip(_)) if inside && !impact => {
                self.yielded.push(switch.contact);
            }
            (_, ContactMode::Slip(_)) => self.pulled.push(switch.contact),
            _ => {}
        }
    }

    /// Whether a contact bounces from the start on until it rests.
    pub(in crate::ocp) fn settles(&self, model: &dyn Model, contact: usize) -> bool {
        self.landed.contains(&contact) && model.restitution(contact) > 0.0
    }

    /// The part that belongs to one of the elements between two switches.
    pub(in crate::ocp) fn of_element(&self, first: bool, last: bool) -> Self {
        let mut turns = self.clone();
        if !first {
            turns.landed = Vec::new();
            (turns.pulled, turns.yielded) = (Vec::new(), Vec::new());
        }
        if !last {
            (turns.stopping, turns.stopped) = (Vec::new(), Vec::new());
            (turns.yielding, turns.opening) = (Vec::new(), Vec::new());
            turns.finishing = false;
        }
        turns
    }
}
