//! Dense LU factorization of small systems, in the caller's memory.
//!
//! Systems of 4 to 100 unknowns are factorized thousands of times a simulation; the factors overwrite
//! the matrix and nothing is allocated but a list of places in large ones.

use crate::yardstick;

/// Order of a matrix from which on rows are looked through for zeros: bodies that do not touch each other are not coupled.
const LARGE: usize = 64;
/// A matrix that cannot be factorized.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("singular matrix: no usable pivot in column {column}")]
pub(crate) struct SingularMatrix {
    /// Column in which no pivot was found.
    pub(crate) column: usize,
}

/// Factorizes the row-major `n x n` matrix `a` in place, `P A = L U` with partial pivoting.
///
/// `pivots[k]` is the row that was swapped with row `k`. A pivot below `1e-14` times the largest entry
/// of its original column counts as zero.
///
/// # Errors
/// [`SingularMatrix`] names the first column without a pivot.
pub(crate) fn factorize(a: &mut [f64], pivots: &mut [usize]) -> Result<(), SingularMatrix> {
    let n = pivots.len();
    debug_assert_eq!(a.len(), n * n);
    let mut nonzeros: Vec<usize> = Vec::new();
    for k in 0..n {
        let (mut best, mut largest) = (k, 0.0);
        let mut column = a[k..].iter().step_by(n);
        // What is above the diagonal already belongs to U; it sets the scale of the column.
        let mut scale = column.by_ref().take(k).fold(0.0_f64, |s, u| s.max(u.abs()));
        for (offset, entry) in column.enumerate() {
            if entry.abs() > largest {
                largest = entry.abs();
                best = k + offset;
            }
        }
        scale = scale.max(largest);
        let pivot = a[best * n + k];
        if !pivot.is_finite() || largest <= 1e-14 * scale {
            return Err(SingularMatrix { column: k });
        }
        pivots[k] = best;
        if best != k {
            let (upper, lower) = a.split_at_mut(best * n);
            upper[k * n..(k + 1) * n].swap_with_slice(&mut lower[..n]);
        }
        let (upper, lower) = a.split_at_mut((k + 1) * n);
        let pivot_row = &upper[k * n + k + 1..(k + 1) * n];
        let inverse = 1.0 / pivot;
        let sparse = n >= LARGE && {
            nonzeros.clear();
            let places = pivot_row.iter().enumerate();
            nonzeros.extend(places.filter(|(_, above)| **above != 0.0).map(|(j, _)| j));
            8 * nonzeros.len() < pivot_row.len()
        };
        for row in lower.chunks_exact_mut(n) {
            let factor = row[k] * inverse;
            row[k] = factor;
            if factor == 0.0 {
                continue;
            }
            let rest = &mut row[k + 1..];
            if sparse {
                for &j in &nonzeros {
                    rest[j] -= factor * pivot_row[j];
                }
            } else {
                for (entry, above) in rest.iter_mut().zip(pivot_row) {
                    *entry -= factor * above;
                }
            }
        }
    }
    Ok(())
}

/// Factorizes the matrix of equations that may follow from each other; `false` where they do, or a number is not finite.
pub(crate) fn factorize_independent(a: &mut [f64], pivots: &mut [usize]) -> bool {
    if factorize(a, pivots).is_err() {
        return false;
    }
    let sizes = a.iter().step_by(pivots.len() + 1).map(|pivot| pivot.abs());
    let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), size| {
        (least.min(size), most.max(size))
    });
    pivots.is_empty() || least > yardstick::ROUNDING * most
}

/// Solves `A x = b` with the factors of [`factorize`]; `b` is overwritten by `x`.
pub(crate) fn solve(factors: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for (k, &pivot) in pivots.iter().enumerate() {
        b.swap(k, pivot);
    }
    // Factors of bodies that do not touch each other begin, or end, with zeros: looking at them is faster than adding them.
    for i in 1..n {
        let row = &factors[i * n..i * n + i];
        let first = row.iter().position(|l| *l != 0.0).unwrap_or(i);
        let sum: f64 = row[first..]
            .iter()
            .zip(&b[first..])
            .map(|(l, x)| l * x)
            .sum();
        b[i] -= sum;
    }
    for i in (0..n).rev() {
        let row = &factors[i * n + i + 1..(i + 1) * n];
        let end = row
            .iter()
            .rposition(|u| *u != 0.0)
            .map_or(0, |last| last + 1);
        let sum: f64 = row[..end].iter().zip(&b[i + 1..]).map(|(u, x)| u * x).sum();
        b[i] = (b[i] - sum) / factors[i * n + i];
    }
}

/// Solves `A' x = b` with the factors of [`factorize`]; `b` is overwritten by `x`.
pub(crate) fn solve_transposed(factors: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for i in 0..n {
        let (solved, rest) = b.split_at_mut(i + 1);
        solved[i] /= factors[i * n + i];
        let row = &factors[i * n + i + 1..(i + 1) * n];
        for (x, u) in rest.iter_mut().zip(row) {
            *x -= u * solved[i];
        }
    }
    for i in (1..n).rev() {
        let (rest, solved) = b.split_at_mut(i);
        for (x, l) in rest.iter_mut().zip(&factors[i * n..]) {
            *x -= l * solved[0];
        }
    }
    for (k, &pivot) in pivots.iter().enumerate().rev() {
        b.swap(k, pivot);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    #[test]
    fn matrix_that_needs_pivoting_is_solved() {
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
        let mut pivots = [0; 3];
        factorize(&mut a, &mut pivots).expect("regular");
        let mut b = [7.0, 3.0, 6.0]; // x = (1, 2, 3)
        solve(&a, &pivots, &mut b);
        for (x, exact) in b.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - exact).abs() < 1e-15);
        }
    }

    #[test]
    fn transposed_system_is_solved_with_the_same_factors() {
        let a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
        let mut factors = a;
        let mut pivots = [0; 3];
        factorize(&mut factors, &mut pivots).expect("regular");
        let exact = [1.0, -2.0, 3.0];
        let mut b = [0, 1, 2].map(|j| (0..3).map(|i| a[3 * i + j] * exact[i]).sum::<f64>());
        solve_transposed(&factors, &pivots, &mut b);
        for (x, exact) in b.iter().zip(exact) {
            // Rounding of three operations with pivots above 1.
            assert!((x - exact).abs() < 1e-14, "{x} instead of {exact}");
        }
    }

    #[test]
    fn singular_matrix_names_its_column() {
        let mut a = [1.0, 2.0, 2.0, 4.0];
        assert_eq!(
            factorize(&mut a, &mut [0; 2]),
            Err(SingularMatrix { column: 1 })
        );
        let mut nan = [f64::NAN];
        assert!(factorize(&mut nan, &mut [0]).is_err());
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        #[test]
        fn solution_reproduces_the_right_hand_side(
            entries in proptest::collection::vec(-1.0..1.0, 36),
            b in proptest::collection::vec(-1.0..1.0, 6),
        ) {
            let mut a = entries.clone();
            for i in 0..6 { a[7 * i] += 4.0; } // diagonally strong: condition below 1e3
            let full = a.clone();
            let mut pivots = [0; 6];
            prop_assert!(factorize(&mut a, &mut pivots).is_ok());
            let mut x = b.clone();
            solve(&a, &pivots, &mut x);
            for i in 0..6 {
                let ax: f64 = (0..6).map(|j| full[6 * i + j] * x[j]).sum();
                prop_assert!((ax - b[i]).abs() < 1e-13);
            }
        }
    }
}
