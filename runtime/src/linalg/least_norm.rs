//! Linear systems whose equations may follow from each other: what they determine, and what they leave open, by orthogonal factors with
//! pivots.
//!
//! ```text
//! A P = Q R,   R = (U' Z')  in its first rank rows
//! ```
//!
//! Source: Golub, Van Loan, *Matrix Computations* (2013), sections 5.4.2 and 5.5.6.

use nalgebra::{ColPivQR, DMatrix, DVector, QR};

/// Pivot, to the largest one, up to which an equation follows from others, of equations of about equal size: forces along directions that
/// differ by less than its root \[rad\] cannot be told apart.
const DEPENDENT: f64 = 1e-10;

/// A matrix taken apart into what it does and what it leaves open.
pub(crate) struct LeastNorm {
    rows: usize,
    columns: usize,
    rank: usize,
    /// `Q`: what the matrix leads to in its first `rank` columns.
    range: DMatrix<f64>,
    /// `U'`, lower triangular.
    triangle: DMatrix<f64>,
    /// `P Z`, a whole basis: what the matrix sees in its first `rank` columns.
    basis: DMatrix<f64>,
}

impl LeastNorm {
    /// Of a row-major matrix with that many columns; `None` without any, or where a number is not finite.
    pub(crate) fn of(matrix: &[f64], columns: usize) -> Option<Self> {
        if columns == 0 || !matrix.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let rows = matrix.len() / columns;
        // With a row a column at least.
        let mut high = DMatrix::zeros(rows.max(columns), columns);
        for (k, &entry) in matrix.iter().enumerate() {
            high[(k / columns, k % columns)] = entry;
        }
        let factors = ColPivQR::new(high);
        let upper = factors.r();
        let largest = upper[(0, 0)].abs();
        let pivots = (0..columns).map(|k| upper[(k, k)].abs());
        let rank = pivots
            .take_while(|pivot| *pivot > DEPENDENT * largest)
            .count();
        let mut seen = DMatrix::zeros(columns, columns);
        for k in 0..rank {
            for j in 0..columns {
                seen[(j, k)] = upper[(k, j)];
            }
        }
        let (mut basis, triangle) = QR::new(seen).unpack();
        factors.p().inv_permute_rows(&mut basis);
        Some(Self {
            rows,
            columns,
            rank,
            range: factors.q(),
            triangle: triangle.view((0, 0), (rank, rank)).transpose(),
            basis,
        })
    }

    /// The smallest `x` for which `matrix x` is nearest to `right`, and what it misses it by in its largest component.
    pub(crate) fn solve(&self, right: &[f64]) -> (Vec<f64>, f64) {
        let wanted = DVector::from_column_slice(right);
        let range = self.range.view((0, 0), (self.rows, self.rank));
        let along = range.tr_mul(&wanted);
        let missed = &wanted - range * &along;
        let shares = self.triangle.solve_lower_triangular(&along);
        let shares = shares.unwrap_or_else(|| DVector::zeros(self.rank));
        let x = self.basis.view((0, 0), (self.columns, self.rank)) * shares;
        (x.iter().copied().collect(), missed.amax())
    }

    /// An orthonormal basis of what the matrix takes to zero.
    pub(crate) fn idle(&self) -> Vec<Vec<f64>> {
        let own = |k: usize| self.basis.column(k).iter().copied().collect();
        (self.rank..self.columns).map(own).collect()
    }

    /// An orthonormal basis of the combinations of rows that vanish, of a square matrix.
    pub(crate) fn redundant(&self) -> Vec<Vec<f64>> {
        let own = |k: usize| self.range.column(k).iter().copied().collect();
        (self.rank..self.rows).map(own).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_equations_have_their_smallest_solution_and_leave_the_rest_open() {
        // x + y = 2 twice, z = 3.
        let matrix = [1.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 1.0];
        let known = LeastNorm::of(&matrix, 3).expect("finite");
        let (x, missed) = known.solve(&[2.0, 4.0, 3.0]);
        for (x, wanted) in x.iter().zip([1.0, 1.0, 3.0]) {
            assert!((x - wanted).abs() < 1e-14, "{x}");
        }
        assert!(missed < 1e-14);
        let idle = known.idle();
        assert_eq!(idle.len(), 1);
        assert!((idle[0][0] + idle[0][1]).abs() < 1e-14 && idle[0][2].abs() < 1e-14);
        let redundant = known.redundant();
        assert!((redundant[0][0] + 2.0 * redundant[0][1]).abs() < 1e-14);
        // x + y cannot be 2 and 3.
        assert!(known.solve(&[2.0, 6.0, 3.0]).1 > 0.1);
        assert!(LeastNorm::of(&[f64::NAN], 1).is_none());
    }

    #[test]
    fn wide_and_high_matrices_are_known_as_well() {
        let wide = LeastNorm::of(&[3.0, 4.0], 2).expect("finite");
        assert_eq!(wide.idle().len(), 1);
        let (x, _) = wide.solve(&[25.0]);
        assert!((x[0] - 3.0).abs() < 1e-14 && (x[1] - 4.0).abs() < 1e-14);
        let high = LeastNorm::of(&[3.0, -3.0, 4.0, -4.0, 0.0, 0.0], 2).expect("finite");
        let idle = high.idle();
        assert!(idle.len() == 1 && (idle[0][0] - idle[0][1]).abs() < 1e-14);
    }
}
