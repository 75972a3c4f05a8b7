//! Switching functions: what they are in a contact mode, their values, and what counts as zero.

use super::{Dynamics, dot};
use crate::model::contact_point;
use crate::simulation::event::contact_state::{ContactState, Direction};
use crate::simulation::event::dop853::System;

/// Normal contact accelerations below this times the accelerations they balance are zero.
const ZERO_FORCE: f64 = 1e-12;
/// Sliding velocities up to this multiple of what counts as zero are those of a contact that others hold: it is held
/// by rounding error where the geometry keeps it, and slides where that was so at one instant only.
const HELD: f64 = 1e3;
/// Value of a switching function that is none.
const CONSTANT: f64 = 1.0;
/// A function of time whose zero ends the contact mode; all are positive within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simulation) enum Switch {
    /// The gap of an open contact.
    Gap(usize),
    /// The normal contact acceleration `r` of an active contact.
    NormalForce(usize),
    /// What a sticking contact has left before it slips in a direction, `mu r + s` or `mu r - s`.
    FrictionLimit(usize, Direction),
    /// The sliding velocity, in its direction, of a contact that slips.
    SlidingVelocity(usize, Direction),
    /// How far the sliding velocity of a contact that others hold is from counting as sliding.
    HeldVelocity(usize),
    /// None: a constant.
    Constant(usize),
}

impl Switch {
    pub(in crate::simulation) fn contact(self) -> usize {
        match self {
            Self::Gap(i)
            | Self::NormalForce(i)
            | Self::FrictionLimit(i, _)
            | Self::SlidingVelocity(i, _)
            | Self::HeldVelocity(i)
            | Self::Constant(i) => i,
        }
    }

    /// What it is, in words.
    pub(in crate::simulation) fn words(self) -> &'static str {
        match self {
            Self::Gap(_) => "the gap",
            Self::NormalForce(_) => "the normal force",
            Self::FrictionLimit(..) => "the reserve of friction",
            Self::SlidingVelocity(..) | Self::HeldVelocity(_) => "the sliding velocity",
            Self::Constant(_) => "nothing",
        }
    }

    fn is_force(self) -> bool {
        matches!(self, Self::NormalForce(_) | Self::FrictionLimit(..))
    }
}

