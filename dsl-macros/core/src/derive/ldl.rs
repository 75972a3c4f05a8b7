//! `M = L D L'` over symbols, without pivoting: valid because a mass matrix is positive definite.

use super::simplify;
use crate::graph::{Compose, Sym};

/// Factors of a symmetric matrix, in the order of elimination that needs the fewest operations.
pub(crate) struct Factorization {
    n: usize,
    /// `order[k]` is the row that is eliminated in step `k`.
    order: Vec<usize>,
    /// Unit lower triangle, row-major, in elimination order.
    lower: Vec<Sym>,
    pivots: Vec<Sym>,
    /// Applied to every intermediate result.
    simplify: fn(Sym) -> Sym,
}

impl Factorization {
    /// Factorizes a row-major matrix.
    ///
    /// # Errors
    /// The coordinate whose pivot is structurally zero.
    pub(crate) fn of(matrix: &[Sym], n: usize) -> Result<Self, usize> {
        let forward: Vec<usize> = (0..n).collect();
        let backward: Vec<usize> = (0..n).rev().collect();
        let first = Self::in_order(matrix, n, forward, simplify)?;
        if n == 1 {
            return Ok(first);
        }
        let second = Self::in_order(matrix, n, backward, simplify)?;
        Ok(if second.operations() < first.operations() {
            second
        } else {
            first
        })
    }

    /// Factorizes a row-major matrix with every intermediate result as one quantity, which keeps
    /// the formulas as long as elimination with numbers would take.
    ///
    /// # Errors
    /// The coordinate whose pivot is structurally zero.
    pub(crate) fn stepwise(matrix: &[Sym], n: usize) -> Result<Self, usize> {
        let forward = Self::in_order(matrix, n, (0..n).collect(), Sym::kept)?;
        let backward = Self::in_order(matrix, n, (0..n).rev().collect(), Sym::kept)?;
        // Sparse matrices fill in differently; the entries themselves cost the same in both.
        Ok(if backward.operations() < forward.operations() {
            backward
        } else {
            forward
        })
    }

    /// Factorizes a positive definite matrix bordered by equations, which are eliminated last, with every intermediate
    /// result as one quantity.
    ///
    /// # Errors
    /// The coordinate whose pivot is structurally zero.
    pub(crate) fn saddle(matrix: &[Sym], n: usize) -> Result<Self, usize> {
        Self::in_order(matrix, n, (0..n).collect(), Sym::kept)
    }

    fn in_order(
        matrix: &[Sym],
        n: usize,
        order: Vec<usize>,
        simplify: fn(Sym) -> Sym,
    ) -> Result<Self, usize> {
        let mut lower = vec![Sym::ZERO; n * n];
        // The entries of L D.
        let mut scaled = vec![Sym::ZERO; n * n];
        let mut pivots: Vec<Sym> = Vec::with_capacity(n);
        for j in 0..n {
            let at = |i: usize, j: usize| matrix[order[i] * n + order[j]];
            let mut pivot = at(j, j);
            let known: Vec<usize> = (0..j)
                .filter(|k| !lower[j * n + k].is_structural_zero())
                .collect();
            for &k in &known {
                pivot -= lower[j * n + k] * scaled[j * n + k];
            }
            let pivot = simplify(pivot);
            if pivot.is_structural_zero() {
                return Err(order[j]);
            }
            let inverse = pivot.power(-2);
            pivots.push(pivot);
            lower[j * n + j] = Sym::ONE;
            for i in j + 1..n {
                let mut entry = at(i, j);
                for &k in &known {
                    entry -= lower[j * n + k] * scaled[i * n + k];
                }
                let entry = simplify(entry);
                scaled[i * n + j] = entry;
                lower[i * n + j] = simplify(entry * inverse);
            }
        }
        Ok(Self {
            n,
            order,
            lower,
            pivots,
            simplify,
        })
    }

    /// Whether the factors take far fewer operations than loops over a full matrix, some two thirds of the cube of its size.
    pub(super) fn is_sparse(&self) -> bool {
        12 * self.operations() < self.n.pow(3)
    }

    fn operations(&self) -> usize {
        let mut all = self.lower.clone();
        all.extend(&self.pivots);
        crate::tape::operations(&all)
    }

    /// Solution of `M x = right`.
    pub(crate) fn solve(&self, right: &[Sym]) -> Vec<Sym> {
        let (n, simplify) = (self.n, self.simplify);
        let mut x: Vec<Sym> = self.order.iter().map(|&row| right[row]).collect();
        for i in 0..n {
            for k in 0..i {
                let (factor, known) = (self.lower[i * n + k], x[k]);
                if !factor.is_structural_zero() {
                    x[i] -= factor * known;
                }
            }
            x[i] = simplify(x[i]);
        }
        for (value, pivot) in x.iter_mut().zip(&self.pivots) {
            *value = simplify(*value / *pivot);
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                let (factor, known) = (self.lower[k * n + i], x[k]);
                if !factor.is_structural_zero() {
                    x[i] -= factor * known;
                }
            }
            x[i] = simplify(x[i]);
        }
        let mut solution = vec![Sym::ZERO; n];
        for (value, &row) in x.into_iter().zip(&self.order) {
            solution[row] = value;
        }
        solution
    }
}
