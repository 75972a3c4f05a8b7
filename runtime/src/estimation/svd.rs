//! Singular values of tall matrices of few columns.

/// Turns of all pairs of columns: one-sided Jacobi iterations converge quadratically, in some ten of them.
const SWEEPS: usize = 60;
/// Cosine of two columns that counts as none.
const ORTHOGONAL: f64 = 1e-15;

/// `A = U S V'`, by columns.
pub(super) struct Svd {
    /// Singular values, in the order of the columns of `v`.
    pub(super) sigma: Vec<f64>,
    /// Left singular vectors; zeros where the singular value is zero.
    pub(super) u: Vec<Vec<f64>>,
    /// Right singular vectors.
    pub(super) v: Vec<Vec<f64>>,
}

impl Svd {
    /// Of the matrix with these columns, by one-sided Jacobi rotations, which find small singular values as accurately as the
    /// columns are known (Demmel, Veselic, *Jacobi's method is more accurate than QR*, 1992).
    pub(super) fn of(columns: Vec<Vec<f64>>) -> Self {
        let n = columns.len();
        let mut u = columns;
        let mut v: Vec<Vec<f64>> = (0..n)
            .map(|k| (0..n).map(|i| if i == k { 1.0 } else { 0.0 }).collect())
            .collect();
        for _ in 0..SWEEPS {
            let mut turned = false;
            for p in 0..n {
                for q in p + 1..n {
                    let (a, b, c) = (dot(&u[p], &u[p]), dot(&u[q], &u[q]), dot(&u[p], &u[q]));
                    if c.abs() <= ORTHOGONAL * (a * b).sqrt() || c == 0.0 {
                        continue;
                    }
                    turned = true;
                    let zeta = (b - a) / (2.0 * c);
                    let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                    let cos = 1.0 / t.hypot(1.0);
                    rotate(&mut u, (p, q), (cos, cos * t));
                    rotate(&mut v, (p, q), (cos, cos * t));
                }
            }
            if !turned {
                break;
            }
        }
        let sigma: Vec<f64> = u.iter().map(|column| dot(column, column).sqrt()).collect();
        for (column, sigma) in u.iter_mut().zip(&sigma) {
            let factor = if *sigma > 0.0 { 1.0 / sigma } else { 0.0 };
            column.iter_mut().for_each(|value| *value *= factor);
        }
        Self { sigma, u, v }
    }

    /// The largest singular value.
    pub(super) fn largest(&self) -> f64 {
        self.sigma.iter().fold(0.0, |most, sigma| sigma.max(most))
    }
}

fn rotate(columns: &mut [Vec<f64>], (p, q): (usize, usize), (cos, sin): (f64, f64)) {
    let (left, right) = columns.split_at_mut(q);
    for (x, y) in left[p].iter_mut().zip(right[0].iter_mut()) {
        (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::{Svd, dot};

    #[test]
    fn matrix_is_the_product_of_its_singular_values_and_a_dependent_column_gives_a_zero() {
        let columns = vec![
            vec![1.0, 2.0, 2.0, 0.0],
            vec![0.0, 3.0, -1.0, 4.0],
            vec![1.0, 5.0, 1.0, 4.0],
        ];
        let svd = Svd::of(columns.clone());
        for (j, column) in columns.iter().enumerate() {
            for (i, wanted) in column.iter().enumerate() {
                let terms = (0..3).map(|k| svd.u[k][i] * svd.sigma[k] * svd.v[k][j]);
                // Rounding of entries of size 5.
                assert!((terms.sum::<f64>() - wanted).abs() < 1e-14);
            }
        }
        // The third column is the sum of the others: nothing changes along (1, 1, -1).
        let least = (0..3)
            .min_by(|&a, &b| svd.sigma[a].total_cmp(&svd.sigma[b]))
            .unwrap();
        assert!(svd.sigma[least] < 1e-14 * svd.largest());
        let along = dot(&svd.v[least], &[1.0, 1.0, -1.0]).abs() / 3.0_f64.sqrt();
        assert!((along - 1.0).abs() < 1e-14, "{along}");
    }
}
