//! Directions of forces that are solved for at run time with one factorization of the inertia for all contacts.
//!
//! With the inertia `K(x)`, which is the mass matrix bordered by the equations of joints, and vectors `c_k(x)` of which the normal
//! `n` comes last, the unknowns `y = (y_1, .., y_m, r)` of a contact solve
//!
//! ```text
//! K y_k - c_k r = 0      n' y_m = 1
//! ```
//!
//! so that `y_m` is the contact direction, the others those of friction, and `1/r = n' K^-1 n`; the direction of a force alone is
//! `K y_1 = c_1`. What its derivatives need besides the few of `c_k` is the same for all contacts: `d(K y)/dx` and
//! `(mu' K y)_xx` with vectors `y` and `mu` that are given as numbers. So what is derived of a contact does not grow with the inertia.

use super::explicit::{Sparse, hessian, jacobian};
use super::implicit::{Implicit, Locked, blocks, derivatives};
use crate::graph::{Sym, Variable};
use std::collections::BTreeSet;

/// The inertia of a scene, shared by all contacts. In its formulas, `Multiplier(i)` stands for `mu[i]` and
/// `Unknown(size + i)` for `y[i]`.
pub(crate) struct SharedInertia {
    pub(crate) size: usize,
    /// `K`, row-major.
    pub(crate) matrix: Vec<Sym>,
    /// `d(K mu)/dx`.
    pub(crate) product: Sparse,
    /// `(mu' K y)_xx`, lower triangle.
    pub(crate) curvature: Sparse,
    /// Number of the connected block of `K` that each row belongs to.
    blocks: Vec<usize>,
}

/// The vectors of one direction. Their components are weighted by `Multiplier(i)`, of one vector after the other.
pub(crate) struct Columns {
    /// Number of vectors.
    pub(crate) count: usize,
    /// Whether the last one is the normal by which all are scaled.
    pub(crate) bordered: bool,
    /// All components.
    pub(crate) values: Vec<Sym>,
    /// Their derivatives.
    pub(crate) jacobian: Sparse,
    /// Second derivatives of their weighted sum, lower triangle.
    pub(crate) hessian: Sparse,
}

/// How a direction is solved for at run time.
pub(crate) enum Directed {
    /// By a system of its own.
    System(Implicit),
    /// By the inertia of the scene.
    Columns(Columns),
}

impl Columns {
    pub(super) fn new(columns: &[Vec<Sym>], bordered: bool, inputs: &[Variable]) -> Self {
        let values = columns.concat();
        Self {
            count: columns.len(),
            bordered,
            jacobian: jacobian(&values, inputs),
            hessian: hessian(&values, inputs),
            values,
        }
    }
}

impl SharedInertia {
    pub(super) fn new(inertia: &Locked<'_>, inputs: &[Variable]) -> Self {
        let size = inertia.size();
        let matrix = inertia.matrix();
        let products = inertia.times(|i| Implicit::unknown(size, i));
        let (jacobian, hessian) = derivatives(inertia.in_steps);
        Self {
            size,
            blocks: blocks(&matrix, size),
            matrix,
            product: jacobian(&inertia.times(Implicit::multiplier), inputs),
            curvature: hessian(&products, inputs),
        }
    }

    /// For each row of the lower triangle, the first column that elimination in this order may fill.
    pub(crate) fn envelope(&self) -> Vec<usize> {
        let n = self.size;
        let first = |i: usize| (0..i).find(|j| !self.matrix[i * n + j].is_structural_zero());
        (0..n).map(|i| first(i).unwrap_or(i)).collect()
    }

    /// Positions at which the derivatives of the first direction may be nonzero.
    pub(crate) fn jacobian_pattern(&self, columns: &Columns, rows: usize) -> Vec<(usize, usize)> {
        let reached = self.sensitivity(columns);
        let inputs = columns.jacobian.columns;
        let all = (0..rows).flat_map(|row| (0..inputs).map(move |column| (row, column)));
        all.filter(|&(row, column)| reached.contains(&(self.blocks[row], column)))
            .collect()
    }

    /// Positions (lower triangle) at which the Hessian of the weighted first direction may be nonzero.
    pub(crate) fn hessian_pattern(&self, columns: &Columns) -> Vec<(usize, usize)> {
        let reached = self.sensitivity(columns);
        let own = columns.hessian.entries.iter();
        let mut entries: BTreeSet<(usize, usize)> = own.copied().collect();
        // Only what belongs to blocks in which the contact acts is not zero.
        let acting = self.acting(columns);
        let both = |&&(i, j): &&(usize, usize)| self.moves(&acting, i) && self.moves(&acting, j);
        entries.extend(self.curvature.entries.iter().filter(both));
        let mut by: BTreeSet<usize> = columns.jacobian.entries.iter().map(|&(_, i)| i).collect();
        let product = self.product.entries.iter();
        by.extend(
            product
                .filter(|&&(row, _)| acting.contains(&self.blocks[row]))
                .map(|&(_, i)| i),
        );
        let inputs: BTreeSet<usize> = reached.iter().map(|&(_, j)| j).collect();
        for &i in &by {
            entries.extend(inputs.iter().map(|&j| (i.max(j), i.min(j))));
        }
        entries.into_iter().collect()
    }

    /// Whether an input changes the inertia of one of these blocks.
    fn moves(&self, acting: &BTreeSet<usize>, input: usize) -> bool {
        let mut product = self.product.entries.iter();
        product.any(|&(row, column)| column == input && acting.contains(&self.blocks[row]))
    }

    /// Blocks in which the vectors have components.
    fn acting(&self, columns: &Columns) -> BTreeSet<usize> {
        let components = columns.values.iter().enumerate();
        let nonzero = components.filter(|(_, value)| !value.is_structural_zero());
        nonzero.map(|(i, _)| self.blocks[i % self.size]).collect()
    }

    /// Blocks of rows and the inputs on which the solution depends there. A scale that all share carries what one depends on
    /// to the others.
    fn sensitivity(&self, columns: &Columns) -> BTreeSet<(usize, usize)> {
        let acting = self.acting(columns);
        let own = columns.jacobian.entries.iter();
        let own = own.map(|&(row, column)| (self.blocks[row % self.size], column));
        let product = self.product.entries.iter();
        let product = product.map(|&(row, column)| (self.blocks[row], column));
        let known: BTreeSet<(usize, usize)> = own
            .chain(product)
            .filter(|(block, _)| acting.contains(block))
            .collect();
        if !columns.bordered {
            return known;
        }
        let of_all = known.iter();
        of_all
            .flat_map(|&(_, column)| acting.iter().map(move |&block| (block, column)))
            .collect()
    }
}
