//! Location of a switch: the element lengths at whose end its condition holds.

use super::driver::{Driver, Stop, TOUCHING_GAP};
use super::switch::{ElementStart, Switch, SwitchKind};
use crate::fesd::contact_mode::Touching;

/// Rounding error of a gap or a normal velocity, relative to the largest coordinate or velocity.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Evaluations of the switch condition that locate one switch.
const MAX_LOCATIONS: usize = 60;

impl Driver<'_> {
    pub(super) fn violation(&mut self) -> Result<Option<Switch>, Stop> {
        let largest = |values: &[f64]| values.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
        let start = ElementStart {
            x: &self.x,
            gaps: &self.gaps,
            velocities: &self.velocities,
            forces: &self.forces,
            rounding: Touching {
                gap: self.gap_rounding(),
                velocity: ROUNDING * largest(&self.state.v),
            },
            touching_gap: TOUCHING_GAP * largest(&self.state.q),
            speed: largest(&self.state.v),
        };
        self.detector
            .first_violation(&self.element, &mut self.contacts, &start)
    }

    /// Rounding error of a gap at the present state.
    pub(super) fn gap_rounding(&self) -> f64 {
        ROUNDING * self.state.q.iter().fold(1.0_f64, |s, q| s.max(q.abs()))
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
                // The element of the last evaluation is the located one.
                self.accept_element()?;
            } else {
                self.state.copy_from(&self.segment_start);
                for _ in 0..count {
                    self.element.solve(&self.state, length, &self.u)?;
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

    /// A sign condition other than the located one that is violated at the present state.
    pub(super) fn earlier_violation(&self, located: Switch) -> Option<Switch> {
        let other = |kind, contact, slope| {
            (contact != located.contact).then_some(Switch {
                kind,
                contact,
                theta: 1.0,
                violated: 1.0,
                slope,
            })
        };
        let closed = self
            .all_contacts
            .iter()
            .filter(|i| !self.active.contains(i))
            .find(|&&i| self.gaps[i] < -self.touching().gap)
            .and_then(|&i| {
                other(
                    SwitchKind::Entry,
                    i,
                    self.contacts.normal_velocity(i).min(-f64::MIN_POSITIVE),
                )
            });
        closed.or_else(|| {
            self.active
                .iter()
                .zip(&self.forces)
                .find(|&(&i, &r)| r < -TOUCHING_GAP * self.contacts.phi_scale(i))
                .and_then(|(&i, _)| other(SwitchKind::Exit, i, located.slope))
        })
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
                return Ok(());
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
            self.element.solve(&self.state, length, &self.u)?;
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
                self.contacts.evaluate_contacts(&self.x, &[switch.contact]);
                let gap = self.contacts.gap(switch.contact);
                Ok(gap.max(self.contacts.normal_velocity(switch.contact)))
            }
            SwitchKind::Exit => {
                self.contacts.evaluate(&self.x, &self.active);
                self.forces.resize(self.active.len(), 0.0);
                self.contacts
                    .contact_accelerations(&self.active, &mut self.forces)?;
                let slot = self.active.iter().position(|&i| i == switch.contact);
                Ok(slot.map_or(f64::NAN, |slot| self.forces[slot]))
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
        let released: Vec<usize> = self
            .active
            .iter()
            .copied()
            .filter(|&i| i != contact)
            .collect();
        self.next_element.set_mode(&released);
        self.next_element.solve(&self.state, h, &self.u)?;
        Ok(self.model.gap(contact, self.next_element.stage_input(0)))
    }
}
