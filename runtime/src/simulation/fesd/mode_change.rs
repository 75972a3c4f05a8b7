//! What happens at a switch: impacts, the new contact mode, and the events that they leave.

use super::driver::{Driver, EnergyGains};
use super::switch::{Switch, SwitchKind};
use crate::fesd::active_contact::{ActiveContact, Tangential, find};
use crate::fesd::contacts::{ModeError, dot};
use crate::fesd::{contact_mode, impact};
use crate::simulation::impact_cluster::{self, NearContact};
use crate::simulation::{ContactMode, Direction, Event, EventKind};
use crate::time_freezing::clock;

/// Rest velocity where none is set, relative to the size of the normal velocity.
const REST: f64 = 1e-6;

/// What a run says of bounces that it leaves out.
pub(super) const LEFT_OUT: &str = "slower than the rest velocity end in contact";

/// What it says of flights that it leaves out, where they begin with more than the share [`FELT`] of the velocity.
pub(super) const LOW_FLIGHTS: &str =
    "flights lower than the rounding error of their gap are left out";
const FELT: f64 = 1e-6;

/// Share of the largest velocity of a contact with which it closes at the end of many bounces.
const SLOW: f64 = 1e-3;

/// Kinetic energies are compared to this relative accuracy.
const SAME_ENERGY: f64 = 1e-12;

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

/// The bodies of a run in a cluster.
struct Bodies<'d, 'a>(&'d mut Driver<'a>);

impl impact_cluster::Bodies for Bodies<'_, '_> {
    type Error = ModeError;

    fn velocity(&mut self) -> &mut [f64] {
        &mut self.0.state.v
    }

    fn kinetic_energy(&mut self) -> f64 {
        self.0.kinetic_energy()
    }

    fn normal_velocity(&mut self, contact: usize) -> f64 {
        self.0.write_input();
        self.0
            .contacts
            .evaluate_contacts(&self.0.x, std::iter::once(contact));
        self.0.contacts.normal_velocity(contact)
    }

    fn zero_velocity(&self, contact: usize) -> f64 {
        let size = self.0.contacts.size(contact, self.0.state.time);
        size.touching_velocity()
    }

    fn slowest_bounce(&self, contact: usize) -> f64 {
        self.0.slowest_bounce(contact, false)
    }

    fn bring_to_rest(&mut self, contacts: &[usize]) {
        let driver = &mut *self.0;
        let resting = contacts.iter().map(|&contact| ActiveContact {
            contact,
            tangential: Tangential::Idle,
        });
        let resting: Vec<ActiveContact> = resting.collect();
        driver.write_input();
        driver
            .contacts
            .evaluate_contacts(&driver.x, contacts.iter().copied());
        if impact::hold(&driver.contacts, &resting, &mut driver.state.v).is_ok() {
            let q = driver.state.q.clone();
            if driver.project(contacts).is_err() {
                driver.state.q = q;
            }
        }
    }

