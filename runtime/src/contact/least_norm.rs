//! Redundant contacts: of all forces, or impulses, that give the same motion the smallest ones, by the proximal point method
//!
//! ```text
//! (K + epsilon 1) (x_k+1 - x_k) = b - K x_k,   x_0 = 0
//! ```
//!
//! whose iterates stay in the range of the symmetric `K`, so that their limit is the solution of least norm: equal contacts carry equal
//! forces.
//!
//! Source: Rockafellar, *Monotone operators and the proximal point algorithm* (1976).

use crate::linalg::dense;

/// Weight of the size of the forces in one step of the proximal point method, as a share of what their equations weigh.
const PROXIMAL: f64 = 1e-6;
/// Its steps. Each leaves this weight of the error, or half of it where directions agree to their sixth digit.
const STEPS: usize = 40;

/// The smallest `x` with `matrix x = rows`, for a matrix with eigenvalues that are not negative, by the proximal point
/// method from 0; `None` if a number is not finite.
pub(crate) fn smallest(matrix: &[f64], rows: &[f64]) -> Option<Vec<f64>> {
    let order = rows.len();
    let mut factors = matrix.to_vec();
    for entry in factors.iter_mut().step_by(order + 1) {
        *entry += PROXIMAL;
    }
    let mut pivots = vec![0; order];
    dense::factorize(&mut factors, &mut pivots).ok()?;
    let mut x = vec![0.0; order];
    for _ in 0..STEPS {
        let products = matrix.chunks_exact(order).zip(rows);
        let mut step: Vec<f64> = products
            .map(|(row, wanted)| wanted - row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>())
            .collect();
        dense::solve(&factors, &pivots, &mut step);
        for (x, step) in x.iter_mut().zip(&step) {
            *x += step;
        }
    }
    x.iter().all(|value| value.is_finite()).then_some(x)
}
