//! A small dense linear system, solved in place by Gaussian elimination with row pivoting.

/// Pivots below this share of the largest entry of the matrix count as zero: rounding leaves `1e-16`,
/// and contact normals that differ by less than `1e-6` rad cannot be told apart by their forces.
const SINGULAR: f64 = 1e-12;

/// Solves `matrix x = right` (row-major, order `right.len()`); the solution replaces `right` and the
/// matrix is destroyed. Returns `false` if the matrix is singular to working accuracy.
pub(in crate::simulation) fn solve(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let m = right.len();
    let largest = matrix.iter().fold(0.0_f64, |s, a| s.max(a.abs()));
    for column in 0..m {
        let mut pivot = column;
        for row in column + 1..m {
            if matrix[row * m + column].abs() > matrix[pivot * m + column].abs() {
                pivot = row;
            }
        }
        let size = matrix[pivot * m + column].abs();
        if size <= SINGULAR * largest || size.is_nan() {
            return false;
        }
        if pivot != column {
            for k in 0..m {
                matrix.swap(column * m + k, pivot * m + k);
            }
            right.swap(column, pivot);
        }
        for row in column + 1..m {
            let factor = matrix[row * m + column] / matrix[column * m + column];
            for k in column..m {
                matrix[row * m + k] -= factor * matrix[column * m + k];
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..m).rev() {
        for k in row + 1..m {
            right[row] -= matrix[row * m + k] * right[k];
        }
        right[row] /= matrix[row * m + row];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn solve_matrix_that_needs_pivoting_gives_exact_solution() {
        let mut matrix = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 4.0, 0.0, 2.0];
        let mut right = [7.0, 3.0, 10.0];
        assert!(solve(&mut matrix, &mut right));
        assert_eq!(right, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn solve_dependent_rows_reports_singular() {
        assert!(!solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0]));
        assert!(!solve(&mut [0.0], &mut [1.0]));
        assert!(!solve(&mut [f64::NAN], &mut [1.0]));
        assert!(solve(&mut [], &mut []));
    }
}
