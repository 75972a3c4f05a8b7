//! Newton's steps of an element whose stages share one Jacobian.
//!
//! With the derivatives `J_q`, `J_v` of the acceleration at one stage in the place of those at all of them, the matrix of an element is
//!
//! ```text
//! I - h^2 A^2 (x) J_q - h A (x) J_v
//! ```
//!
//! which the eigenvectors of the Runge-Kutta matrix `A` take apart into one system of the order of the coordinates for each eigenvalue `l`,
//! `I - (h l)^2 J_q - h l J_v`, of conjugate pairs one (Butcher 1976; Bickart 1977; Hairer, Wanner, Solving ODEs II, section IV.8). Mechanisms with
//! joints have many more coordinates than they can move in, so that the matrix of all stages, and derivatives at each, are what most
//! of their time would go to. Steps contract by what the derivatives change over the element; the solution is the same.

use crate::yardstick;
use nalgebra::{Complex, DMatrix, DVector, Dyn, LU};

use crate::rk::ButcherTableau;

/// Distance of the shift of inverse iteration from an eigenvalue, as a share of it.
const SHIFT: f64 = 1e-10;
/// One eigenvalue with what belongs to it.
struct Part {
    eigenvalue: Complex<f64>,
    /// Its column of the eigenvectors, and its row of their inverse.
    column: Vec<Complex<f64>>,
    row: Vec<Complex<f64>>,
    /// 2 where it stands for its conjugate as well.
    counts: f64,
    factors: Option<LU<Complex<f64>, Dyn, Dyn>>,
}

/// The parts that the eigenvectors of a scheme take an element into.
pub(super) struct Decoupled {
    parts: Vec<Part>,
}

impl Decoupled {
    /// None for a scheme without a basis of eigenvectors.
    pub(super) fn of(tableau: &ButcherTableau) -> Option<Self> {
        let stages = tableau.stages();
        let matrix = DMatrix::from_fn(stages, stages, |i, j| tableau.a(i, j));
        let eigenvalues = matrix.complex_eigenvalues();
        let matrix = matrix.map(|entry| Complex::new(entry, 0.0));
        let mut vectors = DMatrix::zeros(stages, stages);
        for (k, &eigenvalue) in eigenvalues.iter().enumerate() {
            let shifted = &matrix
                - DMatrix::from_diagonal_element(stages, stages, eigenvalue * (1.0 + SHIFT));
            let inverse = shifted.lu();
            let mut vector = DVector::from_element(stages, Complex::new(1.0, 0.0));
            for _ in 0..3 {
                vector = inverse.solve(&vector)?.normalize();
            }
            vectors.set_column(k, &vector);
        }
        let inverse = vectors.clone().try_inverse()?;
        let is_finite = |value: &Complex<f64>| value.re.is_finite() && value.im.is_finite();
        if !inverse.iter().all(is_finite) {
            return None;
        }
        let parts = eigenvalues
            .iter()
            .enumerate()
            .filter_map(|(k, &eigenvalue)| {
                let real = eigenvalue.im.abs() <= yardstick::ROUNDING * eigenvalue.norm();
                (real || eigenvalue.im > 0.0).then(|| Part {
                    eigenvalue,
                    column: vectors.column(k).iter().copied().collect(),
                    row: inverse.row(k).iter().copied().collect(),
                    counts: if real { 1.0 } else { 2.0 },
                    factors: None,
                })
            });
        Some(Self {
            parts: parts.collect(),
        })
    }

    /// Factorizes for an element of length `h` with these derivatives, row-major; `false` if one is not finite or a matrix
    /// singular.
    pub(super) fn factorize(&mut self, h: f64, by_q: &[f64], by_v: &[f64], n: usize) -> bool {
        let finite = by_q.iter().chain(by_v).all(|entry| entry.is_finite());
        finite
            && self.parts.iter_mut().all(|part| {
                let first = part.eigenvalue * h;
                let second = first * first;
                let matrix = DMatrix::from_fn(n, n, |i, j| {
                    let one = f64::from(u8::from(i == j));
                    Complex::from(one) - second * by_q[i * n + j] - first * by_v[i * n + j]
                });
                let factors = matrix.lu();
                let regular = factors.is_invertible();
                part.factors = Some(factors);
                regular
            })
    }

    /// Solves for the step of all stages, one after the other in `residual`, which it overwrites.
    pub(super) fn solve(&self, residual: &mut [f64], n: usize) {
        let given = residual.to_vec();
        residual.fill(0.0);
        let mut step = DVector::zeros(n);
        for part in &self.parts {
            step.fill(Complex::default());
            for (share, stage) in part.row.iter().zip(given.chunks_exact(n)) {
                for (step, value) in step.iter_mut().zip(stage) {
                    *step += share * value;
                }
            }
            if let Some(factors) = &part.factors {
                factors.solve_mut(&mut step);
            }
            for (share, stage) in part.column.iter().zip(residual.chunks_exact_mut(n)) {
                for (value, step) in stage.iter_mut().zip(&step) {
                    *value += part.counts * (share * step).re;
                }
            }
        }
    }
}
