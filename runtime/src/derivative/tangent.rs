//! Derivatives of everything at one place of a motion.

use crate::linalg::dense;
use crate::linalg::products::dot;
use crate::model::Model;

/// A dense matrix, row-major.
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

    /// Some rows as vectors.
    pub(super) fn rows(&self, range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        range.map(|i| self.row(i).to_vec()).collect()
    }
}

/// Factors of a square matrix.
#[derive(Debug, Default)]
pub(super) struct Factors {
    matrix: Vec<f64>,
    pivots: Vec<usize>,
}

impl Factors {
    /// Those of a row-major matrix; none of a singular one.
    pub(super) fn of(mut matrix: Vec<f64>) -> Option<Self> {
        let mut pivots = vec![0; matrix.len().isqrt()];
        dense::factorize(&mut matrix, &mut pivots).ok()?;
        Some(Self { matrix, pivots })
    }

    pub(super) fn solve(&self, right: &mut [f64]) {
        dense::solve(&self.matrix, &self.pivots, right);
    }

    /// Solves with the transposed matrix.
    pub(super) fn solve_transposed(&self, right: &mut [f64]) {
        dense::solve_transposed(&self.matrix, &self.pivots, right);
    }

    /// Solves for all columns of `right`.
    pub(super) fn solve_all(&self, mut right: Matrix) -> Matrix {
        let columns = right.columns;
        let mut column = vec![0.0; self.pivots.len()];
        for c in 0..columns {
            let values = right.values.iter().skip(c).step_by(columns);
            column
                .iter_mut()
                .zip(values)
                .for_each(|(to, value)| *to = *value);
            self.solve(&mut column);
            let values = right.values.iter_mut().skip(c).step_by(columns);
            values.zip(&column).for_each(|(to, value)| *to = *value);
        }
        right
    }
}

/// Which row of a [`Tangent`] is what: the coordinates and velocities, the controls, the time, the parameters, the normal and then the
/// tangential impulses of all contacts so far, the integral of the running cost, and the time of the last event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Coordinates.
    pub(super) n: usize,
    controls: usize,
    explicit_time: bool,
    /// Parameters with derivatives.
    pub(super) parameters: usize,
    contacts: usize,
}

impl Layout {
    pub(super) fn of(model: &dyn Model, parameters: usize) -> Self {
        let declaration = model.declaration();
        Self {
            n: declaration.coordinates.len(),
            controls: declaration.controls.len(),
            explicit_time: declaration.explicit_time,
            parameters,
            contacts: declaration.contacts.len(),
        }
    }

    /// The row of the time.
    pub(super) fn time(&self) -> usize {
        2 * self.n + self.controls
    }

    /// The first row of the parameters.
    pub(super) fn first_parameter(&self) -> usize {
        self.time() + 1
    }

    /// The first row of the impulses.
    pub(super) fn impulses(&self) -> usize {
        self.first_parameter() + self.parameters
    }

    /// The row of the cost.
    pub(super) fn cost(&self) -> usize {
        self.impulses() + 2 * self.contacts
    }

    /// The row of the time of the last event.
    pub(super) fn last_event(&self) -> usize {
        self.cost() + 1
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.last_event() + 1
    }

    /// Number of the columns that derivatives of a function of the scene have: its inputs and the parameters.
    pub(super) fn columns(&self) -> usize {
        self.time() + usize::from(self.explicit_time) + self.parameters
    }

    /// The rows that these columns stand for.
    pub(super) fn read(&self) -> impl Iterator<Item = usize> + Clone {
        let behind = if self.explicit_time {
            self.time()
        } else {
            self.first_parameter()
        };
        (0..self.time()).chain(behind..self.impulses())
    }

    /// Rate of a function with these derivatives where everything changes at these `rates`, and the sum of the sizes of its terms.
    pub(super) fn rate(&self, by: &[f64], rates: &[f64]) -> (f64, f64) {
        let terms = self.read().zip(by).map(|(row, by)| by * rates[row]);
        terms.fold((0.0, 0.0), |(sum, size), term| {
            (sum + term, size + term.abs())
        })
    }
}

/// Derivatives of everything at one place of a motion, a column for each direction in which quantities change.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tangent {
    pub(super) layout: Layout,
    pub(super) all: Matrix,
}

impl Tangent {
    pub(super) fn zeros(layout: Layout, columns: usize) -> Self {
        Self {
            layout,
            all: Matrix::zeros(layout.rows(), columns),
        }
    }

    /// That of everything by itself.
    pub(super) fn identity(layout: Layout) -> Self {
        let mut tangent = Self::zeros(layout, layout.rows());
        for i in 0..layout.rows() {
            tangent.all.row_mut(i)[i] = 1.0;
        }
        tangent
    }

    /// The one column in which the columns change by these shares.
    pub(super) fn along(&self, shares: &[f64]) -> Self {
        let mut one = Self::zeros(self.layout, 1);
        for i in 0..self.layout.rows() {
            one.all.values[i] = dot(self.all.row(i), shares);
        }
        one
    }

    /// The columns of this one, and then those of another one.
    pub(super) fn beside(&self, other: &Self) -> Self {
        let rows = (0..self.layout.rows()).flat_map(|i| [self.all.row(i), other.all.row(i)]);
        Self {
            layout: self.layout,
            all: Matrix {
                columns: self.all.columns + other.all.columns,
                values: rows.flatten().copied().collect(),
            },
        }
    }

    /// The first columns, and the others.
    pub(super) fn split(&self, first: usize) -> [Self; 2] {
        [0..first, first..self.all.columns].map(|range| {
            let columns = range.len();
            let rows = (0..self.layout.rows()).flat_map(|i| &self.all.row(i)[range.clone()]);
            let values = rows.copied().collect();
            Self {
                layout: self.layout,
                all: Matrix { columns, values },
            }
        })
    }

    /// Takes a column from another one.
    pub(super) fn take_column(&mut self, column: usize, from: &Self) {
        for i in 0..self.layout.rows() {
            self.all.row_mut(i)[column] = from.all.row(i)[column];
        }
    }

    /// Derivatives of a function with these by the inputs and the parameters.
    pub(super) fn of(&self, by: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.all.columns];
        for (row, by) in self.layout.read().zip(by) {
            if *by != 0.0 {
                add(&mut sum, *by, self.all.row(row));
            }
        }
        sum
    }

    /// Sums of the sizes of the terms of that.
    pub(super) fn sizes(&self, by: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.all.columns];
        for (row, by) in self.layout.read().zip(by) {
            for (sum, value) in sum.iter_mut().zip(self.all.row(row)) {
                *sum += (by * value).abs();
            }
        }
        sum
    }

    /// Derivatives of a function with these by the parameters.
    pub(super) fn of_parameters(&self, by: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.all.columns];
        for (k, by) in by.iter().enumerate() {
            add(
                &mut sum,
                *by,
                self.all.row(self.layout.first_parameter() + k),
            );
        }
        sum
    }

    /// Moves the instant by `times` along the motion, in which everything changes at these rates.
    pub(super) fn shift(&mut self, rates: &[f64], times: &[f64], sense: f64) {
        for (k, rate) in rates.iter().enumerate() {
            if *rate != 0.0 {
                add(self.all.row_mut(k), sense * rate, times);
            }
        }
    }

    /// The rows of coordinates and velocities.
    pub(super) fn state(&self) -> &[f64] {
        &self.all.values[..2 * self.layout.n * self.all.columns]
    }
}

/// `to += factor * from`.
pub(super) fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}
