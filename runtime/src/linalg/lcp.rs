//! Small linear complementarity problems by Lemke's method.
//!
//! Given `M` and `q`, find `z` with `0 <= z  _|_  M z + q >= 0`. Contacts that touch at the same time
//! pose such problems for their impulses and their accelerations. Source: Cottle, Pang, Stone, The
//! Linear Complementarity Problem, section 4.4.

use crate::yardstick;

/// Why no solution was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum LcpError {
    /// Lemke's method ended on a ray: there may be no solution.
    #[error("the linear complementarity problem has no solution that Lemke's method can reach")]
    Ray,
    /// A number of the data is infinite or not a number.
    #[error("the data of the linear complementarity problem are not finite")]
    NotFinite,
}

/// Solves `0 <= z _|_ M z + q >= 0` for the row-major `n x n` matrix `m`; writes `z` (length `n`).
///
/// # Errors
/// [`LcpError::Ray`] if the method ends on a ray, [`LcpError::NotFinite`] for bad data.
pub(crate) fn solve(m: &[f64], q: &[f64], z: &mut [f64]) -> Result<(), LcpError> {
    let n = q.len();
    debug_assert_eq!(m.len(), n * n);
    if m.iter().chain(q).any(|value| !value.is_finite()) {
        return Err(LcpError::NotFinite);
    }
    z.fill(0.0);
    if n == 1 && q[0] < 0.0 {
        if m[0] <= 0.0 {
            return Err(LcpError::Ray);
        }
        z[0] = -q[0] / m[0];
        return Ok(());
    }
    lemke((m, q), |_| 1.0, z)
}

/// Lemke's pivots on the tableau `w - M z - d z_0 = q` with a covering vector `d` of ones and, where `q` is not negative, zeros; columns are w,
/// z, z_0, right-hand side.
///
/// # Errors
/// [`LcpError::Ray`] if the method ends on a ray.
pub(crate) fn lemke(
    (m, q): (&[f64], &[f64]),
    cover: impl Fn(usize) -> f64,
    z: &mut [f64],
) -> Result<(), LcpError> {
    if q.iter().all(|&value| value >= 0.0) {
        return Ok(());
    }
    let n = q.len();
    let columns = 2 * n + 2;
    let artificial = 2 * n;
    let mut tableau = vec![0.0; n * columns];
    for i in 0..n {
        let row = &mut tableau[i * columns..(i + 1) * columns];
        row[i] = 1.0;
        for j in 0..n {
            row[n + j] = -m[i * n + j];
        }
        row[artificial] = -cover(i);
        row[columns - 1] = q[i];
    }
    let mut basis: Vec<usize> = (0..n).collect();
    let covered = (0..n).filter(|&i| cover(i) > 0.0);
    let mut row = covered
        .min_by(|&i, &j| q[i].total_cmp(&q[j]))
        .unwrap_or_default();
    let mut entering = artificial;
    for _ in 0..50 * (n + 1) {
        pivot(&mut tableau, columns, row, entering);
        let leaving = std::mem::replace(&mut basis[row], entering);
        if leaving == artificial {
            for (i, &variable) in basis.iter().enumerate() {
                if (n..2 * n).contains(&variable) {
                    z[variable - n] = tableau[i * columns + columns - 1].max(0.0);
                }
            }
            return Ok(());
        }
        entering = if leaving < n {
            leaving + n
        } else {
            leaving - n
        };
        row = ratio_test(&tableau, columns, &basis, entering, artificial).ok_or(LcpError::Ray)?;
    }
    Err(LcpError::Ray)
}

fn pivot(tableau: &mut [f64], columns: usize, row: usize, column: usize) {
    let value = tableau[row * columns + column];
    for entry in &mut tableau[row * columns..(row + 1) * columns] {
        *entry /= value;
    }
    let pivot_row = tableau[row * columns..(row + 1) * columns].to_vec();
    for (i, other) in tableau.chunks_exact_mut(columns).enumerate() {
        let factor = other[column];
        if i != row && factor != 0.0 {
            for (entry, above) in other.iter_mut().zip(&pivot_row) {
                *entry -= factor * above;
            }
        }
    }
}

