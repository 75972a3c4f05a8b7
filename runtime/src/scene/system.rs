//! Small linear systems and the derivatives of their solutions.
//!
//! A vector `y(x)` solves `K(x) y = b(x)`; `F(x, y) = K y - b`. With `mu = K^-T lambda` and `P = d(K' mu)/dx`,
//!
//! ```text
//! A = dy/dx = -K^-1 F_x          d2(lambda' y)/dx2 = -(mu' F)_xx - P' A - A' P
//! ```
//!
//! What is zero is passed over, which changes no sum: the inertia of bodies that are not joined to each other is a band, or a diagonal.

use super::data::Places;

/// A position as indices.
pub(super) fn at((row, column): (u32, u32)) -> (usize, usize) {
    (row as usize, column as usize)
}

/// A factorized linear system, its solution and the derivatives of that.
#[derive(Debug, Default)]
pub(super) struct Solution {
    /// Unit lower triangle and upper triangle, row-major.
    pub(super) factors: Vec<f64>,
    /// `rows[i]` is the row of the matrix that became row `i`.
    pub(super) rows: Vec<usize>,
    /// Where each row of the matrix has gone.
    places: Vec<usize>,
    /// Columns of each row from its first nonzero to behind its last one.
    reach: Vec<[usize; 2]>,
    /// Multipliers, and then the solution.
    pub(super) y: Vec<f64>,
    /// Derivatives of the solution, row-major.
    pub(super) sensitivity: Vec<f64>,
    /// A matrix over the inputs, row-major.
    pub(super) product: Vec<f64>,
    /// Right-hand sides and intermediate vectors.
    pub(super) vectors: [Vec<f64>; 2],
}

impl Solution {
    /// Factorizes the matrix of order `size` that stands before the right-hand side in `system`, and solves for it. The
    /// solution stands behind as many zeros in `y`.
    pub(super) fn solve_system(&mut self, system: &[f64], size: usize) {
        let (matrix, right) = system.split_at(size * size);
        self.factorize(matrix, size);
        zeros(&mut self.y, 2 * size);
        let mut y = std::mem::take(&mut self.y);
        self.solve(right, &mut y[size..]);
        self.y = y;
    }

    /// `P K = L U` with row exchanges. A singular matrix gives factors that are not finite.
    fn factorize(&mut self, matrix: &[f64], size: usize) {
        self.factors.clear();
        self.factors.extend_from_slice(matrix);
        self.rows.clear();
        self.rows.extend(0..size);
        self.reach.clear();
        self.reach
            .extend(matrix.chunks_exact(size.max(1)).map(reach));
        let (factors, reach) = (&mut self.factors[..], &mut self.reach[..]);
        for k in 0..size {
            let mut pivot = k;
            for i in k + 1..size {
                if reach[i][0] <= k && factors[i * size + k].abs() > factors[pivot * size + k].abs()
                {
                    pivot = i;
                }
            }
            if pivot != k {
                let (above, below) = factors.split_at_mut(pivot * size);
                above[k * size..][..size].swap_with_slice(&mut below[..size]);
                reach.swap(k, pivot);
            }
            self.rows.swap(k, pivot);
            let inverse = 1.0 / factors[k * size + k];
            let (above, below) = factors.split_at_mut((k + 1) * size);
            let eliminated = &above[k * size..];
            let end = reach[k][1].max(k + 1);
            for (i, row) in below.chunks_exact_mut(size).enumerate() {
                let own = &mut reach[k + 1 + i];
                // One that is not finite makes all others so.
                if own[0] > k && inverse.is_finite() {
                    continue;
                }
                let factor = row[k] * inverse;
                row[k] = factor;
                if factor != 0.0 {
                    subtract(&mut row[k + 1..end], &eliminated[k + 1..end], factor);
                    own[0] = own[0].min(k);
                    own[1] = own[1].max(end);
                }
            }
        }
        zeros(&mut self.places, size);
        for (place, &row) in self.rows.iter().enumerate() {
            self.places[row] = place;
        }
    }

    /// Solution of `K x = b`.
    pub(super) fn solve(&self, b: &[f64], x: &mut [f64]) {
        let rows = self.factors.chunks_exact(x.len()).zip(&self.reach);
        for (i, (row, &[first, _])) in rows.clone().enumerate() {
            let first = first.min(i);
            x[i] = b[self.rows[i]] - inner(&row[first..i], &x[first..i]);
        }
        for (i, (row, &[_, end])) in rows.enumerate().rev() {
            let end = end.max(i + 1);
            x[i] = (x[i] - inner(&row[i + 1..end], &x[i + 1..end])) / row[i];
        }
    }

