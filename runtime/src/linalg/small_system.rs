//! A small dense linear system, solved in place by Gaussian elimination with row pivoting.

use crate::yardstick;

/// Order of a matrix from which on rows are looked through for zeros. Chosen: below, looking takes as long as adding them.
const LARGE: usize = 16;

/// Solves `matrix x = right` (row-major, order `right.len()`); the solution replaces `right` and the
/// matrix is destroyed. Returns the sign of its determinant, `None` if it is singular to working accuracy.
pub(crate) fn solve(matrix: &mut [f64], right: &mut [f64]) -> Option<f64> {
    let m = right.len();
    let mut sign = 1.0;
    let mut places: Vec<usize> = Vec::new();
    let largest = matrix.iter().fold(0.0_f64, |s, a| s.max(a.abs()));
    for column in 0..m {
        let mut pivot = column;
        for row in column + 1..m {
            if matrix[row * m + column].abs() > matrix[pivot * m + column].abs() {
                pivot = row;
            }
        }
        let size = matrix[pivot * m + column].abs();
        if size <= yardstick::ROUNDING * largest || size.is_nan() {
            return None;
        }
        if pivot != column {
            sign = -sign;
            for k in 0..m {
                matrix.swap(column * m + k, pivot * m + k);
            }
            right.swap(column, pivot);
        }
        sign *= matrix[column * m + column].signum();
        let (above, below) = matrix.split_at_mut((column + 1) * m);
        let pivot_row = &above[column * m..];
        let sparse = m >= LARGE && {
            let behind = (column..m).filter(|&k| pivot_row[k] != 0.0);
            places.clear();
            places.extend(behind);
            4 * places.len() < m - column
        };
        for (row, other) in below.chunks_exact_mut(m).enumerate() {
            let factor = other[column] / pivot_row[column];
            // Contacts of bodies that do not touch each other are not coupled.
            if factor == 0.0 {
                continue;
            }
            if sparse {
                for &k in &places {
                    other[k] -= factor * pivot_row[k];
                }
            } else {
                for (other, above) in other[column..].iter_mut().zip(&pivot_row[column..]) {
                    *other -= factor * above;
                }
            }
            right[column + 1 + row] -= factor * right[column];
        }
    }
    for row in (0..m).rev() {
        for k in row + 1..m {
            if matrix[row * m + k] != 0.0 {
                right[row] -= matrix[row * m + k] * right[k];
            }
        }
        right[row] /= matrix[row * m + row];
    }
    Some(sign)
}

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn solve_matrix_that_needs_pivoting_gives_exact_solution() {
        let mut matrix = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 4.0, 0.0, 2.0];
        let mut right = [7.0, 3.0, 10.0];
        // The determinant is -8.
        assert_eq!(solve(&mut matrix, &mut right), Some(-1.0));
        assert_eq!(right, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn solve_dependent_rows_reports_singular() {
        assert_eq!(solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0]), None);
        assert_eq!(solve(&mut [0.0], &mut [1.0]), None);
        assert_eq!(solve(&mut [f64::NAN], &mut [1.0]), None);
        assert_eq!(solve(&mut [], &mut []), Some(1.0));
        assert_eq!(
            solve(&mut [1.0, 2.0, 2.0, 1.0], &mut [1.0, 2.0]),
            Some(-1.0)
        );
    }
}
