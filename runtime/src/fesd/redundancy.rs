//! Constraints that follow from others: what their forces share is determined by their size.
//!
//! Where rows `G` of constraints depend on each other the couplings `K = G D` with the directions of their forces are singular: some
//! combination of rows vanishes, `y' K = 0`, and some combination of forces does nothing, `K z = 0`. The equations
//!
//! ```text
//! w_i + sum_k y_ik z_k' f = 0
//! ```
//!
//! are regular again. The combination `y` of the motions `w` vanishes by itself, so that `w = 0` and `z' f = 0`: of all forces with the same
//! motion the smallest, each measured by the inertia of its constraint. The directions of friction turn while contacts slide, and `z` with
//! them from stage to stage: one that stayed would leave a motion that depends on the shares without its order.

use crate::linalg::dense;
use crate::linalg::least_norm::LeastNorm;

/// What is added to equations that follow from others.
#[derive(Debug, Clone, Default)]
pub(super) struct Redundancy {
    /// Weights `y` of the equations, and `z` of the forces.
    pairs: Vec<(Vec<f64>, Vec<f64>)>,
    /// Weights `z` where the constraints were found.
    first: Vec<Vec<f64>>,
}

impl Redundancy {
    /// Of the row-major `couplings` of constraints with these `(measure of the force, measure of the equation)`.
    pub(super) fn of(couplings: &[f64], measures: &[(f64, f64)]) -> Self {
        let order = measures.len();
        let (mut factors, mut pivots) = (couplings.to_vec(), vec![0; order]);
        if dense::factorize_independent(&mut factors, &mut pivots) {
            return Self::default();
        }
        let scaled = couplings.iter().enumerate();
        let scaled: Vec<f64> = scaled
            .map(|(k, entry)| measures[k / order].1 * entry / measures[k % order].0)
            .collect();
        let Some(known) = LeastNorm::of(&scaled, order) else {
            return Self::default();
        };
        let pairs = known.redundant().into_iter().zip(known.idle());
        let pairs = pairs.map(|(equations, forces)| {
            let equations = equations.iter().zip(measures).map(|(y, known)| y / known.1);
            let forces = forces.iter().zip(measures).map(|(z, known)| z * known.0);
            (equations.collect(), forces.collect())
        });
        let pairs: Vec<(Vec<f64>, Vec<f64>)> = pairs.collect();
        let first = pairs.iter().map(|(_, forces)| forces.clone()).collect();
        Self { pairs, first }
    }

    /// Turns the weights of the forces to those of other `couplings` and measures: `z = (K + sum_k y_k z_k')^-1 y`, with the `z_k` of where
    /// the constraints were found, is a combination of forces that does nothing.
    pub(super) fn turn(&mut self, mut couplings: Vec<f64>, measures: &[(f64, f64)]) {
        let order = measures.len();
        for (row, entries) in couplings.chunks_exact_mut(order).enumerate() {
            for ((equations, _), first) in self.pairs.iter().zip(&self.first) {
                let terms = entries.iter_mut().zip(first);
                terms.for_each(|(entry, z)| *entry += equations[row] * z);
            }
        }
        let mut pivots = vec![0; order];
        if dense::factorize(&mut couplings, &mut pivots).is_err() {
            return;
        }
        for (equations, forces) in &mut self.pairs {
            forces.copy_from_slice(equations);
            dense::solve(&couplings, &pivots, forces);
            let weights = forces.iter_mut().zip(measures);
            weights.for_each(|(z, known)| *z *= known.0 * known.0);
        }
    }

    /// Whether nothing is added.
    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Adds to the equations what the `forces` make of them.
    pub(super) fn add(&self, forces: &[f64], equations: &mut [f64]) {
        for (own, weights) in &self.pairs {
            let sum: f64 = weights.iter().zip(forces).map(|(z, f)| z * f).sum();
            for (equation, y) in equations.iter_mut().zip(own) {
                *equation += y * sum;
            }
        }
    }

    /// Adds what they make of one equation by each force.
    pub(super) fn add_row(&self, equation: usize, row: &mut [f64]) {
        for (own, weights) in &self.pairs {
            for (entry, z) in row.iter_mut().zip(weights) {
                *entry += own[equation] * z;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_equations_are_regular_with_the_smallest_forces() {
        // Two equal supports carry 3 together: the one measured twice as large carries less.
        let couplings = [1.0, 1.0, 1.0, 1.0];
        let known = Redundancy::of(&couplings, &[(1.0, 1.0), (2.0, 1.0)]);
        let mut matrix = couplings;
        for (equation, row) in matrix.chunks_exact_mut(2).enumerate() {
            known.add_row(equation, row);
        }
        let (mut pivots, mut forces) = (vec![0; 2], [3.0, 3.0]);
        assert!(dense::factorize_independent(&mut matrix, &mut pivots));
        dense::solve(&matrix, &pivots, &mut forces);
        // Least f_1^2 + 4 f_2^2 with f_1 + f_2 = 3.
        assert!((forces[0] - 2.4).abs() < 1e-14 && (forces[1] - 0.6).abs() < 1e-14);
        let mut equations = [0.0; 2];
        known.add(&forces, &mut equations);
        assert!(equations[0].abs() < 1e-14 && equations[1].abs() < 1e-14);
        assert!(Redundancy::of(&[1.0, 0.5, 0.5, 1.0], &[(1.0, 1.0); 2]).is_empty());
    }
}
