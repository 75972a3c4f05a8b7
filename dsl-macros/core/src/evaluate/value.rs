//! What expressions stand for: numbers with their units, vectors, matrices.

use crate::dimension::Dimension;
use crate::graph::{Compose, Sym};
use hangtime_units::Ratio;
use std::rc::Rc;

/// A number of the scene: its node, and its unit.
#[derive(Debug, Clone)]
pub(crate) struct Number {
    pub(crate) sym: Sym,
    pub(crate) unit: Dimension,
}

impl Number {
    /// Another number in the same unit.
    pub(crate) fn with(&self, sym: Sym) -> Self {
        let unit = self.unit.clone();
        Self { sym, unit }
    }

    /// The same number in another unit.
    pub(crate) fn in_unit(&self, unit: Dimension) -> Self {
        let sym = self.sym;
        Self { sym, unit }
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        Self {
            sym: self.sym * other.sym,
            unit: self.unit.times(&other.unit),
        }
    }

    pub(super) fn over(&self, other: &Self) -> Self {
        Self {
            sym: self.sym * other.sym.power(-2),
            unit: self.unit.over(&other.unit),
        }
    }
}

/// What an expression stands for, by its components.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Scalar(Number),
    Vector(Rc<[Number]>),
    Matrix(Matrix),
}

impl Value {
    pub(crate) fn components(&self) -> &[Number] {
        match self {
            Self::Scalar(number) => std::slice::from_ref(number),
            Self::Vector(components) => components,
            Self::Matrix(matrix) => &matrix.entries,
        }
    }

    /// The nodes of its components.
    pub(crate) fn syms(&self) -> Vec<Sym> {
        let components = self.components().iter();
        components.map(|component| component.sym).collect()
    }

    /// A value of this shape and in these units with other numbers.
    pub(super) fn with_syms(&self, syms: Vec<Sym>) -> Self {
        let own = self.components().iter().zip(syms);
        self.with_components(own.map(|(own, sym)| own.with(sym)).collect())
    }

    /// A value of this shape with other components.
    fn with_components(&self, components: Vec<Number>) -> Self {
        match self {
            Self::Scalar(own) => {
                Self::Scalar(components.into_iter().next().unwrap_or_else(|| own.clone()))
            }
            Self::Vector(_) => Self::Vector(components.into()),
            Self::Matrix(matrix) => Self::Matrix(Matrix::new(components, matrix.columns)),
        }
    }

    /// A value of this shape with another component for each.
    pub(crate) fn map(&self, other: impl Fn(&Number) -> Number) -> Self {
        self.with_components(self.components().iter().map(other).collect())
    }

    /// The same value in units over a power of another one.
    pub(super) fn per(&self, unit: &Dimension, order: usize) -> Self {
        let divisor = unit.power(Ratio::integer(i32::try_from(order).unwrap_or(1)));
        self.map(|own| own.in_unit(own.unit.over(&divisor)))
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
pub(crate) struct Matrix {
    pub(crate) entries: Rc<[Number]>,
    pub(crate) columns: usize,
}

impl Matrix {
    pub(crate) fn new(entries: Vec<Number>, columns: usize) -> Self {
        Self {
            entries: entries.into(),
            columns,
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.entries.len() / self.columns.max(1)
    }

    /// For each entry of the product with a matrix of so many columns, row by row, the products that it adds up.
    pub(super) fn products<'a>(
        &'a self,
        other: &'a [Number],
        columns: usize,
    ) -> impl Iterator<Item = Vec<Number>> + use<'a> {
        let rows = self.entries.chunks(self.columns.max(1));
        let column = move |j| other.iter().skip(j).step_by(columns);
        let products = move |row: &'a [Number], j| {
            let pairs = row.iter().zip(column(j));
            pairs.map(|(a, b)| a.times(b)).collect::<Vec<_>>()
        };
        rows.flat_map(move |row| (0..columns).map(move |j| products(row, j)))
    }

    pub(crate) fn transposed(&self) -> Self {
        let columns = 0..self.columns;
        let entries = columns.flat_map(|j| self.entries.iter().skip(j).step_by(self.columns));
        Self::new(entries.cloned().collect(), self.rows())
    }
}