    fn strike(&mut self, together: &[usize], elastic: bool) -> Result<f64, ModeError> {
        let driver = &mut *self.0;
        driver.write_input();
        driver
            .contacts
            .evaluate_contacts(&driver.x, together.iter().copied());
        let restitution: Vec<f64> = together
            .iter()
            .map(|&i| {
                let bounces = -driver.contacts.normal_velocity(i) > driver.slowest_bounce(i, false);
                if elastic && bounces {
                    driver.restitution[i]
                } else {
                    0.0
                }
            })
            .collect();
        let mut impulses = Vec::new();
        let v = &mut driver.state.v;
        impact::strike(&driver.contacts, together, &restitution, &mut impulses, v)?;
        Ok(clock::jump(
            &impulses,
            driver.settings.auxiliary_acceleration,
        ))
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

    /// The present mode of each contact.
    pub(super) fn modes(&self) -> Vec<ContactMode> {
        let mode = |&i: &usize| match find(&self.active, i) {
            None => ContactMode::Open,
            Some(Tangential::Forward) => ContactMode::Slip(Direction::Forward),
            Some(Tangential::Backward) => ContactMode::Slip(Direction::Backward),
            Some(_) if self.contacts.friction(i) > 0.0 => ContactMode::Stick,
            Some(_) => ContactMode::Frictionless,
        };
        self.all_contacts.iter().map(mode).collect()
    }

    pub(super) fn push_event(&mut self, kind: EventKind, contact: usize, v_before: Vec<f64>) {
        self.events.push(Event {
            time: self.state.time,
            kind,
            contact,
            contact_name: self.model.declaration().contacts[contact].name,
            modes: self.modes(),
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
        self.contacts.remember_sizes(&self.x);
        let time = self.state.time;
        let mut touching: Vec<usize> = self
            .all_contacts
            .iter()
            .copied()
            .filter(|&i| {
                self.contacts.gap(i) <= self.contacts.size(i, time).touching_gap()
                    || switched.contains(&i)
                    || find(&self.active, i).is_some()
            })
            .collect();
        let mut closing: Vec<usize> = touching
            .iter()
            .copied()
            .filter(|&i| {
                let limit = self.contacts.size(i, time).touching_velocity();
                self.contacts.normal_velocity(i) < -limit
            })
            .collect();
        let v_before = self.state.v.clone();
        let mut ended = Vec::new();
        let mut near = self.collapsing(&touching, &closing);
        if !near.is_empty() {
            closing = self.cluster(&near)?;
            touching = near.iter().map(|near| near.contact).collect();
        } else if !closing.is_empty() {
            match self.impact(&touching, &closing) {
                Ok(bounces) => ended = bounces,
                // At the end of bounces contacts may strike one after the other where together they jam.
                Err(ModeError::Jammed) if touching.len() > 1 && self.are_slow(&closing) => {
                    near = self.near(&touching);
                    closing = self.cluster(&near)?;
                }
                Err(error) => return Err(error),
            }
        }
        let previous = self.active.clone();
        let mut active = std::mem::take(&mut self.active);
        let selected =
            contact_mode::select(&mut self.contacts, &self.x, &touching, time, &mut active);
        self.active = active;
        selected?;
        self.end_cascades(&ended);
        if !self.active.is_empty() {
            let active: Vec<usize> = self.active.iter().map(|held| held.contact).collect();
            if !near.is_empty() {
                // A cluster ends within gaps that are more than rounding.
                self.project(&active)?;
                self.write_input();
            }
            self.contacts.evaluate_contacts(&self.x, active);
            self.note_held_flights();
            impact::hold(&self.contacts, &self.active, &mut self.state.v)?;
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

    /// Says whether contacts are held that leave with a velocity others could feel.
    fn note_held_flights(&mut self) {
        let time = self.state.time;
        let leaves = |held: &ActiveContact| {
            let i = held.contact;
            self.contacts.normal_velocity(i) > FELT * self.contacts.size(i, time).speed()
        };
        if self.active.iter().any(leaves) {
            self.note(LOW_FLIGHTS);
        }
    }

    /// Normal velocity below which a contact with restitution no longer bounces.
    pub(super) fn rest_velocity(&self, contact: usize) -> f64 {
        let largest = self.contacts.size(contact, self.state.time).speed();
        self.settings.rest_velocity.unwrap_or(REST * largest)
    }

    /// Speed up to which a contact that touches, `alone` or beside others, does not bounce: its bounce would stay within
    /// what counts as touching. Infinite without restitution.
    fn slowest_bounce(&self, contact: usize, alone: bool) -> f64 {
        let size = self.contacts.size(contact, self.state.time);
        let lowest = if alone {
            size.gap_rounding()
        } else {
            size.touching_gap()
        };
        let slowest = (2.0 * self.contacts.phi_scale(contact) * lowest).sqrt();
        self.rest_velocity(contact)
            .max(slowest / self.restitution[contact])
    }

    /// The contacts of a cluster, if the impact of the `closing` ones is one of several that follow too fast to be told
    /// apart: a contact that touches has left its surface and goes on leaving, so it is not struck at the same instant.
    /// At the start only its gap tells.
    fn collapsing(&self, touching: &[usize], closing: &[usize]) -> Vec<NearContact> {
        let time = self.state.time;
        let leaves = |&i: &usize| {
            let size = self.contacts.size(i, time);
            find(&self.active, i).is_none()
                && (time > 0.0 || self.contacts.gap(i) > size.gap_rounding())
                && self.contacts.normal_velocity(i) > size.touching_velocity()
        };
        if closing.is_empty() || !touching.iter().any(leaves) {
            return Vec::new();
        }
        self.near(touching)
    }

    /// Whether contacts close with little of what their velocities have been.
    fn are_slow(&self, closing: &[usize]) -> bool {
        closing.iter().all(|&i| {
            let size = self.contacts.size(i, self.state.time);
            -self.contacts.normal_velocity(i) <= SLOW * size.speed()
        })
    }

    /// The gaps of contacts that may strike one after the other.
    fn near(&self, touching: &[usize]) -> Vec<NearContact> {
        let time = self.state.time;
        let near = |&contact: &usize| {
            let held = find(&self.active, contact).is_some();
            let (gap, touching) = (
                self.contacts.gap(contact).max(0.0),
                self.contacts.size(contact, time).touching_gap(),
            );
            let (gap, rounding) = if held { (0.0, 0.0) } else { (gap, touching) };
            NearContact {
                contact,
                gap,
                rounding,
            }
        };
        touching.iter().map(near).collect()
    }

    /// Carries out the impacts of a cluster; returns the contacts struck.
    fn cluster(&mut self, near: &[NearContact]) -> Result<Vec<usize>, ModeError> {
        let cluster = impact_cluster::resolve(&mut Bodies(self), near)?;
        self.write_input();
        self.contacts
            .evaluate_contacts(&self.x, 0..self.all_contacts.len());
        self.numerical_time += cluster.numerical_time;
        if let Some(note) = cluster.note() {
            self.note(note);
        }
        Ok(cluster.struck)
    }

    /// The velocity jump of an impact of the `closing` contacts in which all `touching` ones take part.
    /// Returns those with restitution among them that do not bounce, with their speed.
    fn impact(
        &mut self,
        touching: &[usize],
        closing: &[usize],
    ) -> Result<Vec<(usize, f64)>, ModeError> {
        let alone = touching.len() == 1;
        let mut ended = Vec::new();
        let mut restitution = vec![0.0; touching.len()];
        for (e, &i) in restitution.iter_mut().zip(touching) {
            let speed = -self.contacts.normal_velocity(i);
            if speed > self.slowest_bounce(i, alone) {
                *e = self.restitution[i];
            } else if self.restitution[i] > 0.0 && closing.contains(&i) {
                ended.push((i, speed));
            }
        }
        let elastic = restitution.iter().any(|e| *e > 0.0);
        let before = if elastic { self.kinetic_energy() } else { 0.0 };
        let mut impulses = Vec::new();
        let v = &mut self.state.v;
        impact::strike(&self.contacts, touching, &restitution, &mut impulses, v)?;
        self.numerical_time += clock::jump(&impulses, self.settings.auxiliary_acceleration);
        self.write_input();
        if elastic {
            self.compare_energies(before, closing);
        }
        if touching.len() > 1 {
            self.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
        }
        Ok(ended)
    }

    /// Kinetic energy at the present state, `v' M v / 2`, at the position last written to the input vector.
    fn kinetic_energy(&self) -> f64 {
        let (n, v) = (self.n, &self.state.v);
        let mut mass = vec![0.0; n * n];
        self.model.mass_matrix(&self.x, &mut mass);
        let momentum = mass.chunks_exact(n).map(|row| dot(row, v));
        0.5 * momentum.zip(v).map(|(p, v)| p * v).sum::<f64>()
    }

    /// Remembers an impact of the `closing` contacts that raised the kinetic energy.
    fn compare_energies(&mut self, before: f64, closing: &[usize]) {
        let after = self.kinetic_energy();
        let Some(&contact) = closing.first() else {
            return;
        };
        if after > before * (1.0 + SAME_ENERGY) {
            let gains = self.energy_gains.get_or_insert(EnergyGains {
                count: 0,
                first: (self.state.time, contact),
                energies: (before, after),
            });
            gains.count += 1;
        }
    }

    /// Says whether impacts raised the kinetic energy.
    pub(super) fn note_energy_gains(&mut self) {
        let Some(gains) = self.energy_gains else {
            return;
        };
        let ((time, contact), (before, after)) = (gains.first, gains.energies);
        self.note(&format!(
            "{} impacts raise the kinetic energy, the first of `{}` at {time:.6} s from {before:.6e} to \
             {after:.6e}: restitution in the normal direction alone does so where friction or several \
             contacts couple; lower the restitution",
            gains.count,
            self.model.declaration().contacts[contact].name
        ));
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
                    "bounces of `{}` {LEFT_OUT}: {times}, first at t = {} s; \
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
            impact::close_gaps(&self.contacts, close, &mut self.state.q)?;
        }
        Ok(())
    }
}
