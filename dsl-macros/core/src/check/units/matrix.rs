//! Units of matrices: entry by entry, as those of moments of inertia and of rotations differ.

use super::{Units, Walk};
use crate::ast::{Expr, Link, Name, Prefix};
use crate::diagnostics::{Checked, Reported};
use crate::dimension::Dimension;

/// Units of the entries, row by row.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    pub(super) entries: Vec<Dimension>,
    pub(super) columns: usize,
}

impl Matrix {
    pub(super) fn rows(&self) -> impl Iterator<Item = &[Dimension]> {
        self.entries.chunks(self.columns.max(1))
    }

    fn column(&self, j: usize) -> Vec<Dimension> {
        let column = self.entries.iter().skip(j).step_by(self.columns.max(1));
        column.cloned().collect()
    }
}

impl Walk<'_> {
    /// Units of `((a, b), (c, d))`, or of `(a, b)`.
    pub(super) fn stacked(&mut self, items: &[Expr]) -> Checked<Units> {
        let mut entries = Vec::with_capacity(items.len());
        let mut columns = None;
        for item in items {
            match self.units(item)? {
                Units::Scalar(dimension) => entries.push(dimension),
                Units::Vector(row) => {
                    columns = Some(row.len());
                    entries.extend(row);
                }
                Units::Matrix(_) => return Err(Reported),
            }
        }
        Ok(match columns {
            Some(columns) => Units::Matrix(Matrix { entries, columns }),
            None => Units::Vector(entries),
        })
    }

    /// Units of a product in which a matrix stands on the left.
    pub(super) fn matrix_product(
        &mut self,
        left: &Prefix<'_>,
        own: &Matrix,
        link: &Link,
        its: &Units,
    ) -> Checked<Units> {
        let (columns, width) = match its {
            Units::Vector(vector) => (vec![vector.clone()], None),
            Units::Matrix(other) => (
                (0..other.columns).map(|j| other.column(j)).collect(),
                Some(other.columns),
            ),
            Units::Scalar(factor) => {
                let entries = own.entries.iter().map(|entry| entry.times(factor));
                return Ok(Units::Matrix(Matrix {
                    entries: entries.collect(),
                    columns: own.columns,
                }));
            }
        };
        let mut entries = Vec::new();
        for row in own.rows() {
            for column in &columns {
                let products: Vec<Dimension> =
                    row.iter().zip(column).map(|(a, b)| a.times(b)).collect();
                let first = products.first().cloned().ok_or(Reported)?;
                for product in &products {
                    if !self.unifier.unify(product, &first) {
                        let message = format!(
                            "units differ: the terms of the product `{left}*{}` are in {} and {}",
                            link.operand,
                            self.unifier.show(&first),
                            self.unifier.show(product)
                        );
                        return Err(self.diagnostics.report("E03", link.place, message));
                    }
                }
                entries.push(first);
            }
        }
        Ok(match width {
            Some(columns) => Units::Matrix(Matrix { entries, columns }),
            None => Units::Vector(entries),
        })
    }

    /// Units of what the functions of matrices make.
    pub(super) fn matrix_function(
        &mut self,
        function: &Name,
        arguments: &[Expr],
    ) -> Checked<Units> {
        match (function.text.as_str(), arguments) {
            ("transpose", [argument]) => match self.units(argument)? {
                Units::Matrix(matrix) => {
                    let entries = (0..matrix.columns).flat_map(|j| matrix.column(j)).collect();
                    let columns = matrix.rows().count();
                    Ok(Units::Matrix(Matrix { entries, columns }))
                }
                _ => Err(Reported),
            },
            ("diagonal", items) => {
                let n = items.len();
                // Zeros fit anywhere.
                let mut entries: Vec<Dimension> =
                    (0..n * n).map(|_| self.unifier.unknown("")).collect();
                for (i, item) in items.iter().enumerate() {
                    entries[i * n + i] = self.scalar(item)?;
                }
                Ok(Units::Matrix(Matrix {
                    entries,
                    columns: n,
                }))
            }
            (name, [angle]) => {
                self.pure(angle, name)?;
                let columns = if name == "rotation" { 2 } else { 3 };
                Ok(Units::Matrix(Matrix {
                    entries: vec![Dimension::one(); columns * columns],
                    columns,
                }))
            }
            _ => Err(Reported),
        }
    }
}
