//! Multifrontal `L B L'` with threshold pivoting.
//!
//! The matrix is eliminated along its assembly tree (Duff and Reid 1983): each supernode gathers its
//! entries and the Schur complements of its children in a dense front, eliminates what threshold pivoting
//! with 1x1 and 2x2 blocks allows, and passes the rest on; columns without a good pivot are postponed to
//! the parent. The inertia is that of `B` and hence, up to rounding, that of the matrix; no shifts are
//! needed. Matrices are equilibrated before.
//!
//! Fronts of sparse programs have a handful of rows, so what costs is not arithmetic but finding places. As long as no
//! column is postponed to a front, its rows are known from the pattern, and entries and Schur complements go to places
//! computed once; only fronts that inherit columns look places up. Columns of fronts are padded to blocks of four rows, and
//! factorization and solution are compiled for the widest vectors of the machine as well, with the same results.
//!
//! Postponed columns can fill everything where a matrix is close to singular in many places. A factorization that
//! takes far more work than the pattern asks for is stopped, and counts what is left as zero in the inertia: the
//! matrix wants larger shifts.

mod assembly_tree;
mod factors;
mod front;
mod kernels;
mod substitution;
mod symbolic;

use pulp::Simd;

use factors::{Factors, FrontRecord};
use front::{Front, LOOK, Pivot};
use kernels::padded;
use symbolic::{Node, Symbolic};

use super::{FactorizationError, Inertia, SymmetricPattern};
use crate::until::Until;

/// Multifrontal factorization with pivoting, `S P' L B L' P S` for a matrix equilibrated by a diagonal `S`.
pub(crate) struct MultifrontalLdl {
    primal: usize,
    symbolic: Symbolic,
    /// Equilibration of permuted rows, kept from one matrix to the next; whether there is one, and a work array.
    scale: Vec<f64>,
    is_scaled: bool,
    work: Vec<f64>,
    /// Shifted values: the diagonal by permuted row, and the others in the order of the entries.
    diagonal: Vec<f64>,
    entries: Vec<f64>,
    /// Permuted row to row of the current front, for fronts that inherit columns.
    local: Vec<u32>,
    /// Work arrays of a front's rows.
    product: Vec<f64>,
    gathered: Vec<f64>,
    stack: Stack,
    pivots: Vec<Pivot>,
    factors: Factors,
    limits: Limits,
}

/// How long a factorization may work.
#[derive(Debug)]
struct Limits {
    /// Most multiplications.
    most_work: f64,
    until: Until,
}

/// The stack of Schur complements.
#[derive(Debug, Default)]
struct Stack {
    /// Square blocks, the names of their postponed columns, and one record for each.
    blocks: Vec<f64>,
    postponed: Vec<u32>,
    records: Vec<Block>,
}

/// Most multiplications of a factorization: this many times those without postponed columns, and this many more.
const MOST_WORK: (f64, f64) = (64.0, 1e8);

/// Most sweeps of equilibration, and the imbalance before a sweep that is small enough after it: no entry that matters is
/// below its root then, far above what counts as zero.
const SWEEPS: usize = 10;
const IMBALANCE: f64 = 1e14;

/// A Schur complement on the stack: its postponed columns, then the rows below its node.
#[derive(Debug, Clone, Copy)]
struct Block {
    node: usize,
    size: usize,
    postponed: usize,
}

