//! Derivatives of the solution of a linear system through its residual, as formulas.
//!
//! The formulas of [`super::implicit`] with the elimination written out: every intermediate result is
//! one quantity ([`graph::Node::Kept`]), so the entries of the inverse are never multiplied out. That takes
//! fewer operations than differentiating the solution from two or three coordinates on.

use super::explicit::by_parameters;
use super::ldl::Factorization;
use super::{Explicit, Implicit, Sparse};
use crate::graph::{self, Compose, Sym, Variable};
use std::collections::BTreeMap;

/// Solves `K y = b` and `K' mu = lambda` by formulas.
pub(super) trait Elimination {
    fn solve(&self, right: &[Sym]) -> Vec<Sym>;
    fn solve_transposed(&self, right: &[Sym]) -> Vec<Sym>;
}

/// The mass matrix.
impl Elimination for Factorization {
    fn solve(&self, right: &[Sym]) -> Vec<Sym> {
        self.solve(right)
    }
    fn solve_transposed(&self, right: &[Sym]) -> Vec<Sym> {
        self.solve(right)
    }
}

/// The mass matrix bordered by vectors, the normal `n` last: with unknowns `e` for each tangent `b`, then `d`
/// and `r`, `M e - b r = f`, `M d - n r = g`, `n' d = h`.
pub(super) struct Bordered<'a> {
    mass: &'a Factorization,
    columns: Vec<Vec<Sym>>,
    /// `M^-1` times each column.
    along: Vec<Vec<Sym>>,
    /// `1 / (n' M^-1 n)`.
    scale: Sym,
}

impl<'a> Bordered<'a> {
    pub(super) fn new(mass: &'a Factorization, columns: Vec<Vec<Sym>>) -> Self {
        let along: Vec<Vec<Sym>> = columns.iter().map(|column| mass.solve(column)).collect();
        let scale = last_product(&columns, &along).power(-2).kept();
        Self {
            mass,
            columns,
            along,
            scale,
        }
    }

    /// `n' M^-1 n`.
    pub(super) fn inverse_inertia(&self) -> Sym {
        last_product(&self.columns, &self.along)
    }

    /// `M^-1` times each block, and what remains behind the blocks.
    fn blocks(&self, right: &[Sym]) -> (Vec<Vec<Sym>>, Sym) {
        let n = self.columns[0].len();
        let blocks = right.chunks_exact(n).take(self.columns.len());
        let solve = |block: &[Sym]| {
            if block.iter().all(|f| f.is_structural_zero()) {
                block.to_vec()
            } else {
                self.mass.solve(block)
            }
        };
        (blocks.map(solve).collect(), right[n * self.columns.len()])
    }
}

impl Elimination for Bordered<'_> {
    fn solve(&self, right: &[Sym]) -> Vec<Sym> {
        let (mut blocks, closing) = self.blocks(right);
        let gap = closing - last_product(&self.columns, &blocks);
        let r = (gap.kept() * self.scale).kept();
        for (block, along) in blocks.iter_mut().zip(&self.along) {
            add_multiple(block, along, r);
        }
        let mut y = blocks.concat();
        y.push(r);
        y
    }

    fn solve_transposed(&self, right: &[Sym]) -> Vec<Sym> {
        let (mut blocks, closing) = self.blocks(right);
        let products = self.columns.iter().zip(&blocks);
        let total: Sym = products.map(|(column, block)| inner(column, block)).sum();
        let r = ((total + closing).kept() * self.scale).kept();
        if let (Some(block), Some(along)) = (blocks.last_mut(), self.along.last()) {
            add_multiple(block, along, -r);
        }
        let mut mu = blocks.concat();
        mu.push(r);
        mu
    }
}

/// Product of the last vectors of two lists.
fn last_product(a: &[Vec<Sym>], b: &[Vec<Sym>]) -> Sym {
    match (a.last(), b.last()) {
        (Some(a), Some(b)) => inner(a, b),
        _ => Sym::ZERO,
    }
}

fn add_multiple(to: &mut [Sym], vector: &[Sym], factor: Sym) {
    for (to, &component) in to.iter_mut().zip(vector) {
        *to = (*to + component * factor).kept();
    }
}

fn inner(a: &[Sym], b: &[Sym]) -> Sym {
    let product: Sym = a.iter().zip(b).map(|(&a, &b)| a * b).sum();
    product.kept()
}

/// The first components of the solution, as many as there are `weights`, and their derivatives; the
/// Hessian is that of their sum weighted by `weights`.
pub(super) fn derivatives(
    system: &Implicit,
    elimination: &dyn Elimination,
    weights: &[Sym],
    inputs: &[Variable],
) -> Explicit {
    let (size, rows) = (system.size, weights.len());
    let y = elimination.solve(&system.right);
    let mut padded = weights.to_vec();
    padded.resize(size, Sym::ZERO);
    let mu = elimination.solve_transposed(&padded);
    let at_solution = |sparse: &Sparse| -> BTreeMap<(usize, usize), Sym> {
        let values = graph::substitute(&sparse.values, |variable| match variable {
            Variable::Unknown(i) => y.get(usize::from(i) - size).copied(),
            Variable::Multiplier(i) => mu.get(usize::from(i)).copied(),
            _ => None,
        });
        let kept = values.into_iter().map(Sym::kept);
        sparse.entries.iter().copied().zip(kept).collect()
    };
    let first = at_solution(&system.residual_jacobian);
    let columns: Vec<Vec<Sym>> = (0..inputs.len())
        .map(|j| {
            let right: Vec<Sym> = (0..size)
                .map(|i| first.get(&(i, j)).map_or(Sym::ZERO, |&value| -value))
                .collect();
            if right.iter().all(|value| value.is_structural_zero()) {
                right
            } else {
                elimination.solve(&right)
            }
        })
        .collect();
    let jacobian = (0..rows).flat_map(|i| (0..inputs.len()).map(move |j| (i, j)));
    let jacobian = jacobian.map(|(i, j)| ((i, j), columns[j][i]));

    let mut terms: BTreeMap<(usize, usize), Vec<(Sym, f64)>> = BTreeMap::new();
    for (entry, value) in at_solution(&system.residual_hessian) {
        terms.entry(entry).or_default().push((value, -1.0));
    }
    let cross = if by_parameters(inputs) {
        BTreeMap::new()
    } else {
        at_solution(&system.cross)
    };
    for ((k, i), value) in cross {
        for (j, column) in columns.iter().enumerate() {
            // P'A and its transpose: on the diagonal both are the same product.
            let factor = if i == j { -2.0 } else { -1.0 };
            let entry = (i.max(j), i.min(j));
            let list = terms.entry(entry).or_default();
            list.push((value * column[k], factor));
        }
    }
    let hessian = terms
        .into_iter()
        .map(|(entry, terms)| (entry, graph::sum(terms)));
    Explicit {
        jacobian: Sparse::nonzeros(rows, inputs.len(), jacobian),
        hessian: Sparse::nonzeros(inputs.len(), inputs.len(), hessian),
        values: y[..rows].to_vec(),
    }
}
