//! Contacts that slide along two directions: both sliding velocities in the frame of each, and where it points.

use super::{Dynamics, dot};
use crate::fesd::frame::Frame;
use crate::model::tangent_point;
use crate::simulation::event::contact_state::ContactState;

/// A sliding velocity that is held: in space each contact has two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stuck {
    pub(super) contact: usize,
    /// Whether it is the second one.
    pub(super) across: bool,
}

impl Dynamics<'_> {
    /// Whether a contact slides along two directions.
    pub(in crate::simulation) fn is_in_space(&self, contact: usize) -> bool {
        let friction = self.model.declaration().contacts[contact].friction;
        !self.frames.is_empty() && friction.is_some_and(|friction| friction.across.is_some())
    }

    /// Turns what was evaluated of a contact in space by a frame.
    pub(super) fn turn(&mut self, contact: usize, by: Frame) {
        let (n, length) = (self.n, tangent_point::length(self.n));
        let tangent = &mut self.evaluated.tangents[contact * length..(contact + 1) * length];
        let across = &mut self.evaluated.across[contact * length..(contact + 1) * length];
        by.turn(tangent, across);
        let slide = self.frames[contact].direction((
            tangent[tangent_point::SLIDING_VELOCITY],
            across[tangent_point::SLIDING_VELOCITY],
        ));
        let directions = tangent[tangent_point::direction(n)..]
            .iter()
            .zip(&across[tangent_point::direction(n)..]);
        let slipping = &mut self.evaluated.slipping[contact * n..(contact + 1) * n];
        for (slip, (along, across)) in slipping.iter_mut().zip(directions) {
            *slip = slide.along * along + slide.across * across;
        }
    }

    /// Turns the frame of a contact in space so that it points along what is `(first, second)` in it.
    pub(in crate::simulation) fn align(&mut self, contact: usize, to: (f64, f64)) {
        if self.is_in_space(contact) {
            let mut by = Frame::default();
            by.align(to);
            self.frames[contact].align(to);
            self.turn(contact, by);
        }
    }

    /// Lets the frame of a contact in space point along its sliding velocity, where that has a direction.
    pub(in crate::simulation) fn align_with_sliding(&mut self, contact: usize) {
        if self.is_in_space(contact) && self.sliding_speed(contact) > self.frames[contact].soft {
            self.align(contact, self.sliding(contact));
        }
    }

    /// The second tangential side of a contact in space as last evaluated.
    fn across_point(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.n);
        &self.evaluated.across[contact * length..(contact + 1) * length]
    }

    /// Both sliding velocities as last evaluated; the second is 0 in the plane.
    pub(in crate::simulation) fn sliding(&self, contact: usize) -> (f64, f64) {
        let across = match self.is_in_space(contact) {
            true => self.across_point(contact)[tangent_point::SLIDING_VELOCITY],
            false => 0.0,
        };
        (self.sliding_velocity(contact), across)
    }

    /// Size of the sliding velocity as last evaluated.
    pub(in crate::simulation) fn sliding_speed(&self, contact: usize) -> f64 {
        pair_size(self.sliding(contact))
    }

    /// The second tangent of a contact in space, and the direction of its force, as last evaluated.
    pub(in crate::simulation) fn across(&self, contact: usize) -> (&[f64], &[f64]) {
        let across = self.across_point(contact);
        (
            &across[tangent_point::TANGENT..][..self.n],
            &across[tangent_point::direction(self.n)..][..self.n],
        )
    }

    /// Rate of the second sliding velocity of a contact in space under the acceleration `a`; 0 in the plane.
    pub(in crate::simulation) fn across_acceleration(&self, contact: usize, a: &[f64]) -> f64 {
        match self.is_in_space(contact) {
            true => {
                let curvature = self.across_point(contact)[tangent_point::CURVATURE];
                curvature + dot(self.across(contact).0, a)
            }
            false => 0.0,
        }
    }

    /// Tangent and direction of the force of a sliding velocity that is held.
    pub(super) fn stuck(&self, held: Stuck) -> (&[f64], &[f64]) {
        match held.across {
            true => self.across(held.contact),
            false => (
                self.tangent(held.contact),
                self.friction_direction(held.contact),
            ),
        }
    }

    /// Rate of a sliding velocity that is held under the acceleration `a`.
    pub(super) fn stuck_acceleration(&self, held: Stuck, a: &[f64]) -> f64 {
        match held.across {
            true => self.across_acceleration(held.contact, a),
            false => self.contact_accelerations(held.contact, a).1,
        }
    }

    /// The direction in which friction of a contact acts that slips.
    pub(in crate::simulation) fn slip_direction(&self, contact: usize) -> &[f64] {
        match self.is_in_space(contact) {
            true => &self.evaluated.slipping[contact * self.n..(contact + 1) * self.n],
            false => self.friction_direction(contact),
        }
    }

    /// Below this speed a contact does not slide.
    pub(in crate::simulation) fn zero_speed(&self, contact: usize) -> f64 {
        let zero = self.zero_sliding_velocity(contact);
        match self.is_in_space(contact) {
            true => zero.max(self.frames[contact].soft),
            false => zero,
        }
    }

    /// Size of the tangential acceleration that a contact provides at the last evaluation.
    pub(in crate::simulation) fn friction_size(&self, contact: usize) -> f64 {
        pair_size((self.equations.s[contact], self.equations.across[contact]))
    }

    /// Takes note of the sliding of an evaluated contact in space, and lets its frame point along that while it slips.
    pub(super) fn observe_sliding(&mut self, contact: usize) {
        if !self.is_in_space(contact) || !self.has_friction(contact) {
            return;
        }
        let speed = self.sliding_speed(contact);
        let scale = &mut self.scales[contact];
        scale.observe_switch(speed);
        self.frames[contact].measure(scale.sliding_velocity(), scale.zero_sliding_velocity());
        if matches!(self.mode.states[contact], ContactState::Slip(_)) {
            self.align_with_sliding(contact);
        }
    }
}

/// Size of a pair, exactly that of its first number where the second is 0.
pub(in crate::simulation) fn pair_size((first, second): (f64, f64)) -> f64 {
    if second == 0.0 {
        first.abs()
    } else {
        first.hypot(second)
    }
}