impl MultifrontalLdl {
    /// Analyses the pattern; the first `primal` rows are primal, the others dual.
    ///
    /// # Errors
    /// [`FactorizationError::Analysis`] when memory or the index range does not suffice.
    pub(crate) fn new(
        pattern: &SymmetricPattern,
        primal: usize,
    ) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        let symbolic = Symbolic::new(pattern)?;
        let panel = |node: &Node| node.columns * padded(node.rows.len());
        let factor: usize = symbolic.nodes.iter().map(panel).sum();
        let square = |node: &Node| node.rows.len() * padded(node.rows.len());
        let largest = symbolic.nodes.iter().map(square).max().unwrap_or(0);
        let least_work = symbolic.nodes.iter();
        let least_work = least_work.map(|node| work(node.rows.len(), node.columns));
        let most_work = MOST_WORK.0 * least_work.sum::<f64>() + MOST_WORK.1;
        Ok(Self {
            primal,
            scale: vec![1.0; n],
            is_scaled: false,
            work: vec![0.0; n],
            diagonal: vec![0.0; n],
            entries: vec![0.0; symbolic.entries.len()],
            local: vec![0; n],
            product: Vec::new(),
            gathered: Vec::new(),
            stack: Stack {
                blocks: Vec::with_capacity(symbolic.stack()),
                ..Stack::default()
            },
            pivots: Vec::with_capacity(n),
            factors: Factors {
                values: Vec::with_capacity(factor + largest),
                rows: Vec::with_capacity(symbolic.rows.len()),
                fronts: Vec::with_capacity(symbolic.nodes.len()),
                inverse: Vec::with_capacity(n),
            },
            limits: Limits {
                most_work,
                until: Until::default(),
            },
            symbolic,
        })
    }

    /// Until when factorizations may work; one that does not end then has no factors.
    pub(crate) fn work_until(&mut self, until: Until) {
        self.limits.until = until;
    }

    /// Factorizes `P (K + D) P' = L B L'`, the matrix with the given values (order of the pattern) and shifts, both of them `>= 0`,
    ///
    /// ```text
    ///     K + D = [ W + delta_w I        A'      ]   primal rows
    ///             [       A        -(C + delta_c I)]   dual rows
    /// ```
    ///
    /// and returns the inertia of what was factorized. Allocates only where more pivots are postponed than ever before.
    ///
    /// # Errors
    /// [`FactorizationError`] when there are no factors to solve with.
    pub(crate) fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        self.take_values(values, delta_w, delta_c)?;
        pulp::Arch::new().dispatch(Eliminate(self));
        if self.limits.until.is_over() {
            return Err(FactorizationError::Stopped);
        }
        invert(&self.pivots, &mut self.factors.inverse);
        let mut inertia = inertia(&self.pivots).ok_or(FactorizationError::NotFinite)?;
        inertia.zero += self.scale.len() - self.pivots.len();
        Ok(inertia)
    }

    /// Solves with the factors of the last successful [`MultifrontalLdl::factor`], in place.
    pub(crate) fn solve(&mut self, right_hand_side: &mut [f64]) {
        let scaled = self.symbolic.permutation.iter().zip(&self.scale);
        for (x, (&old, scale)) in self.work.iter_mut().zip(scaled) {
            *x = right_hand_side[old as usize] * scale;
        }
        substitution::solve(&self.factors, &mut self.work, &mut self.gathered);
        let scaled = self.symbolic.permutation.iter().zip(&self.scale);
        for (x, (&old, scale)) in self.work.iter().zip(scaled) {
            right_hand_side[old as usize] = x * scale;
        }
    }

    /// Entries of the factor, a measure of fill.
    #[cfg(test)]
    pub(crate) fn factor_entries(&self) -> usize {
        let entries = |front: &FrontRecord| {
            let (pivots, rows) = (front.pivots as usize, front.rows as usize);
            pivots * rows - pivots * pivots.saturating_sub(1) / 2
        };
        self.factors.fronts.iter().map(entries).sum()
    }

    /// Brings the shifted values into the order of elimination and equilibrates them in the infinity norm (Ruiz 2001). The
    /// matrices of an interior point method mostly change little from one to the next, so that one sweep mends the scales
    /// of the last; but a large shift needs more, or rows beside it would look like zeros.
    fn take_values(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<(), FactorizationError> {
        // zero, and not a number from the first entry on that is not finite
        let mut fault = 0.0;
        let rows = self
            .symbolic
            .permutation
            .iter()
            .zip(&self.symbolic.diagonal);
        for (value, (&old, &position)) in self.diagonal.iter_mut().zip(rows) {
            let is_primal = (old as usize) < self.primal;
            *value = values[position as usize] + if is_primal { delta_w } else { -delta_c };
            fault += *value * 0.0;
        }
        for (value, entry) in self.entries.iter_mut().zip(&self.symbolic.entries) {
            *value = values[entry.position as usize];
            fault += *value * 0.0;
        }
        if fault != 0.0 {
            return Err(FactorizationError::NotFinite);
        }
        if !self.is_scaled {
            self.is_scaled = true;
            self.equilibrate();
        }
        for _ in 0..SWEEPS {
            if self.equilibrate() <= IMBALANCE {
                break;
            }
        }
        Ok(())
    }

    /// A sweep of equilibration: divides the scale of each row by the root of its largest entry. Returns by which factor
    /// the largest entry of a row was off one at most.
    fn equilibrate(&mut self) -> f64 {
        for ((largest, value), scale) in self.work.iter_mut().zip(&self.diagonal).zip(&self.scale) {
            *largest = (value * scale * scale).abs();
        }
        for (value, entry) in self.entries.iter().zip(&self.symbolic.entries) {
            let (row, column) = (entry.row as usize, entry.column as usize);
            let a = (value * self.scale[row] * self.scale[column]).abs();
            // entries are finite here; plain comparisons cost less than `f64::max`
            if a > self.work[row] {
                self.work[row] = a;
            }
            if a > self.work[column] {
                self.work[column] = a;
            }
        }
        let (mut least, mut greatest) = (1.0_f64, 1.0_f64);
        for (scale, &largest) in self.scale.iter_mut().zip(&self.work) {
            // a row of zeros says nothing, and a scale that overflowed may not stay
            *scale = if largest > 0.0 && largest.is_finite() {
                least = if largest < least { largest } else { least };
                greatest = if largest > greatest {
                    largest
                } else {
                    greatest
                };
                *scale / largest.sqrt()
            } else {
                1.0
            };
        }
        greatest.max(1.0 / least)
    }

    /// Builds the front of node `k` from its entries and its children: the square at the end of `factor`, its rows at the
    /// end of `factor_rows`. Returns the numbers of rows and of summed columns.
    #[inline(always)]
    fn assemble(&mut self, k: usize) -> (usize, usize) {
        let node = self.symbolic.nodes[k].clone();
        let first_child = self.stack.records.len() - node.children;
        let inherited: usize = self.stack.records[first_child..]
            .iter()
            .map(|block| block.postponed)
            .sum();
        let names = &self.symbolic.rows[node.rows.clone()];
        let summed = node.columns + inherited;
        let rows = names.len() + inherited;
        let stride = padded(rows);
        let start = self.factors.values.len();
        self.factors.values.resize(start + rows * stride, 0.0);
        if inherited == 0 {
            self.factors.rows.extend_from_slice(names);
            self.gather(&node, start, stride);
        } else {
            let (columns, below) = names.split_at(node.columns);
            self.factors.rows.extend_from_slice(columns);
            let postponed = self.stack.postponed.len() - inherited;
            self.factors
                .rows
                .extend_from_slice(&self.stack.postponed[postponed..]);
            self.factors.rows.extend_from_slice(below);
            self.gather_inherited(&node, start, rows);
        }
        // summed rows and columns are symmetric, so that pivoting can exchange them
        let square = &mut self.factors.values[start..];
        for column in 0..summed {
            for row in column + 1..summed {
                square[row * stride + column] = square[column * stride + row];
            }
        }
        (rows, summed)
    }

    /// Scaled entry on the diagonal of a permuted row.
    #[inline(always)]
    fn scaled_diagonal(&self, row: usize) -> f64 {
        self.diagonal[row] * self.scale[row] * self.scale[row]
    }

    /// Adds entries and children at the places known from the pattern.
    #[inline(always)]
    fn gather(&mut self, node: &Node, start: usize, stride: usize) {
        let first = self.symbolic.rows[node.rows.start] as usize;
        for column in 0..node.columns {
            self.factors.values[start + column * (stride + 1)] =
                self.scaled_diagonal(first + column);
        }
        let square = &mut self.factors.values[start..];
        let values = &self.entries[node.entries.clone()];
        let entries = &self.symbolic.entries[node.entries.clone()];
        for (value, entry) in values.iter().zip(entries) {
            square[entry.place as usize] =
                value * self.scale[entry.row as usize] * self.scale[entry.column as usize];
        }
        for _ in 0..node.children {
            let Some(block) = self.stack.records.pop() else {
                return;
            };
            let size = block.size;
            let first = self.symbolic.nodes[block.node].parent_places;
            let places = &self.symbolic.parent_places[first..first + size];
            let from = self.stack.blocks.len() - size * size;
            for (c, column) in self.stack.blocks[from..].chunks_exact(size).enumerate() {
                // places increase: everything from the diagonal down stays there
                let target = &mut square[places[c] as usize * stride..][..stride];
                for (a, &place) in column[c..].iter().zip(&places[c..]) {
                    target[place as usize] += a;
                }
            }
            self.stack.blocks.truncate(from);
        }
    }

    /// As [`MultifrontalLdl::gather`], for a front with postponed columns, whose places are looked up.
    #[inline(never)]
    fn gather_inherited(&mut self, node: &Node, start: usize, rows: usize) {
        let stride = padded(rows);
        let names = self.factors.rows.len() - rows;
        for (place, &row) in self.factors.rows[names..].iter().enumerate() {
            self.local[row as usize] = place as u32;
        }
        let first = self.symbolic.rows[node.rows.start] as usize;
        for column in 0..node.columns {
            self.factors.values[start + column * (stride + 1)] =
                self.scaled_diagonal(first + column);
        }
        let square = &mut self.factors.values[start..];
        let values = &self.entries[node.entries.clone()];
        let entries = &self.symbolic.entries[node.entries.clone()];
        for (value, entry) in values.iter().zip(entries) {
            let (row, column) = (entry.row as usize, entry.column as usize);
            let (i, j) = (self.local[row] as usize, self.local[column] as usize);
            square[j * stride + i] = value * self.scale[row] * self.scale[column];
        }
        for _ in 0..node.children {
            let Some(block) = self.stack.records.pop() else {
                return;
            };
            let size = block.size;
            let child = &self.symbolic.nodes[block.node];
            let below = &self.symbolic.rows[child.rows.clone()][child.columns..];
            let names = self.stack.postponed.len() - block.postponed;
            let name = |k: usize| match k.checked_sub(block.postponed) {
                None => self.stack.postponed[names + k],
                Some(k) => below[k],
            };
            let from = self.stack.blocks.len() - size * size;
            for (c, column) in self.stack.blocks[from..].chunks_exact(size).enumerate() {
                let j = self.local[name(c) as usize] as usize;
                for (r, a) in column.iter().enumerate().skip(c) {
                    let i = self.local[name(r) as usize] as usize;
                    square[i.min(j) * stride + i.max(j)] += a;
                }
            }
            self.stack.postponed.truncate(names);
            self.stack.blocks.truncate(from);
        }
    }

    /// Keeps the eliminated columns of the front and pushes the Schur complement.
    #[inline(always)]
    fn store(&mut self, k: usize, rows: usize, summed: usize, done: usize) {
        let stride = padded(rows);
        let start = self.factors.values.len() - rows * stride;
        self.factors.fronts.push(FrontRecord {
            pivots: done as u32,
            rows: rows as u32,
        });
        if !self.symbolic.nodes[k].is_root {
            let names = self.factors.rows.len() - rows;
            self.stack
                .postponed
                .extend_from_slice(&self.factors.rows[names + done..names + summed]);
            let columns = &self.factors.values[start + done * stride..];
            for column in columns.chunks_exact(stride) {
                self.stack.blocks.extend_from_slice(&column[done..rows]);
            }
            self.stack.records.push(Block {
                node: k,
                size: rows - done,
                postponed: summed - done,
            });
        }
        self.factors.values.truncate(start + done * stride);
    }

    /// Eliminates node after node, as long as the work stays within its limit.
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, simd: S) {
        self.stack.blocks.clear();
        self.stack.postponed.clear();
        self.stack.records.clear();
        self.pivots.clear();
        self.factors.values.clear();
        self.factors.rows.clear();
        self.factors.fronts.clear();
        let (mut done_work, mut looked_at) = (0.0, 0.0);
        for k in 0..self.symbolic.nodes.len() {
            let (rows, summed) = self.assemble(k);
            done_work += work(rows, summed);
            let mut is_over = done_work > self.limits.most_work;
            if done_work > looked_at + LOOK {
                looked_at = done_work;
                is_over |= self.limits.until.is_over();
            }
            if is_over {
                self.factors.rows.truncate(self.factors.rows.len() - rows);
                self.factors
                    .values
                    .truncate(self.factors.values.len() - rows * padded(rows));
                return;
            }
            let stride = padded(rows);
            let start = self.factors.values.len() - rows * stride;
            let names = self.factors.rows.len() - rows;
            let mut front = Front {
                simd,
                rows,
                stride,
                summed,
                square: &mut self.factors.values[start..],
                index: &mut self.factors.rows[names..],
                product: &mut self.product,
                until: &self.limits.until,
            };
            let done = front.factorize(self.symbolic.nodes[k].is_root, &mut self.pivots);
            self.store(k, rows, summed, done);
        }
    }
}

