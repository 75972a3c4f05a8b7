//! Contacts that slide along two directions: their second tangential sides, and the frames in which they slide.

use super::frame::{Frame, pair_size};
use super::{Function, Model, tangent_point};

/// What contacts in space have besides, as last evaluated: tangential sides in the frame of each.
#[derive(Debug, Clone)]
pub(crate) struct Space {
    n: usize,
    is_in: Vec<bool>,
    frames: Vec<Frame>,
    across: Vec<f64>,
    slipping: Vec<f64>,
}

impl Space {
    /// Of a scene that has any.
    pub(crate) fn of(model: &dyn Model) -> Option<Self> {
        let contacts = model.declaration().contacts;
        let n = model.declaration().coordinates.len();
        let slides_in = |i: usize| {
            let across = contacts[i].friction.and_then(|known| known.across);
            across.is_some() && model.friction(i) > 0.0
        };
        let is_in: Vec<bool> = (0..contacts.len()).map(slides_in).collect();
        is_in.contains(&true).then(|| Self {
            n,
            frames: vec![Frame::default(); contacts.len()],
            across: vec![0.0; contacts.len() * tangent_point::length(n)],
            slipping: vec![0.0; contacts.len() * n],
            is_in,
        })
    }

    /// Whether a contact slides along two directions.
    pub(crate) fn contains(&self, contact: usize) -> bool {
        self.is_in[contact]
    }

    /// The frames of all contacts.
    pub(crate) fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The second tangential side, laid out as in [`tangent_point`].
    pub(crate) fn across(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.n);
        &self.across[contact * length..(contact + 1) * length]
    }

    /// The direction of the force of a contact that slides.
    pub(crate) fn slipping(&self, contact: usize) -> &[f64] {
        &self.slipping[contact * self.n..(contact + 1) * self.n]
    }

    /// Evaluates the second side at `x`, and takes it and the first one, `tangent`, into the frame.
    pub(crate) fn evaluate(
        &mut self,
        model: &dyn Model,
        contact: usize,
        x: &[f64],
        tangent: &mut [f64],
    ) {
        let length = tangent_point::length(self.n);
        let across = &mut self.across[contact * length..(contact + 1) * length];
        model.values(Function::Across(contact), x, across);
        let frame = self.frames[contact];
        self.turn(contact, frame, tangent);
    }

    fn turn(&mut self, contact: usize, by: Frame, tangent: &mut [f64]) {
        let (n, length) = (self.n, tangent_point::length(self.n));
        let across = &mut self.across[contact * length..(contact + 1) * length];
        by.turn(tangent, across);
        let slide = self.frames[contact].direction((
            tangent[tangent_point::SLIDING_VELOCITY],
            across[tangent_point::SLIDING_VELOCITY],
        ));
        let first = tangent_point::direction(n);
        let directions = tangent[first..].iter().zip(&across[first..]);
        let slipping = &mut self.slipping[contact * n..(contact + 1) * n];
        for (slip, (along, across)) in slipping.iter_mut().zip(directions) {
            *slip = slide.along * along + slide.across * across;
        }
    }

    /// Turns the frame so that it points along what is `(first, second)` in it, and all that was evaluated; `tangent` is the first
    /// side.
    pub(crate) fn align(&mut self, contact: usize, to: (f64, f64), tangent: &mut [f64]) {
        let mut by = Frame::default();
        by.align(to);
        self.frames[contact].align(to);
        self.turn(contact, by, tangent);
    }

    /// Turns the frame so that it points along the sliding velocity, where that has a direction.
    pub(crate) fn align_with_sliding(&mut self, contact: usize, tangent: &mut [f64]) {
        let velocity = (
            tangent[tangent_point::SLIDING_VELOCITY],
            self.across(contact)[tangent_point::SLIDING_VELOCITY],
        );
        if pair_size(velocity) > self.frames[contact].soft {
            self.align(contact, velocity, tangent);
        }
    }

    /// Takes note of the largest sliding velocity so far, and of the speed that counts as rest.
    pub(crate) fn measure(&mut self, contact: usize, largest: f64, rest: f64) {
        self.frames[contact].measure(largest, rest);
    }
}
