//! What expressions stand for: numbers, vectors, matrices; or the units of their components.

use crate::graph::Sym;
use std::rc::Rc;

/// What an expression stands for, by its components.
#[derive(Debug, Clone)]
pub(crate) enum Value<T = Sym> {
    Scalar(T),
    Vector(Rc<[T]>),
    Matrix(Matrix<T>),
}

impl<T: Clone> Value<T> {
    pub(crate) fn components(&self) -> &[T] {
        match self {
            Self::Scalar(number) => std::slice::from_ref(number),
            Self::Vector(components) => components,
            Self::Matrix(matrix) => &matrix.entries,
        }
    }

    /// A value of this shape with other components.
    pub(super) fn with_components(&self, components: Vec<T>) -> Self {
        match self {
            Self::Scalar(own) => {
                Self::Scalar(components.into_iter().next().unwrap_or_else(|| own.clone()))
            }
            Self::Vector(_) => Self::Vector(components.into()),
            Self::Matrix(matrix) => Self::Matrix(Matrix::new(components, matrix.columns)),
        }
    }

    /// A value of this shape with another component for each.
    pub(crate) fn map(&self, other: impl Fn(&T) -> T) -> Self {
        self.with_components(self.components().iter().map(other).collect())
    }

    /// A component of a vector, or a row of a matrix.
    pub(crate) fn at(&self, index: usize) -> Option<Self> {
        match self {
            Self::Scalar(_) => None,
            Self::Vector(components) => components.get(index).cloned().map(Self::Scalar),
            Self::Matrix(matrix) => {
                let row = matrix.entries.chunks(matrix.columns.max(1)).nth(index)?;
                Some(Self::Vector(row.into()))
            }
        }
    }

    /// Its shape in words.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Scalar(_) => "a number".to_owned(),
            Self::Vector(components) => format!("a vector with {} components", components.len()),
            Self::Matrix(matrix) => {
                format!("a {} by {} matrix", matrix.rows(), matrix.columns)
            }
        }
    }
}

/// A matrix, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Matrix<T = Sym> {
    pub(crate) entries: Rc<[T]>,
    pub(crate) columns: usize,
}

impl<T: Clone> Matrix<T> {
    pub(crate) fn new(entries: Vec<T>, columns: usize) -> Self {
        Self {
            entries: entries.into(),
            columns,
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.entries.len() / self.columns.max(1)
    }

    /// For each entry of the product with a matrix of so many columns, row by row, the pairs whose products it adds up.
    pub(crate) fn products<'a>(
        &'a self,
        other: &'a [T],
        columns: usize,
    ) -> impl Iterator<Item = Vec<(&'a T, &'a T)>> {
        let rows = self.entries.chunks(self.columns.max(1));
        let column = move |j| other.iter().skip(j).step_by(columns);
        let pairs = move |row: &'a [T], j| row.iter().zip(column(j)).collect::<Vec<_>>();
        rows.flat_map(move |row| (0..columns).map(move |j| pairs(row, j)))
    }

    pub(crate) fn transposed(&self) -> Self {
        let columns = 0..self.columns;
        let entries = columns.flat_map(|j| self.entries.iter().skip(j).step_by(self.columns));
        Self::new(entries.cloned().collect(), self.rows())
    }
}
