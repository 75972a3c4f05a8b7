//! How large a motion has been, which errors are measured by.

use crate::yardstick;

/// Largest values of a motion so far. Distances are measured from its start, so that a translation of the
/// scene changes nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct MotionSize {
    start: Vec<f64>,
    /// Number of coordinates of the mechanism.
    mechanical: usize,
    /// Largest size of each state of first order.
    pub(crate) states: Vec<f64>,
    /// Largest distance of a coordinate from its start.
    pub(crate) distance: f64,
    /// Largest velocity.
    pub(crate) speed: f64,
    /// Rounding error of the coordinates.
    pub(crate) rounding: f64,
}

impl MotionSize {
    /// Of a motion that starts at `(q, v)`, with so many coordinates of a mechanism.
    pub(crate) fn new(q: &[f64], v: &[f64], mechanical: usize) -> Self {
        let mut size = Self {
            start: q.to_vec(),
            mechanical,
            states: vec![0.0; q.len() - mechanical],
            ..Self::default()
        };
        size.include(q, v);
        size
    }

    /// How much a function with the gradient `normal` has changed by the way to the state `(q, v)`, or in the time `h`
    /// there if that is more: the sum of the sizes of its terms.
    pub(crate) fn along(&self, normal: &[f64], (q, v): (&[f64], &[f64]), h: f64) -> f64 {
        let ways = self.start.iter().zip(q).map(|(start, q)| (q - start).abs());
        let ways = ways.zip(v).map(|(way, v)| way.max(h * v.abs()));
        normal.iter().zip(ways).map(|(n, way)| n.abs() * way).sum()
    }

    /// Grows to the state `(q, v)`.
    pub(crate) fn include(&mut self, q: &[f64], v: &[f64]) {
        for (size, state) in self.states.iter_mut().zip(&v[self.mechanical..]) {
            *size = size.max(state.abs());
        }
        for (k, start) in self.start.iter().enumerate().take(self.mechanical) {
            self.distance = self.distance.max((q[k] - start).abs());
            self.speed = self.speed.max(v[k].abs());
            self.rounding = self.rounding.max(yardstick::DIGITS * q[k].abs());
        }
    }
}
