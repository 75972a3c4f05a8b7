//! The problem of the lines of all contacts, its states and its residual.

use super::state::ContactState;
use crate::linalg::dense;
use crate::yardstick;

/// Friction of one contact: the line of its normal and its coefficient.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cone {
    pub(crate) normal: usize,
    pub(crate) friction: f64,
    /// The coefficient of sliding, below that of rest where there are two.
    pub(crate) kinetic: f64,
    /// In space the line of the second tangent, which stands behind all first ones.
    pub(crate) across: Option<usize>,
}

/// The tangent of a contact: its line, and the coefficients of rest and of sliding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    pub(super) line: usize,
    pub(super) friction: f64,
    pub(super) kinetic: f64,
}

/// Lines that are the tangent of a cone come last, in the order of `cones`; all others are normals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Problem<'a> {
    /// `K`, row-major.
    pub(crate) matrix: &'a [f64],
    /// `q`.
    pub(crate) offsets: &'a [f64],
    pub(crate) cones: &'a [Cone],
    /// Number of normals that may carry no force; the others, behind them, are dry friction, whose force is given.
    pub(crate) surfaces: usize,
    /// Whether some of the contacts slide along two directions, with a cone or not.
    pub(crate) in_space: bool,
}

/// A solution.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solution {
    /// State of the contact of each normal.
    pub(crate) states: Vec<ContactState>,
    /// `f`, of all lines.
    pub(crate) forces: Vec<f64>,
}

impl Problem<'_> {
    /// Number of lines.
    pub(super) fn lines(&self) -> usize {
        self.offsets.len()
    }

    /// Number of normals.
    pub(super) fn normals(&self) -> usize {
        self.offsets.len() - self.cones.len()
    }

    /// The tangent of each normal.
    pub(super) fn tangents(&self) -> Vec<Option<Tangent>> {
        let mut tangents = vec![None; self.normals()];
        for (k, cone) in self.cones.iter().enumerate() {
            tangents[cone.normal] = Some(Tangent {
                line: self.normals() + k,
                friction: cone.friction,
                kinetic: cone.kinetic,
            });
        }
        tangents
    }

    /// Whether Newton's method on cones is the way: with cones in space, and where contacts that slide in space depend on each other, so that
    /// the smallest forces are to be found.
    pub(super) fn is_of_space(&self) -> bool {
        let slides = || {
            let (mut factors, mut pivots) = (self.matrix.to_vec(), vec![0; self.lines()]);
            !dense::factorize_independent(&mut factors, &mut pivots)
        };
        self.cones.iter().any(|cone| cone.across.is_some()) || self.in_space && slides()
    }

    /// Whether a contact slides with a lower coefficient than it rests with.
    pub(super) fn breaks(&self) -> bool {
        self.cones.iter().any(|cone| cone.kinetic < cone.friction)
    }

    /// Whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let mut numbers = self.matrix.iter().chain(self.offsets);
        numbers.all(|value| value.is_finite())
    }

    /// `K_ij`.
    pub(super) fn coupling(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.lines() + column]
    }

    /// `w` of a line with the forces `f`, and the sum of the sizes of its terms.
    pub(super) fn motion(&self, line: usize, forces: &[f64]) -> (f64, f64) {
        let row = &self.matrix[line * self.lines()..(line + 1) * self.lines()];
        let own = self.offsets[line];
        row.iter()
            .zip(forces)
            .filter(|(_, force)| **force != 0.0)
            .fold((own, own.abs()), |(sum, size), (k, f)| {
                (sum + k * f, size + (k * f).abs())
            })
    }

    /// Motions of all lines, and what counts as zero beside each.
    pub(super) fn motions(&self, forces: &[f64]) -> Vec<(f64, f64)> {
        let floor = f64::MIN_POSITIVE + yardstick::ROUNDING * self.largest_offset();
        let motions = (0..self.lines()).map(|line| self.motion(line, forces));
        let zero = |(motion, size): (f64, f64)| (motion, (yardstick::ROUNDING * size).max(floor));
        motions.map(zero).collect()
    }

    pub(super) fn largest_offset(&self) -> f64 {
        self.offsets.iter().fold(0.0, |most, q| most.max(q.abs()))
    }

    /// Force below which one of a line is zero: what counts as zero of the motion there, in its own coupling.
    pub(super) fn zero_force(&self, line: usize, zero_motion: f64) -> f64 {
        let own = self.coupling(line, line).abs();
        zero_motion / if own > 0.0 { own } else { 1.0 }
    }
}
