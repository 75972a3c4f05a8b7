//! Contacts that slide along two directions: both sliding velocities in the frame of each, and where it points.

use super::Contacts;
use crate::fesd::frame::Frame;
use crate::model::{Model, tangent_point};

/// What contacts in space have besides.
pub(super) struct Space {
    pub(super) is_in: Vec<bool>,
    pub(super) frames: Vec<Frame>,
    pub(super) across: Vec<f64>,
    pub(super) slipping: Vec<f64>,
}

impl Space {
    /// Of a scene that has any.
    pub(super) fn of(model: &dyn Model) -> Option<Self> {
        let contacts = model.declaration().contacts;
        let n = model.declaration().coordinates.len();
        let is_in = contacts.iter().map(|known| known.friction.is_some_and(|known| known.across.is_some()));
        let is_in: Vec<bool> = is_in.collect();
        is_in.contains(&true).then(|| Self {
            frames: vec![Frame::default(); contacts.len()],
            across: vec![0.0; contacts.len() * tangent_point::length(n)],
            slipping: vec![0.0; contacts.len() * n],
            is_in,
        })
    }

    /// The frame of a contact, if it is in space.
    fn frame(&self, contact: usize) -> Option<&Frame> {
        self.is_in[contact].then(|| &self.frames[contact])
    }
}

impl Contacts<'_> {
    /// Whether a contact slides along two directions.
    pub(crate) fn is_in_space(&self, contact: usize) -> bool {
        let space = self.space.as_ref();
        space.is_some_and(|space| space.frame(contact).is_some()) && self.friction[contact] > 0.0
    }

    /// The frames in which contacts in space slide; none without any.
    pub(crate) fn frames(&self) -> &[Frame] {
        self.space.as_ref().map_or(&[], |space| &space.frames)
    }

    /// The second tangential side of a contact in space at the last evaluation.
    pub(super) fn across(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.n);
        let across = self.space.as_ref().map_or(&[][..], |space| &space.across);
        &across[contact * length..(contact + 1) * length]
    }

    /// Both sliding velocities of a contact at the last evaluation; the second is 0 in the plane.
    pub(crate) fn sliding(&self, contact: usize) -> (f64, f64) {
        let across = match self.is_in_space(contact) {
            true => self.across(contact)[tangent_point::SLIDING_VELOCITY],
            false => 0.0,
        };
        (self.sliding_velocity(contact), across)
    }

    /// Size of the sliding velocity at the last evaluation.
    pub(crate) fn sliding_speed(&self, contact: usize) -> f64 {
        let (along, across) = self.sliding(contact);
        if across == 0.0 { along.abs() } else { along.hypot(across) }
    }

    /// The direction in which friction of a contact acts that slides forward, or that sticks.
    pub(super) fn slip_direction(&self, contact: usize) -> &[f64] {
        match &self.space {
            Some(space) if space.is_in[contact] => &space.slipping[contact * self.n..][..self.n],
            _ => self.friction_direction(contact),
        }
    }

    /// Turns what was evaluated of a contact in space from its directions as declared into its frame.
    pub(super) fn turn(&mut self, contact: usize, frame: Frame) {
        let length = tangent_point::length(self.n);
        let Some(space) = &mut self.space else { return };
        let tangent = &mut self.tangents[contact * length..(contact + 1) * length];
        let across = &mut space.across[contact * length..(contact + 1) * length];
        frame.turn(tangent, across);
        let own = &space.frames[contact];
        let slide = own.direction((
            tangent[tangent_point::SLIDING_VELOCITY],
            across[tangent_point::SLIDING_VELOCITY],
        ));
        let directions = tangent[tangent_point::direction(self.n)..]
            .iter()
            .zip(&across[tangent_point::direction(self.n)..]);
        let slipping = &mut space.slipping[contact * self.n..][..self.n];
        for (slip, (along, across)) in slipping.iter_mut().zip(directions) {
            *slip = slide.along * along + slide.across * across;
        }
    }

    /// Turns the frame of a contact in space so that it points along what is `(first, second)` in it, and all that was evaluated
    /// of it.
    pub(crate) fn align(&mut self, contact: usize, (first, second): (f64, f64)) {
        let Some(space) = self.space.as_mut().filter(|space| space.is_in[contact]) else {
            return;
        };
        let mut by = Frame::default();
        by.align((first, second));
        space.frames[contact].align((first, second));
        self.turn(contact, by);
    }

    /// Lets the frame of a contact in space point along its sliding velocity, where that has a direction.
    pub(crate) fn align_with_sliding(&mut self, contact: usize) {
        if !self.is_in_space(contact) {
            return;
        }
        let velocity = self.sliding(contact);
        let soft = self.frames()[contact].soft;
        if velocity.0.hypot(velocity.1) > soft {
            self.align(contact, velocity);
        }
    }

    /// Takes note of the speed below which the sliding of a contact in space has no direction, at `time`.
    pub(crate) fn measure_sliding(&mut self, contact: usize, time: f64) {
        if !self.is_in_space(contact) {
            return;
        }
        let rest = self.size(contact, time).at_rest();
        let largest = self.sizes[contact].sliding;
        if let Some(space) = &mut self.space {
            space.frames[contact].measure(largest, rest);
        }
    }

    /// Speed up to which a contact is at rest along the ground.
    pub(crate) fn rest_speed(&self, contact: usize, time: f64) -> f64 {
        let rest = self.size(contact, time).at_rest();
        match self.is_in_space(contact) {
            true => rest.max(self.frames()[contact].soft),
            false => rest,
        }
    }
}
