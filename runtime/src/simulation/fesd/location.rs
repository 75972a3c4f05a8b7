//! Location of a switch: the element lengths at whose end its condition holds.

use super::driver::Driver;
use super::stop::Stop;
use super::switch::{ElementStart, Switch, SwitchKind};
use crate::fesd::active_contact::{ActiveContact, Tangential, find, force_count};

/// Force beyond its bound that another switch explains, relative to its terms; larger ones are switches of
/// their own.
const CROSSED: f64 = 1e-9;
/// Size of a force that changes its sign, relative to its terms, above which it does so through infinity.
const POLE: f64 = 1e-3;
/// Evaluations of the switch condition that locate one switch.
const MAX_LOCATIONS: usize = 60;

impl Driver<'_> {
    pub(super) fn violation(&mut self) -> Result<Option<Switch>, Stop> {
        let start = ElementStart {
            x: &self.x,
            gaps: &self.gaps,
            velocities: &self.velocities,
            sliding: &self.sliding,
            forces: &self.forces,
            acceleration: &self.acceleration,
            time: self.state.time,
        };
        self.detector
            .first_violation(&self.element, &mut self.contacts, &start)
    }

    /// Finds the common length of `count` elements at whose end the switch condition holds, and makes
    /// them part of the trajectory. Another contact that turns out to switch earlier takes over.
    pub(super) fn locate(
        &mut self,
        mut switch: Switch,
        longest: f64,
        count: usize,
        recorded: usize,
    ) -> Result<Switch, Stop> {
        let start_numerical_time = self.numerical_time;
        for _ in 0..=2 * self.all_contacts.len() {
            self.locate_one(switch, longest, count)?;
            self.trajectory.truncate(recorded);
            self.numerical_time = start_numerical_time;
            let mut length = self.element.length();
            if switch.kind == SwitchKind::Exit && !self.settings.exit_condition {
                length = self.earliest_release(switch.contact, length, longest, count)?;
            }
            if count == 1 && length == self.element.length() {
                // The element of the last evaluation is the located one; the present state is its end already.
                self.state.copy_from(&self.segment_start);
                self.accept_element()?;
            } else {
                self.state.copy_from(&self.segment_start);
                for _ in 0..count {
                    self.element.solve(&self.state, length, &self.piece)?;
                    self.accept_element()?;
                }
            }
            match self.earlier_violation(switch) {
                None => return Ok(switch),
                Some(other) => {
                    switch = other;
                    let ratio = length / longest;
                    switch.theta = ratio * count as f64 - (count - 1) as f64;
                    switch.violated = switch.theta;
                    self.trajectory.truncate(recorded);
                    self.numerical_time = start_numerical_time;
                    self.state.copy_from(&self.segment_start);
                }
            }
        }
        Err(Stop::Location)
    }

    /// Whether the condition of a switch already holds at the start of the segment: where dense output puts it
    /// next to the start, it may be far from it for an element that is much too long.
    pub(super) fn holds_at_start(&self, switch: Switch) -> bool {
        let i = switch.contact;
        let size = self.contacts.size(i, self.state.time);
        let slot = self.active.iter().position(|held| held.contact == i);
        let force = slot.map_or(0.0, |slot| self.forces[slot]);
        match switch.kind {
            SwitchKind::Entry => self.gaps[i] <= size.touching_gap(),
            SwitchKind::Reentry => true,
            SwitchKind::Exit => force <= CROSSED * self.contacts.phi_scale(i),
            SwitchKind::Slipping => {
                let frictions = self.contacts.frictions(&self.active, &self.forces);
                let s = frictions
                    .zip(&self.active)
                    .find(|(_, held)| held.contact == i);
                let margin = self.contacts.friction(i) * force - s.map_or(0.0, |(s, _)| s.abs());
                margin <= CROSSED * self.contacts.tangential_scale(i)
            }
            SwitchKind::Stopping => self.sliding[i].abs() <= size.crossed_rest(),
        }
    }

    /// A sign condition other than the located one that is violated at the present state.
    pub(super) fn earlier_violation(&self, located: Switch) -> Option<Switch> {
        let other = |kind, contact, slope| {
            let normal = |kind| {
                matches!(
                    kind,
                    SwitchKind::Entry | SwitchKind::Reentry | SwitchKind::Exit
                )
            };
            let same = contact == located.contact && normal(kind) == normal(located.kind);
            (!same).then_some(Switch {
                kind,
                contact,
                theta: 1.0,
                violated: 1.0,
                slope,
            })
        };
        let size = |i: usize| self.contacts.size(i, self.state.time);
        let closed = self
            .all_contacts
            .iter()
            .filter(|&&i| find(&self.active, i).is_none())
            .find(|&&i| self.gaps[i] < -size(i).touching_gap())
            .and_then(|&i| {
                other(
                    SwitchKind::Entry,
                    i,
                    self.contacts.normal_velocity(i).min(-f64::MIN_POSITIVE),
                )
            });
        if closed.is_some() {
            return closed;
        }
        let frictions = self.contacts.frictions(&self.active, &self.forces);
        for ((held, &r), s) in self.active.iter().zip(&self.forces).zip(frictions) {
            let i = held.contact;
            let found = if r < -CROSSED * self.contacts.phi_scale(i) {
                other(SwitchKind::Exit, i, located.slope)
            } else if held.sticks() {
                let margin = self.contacts.friction(i) * r - s.abs();
                (margin < -CROSSED * self.contacts.tangential_scale(i))
                    .then(|| other(SwitchKind::Slipping, i, located.slope))
                    .flatten()
            } else {
                let speed = held.tangential.sense() * self.sliding[i];
                (speed < -size(i).crossed_rest())
                    .then(|| other(SwitchKind::Stopping, i, located.slope))
                    .flatten()
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// Newton's method with secant slopes on the common element length, kept inside a bracket.
    pub(super) fn locate_one(
        &mut self,
        switch: Switch,
        longest: f64,
        count: usize,
    ) -> Result<(), Stop> {
        let tolerance = 2.0 * f64::EPSILON * self.segment_start.time.max(longest * count as f64);
        let length_at = |theta: f64| ((count - 1) as f64 + theta) * longest / count as f64;
        // A little room beyond the violated place, which the dense output of another element named.
        let (mut before, mut after) = (0.0, length_at(switch.violated) + 0.01 * longest);
        let mut length = length_at(switch.theta);
        let mut slope = switch.slope * count as f64;
        let mut previous: Option<(f64, f64)> = None;
        for _ in 0..MAX_LOCATIONS {
            let value = self.switch_condition(switch, length, count)?;
            if let Some((earlier, earlier_value)) = previous {
                let secant = (value - earlier_value) / (length - earlier);
                if secant.is_finite() && secant != 0.0 {
                    slope = secant;
                }
            }
            previous = Some((length, value));
            if value > 0.0 {
                before = length;
            } else {
                after = length;
            }
            let step = value / slope;
            if value == 0.0 || step.abs() <= tolerance || after - before <= tolerance {
                let force = matches!(switch.kind, SwitchKind::Exit | SwitchKind::Slipping);
                let pole = force && value.abs() > POLE * self.contacts.phi_scale(switch.contact);
                return if pole { Err(Stop::Location) } else { Ok(()) };
            }
            length -= step;
            if !(before < length && length < after) {
                length = 0.5 * (before + after);
            }
        }
        Err(Stop::Location)
    }

    /// Solves `count` elements of `length` from the segment's start, without recording.
    pub(super) fn solve_elements(&mut self, length: f64, count: usize) -> Result<(), Stop> {
        self.state.copy_from(&self.segment_start);
        for _ in 0..count {
            self.element.solve(&self.state, length, &self.piece)?;
            self.state.copy_from(&self.element.end);
        }
        Ok(())
    }

    /// Value of the switching function after `count` elements of `length` from the segment's start.
    pub(super) fn switch_condition(
        &mut self,
        switch: Switch,
        length: f64,
        count: usize,
    ) -> Result<f64, Stop> {
        self.solve_elements(length, count)?;
        self.write_input();
        match switch.kind {
            SwitchKind::Entry => Ok(self.model.gap(switch.contact, &self.x)),
            SwitchKind::Reentry => {
                self.contacts.evaluate_contacts(&self.x, [switch.contact]);
                let gap = self.contacts.gap(switch.contact);
                Ok(gap.max(self.contacts.normal_velocity(switch.contact)))
            }
            SwitchKind::Exit | SwitchKind::Slipping => {
                let held = self.active.iter().map(|held| held.contact);
                self.contacts.evaluate(&self.x, held);
                self.forces.resize(force_count(&self.active), 0.0);
                self.contacts
                    .contact_forces(&self.active, &mut self.forces)?;
                let of = |held: &ActiveContact| held.contact == switch.contact;
                let Some(slot) = self.active.iter().position(of) else {
                    return Ok(f64::NAN);
                };
                let r = self.forces[slot];
                if switch.kind == SwitchKind::Exit {
                    return Ok(r);
                }
                let s = self
                    .contacts
                    .frictions(&self.active, &self.forces)
                    .nth(slot);
                Ok(self.contacts.friction(switch.contact) * r - s.map_or(f64::NAN, f64::abs))
            }
            SwitchKind::Stopping => {
                self.contacts.evaluate_contacts(&self.x, [switch.contact]);
                let sense = find(&self.active, switch.contact).map_or(f64::NAN, Tangential::sense);
                Ok(sense * self.contacts.sliding_velocity(switch.contact))
            }
        }
    }

    /// Without the exit condition the published method also admits earlier take-offs: down to the common
    /// element length at which the gap at the first stage of the following element vanishes. Returns that
    /// length, by bisection, or `latest` where the scheme admits no earlier one.
    pub(super) fn earliest_release(
        &mut self,
        contact: usize,
        latest: f64,
        next_length: f64,
        count: usize,
    ) -> Result<f64, Stop> {
        let (mut early, mut late) = (0.0, latest);
        for _ in 0..52 {
            let middle = 0.5 * (early + late);
            self.solve_elements(middle, count)?;
            if self.first_gap_after_release(contact, next_length)? >= 0.0 {
                late = middle;
            } else {
                early = middle;
            }
        }
        Ok(late)
    }

    /// Gap at the first stage of an element of length `h` from the present state without `contact`.
    pub(super) fn first_gap_after_release(&mut self, contact: usize, h: f64) -> Result<f64, Stop> {
        let released: Vec<ActiveContact> = self
            .active
            .iter()
            .copied()
            .filter(|held| held.contact != contact)
            .collect();
        self.next_element.set_mode(&released);
        self.next_element.solve(&self.state, h, &self.piece)?;
        Ok(self.model.gap(contact, self.next_element.stage_input(0)))
    }
}
