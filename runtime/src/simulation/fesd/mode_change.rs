//! What happens at a switch: impacts, the new contact mode, and the events that they leave.

use super::driver::Driver;
use super::switch::{Switch, SwitchKind};
use crate::fesd::active_contact::{Tangential, find};
use crate::fesd::contacts::ModeError;
use crate::simulation::{Event, EventKind};
use crate::time_freezing::clock;

/// Rest velocity where none is set, relative to the largest velocity.
const REST: f64 = 1e-6;

/// What the change of a tangential state is called.
pub(super) fn sliding_event(before: Tangential, after: Tangential) -> Option<EventKind> {
    if before.sense() == after.sense() {
        None
    } else if after.sense() == 0.0 {
        Some(EventKind::Stick)
    } else {
        Some(EventKind::Slip)
    }
}

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
        self.active.retain(|held| held.contact != contact);
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
        self.contacts
            .evaluate_contacts(&self.x, 0..self.all_contacts.len());
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
        // A flight lower than the rounding error of its gap is none: impacts that follow each other ever
        // faster end in contact.
        let lowest = self.gap_rounding();
        let slow = (2.0 * self.contacts.largest_scale(&touching) * lowest).sqrt();
        let v_before = self.state.v.clone();
        let mut ended = Vec::new();
        if !closing.is_empty() {
            ended = self.impact(&touching, &closing, slow)?;
        }
        let previous = self.active.clone();
        let mut active = std::mem::take(&mut self.active);
        let selected = self.contacts.select(
            &self.x,
            &touching,
            (tolerance.velocity.max(slow), tolerance.sliding),
            &mut active,
        );
        self.active = active;
        selected?;
        self.end_cascades(&ended);
        if !self.active.is_empty() {
            let active = self.active.iter().map(|held| held.contact);
            self.contacts.evaluate_contacts(&self.x, active);
            self.contacts.hold(&self.active, &mut self.state.v)?;
        }
        // A contact that already carried a force takes part in the impact without one of its own.
        for &i in &closing {
            self.push_event(EventKind::Impact, i, v_before.clone());
        }
        for i in self.all_contacts.clone() {
            let struck = closing.contains(&i);
            let (before, after) = (find(&previous, i), find(&self.active, i));
            match (before, after) {
                (Some(_), None) => self.push_event(EventKind::LiftOff, i, v_before.clone()),
                (None, Some(_)) if !struck && self.state.time > 0.0 => {
                    self.push_event(EventKind::Contact, i, v_before.clone());
                }
                (Some(before), Some(after)) => {
                    if let Some(kind) = sliding_event(before, after) {
                        self.push_event(kind, i, v_before.clone());
                    }
                }
                _ => {}
            }
        }
        self.element.set_mode(&self.active);
        self.evaluate_state()
    }

    /// Rest velocity at the present state.
    pub(super) fn rest_velocity(&self) -> f64 {
        let largest = self.state.v.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
        self.settings.rest_velocity.unwrap_or(REST * largest)
    }

    /// The velocity jump of an impact of the `closing` contacts in which all `touching` ones take part.
    /// Contacts slower than the rest velocity, or at most `slow` afterwards, do not bounce; returns those with
    /// restitution among them, with their speed.
    fn impact(
        &mut self,
        touching: &[usize],
        closing: &[usize],
        slow: f64,
    ) -> Result<Vec<(usize, f64)>, ModeError> {
        let rest = self.rest_velocity();
        let mut ended = Vec::new();
        let mut restitution = vec![0.0; touching.len()];
        for (e, &i) in restitution.iter_mut().zip(touching) {
            let speed = -self.contacts.normal_velocity(i);
            if speed > rest && self.restitution[i] * speed > slow {
                *e = self.restitution[i];
            } else if self.restitution[i] > 0.0 && closing.contains(&i) {
                ended.push((i, speed));
            }
        }
        let mut impulses = Vec::new();
        self.contacts
            .impact(touching, &restitution, &mut impulses, &mut self.state.v)?;
        self.numerical_time += clock::jump(&impulses, self.settings.auxiliary_acceleration);
        self.write_input();
        if touching.len() > 1 {
            self.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
        }
        Ok(ended)
    }

    /// Remembers the bounces that the contacts in `ended`, which came with the given speeds and stay, did not
    /// carry out.
    pub(super) fn end_cascades(&mut self, ended: &[(usize, f64)]) {
        for &(i, speed) in ended {
            if find(&self.active, i).is_none() {
                continue;
            }
            let pull = -self.contacts.normal_acceleration(i);
            let height = (self.restitution[i] * speed).powi(2) / (2.0 * pull);
            let cascades = &mut self.cascades[i];
            if cascades.count == 0 {
                cascades.first = self.state.time;
            }
            cascades.count += 1;
            cascades.height = cascades.height.max(height);
        }
    }

    /// Says which bounce cascades were ended.
    pub(super) fn note_cascades(&mut self) {
        let contacts = self.model.declaration().contacts;
        for (cascades, contact) in self.cascades.clone().iter().zip(contacts) {
            if cascades.count > 0 {
                let times = if cascades.count == 1 {
                    "once"
                } else {
                    "repeatedly"
                };
                self.note(&format!(
                    "bounces of `{}` slower than the rest velocity end in contact: {times}, first at t = {} s; \
                     a bounce left out is at most {:.1e} {} high",
                    contact.name, cascades.first, cascades.height, contact.unit
                ));
            }
        }
    }

    /// Moves the present positions onto the surfaces of `close` contacts, along their directions.
    pub(super) fn project(&mut self, close: &[usize]) -> Result<(), ModeError> {
        for _ in 0..3 {
            self.write_input();
            self.contacts
                .evaluate_contacts(&self.x, close.iter().copied());
            self.contacts.close_gaps(close, &mut self.state.q)?;
        }
        Ok(())
    }
}
