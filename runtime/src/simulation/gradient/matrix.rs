//! A dense matrix, row-major.

/// Rows of equal length, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Matrix {
    pub(super) columns: usize,
    pub(super) values: Vec<f64>,
}

impl Matrix {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            columns,
            values: vec![0.0; rows * columns],
        }
    }

    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.columns..][..self.columns]
    }

    pub(super) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.columns..][..self.columns]
    }

    /// All rows as vectors.
    pub(super) fn rows(&self, range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        range.map(|i| self.row(i).to_vec()).collect()
    }
}

/// What one value depends on: the derivatives of `(q, v)` and of the impulses so far at some instant, the integral of the running
/// cost, and beyond those the quantities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Covector {
    pub(super) state: Vec<f64>,
    pub(super) impulses: Vec<f64>,
    pub(super) cost: f64,
    pub(super) by: Vec<f64>,
}

/// `to += factor * from`.
pub(super) fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}