    /// Solution of `K' mu = lambda`, which becomes the first half of `y`.
    pub(super) fn solve_transposed(&mut self, lambda: &[f64]) {
        let size = lambda.len();
        let rows = self.factors.chunks_exact(size);
        let work = &mut self.vectors[0];
        work.clear();
        work.extend_from_slice(lambda);
        for (i, row) in rows.clone().enumerate() {
            work[i] /= row[i];
            let (known, rest) = work.split_at_mut(i + 1);
            subtract(rest, &row[i + 1..], known[i]);
        }
        for (i, row) in rows.enumerate().rev() {
            let (rest, known) = work.split_at_mut(i);
            subtract(rest, &row[..i], known[0]);
        }
        for (value, &row) in work.iter().zip(&self.rows) {
            self.y[row] = *value;
        }
    }

    /// `A = -K^-1 F_x` from the nonzeros of `F_x`, with a column for each input.
    pub(super) fn differentiate(&mut self, pattern: Places, values: &[f64], inputs: usize) {
        let size = self.rows.len();
        zeros(&mut self.sensitivity, size * inputs);
        let a = &mut self.sensitivity[..];
        for (&place, value) in pattern.iter().zip(values) {
            let (row, column) = at(place);
            a[self.places[row] * inputs + column] = -value;
        }
        let rows = self.factors.chunks_exact(size);
        for (i, factors) in rows.clone().enumerate() {
            let (known, rest) = a.split_at_mut(i * inputs);
            for (row, &factor) in known.chunks_exact(inputs).zip(factors) {
                if factor != 0.0 {
                    subtract(&mut rest[..inputs], row, factor);
                }
            }
        }
        for (i, factors) in rows.enumerate().rev() {
            let (rest, known) = a.split_at_mut((i + 1) * inputs);
            let own = &mut rest[i * inputs..];
            for (row, &factor) in known.chunks_exact(inputs).zip(&factors[i + 1..]) {
                if factor != 0.0 {
                    subtract(own, row, factor);
                }
            }
            let inverse = 1.0 / factors[i];
            for value in own {
                *value *= inverse;
            }
        }
    }

    /// Picks entries of `A`; `above` is subtracted from their rows.
    pub(super) fn gather(&self, pattern: Places, above: usize, values: &mut [f64]) {
        let inputs = self.sensitivity.len() / self.rows.len();
        for (&place, value) in pattern.iter().zip(values) {
            let (row, column) = at(place);
            *value = self.sensitivity[(row - above) * inputs + column];
        }
    }

    /// Hessian of `lambda' y` at the positions `pattern` of its lower triangle: from `A`, the nonzeros of `(mu' F)_xx`
    /// (lower triangle) and those of `P`.
    pub(super) fn pull_back(
        &mut self,
        (residual_pattern, residual): (Places, &[f64]),
        (cross_pattern, cross): (Places, &[f64]),
        pattern: Places,
        values: &mut [f64],
    ) {
        let inputs = self.sensitivity.len() / self.rows.len();
        zeros(&mut self.product, inputs * inputs);
        let product = &mut self.product[..];
        // P'A, row i from each nonzero P[k][i]; its transpose is added where an entry is read.
        for (&place, &value) in cross_pattern.iter().zip(cross) {
            let (k, i) = at(place);
            let row = &self.sensitivity[k * inputs..][..inputs];
            subtract(&mut product[i * inputs..][..inputs], row, -value);
        }
        // An entry is read as the sum of its two places, which on the diagonal are one.
        for (&place, &value) in residual_pattern.iter().zip(residual) {
            let (i, j) = at(place);
            product[i * inputs + j] += if i == j { 0.5 * value } else { value };
        }
        for (&place, value) in pattern.iter().zip(values) {
            let (i, j) = at(place);
            *value = -(product[i * inputs + j] + product[j * inputs + i]);
        }
    }
}

/// From the first nonzero of a row to behind its last one.
fn reach(row: &[f64]) -> [usize; 2] {
    let first = row.iter().position(|entry| *entry != 0.0);
    let last = row.iter().rposition(|entry| *entry != 0.0);
    match (first, last) {
        (Some(first), Some(last)) => [first, last + 1],
        _ => [row.len(), 0],
    }
}

pub(super) fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y -= factor * x`.
pub(super) fn subtract(y: &mut [f64], x: &[f64], factor: f64) {
    if factor != 0.0 {
        for (y, x) in y.iter_mut().zip(x) {
            *y -= factor * x;
        }
    }
}

/// The vector with this length, of zeros.
pub(super) fn zeros<T: Copy + Default>(vector: &mut Vec<T>, length: usize) {
    vector.clear();
    vector.resize(length, T::default());
}