impl Dynamics<'_> {
    /// What a switching function is in the present mode.
    pub(in crate::simulation) fn switch(&self, function: usize) -> Switch {
        if function < self.contacts {
            return if self.mode[function].is_open() {
                Switch::Gap(function)
            } else {
                Switch::NormalForce(function)
            };
        }
        let index = function - self.contacts;
        let contact = self.frictional[index / 2];
        match (self.mode[contact], index % 2) {
            (ContactState::Stick, 0) => Switch::FrictionLimit(contact, Direction::Forward),
            (ContactState::Stick, _) => Switch::FrictionLimit(contact, Direction::Backward),
            (ContactState::Slip(direction), 0) => Switch::SlidingVelocity(contact, direction),
            (ContactState::Held(_), 0) => Switch::HeldVelocity(contact),
            _ => Switch::Constant(contact),
        }
    }

    /// Number of switching functions.
    pub(in crate::simulation) fn functions(&self) -> usize {
        self.values.len()
    }

    /// Sets the sizes of forces to which others are compared, for the contacts given; contacts and free
    /// acceleration are evaluated.
    pub(in crate::simulation) fn set_force_floors(&mut self, contacts: &[usize]) {
        self.model.mass_matrix(&self.x, &mut self.mass);
        let a = &self.acceleration;
        let square: f64 = self
            .mass
            .chunks_exact(self.n.max(1))
            .zip(a)
            .map(|(row, a_k)| a_k * dot(row, a))
            .sum();
        for &i in contacts {
            let inverse_inertia = self.point(i)[contact_point::INVERSE_INERTIA];
            let floor = f64::max(
                (inverse_inertia * square).max(0.0).sqrt(),
                self.scales[i].acceleration(),
            );
            self.force_floor[i] = floor;
            self.accepted_pull[i] = 0.0;
            if let Some(slot) = self.frictional.iter().position(|&other| other == i) {
                let first = self.contacts + 2 * slot;
                self.force_floor[first..first + 2].fill((1.0 + self.friction[i]) * floor);
                self.accepted_pull[first..first + 2].fill(0.0);
            }
        }
    }

    /// Size of forces to which those of a contact are compared.
    pub(in crate::simulation) fn force_floor(&self, contact: usize) -> f64 {
        self.force_floor[contact]
    }

    /// Accepts the contact forces last evaluated: one that is negative by rounding error, or for an instant only, is
    /// no reason to leave a new mode again.
    pub(in crate::simulation) fn accept_forces(&mut self) {
        for function in 0..self.functions() {
            if self.switch(function).is_force() {
                let pull = -self.values[function];
                let accepted = &mut self.accepted_pull[function];
                *accepted = accepted.max(2.0 * pull);
            }
        }
    }

    /// Makes `values` the first sample of a step.
    pub(in crate::simulation) fn sample_from(&mut self, values: &[f64]) {
        self.lowest.copy_from_slice(values);
        self.highest.copy_from_slice(values);
        self.undefined = None;
    }

    /// Below this gap a contact is closed.
    pub(in crate::simulation) fn closed_gap(&self, contact: usize) -> f64 {
        self.scales[contact].closed_gap()
    }

    /// Rounding error of a gap.
    pub(super) fn gap_rounding(&self, contact: usize) -> f64 {
        self.scales[contact].rounding()
    }

    /// Range of the values of a gap so far.
    pub(in crate::simulation) fn gap_range(&self, contact: usize) -> f64 {
        self.scales[contact].range()
    }

    /// Flights lower than this are none.
    pub(in crate::simulation) fn lowest_flight(&self, contact: usize) -> f64 {
        self.scales[contact].lowest_flight()
    }

    /// Below this normal velocity a contact is at rest.
    pub(in crate::simulation) fn zero_normal_velocity(&self, contact: usize) -> f64 {
        self.scales[contact].zero_normal_velocity()
    }

    /// Below this sliding velocity a contact does not slide.
    pub(in crate::simulation) fn zero_sliding_velocity(&self, contact: usize) -> f64 {
        self.scales[contact].zero_sliding_velocity()
    }

    /// Up to this a sliding velocity is that of a contact that others hold.
    fn held_velocity(&self, contact: usize) -> f64 {
        HELD * self.zero_sliding_velocity(contact)
    }

    /// What counts as zero for a switching function.
    pub(in crate::simulation) fn zero_value(&self, function: usize) -> f64 {
        match self.switch(function) {
            Switch::Gap(i) => self.closed_gap(i),
            Switch::SlidingVelocity(i, _) => self.zero_sliding_velocity(i),
            Switch::NormalForce(_) | Switch::FrictionLimit(..) => {
                (ZERO_FORCE * self.size(function)).max(self.accepted_pull[function])
            }
            Switch::HeldVelocity(_) | Switch::Constant(_) => 0.0,
        }
    }

    /// Size of a switching function: the range of a gap, the terms of forces, the largest sliding velocity.
    pub(in crate::simulation) fn size(&self, function: usize) -> f64 {
        match self.switch(function) {
            Switch::Gap(i) => self.gap_range(i),
            Switch::SlidingVelocity(i, _) | Switch::HeldVelocity(i) => {
                self.scales[i].sliding_velocity()
            }
            Switch::NormalForce(_) | Switch::FrictionLimit(..) => {
                self.force_scale[function].max(self.force_floor[function])
            }
            Switch::Constant(_) => CONSTANT,
        }
    }

    /// Evaluates one switching function; `slope` is for the derivative, if it needs that.
    pub(in crate::simulation) fn switching_value(
        &mut self,
        function: usize,
        t: f64,
        y: &[f64],
        slope: &mut [f64],
    ) -> f64 {
        match self.switch(function) {
            Switch::Gap(i) => {
                self.load(t, y);
                self.gap(i)
            }
            Switch::SlidingVelocity(i, direction) => {
                self.load(t, y);
                self.evaluate_tangent(i);
                direction.sign() * self.sliding_velocity(i)
            }
            Switch::HeldVelocity(i) => {
                self.load(t, y);
                self.evaluate_tangent(i);
                self.held_velocity(i) - self.sliding_velocity(i).abs()
            }
            Switch::NormalForce(_) | Switch::FrictionLimit(..) => {
                self.derivative(t, y, slope);
                self.values[function]
            }
            Switch::Constant(_) => CONSTANT,
        }
    }

    /// Writes the switching functions, once rows and contact accelerations are known, and the sizes of the
    /// terms of those that are forces.
    pub(super) fn evaluate_switches(&mut self, rows: usize) {
        for i in 0..self.contacts {
            if self.mode[i].is_open() {
                self.values[i] = self.gap(i);
            }
        }
        for slot in 0..self.active.len() {
            let i = self.active[slot];
            self.values[i] = self.r[i];
            self.force_scale[i] = self.row_scale(slot, rows);
        }
        for function in self.contacts..self.functions() {
            self.values[function] = match self.switch(function) {
                Switch::FrictionLimit(i, direction) => {
                    self.friction[i] * self.r[i] + direction.sign() * self.s[i]
                }
                Switch::SlidingVelocity(i, direction) => {
                    direction.sign() * self.sliding_velocity(i)
                }
                Switch::HeldVelocity(i) => self.held_velocity(i) - self.sliding_velocity(i).abs(),
                _ => CONSTANT,
            };
        }
        for slot in 0..self.sticking.len() {
            let i = self.sticking[slot];
            let scale = self.friction[i] * self.force_scale[i]
                + self.row_scale(self.active.len() + slot, rows);
            let first = self
                .frictional
                .iter()
                .position(|&other| other == i)
                .map_or(0, |slot| self.contacts + 2 * slot);
            self.force_scale[first..first + 2].fill(scale);
        }
    }
}
