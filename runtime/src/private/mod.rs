//! What emitted code needs: small linear systems and the derivatives of their solutions. Not part of
//! the public interface.
//!
//! A vector `y(x)` solves `K(x) y = b(x)`; `F(x, y) = K y - b` is linear in `y`. With
//! `mu = K^-T lambda` and `P = d(K' mu)/dx`, differentiating `F(x, y(x)) = 0` once and twice gives
//!
//! ```text
//! A = dy/dx = -K^-1 F_x          d2(lambda' y)/dx2 = -(mu' F)_xx - P' A - A' P
//! ```

mod inertia;

pub use inertia::{
    Columns, Inertia, Kernel, Nonzeros, Place, direction, direction_hessian, direction_jacobian,
};
#[cfg(feature = "oracle")]
pub use num_dual;

/// Squares below are of rest: the third power of their inverse root has no value in `f64`.
const REST: f64 = 1e-200;

/// `1/sqrt(x)`, and 0 at rest: part of derivatives of `|v| v`, in which what it is multiplied with vanishes faster.
#[must_use]
pub fn inverse_root(x: f64) -> f64 {
    if x < REST { 0.0 } else { 1.0 / x.sqrt() }
}

/// Value of the derivative of this `order` of a function given by points: polynomials in the distance from the places where
/// they begin to hold, constant first; the first of them holds in front of all places.
#[must_use]
pub fn profile(pieces: &[(f64, [f64; 6])], order: usize, x: f64) -> f64 {
    let Some((_, behind)) = pieces.split_first() else {
        return f64::NAN;
    };
    let (from, coefficients) = pieces[behind.partition_point(|piece| piece.0 <= x)];
    let mut value = 0.0;
    for power in (order..coefficients.len()).rev() {
        let factor: f64 = (power - order + 1..=power).map(|k| k as f64).product();
        value = value * (x - from) + factor * coefficients[power];
    }
    value
}

/// Position of a structural nonzero: row, column.
type Position = (u32, u32);

/// `P K = L U` with row exchanges, of a matrix of order `M`.
#[derive(Debug, Clone)]
pub struct Lu<const M: usize> {
    /// Unit lower triangle and upper triangle.
    factors: [[f64; M]; M],
    /// `rows[i]` is the row of `K` that became row `i`.
    rows: [usize; M],
}