/// Row with the smallest ratio; ties go to the artificial variable, then to the lexicographic order of
/// the rows of the basis inverse, which prevents cycling.
fn ratio_test(
    tableau: &[f64],
    columns: usize,
    basis: &[usize],
    entering: usize,
    artificial: usize,
) -> Option<usize> {
    let n = basis.len();
    let ratio =
        |i: usize, column: usize| tableau[i * columns + column] / tableau[i * columns + entering];
    let mut best: Option<usize> = None;
    for i in 0..n {
        // Entries of contacts are of the order of one; small ones carry the inertia of light bodies between heavy ones.
        if tableau[i * columns + entering] <= yardstick::DIGITS {
            continue;
        }
        let Some(current) = best else {
            best = Some(i);
            continue;
        };
        let difference = ratio(i, columns - 1) - ratio(current, columns - 1);
        let better = if difference.abs() > 1e-14 * ratio(current, columns - 1).abs() {
            difference < 0.0
        } else if basis[current] == artificial {
            false
        } else if basis[i] == artificial {
            true
        } else {
            (0..n)
                .map(|column| ratio(i, column) - ratio(current, column))
                .find(|value| value.abs() > 1e-14)
                .is_some_and(|value| value < 0.0)
        };
        if better {
            best = Some(i);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    #[test]
    fn one_contact_takes_the_impulse_that_stops_it() {
        let mut z = [0.0];
        solve(&[2.0], &[-3.0], &mut z).expect("solvable");
        assert_eq!(z, [1.5]);
        solve(&[2.0], &[3.0], &mut z).expect("solvable");
        assert_eq!(z, [0.0]);
        assert_eq!(solve(&[-1.0], &[-1.0], &mut z), Err(LcpError::Ray));
    }

    #[test]
    fn positive_coupling_lets_the_second_contact_separate() {
        // v = (-2, -1), D = [1 0.9; 0.9 1]: z_1 alone stops 1 and throws 2 off (w_2 = 0.8).
        let mut z = [0.0; 2];
        solve(&[1.0, 0.9, 0.9, 1.0], &[-2.0, -1.0], &mut z).expect("solvable");
        assert!((z[0] - 2.0).abs() < 1e-14 && z[1] == 0.0);
    }

    #[test]
    fn dependent_normals_still_have_a_solution() {
        let mut z = [0.0; 2];
        solve(&[1.0, 1.0, 1.0, 1.0], &[-2.0, -2.0], &mut z).expect("solvable");
        assert!((z[0] + z[1] - 2.0).abs() < 1e-14);
    }

    #[test]
    fn data_that_are_not_finite_are_refused() {
        assert_eq!(
            solve(&[1.0, 0.0, 0.0, f64::NAN], &[-1.0, 0.0], &mut [0.0; 2]),
            Err(LcpError::NotFinite)
        );
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        #[test]
        fn positive_definite_problems_are_solved_complementarily(
            root in proptest::collection::vec(-1.0..1.0, 25),
            q in proptest::collection::vec(-1.0..1.0, 5),
        ) {
            let n = 5;
            let mut m = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    m[i * n + j] = (0..n).map(|k| root[k * n + i] * root[k * n + j]).sum::<f64>()
                        + if i == j { 0.1 } else { 0.0 };
                }
            }
            let mut z = vec![0.0; n];
            prop_assert_eq!(solve(&m, &q, &mut z), Ok(()));
            for i in 0..n {
                let w: f64 = q[i] + (0..n).map(|j| m[i * n + j] * z[j]).sum::<f64>();
                // condition number below 1e3 by the shift of 0.1
                prop_assert!(z[i] >= 0.0 && w >= -1e-11, "w = {w:e}");
                prop_assert!((z[i] * w).abs() < 1e-10);
            }
        }
    }
}
