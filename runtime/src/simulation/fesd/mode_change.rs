//! What happens at a switch: impacts, the new contact mode, and the events that they leave.

use super::driver::Driver;
use super::switch::{Switch, SwitchKind};
use crate::fesd::contact_mode::ModeError;
use crate::simulation::{Event, EventKind};
use crate::time_freezing::clock;

impl Driver<'_> {
    /// Carries out a located switch at the present state.
    pub(super) fn carry_out(&mut self, switch: Switch) -> Result<(), ModeError> {
        if switch.kind == SwitchKind::Exit && !self.settings.exit_condition {
            self.release(switch.contact)?;
        } else {
            self.settle(&[switch.contact])?;
        }
        self.record();
        Ok(())
    }

    /// Ends the contact although its force has not vanished (no exit condition).
    pub(super) fn release(&mut self, contact: usize) -> Result<(), ModeError> {
        self.active.retain(|&i| i != contact);
        self.element.set_mode(&self.active);
        self.push_event(EventKind::LiftOff, contact, self.state.v.clone());
        self.evaluate_state()
    }

    pub(super) fn push_event(&mut self, kind: EventKind, contact: usize, v_before: Vec<f64>) {
        self.events.push(Event {
            time: self.state.time,
            kind,
            contact,
            q: self.state.q.clone(),
            v_before,
            v_after: self.state.v.clone(),
        });
    }

    /// Impact of everything that touches and closes, then the contact mode; records the events. The
    /// contacts that `switched` touch whatever the discretization error of their gaps.
    pub(super) fn settle(&mut self, switched: &[usize]) -> Result<(), ModeError> {
        self.write_input();
        self.contacts.evaluate_contacts(&self.x, &self.all_contacts);
        let tolerance = self.touching();
        let touching: Vec<usize> = self
            .all_contacts
            .iter()
            .copied()
            .filter(|&i| self.contacts.gap(i).abs() <= tolerance.gap || switched.contains(&i))
            .collect();
        let closing: Vec<usize> = touching
            .iter()
            .copied()
            .filter(|&i| self.contacts.normal_velocity(i) < -tolerance.velocity)
            .collect();
        let v_before = self.state.v.clone();
        let mut impulses = Vec::new();
        if !closing.is_empty() {
            self.contacts
                .impact(&touching, &mut impulses, &mut self.state.v)?;
            self.numerical_time += clock::jump(&impulses, self.settings.auxiliary_acceleration);
            self.write_input();
            if touching.len() > 1 {
                self.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
            }
        }
        let previous = self.active.clone();
        let mut active = std::mem::take(&mut self.active);
        // A flight lower than the rounding error of its gap is none: impacts that follow each other ever
        // faster end in contact.
        let lowest = self.gap_rounding();
        let slow = (2.0 * self.contacts.largest_scale(&touching) * lowest).sqrt();
        let selected = self.contacts.select(
            &self.x,
            &touching,
            tolerance.velocity.max(slow),
            &mut active,
        );
        self.active = active;
        selected?;
        if !self.active.is_empty() {
            self.contacts.evaluate_contacts(&self.x, &self.active);
            self.contacts.hold(&self.active, &mut self.state.v)?;
        }
        for i in self.all_contacts.clone() {
            // A contact that already carried a force takes part in the impact without one of its own.
            let struck = closing.contains(&i);
            let (before, after) = (previous.contains(&i), self.active.contains(&i));
            if struck {
                self.push_event(EventKind::Impact, i, v_before.clone());
            }
            if before && !after {
                self.push_event(EventKind::LiftOff, i, v_before.clone());
            } else if after && !before && !struck && self.state.time > 0.0 {
                self.push_event(EventKind::Contact, i, v_before.clone());
            }
        }
        self.element.set_mode(&self.active);
        self.evaluate_state()
    }

    /// Moves the present positions onto the surfaces of `close` contacts, along their directions.
    pub(super) fn project(&mut self, close: &[usize]) -> Result<(), ModeError> {
        for _ in 0..3 {
            self.write_input();
            self.contacts.evaluate_contacts(&self.x, close);
            self.contacts.close_gaps(close, &mut self.state.q)?;
        }
        Ok(())
    }
}
