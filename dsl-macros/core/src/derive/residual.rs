//! Derivatives of the solution of a linear system through its residual, as formulas.
//!
//! The formulas of [`super::implicit`] with the elimination written out: every intermediate result is
//! one quantity ([`graph::Node::Kept`]), so the entries of the inverse are never multiplied out. That takes
//! fewer operations than differentiating the solution from two or three coordinates on.

use super::ldl::Factorization;
use super::{Explicit, Implicit, Sparse};
use crate::graph::{self, Sym, Variable};
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

/// The mass matrix bordered by a normal: `M d - n r = f`, `n' d = g`.
pub(super) struct Bordered<'a> {
    mass: &'a Factorization,
    normal: &'a [Sym],
    /// `M^-1 n`.
    along: Vec<Sym>,
    /// `1 / (n' M^-1 n)`.
    scale: Sym,
}

impl<'a> Bordered<'a> {
    pub(super) fn new(mass: &'a Factorization, normal: &'a [Sym]) -> Self {
        let along = mass.solve(normal);
        let scale = inner(normal, &along).power(-2).kept();
        Self {
            mass,
            normal,
            along,
            scale,
        }
    }

    /// `n' M^-1 n`.
    pub(super) fn inverse_inertia(&self) -> Sym {
        inner(self.normal, &self.along)
    }

    /// `M^-1 f + sign M^-1 n r`, and `r` last.
    fn solve_signed(&self, right: &[Sym], sign: f64) -> Vec<Sym> {
        let (first, last) = right.split_at(self.normal.len());
        // Forces along the normal alone come often; for them `M^-1 f` is not needed.
        let mut y = if first.iter().all(|f| f.is_structural_zero()) {
            first.to_vec()
        } else {
            self.mass.solve(first)
        };
        let gap = last[0].scaled(sign) - inner(self.normal, &y);
        let r = (gap.kept() * self.scale).kept();
        for (y, &along) in y.iter_mut().zip(&self.along) {
            *y = (*y + along * r).kept();
        }
        y.push(r.scaled(sign));
        y
    }
}

impl Elimination for Bordered<'_> {
    fn solve(&self, right: &[Sym]) -> Vec<Sym> {
        self.solve_signed(right, 1.0)
    }
    fn solve_transposed(&self, right: &[Sym]) -> Vec<Sym> {
        self.solve_signed(right, -1.0)
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
    for ((k, i), value) in at_solution(&system.cross) {
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