impl<const M: usize> Lu<M> {
    /// Factorizes a row-major matrix. A singular one gives factors that are not finite, and so do the
    /// solutions.
    #[must_use]
    pub fn new(matrix: &[f64]) -> Self {
        let mut factors = [[0.0; M]; M];
        for (row, values) in factors.iter_mut().zip(matrix.chunks_exact(M)) {
            row.copy_from_slice(values);
        }
        let mut rows = [0; M];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = i;
        }
        for k in 0..M {
            let mut pivot = k;
            for i in k + 1..M {
                if factors[i][k].abs() > factors[pivot][k].abs() {
                    pivot = i;
                }
            }
            factors.swap(k, pivot);
            rows.swap(k, pivot);
            let inverse = 1.0 / factors[k][k];
            let (above, below) = factors.split_at_mut(k + 1);
            let eliminated = &above[k];
            for row in below {
                let factor = row[k] * inverse;
                row[k] = factor;
                if factor != 0.0 {
                    subtract(&mut row[k + 1..], &eliminated[k + 1..], factor);
                }
            }
        }
        Self { factors, rows }
    }

    /// Solution of `K x = b`.
    #[must_use]
    pub fn solve(&self, b: &[f64; M]) -> [f64; M] {
        let mut x = [0.0; M];
        for (i, row) in self.factors.iter().enumerate() {
            x[i] = b[self.rows[i]] - inner(&row[..i], &x[..i]);
        }
        for (i, row) in self.factors.iter().enumerate().rev() {
            x[i] = (x[i] - inner(&row[i + 1..], &x[i + 1..])) / row[i];
        }
        x
    }

    /// Solution of `K' x = b`.
    #[must_use]
    pub fn solve_transposed(&self, b: &[f64; M]) -> [f64; M] {
        let mut y = *b;
        for (i, row) in self.factors.iter().enumerate() {
            y[i] /= row[i];
            let (known, rest) = y.split_at_mut(i + 1);
            subtract(rest, &row[i + 1..], known[i]);
        }
        for (i, row) in self.factors.iter().enumerate().rev() {
            let (rest, known) = y.split_at_mut(i);
            subtract(rest, &row[..i], known[0]);
        }
        let mut x = [0.0; M];
        for (value, &row) in y.iter().zip(&self.rows) {
            x[row] = *value;
        }
        x
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y -= factor * x`.
fn subtract(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= factor * x;
    }
}

/// Factorizes and solves a system given as `K` (row-major) followed by `b`.
#[must_use]
pub fn solve_system<const M: usize>(system: &[f64]) -> (Lu<M>, [f64; M]) {
    let (matrix, right) = system.split_at(M * M);
    let lu = Lu::new(matrix);
    let mut b = [0.0; M];
    b.copy_from_slice(right);
    let y = lu.solve(&b);
    (lu, y)
}

/// `A = -K^-1 F_x` from the nonzeros of `F_x`, dense: `a[row][column]`. All columns are solved for
/// together, so that the innermost loops run over whole rows.
#[must_use]
pub fn sensitivity<const M: usize, const N: usize>(
    lu: &Lu<M>,
    pattern: &[Position],
    values: &[f64],
) -> [[f64; N]; M] {
    let mut place = [0; M];
    for (i, &row) in lu.rows.iter().enumerate() {
        place[row] = i;
    }
    let mut a = [[0.0; N]; M];
    for (&(row, column), value) in pattern.iter().zip(values) {
        a[place[row as usize]][column as usize] = -value;
    }
    for (i, factors) in lu.factors.iter().enumerate() {
        let (known, rest) = a.split_at_mut(i);
        for (row, &factor) in known.iter().zip(factors) {
            subtract(&mut rest[0], row, factor);
        }
    }
    for (i, factors) in lu.factors.iter().enumerate().rev() {
        let (rest, known) = a.split_at_mut(i + 1);
        for (row, &factor) in known.iter().zip(&factors[i + 1..]) {
            subtract(&mut rest[i], row, factor);
        }
        let inverse = 1.0 / factors[i];
        for value in &mut rest[i] {
            *value *= inverse;
        }
    }
    a
}

/// Picks entries of `A`.
pub fn gather<const M: usize, const N: usize>(
    a: &[[f64; N]; M],
    pattern: &[Position],
    values: &mut [f64],
) {
    for (&(row, column), value) in pattern.iter().zip(values) {
        *value = a[row as usize][column as usize];
    }
}

/// Hessian of `lambda' y`, at the positions `pattern` of its lower triangle: from `A`, the nonzeros of
/// `(mu' F)_xx` (lower triangle) and those of `P`.
pub fn pull_back<const M: usize, const N: usize>(
    a: &[[f64; N]; M],
    (residual_pattern, residual): (&[Position], &[f64]),
    (cross_pattern, cross): (&[Position], &[f64]),
    pattern: &[Position],
    values: &mut [f64],
) {
    // P'A, row i from each nonzero P[k][i]; its transpose is added where an entry is read.
    let mut product = [[0.0; N]; N];
    for (&(k, i), &value) in cross_pattern.iter().zip(cross) {
        subtract(&mut product[i as usize], &a[k as usize], -value);
    }
    // An entry is read as the sum of its two places, which on the diagonal are one.
    for (&(i, j), &value) in residual_pattern.iter().zip(residual) {
        product[i as usize][j as usize] += if i == j { 0.5 * value } else { value };
    }
    for (&(i, j), value) in pattern.iter().zip(values) {
        let (i, j) = (i as usize, j as usize);
        *value = -(product[i][j] + product[j][i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lu_solves_a_matrix_that_needs_row_exchanges() {
        let matrix = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 2.0];
        let lu = Lu::<3>::new(&matrix);
        let x = [1.0, -2.0, 3.0];
        let product = |transposed: bool| -> [f64; 3] {
            std::array::from_fn(|i| {
                (0..3)
                    .map(|j| {
                        x[j] * if transposed {
                            matrix[3 * j + i]
                        } else {
                            matrix[3 * i + j]
                        }
                    })
                    .sum()
            })
        };
        // Entries and solution are small integers; a handful of roundings remain.
        for (found, wanted) in [
            (lu.solve(&product(false)), x),
            (lu.solve_transposed(&product(true)), x),
        ] {
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
            }
        }
    }

    #[test]
    fn lu_of_a_singular_matrix_is_not_finite() {
        let lu = Lu::<2>::new(&[1.0, 2.0, 2.0, 4.0]);
        assert!(lu.solve(&[1.0, 1.0]).iter().any(|x| !x.is_finite()));
    }

    #[test]
    fn derivatives_of_a_quotient_agree_with_hand_computed_ones() {
        // K = x0, b = x1, so y = x1/x0 and F = x0 y - x1.
        let x = [2.0, 3.0];
        let (lu, y) = solve_system::<1>(&[x[0], x[1]]);
        assert_eq!(y, [1.5]);
        let a = sensitivity::<1, 2>(&lu, &[(0, 0), (0, 1)], &[y[0], -1.0]);
        let mut jacobian = [0.0; 2];
        gather(&a, &[(0, 0), (0, 1)], &mut jacobian);
        assert_eq!(jacobian, [-0.75, 0.5]);
        // lambda = 1: mu = 1/2, P = d(x0 mu)/dx = (mu, 0), (mu F)_xx = 0.
        let mu = lu.solve_transposed(&[1.0]);
        let mut hessian = [0.0; 3];
        pull_back(
            &a,
            (&[], &[]),
            (&[(0, 0)], &[mu[0]]),
            &[(0, 0), (1, 0), (1, 1)],
            &mut hessian,
        );
        assert_eq!(hessian, [2.0 * 3.0 / 8.0, -0.25, 0.0]);
    }

    #[test]
    fn derivatives_of_a_nonlinear_right_side_agree_with_hand_computed_ones() {
        // y = x0^2 x1: K = 1, F = y - x0^2 x1, so (mu F)_xx = -mu (2 x1, 2 x0; 2 x0, 0).
        let x = [2.0, 3.0];
        let (lu, _) = solve_system::<1>(&[1.0, x[0] * x[0] * x[1]]);
        let a = sensitivity::<1, 2>(&lu, &[(0, 0), (0, 1)], &[-2.0 * x[0] * x[1], -x[0] * x[0]]);
        assert_eq!(a, [[12.0, 4.0]]);
        let mut hessian = [0.0; 3];
        pull_back(
            &a,
            (&[(0, 0), (1, 0)], &[-2.0 * x[1], -2.0 * x[0]]),
            (&[], &[]),
            &[(0, 0), (1, 0), (1, 1)],
            &mut hessian,
        );
        assert_eq!(hessian, [6.0, 4.0, 0.0]);
    }
}
