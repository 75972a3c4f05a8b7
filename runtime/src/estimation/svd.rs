//! Singular values of tall matrices of few columns.

use nalgebra::DMatrix;

/// Most iterations. Chosen: they converge cubically, in a few a column.
const ITERATIONS: usize = 10_000;

/// `A = U S V'`, by columns.
pub(super) struct Svd {
    /// Singular values, in the order of the columns of `v`.
    pub(super) sigma: Vec<f64>,
    /// Left singular vectors.
    pub(super) u: Vec<Vec<f64>>,
    /// Right singular vectors.
    pub(super) v: Vec<Vec<f64>>,
}

impl Svd {
    /// Of the matrix with these columns; zeros where they are not numbers.
    pub(super) fn of(columns: Vec<Vec<f64>>) -> Self {
        let n = columns.len();
        // As many rows as columns at least, so that there is a vector for every direction.
        let rows = columns.iter().map(Vec::len).fold(n, usize::max);
        let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
        let matrix = DMatrix::from_fn(rows, n, entry);
        let found = matrix.try_svd(true, true, f64::EPSILON, ITERATIONS);
        let Some((sigma, u, v)) =
            found.and_then(|svd| Some((svd.singular_values, svd.u?, svd.v_t?)))
        else {
            return Self {
                sigma: vec![0.0; n],
                u: vec![vec![0.0; rows]; n],
                v: vec![vec![0.0; n]; n],
            };
        };
        let left = u
            .column_iter()
            .map(|column| column.iter().copied().collect());
        let right = v.row_iter().map(|row| row.iter().copied().collect());
        Self {
            sigma: sigma.iter().copied().collect(),
            u: left.collect(),
            v: right.collect(),
        }
    }

    /// The largest singular value.
    pub(super) fn largest(&self) -> f64 {
        self.sigma.iter().fold(0.0, |most, sigma| sigma.max(most))
    }
}

#[cfg(test)]
mod tests {
    use super::Svd;
    use crate::linalg::products::dot;

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
