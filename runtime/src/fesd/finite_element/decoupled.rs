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
use nalgebra::{Complex, DMatrix, DVector};

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
    factors: Factors,
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
                    factors: Factors::default(),
                })
            });
        Some(Self {
            parts: parts.collect(),
        })
    }

    /// Factorizes for an element of length `h` with these derivatives, row-major; `false` if a matrix is singular.
    pub(super) fn factorize(&mut self, h: f64, by_q: &[f64], by_v: &[f64], n: usize) -> bool {
        self.parts.iter_mut().all(|part| {
            let first = part.eigenvalue * h;
            let second = first * first;
            let entries = by_q.iter().zip(by_v);
            part.factors.matrix.clear();
            part.factors.matrix.extend(
                entries
                    .map(|(q, v)| [-second.re * q - first.re * v, -second.im * q - first.im * v]),
            );
            for i in 0..n {
                part.factors.matrix[i * n + i][0] += 1.0;
            }
            part.factors.compute(n)
        })
    }

    /// Solves for the step of all stages, one after the other in `residual`, which it overwrites.
    pub(super) fn solve(&self, residual: &mut [f64], n: usize) {
        let given = residual.to_vec();
        residual.fill(0.0);
        let mut step = vec![[0.0; 2]; n];
        for part in &self.parts {
            step.fill([0.0; 2]);
            for (share, stage) in part.row.iter().zip(given.chunks_exact(n)) {
                for (step, value) in step.iter_mut().zip(stage) {
                    step[0] += share.re * value;
                    step[1] += share.im * value;
                }
            }
            part.factors.solve(&mut step);
            for (share, stage) in part.column.iter().zip(residual.chunks_exact_mut(n)) {
                for (value, step) in stage.iter_mut().zip(&step) {
                    *value += part.counts * (share.re * step[0] - share.im * step[1]);
                }
            }
        }
    }
}

/// `P M = L U` of a complex matrix, row-major, real and imaginary parts side by side.
#[derive(Default)]
struct Factors {
    matrix: Vec<[f64; 2]>,
    pivots: Vec<usize>,
}

impl Factors {
    /// Factorizes the matrix of that order in its place; `false` if it is singular.
    fn compute(&mut self, n: usize) -> bool {
        self.pivots.clear();
        for k in 0..n {
            let size = |entry: [f64; 2]| entry[0].abs() + entry[1].abs();
            let (mut best, mut most) = (k, 0.0);
            for i in k..n {
                let here = size(self.matrix[i * n + k]);
                if here > most {
                    (best, most) = (i, here);
                }
            }
            if !(most > 0.0 && most.is_finite()) {
                return false;
            }
            self.pivots.push(best);
            if best != k {
                let (upper, lower) = self.matrix.split_at_mut(best * n);
                upper[k * n..(k + 1) * n].swap_with_slice(&mut lower[..n]);
            }
            let (upper, lower) = self.matrix.split_at_mut((k + 1) * n);
            let pivots = &upper[k * n + k..];
            let [re, im] = pivots[0];
            let square = re * re + im * im;
            for row in lower.chunks_exact_mut(n) {
                let [a, b] = row[k];
                let factor = [(a * re + b * im) / square, (b * re - a * im) / square];
                row[k] = factor;
                subtract(&mut row[k + 1..], factor, &pivots[1..]);
            }
        }
        true
    }

    /// Solves in the place of the right-hand side.
    fn solve(&self, x: &mut [[f64; 2]]) {
        let n = x.len();
        for (k, &pivot) in self.pivots.iter().enumerate() {
            x.swap(k, pivot);
        }
        for i in 0..n {
            let row = &self.matrix[i * n..(i + 1) * n];
            let (known, rest) = x.split_at_mut(i);
            rest[0] = less(rest[0], &row[..i], known);
        }
        for i in (0..n).rev() {
            let row = &self.matrix[i * n..(i + 1) * n];
            let (own, known) = x.split_at_mut(i + 1);
            let [a, b] = less(own[i], &row[i + 1..], known);
            let [re, im] = row[i];
            let square = re * re + im * im;
            own[i] = [(a * re + b * im) / square, (b * re - a * im) / square];
        }
    }
}

/// Subtracts a multiple of a row.
fn subtract(row: &mut [[f64; 2]], factor: [f64; 2], other: &[[f64; 2]]) {
    let [a, b] = factor;
    for (entry, [re, im]) in row.iter_mut().zip(other) {
        entry[0] -= a * re - b * im;
        entry[1] -= a * im + b * re;
    }
}

/// A value less a sum of products.
fn less(value: [f64; 2], row: &[[f64; 2]], x: &[[f64; 2]]) -> [f64; 2] {
    let [mut a, mut b] = value;
    for ([re, im], [x, y]) in row.iter().zip(x) {
        a -= re * x - im * y;
        b -= re * y + im * x;
    }
    [a, b]
}