/// [`MultifrontalLdl::eliminate`], for the vectors of the machine.
struct Eliminate<'m>(&'m mut MultifrontalLdl);

impl pulp::WithSimd for Eliminate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.eliminate(simd);
    }
}

/// Multiplications for the elimination of `columns` of a front, as if all rows took part to the end.
fn work(rows: usize, columns: usize) -> f64 {
    rows as f64 * rows as f64 * columns as f64
}

/// Diagonal and coupling to the next row of `B^-1`.
fn invert(pivots: &[Pivot], inverse: &mut Vec<[f64; 2]>) {
    inverse.clear();
    let mut second = 0.0;
    inverse.extend(pivots.iter().map(|pivot| match *pivot {
        Pivot::One(d) => [1.0 / d, 0.0],
        Pivot::Two(a, b, c) => {
            let determinant = a * c - b * b;
            second = a / determinant;
            [c / determinant, -b / determinant]
        }
        Pivot::Second => [second, 0.0],
        Pivot::Zero => [0.0, 0.0],
    }));
}

/// Inertia of `B`; `None` if a pivot is not finite.
fn inertia(pivots: &[Pivot]) -> Option<Inertia> {
    let mut inertia = Inertia {
        positive: 0,
        negative: 0,
        zero: 0,
    };
    for pivot in pivots {
        match *pivot {
            Pivot::One(d) if !d.is_finite() => return None,
            Pivot::Two(a, b, c) if !(a.is_finite() && b.is_finite() && c.is_finite()) => {
                return None;
            }
            Pivot::One(d) if d > 0.0 => inertia.positive += 1,
            Pivot::One(_) => inertia.negative += 1,
            Pivot::Two(a, b, c) if a * c - b * b < 0.0 => {
                inertia.positive += 1;
                inertia.negative += 1;
            }
            Pivot::Two(a, _, c) if a + c > 0.0 => inertia.positive += 2,
            Pivot::Two(..) => inertia.negative += 2,
            Pivot::Second => {}
            Pivot::Zero => inertia.zero += 1,
        }
    }
    Some(inertia)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::until::Interrupt;

    #[test]
    fn factorization_that_is_asked_to_end_has_no_factors_and_does_little() {
        let flag = Arc::new(AtomicBool::new(true));
        // a dense front of some 1e8 multiplications, and many small ones
        let dense: Vec<_> = (0..700)
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .collect();
        let chain: Vec<_> = (0..700).flat_map(|i| [(i, i), (i, i.max(1) - 1)]).collect();
        for entries in [dense, chain] {
            let (pattern, map) = SymmetricPattern::new(700, &entries).unwrap();
            let mut values = vec![0.0; pattern.stored()];
            for (&position, (i, j)) in map.iter().zip(&entries) {
                values[position] = if i == j { 1e3 } else { 1.0 };
            }
            let mut factorization = MultifrontalLdl::new(&pattern, 700).unwrap();
            let interrupt = Interrupt::by(Arc::clone(&flag));
            flag.store(true, Ordering::Relaxed);
            factorization.work_until(Until::new(&interrupt, f64::INFINITY));
            let stopped = factorization.factor(&values, 0.0, 0.0);
            assert_eq!(stopped, Err(FactorizationError::Stopped));
            let is_dense = entries.len() > 10_000;
            assert!(!is_dense || factorization.pivots.len() < 100);
            // a limit on seconds that are over does the same
            flag.store(false, Ordering::Relaxed);
            factorization.work_until(Until::new(&interrupt, 0.0));
            let stopped = factorization.factor(&values, 0.0, 0.0);
            assert_eq!(stopped, Err(FactorizationError::Stopped));
            factorization.work_until(Until::new(&interrupt, f64::INFINITY));
            let whole = factorization.factor(&values, 0.0, 0.0).unwrap();
            assert_eq!(whole.positive, 700);
        }
    }

    #[test]
    fn factorization_beyond_its_limit_of_work_counts_the_rest_as_zero() {
        // A chain of six masses, tied together by five springs of no compliance.
        let n = 11;
        let entries: Vec<(usize, usize)> = (0..6)
            .map(|i| (i, i))
            .chain((0..5).flat_map(|k| [(6 + k, k), (6 + k, k + 1)]))
            .collect();
        let (pattern, map) = SymmetricPattern::new(n, &entries).unwrap();
        let mut values = vec![0.0; pattern.stored()];
        for (&position, a) in map
            .iter()
            .zip([2.0; 6].into_iter().chain([1.0, -1.0].repeat(5)))
        {
            values[position] += a;
        }
        let mut factorization = MultifrontalLdl::new(&pattern, 6).unwrap();
        let most_work = std::mem::replace(&mut factorization.limits.most_work, 20.0);
        let stopped = factorization.factor(&values, 0.0, 0.0).unwrap();
        assert!(stopped.zero > 0, "{stopped:?}");
        assert_eq!(stopped.positive + stopped.negative + stopped.zero, n);
        // What is there can be solved with, whatever it is worth.
        factorization.solve(&mut vec![1.0; n]);
        factorization.limits.most_work = most_work;
        let whole = factorization.factor(&values, 0.0, 0.0).unwrap();
        assert_eq!((whole.positive, whole.negative, whole.zero), (6, 5, 0));
    }
}
