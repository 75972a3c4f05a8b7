//! What expressions stand for: numbers, vectors, matrices.

use crate::graph::Sym;
use std::rc::Rc;

/// What an expression stands for.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Scalar(Sym),
    Vector(Rc<[Sym]>),
    Matrix(Matrix),
}

impl Value {
    pub(crate) fn components(&self) -> &[Sym] {
        match self {
            Self::Scalar(sym) => std::slice::from_ref(sym),
            Self::Vector(components) => components,
            Self::Matrix(matrix) => &matrix.entries,
        }
    }

    /// The same shape with other components.
    pub(super) fn with_components(&self, components: Vec<Sym>) -> Self {
        match self {
            Self::Scalar(sym) => Self::Scalar(components.first().copied().unwrap_or(*sym)),
            Self::Vector(_) => Self::Vector(components.into()),
            Self::Matrix(matrix) => Self::Matrix(Matrix::new(components, matrix.columns)),
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
pub(crate) struct Matrix {
    pub(crate) entries: Rc<[Sym]>,
    pub(crate) columns: usize,
}

impl Matrix {
    pub(super) fn new(entries: Vec<Sym>, columns: usize) -> Self {
        Self {
            entries: entries.into(),
            columns,
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.entries.len() / self.columns.max(1)
    }

    pub(super) fn at(&self, i: usize, j: usize) -> Sym {
        self.entries[i * self.columns + j]
    }

    pub(super) fn row(&self, i: usize) -> Option<Value> {
        let row = self.entries.chunks(self.columns.max(1)).nth(i)?;
        Some(Value::Vector(row.into()))
    }

    /// `self * vector`, which has as many components as there are columns.
    pub(super) fn times_vector(&self, vector: &[Sym]) -> Vec<Sym> {
        self.entries
            .chunks(self.columns.max(1))
            .map(|row| row.iter().zip(vector).map(|(&m, &v)| m * v).sum())
            .collect()
    }

    /// `self * other`, which has as many rows as there are columns.
    pub(super) fn times(&self, other: &Self) -> Self {
        let mut entries = Vec::with_capacity(self.rows() * other.columns);
        for i in 0..self.rows() {
            for j in 0..other.columns {
                let terms = (0..self.columns).map(|k| self.at(i, k) * other.at(k, j));
                entries.push(terms.sum());
            }
        }
        Self::new(entries, other.columns)
    }

    pub(super) fn transposed(&self) -> Self {
        let mut entries = Vec::with_capacity(self.entries.len());
        for j in 0..self.columns {
            entries.extend((0..self.rows()).map(|i| self.at(i, j)));
        }
        Self::new(entries, self.rows())
    }
}
