//! Partial factorization of one dense front.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};

use pulp::Simd;

use crate::until::Until;

use super::kernels::{largest, multiply, subtract, subtract_four, subtract_two, transform_two};

/// A pivot block of `B`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pivot {
    /// A 1x1 block.
    One(f64),
    /// First row of a 2x2 block: `[a, b; b, c]`.
    Two(f64, f64, f64),
    /// Second row of a 2x2 block.
    Second,
    /// A vanishing pivot: its component of a solution is set to zero.
    Zero,
}

/// Pivot threshold: a pivot may not enlarge entries by more than its inverse.
pub(crate) const THRESHOLD: f64 = 1e-6;

/// Columns whose entries are all below this, in a matrix scaled to entries of size one, are zero.
const ZERO: f64 = 1e-13;

/// Multiplications after which a factorization looks whether it may go on, about a millisecond.
pub(crate) const LOOK: f64 = 1e6;

/// A dense symmetric front whose first `summed` columns may be eliminated.
///
/// `square` holds all columns, padded to `stride` entries, a multiple of four. The summed columns hold all rows, so that
/// pivoting can exchange them, but rows already eliminated are zero in the columns after; the others hold their lower
/// triangle below the summed rows, and nothing of meaning above.
pub(crate) struct Front<'m, S> {
    pub(crate) simd: S,
    pub(crate) rows: usize,
    pub(crate) stride: usize,
    pub(crate) summed: usize,
    pub(crate) square: &'m mut [f64],
    /// Names of the rows; reordered with them.
    pub(crate) index: &'m mut [u32],
    /// Work array.
    pub(crate) product: &'m mut Vec<f64>,
    pub(crate) until: &'m Until,
}

impl<S: Simd> Front<'_, S> {
    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> f64 {
        self.square[column * self.stride + row]
    }

    /// Largest entry of a summed column below the `done` eliminated rows.
    #[inline(always)]
    fn largest(&self, column: usize, done: usize) -> f64 {
        // eliminated rows and padding are zero
        let entries = &self.square[column * self.stride..(column + 1) * self.stride];
        largest(self.simd, &entries[done & !3..])
    }

    /// As [`Front::largest`], outside the rows `a` and `b`.
    #[inline(never)]
    fn largest_outside(&self, column: usize, [a, b]: [usize; 2], done: usize) -> f64 {
        let entries = &self.square[column * self.stride..(column + 1) * self.stride];
        let outside = |&(row, _): &(usize, &f64)| row != a && row != b;
        let rows = entries.iter().enumerate().skip(done).filter(outside);
        rows.fold(0.0, |m: f64, (_, a)| if a.abs() > m { a.abs() } else { m })
    }

    /// Largest entry of a column in the summed rows below the `done` eliminated ones, its diagonal left out, with its row.
    #[inline(always)]
    fn largest_summed(&self, column: usize, done: usize) -> (f64, usize) {
        let entries = &self.square[column * self.stride..column * self.stride + self.summed];
        let (mut summed, mut position) = (0.0, done);
        for (row, a) in entries.iter().enumerate().skip(done) {
            if row != column && a.abs() > summed {
                summed = a.abs();
                position = row;
            }
        }
        (summed, position)
    }

    /// Exchanges summed rows and columns `a` and `b`.
    #[inline(always)]
    fn swap(&mut self, a: usize, b: usize) {
        if a == b {
            return;
        }
        let (a, b) = (a.min(b), a.max(b));
        let stride = self.stride;
        let (head, tail) = self.square.split_at_mut(b * stride);
        head[a * stride..(a + 1) * stride].swap_with_slice(&mut tail[..stride]);
        for column in self.square[..self.summed * stride].chunks_exact_mut(stride) {
            column.swap(a, b);
        }
        self.index.swap(a, b);
    }

    /// Eliminates as many summed columns as threshold pivoting allows and returns their number; with
    /// `is_root` all of them. Pivots are appended to `pivots`.
    ///
    /// Afterwards the eliminated columns hold `L` below the diagonal blocks, and the others the Schur complement.
    #[inline(always)]
    pub(crate) fn factorize(&mut self, is_root: bool, pivots: &mut Vec<Pivot>) -> usize {
        let first_pivot = pivots.len();
        let mut done = 0;
        // columns tried since the last success; success makes the others worth another try
        let mut tried = 0;
        let mut looked_at = 0;
        while done < self.summed {
            if (done - looked_at) as f64 * self.square.len() as f64 > LOOK {
                looked_at = done;
                if self.until.is_over() {
                    return done;
                }
            }
            if tried >= self.summed - done {
                if !is_root {
                    break;
                }
                self.take_any(done, pivots);
                done = pivots.len() - first_pivot;
                tried = 0;
                continue;
            }
            let column = done + tried;
            let diagonal = self.at(column, column).abs();
            // where the diagonal is the largest entry, the others do not matter
            let all = self.largest(column, done);
            if all <= ZERO {
                if is_root {
                    self.swap(done, column);
                    self.eliminate_zero(done);
                    pivots.push(Pivot::Zero);
                    done += 1;
                    tried = 0;
                } else {
                    tried += 1;
                }
                continue;
            }
            let mut partner = None;
            let mut takes_one = diagonal >= 0.1 * all;
            if !takes_one {
                let (summed, position) = self.largest_summed(column, done);
                // a weak 1x1 pivot is good enough where no pair grows entries less
                let admissible = diagonal > ZERO && diagonal >= THRESHOLD * all;
                let limit = if admissible {
                    (all / diagonal).min(1.0 / THRESHOLD)
                } else {
                    1.0 / THRESHOLD
                };
                if summed > ZERO && self.is_good_pair((column, position), done, all, limit) {
                    partner = Some(position);
                }
                takes_one = admissible && partner.is_none();
            }
            if takes_one {
                self.swap(done, column);
                pivots.push(self.eliminate_one(done));
                done += 1;
                tried = 0;
            } else if let Some(partner) = partner {
                self.eliminate_pair(done, (column, partner), pivots);
                done += 2;
                tried = 0;
            } else {
                tried += 1;
            }
        }
        self.update_rest(done, &pivots[first_pivot..]);
        done
    }

    /// Whether the 2x2 pivot (`k`, `r`) grows entries by less than `limit`: the larger row sum of
    /// `|P^-1| (max_k, max_r)'`, where the maxima leave the pair out; `k_largest` is that of the whole column `k`.
    #[inline(always)]
    fn is_good_pair(
        &self,
        (k, r): (usize, usize),
        done: usize,
        k_largest: f64,
        limit: f64,
    ) -> bool {
        let (a, b, c) = (self.at(k, k), self.at(r, k), self.at(r, r));
        let size = a.abs().max(b.abs()).max(c.abs());
        let determinant = (a * c - b * b).abs();
        // a determinant lost in cancellation says nothing
        if determinant <= 1e-10 * size * size {
            return false;
        }
        let is_below_limit = |k_max: f64, r_max: f64| {
            let bound = limit * determinant;
            c.abs() * k_max + b.abs() * r_max < bound && b.abs() * k_max + a.abs() * r_max < bound
        };
        // the maxima of whole columns are quicker found, and mostly enough
        is_below_limit(k_largest, self.largest(r, done))
            || is_below_limit(
                self.largest_outside(k, [k, r], done),
                self.largest_outside(r, [k, r], done),
            )
    }

    /// Brings the pair to the rows `done` and `done + 1` and eliminates it.
    #[inline(always)]
    fn eliminate_pair(
        &mut self,
        done: usize,
        (column, partner): (usize, usize),
        pivots: &mut Vec<Pivot>,
    ) {
        self.swap(done, column);
        let partner = if partner == done { column } else { partner };
        self.swap(done + 1, partner);
        pivots.push(self.eliminate_two(done));
        pivots.push(Pivot::Second);
    }

    /// At a root nothing can be postponed: the pivot with the largest diagonal or pair among what is left.
    #[inline(never)]
    fn take_any(&mut self, done: usize, pivots: &mut Vec<Pivot>) {
        let mut best = (0.0, done, done);
        for column in done..self.summed {
            let (summed, partner) = self.largest_summed(column, done);
            if summed > best.0 {
                best = (summed, column, partner);
            }
            let diagonal = self.at(column, column).abs();
            if diagonal > best.0 {
                best = (diagonal, column, column);
            }
        }
        let (size, column, partner) = best;
        if size <= ZERO {
            self.eliminate_zero(done);
            pivots.push(Pivot::Zero);
        } else if column == partner {
            self.swap(done, column);
            pivots.push(self.eliminate_one(done));
        } else {
            self.eliminate_pair(done, (column, partner), pivots);
        }
    }

    fn eliminate_zero(&mut self, p: usize) {
        for row in p..self.rows {
            self.square[p * self.stride + row] = 0.0;
        }
        for column in p..self.summed {
            self.square[column * self.stride + p] = 0.0;
        }
    }

    #[inline(always)]
    fn eliminate_one(&mut self, p: usize) -> Pivot {
        let stride = self.stride;
        let d = self.at(p, p);
        let inverse = 1.0 / d;
        let (head, tail) = self.square[..self.summed * stride].split_at_mut((p + 1) * stride);
        // whole blocks: what is above the next row does not matter
        let first = (p + 1) & !3;
        let pivot_column = &mut head[p * stride + first..];
        for column in tail.chunks_exact_mut(stride) {
            let factor = column[p] * inverse;
            if factor != 0.0 {
                subtract(self.simd, &mut column[first..], factor, pivot_column);
            }
            column[p] = 0.0;
        }
        multiply(self.simd, pivot_column, inverse);
        Pivot::One(d)
    }

    #[inline(always)]
    fn eliminate_two(&mut self, p: usize) -> Pivot {
        let stride = self.stride;
        let (a, b, c) = (self.at(p, p), self.at(p + 1, p), self.at(p + 1, p + 1));
        let determinant = a * c - b * b;
        // the inverse of the block is [i, j; j, k]
        let (i, j, k) = (c / determinant, -b / determinant, a / determinant);
        let (head, tail) = self.square[..self.summed * stride].split_at_mut((p + 2) * stride);
        let (first, second) = head[p * stride..].split_at_mut(stride);
        let start = (p + 2) & !3;
        for column in tail.chunks_exact_mut(stride) {
            let (u, v) = (column[p], column[p + 1]);
            let f = [i * u + j * v, j * u + k * v];
            if f != [0.0, 0.0] {
                let (l, m) = (&first[start..], &second[start..]);
                subtract_two(self.simd, &mut column[start..], f, l, m);
            }
            column[p] = 0.0;
            column[p + 1] = 0.0;
        }
        let (l, m) = (&mut first[start..], &mut second[start..]);
        transform_two(self.simd, l, m, [i, j, k]);
        // the coupling belongs to the block, not to L
        first[p + 1] = 0.0;
        Pivot::Two(a, b, c)
    }

    /// Subtracts `L B L'` from the columns that are not summed.
    #[inline(always)]
    fn update_rest(&mut self, done: usize, pivots: &[Pivot]) {
        let (stride, summed) = (self.stride, self.summed);
        let length = self.rows - summed;
        if done == 0 || length == 0 {
            return;
        }
        self.scale_rows(done, pivots);
        let (panel, rest) = self.square.split_at_mut(summed * stride);
        if done >= 8 && length >= 32 {
            let l = &panel[summed..];
            let l = MatRef::from_column_major_slice_with_stride(l, length, done, stride);
            let product = MatRef::from_column_major_slice(&*self.product, done, length);
            let rest = &mut rest[summed..];
            let rest =
                MatMut::from_column_major_slice_with_stride_mut(rest, length, length, stride);
            matmul(
                rest,
                BlockStructure::TriangularLower,
                Accum::Add,
                l,
                BlockStructure::Rectangular,
                product,
                BlockStructure::Rectangular,
                -1.0,
                Par::Seq,
            );
            return;
        }
        for (j, (target, factors)) in rest
            .chunks_exact_mut(stride)
            .zip(self.product.chunks_exact(done))
            .enumerate()
        {
            let start = (summed + j) & !3;
            let target = &mut target[start..];
            let column = |k: usize| &panel[k * stride + start..(k + 1) * stride];
            // four columns at a time quarter the traffic of the target
            let (fours, others) = factors.as_chunks::<4>();
            for (block, factors) in fours.iter().enumerate() {
                let columns = [0, 1, 2, 3].map(|k| column(4 * block + k));
                subtract_four(self.simd, target, factors, columns);
            }
            let k = 4 * fours.len();
            match *others {
                [f, g, h] => {
                    subtract_two(self.simd, target, [f, g], column(k), column(k + 1));
                    subtract(self.simd, target, h, column(k + 2));
                }
                [f, g] => subtract_two(self.simd, target, [f, g], column(k), column(k + 1)),
                [f] => subtract(self.simd, target, f, column(k)),
                _ => {}
            }
        }
    }

    /// `B L'` of the rows below into `product`, column-major with `done` rows.
    #[inline(always)]
    fn scale_rows(&mut self, done: usize, pivots: &[Pivot]) {
        let (rows, stride, summed) = (self.rows, self.stride, self.summed);
        self.product.clear();
        self.product.resize(done * (rows - summed), 0.0);
        for (k, pivot) in pivots.iter().enumerate() {
            let row = |k: usize| &self.square[k * stride + summed..k * stride + rows];
            match *pivot {
                Pivot::One(d) => {
                    for (products, l) in self.product.chunks_exact_mut(done).zip(row(k)) {
                        products[k] = d * l;
                    }
                }
                Pivot::Two(a, b, c) => {
                    let both = row(k).iter().zip(row(k + 1));
                    for (products, (l, m)) in self.product.chunks_exact_mut(done).zip(both) {
                        products[k] = a * l + b * m;
                        products[k + 1] = b * l + c * m;
                    }
                }
                Pivot::Second | Pivot::Zero => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Factorizes the front with these columns; returns the number of pivots, the pivots and the columns afterwards.
    fn factorize(
        columns: &[&[f64]],
        summed: usize,
        is_root: bool,
    ) -> (usize, Vec<Pivot>, Vec<Vec<f64>>) {
        let rows = columns.len();
        let stride = rows.next_multiple_of(4);
        let mut square = vec![0.0; rows * stride];
        for (target, column) in square.chunks_exact_mut(stride).zip(columns) {
            target[..rows].copy_from_slice(column);
        }
        let mut index: Vec<u32> = (0..rows as u32).collect();
        let (mut product, mut pivots) = (Vec::new(), Vec::new());
        let mut front = Front {
            simd: pulp::Scalar,
            rows,
            stride,
            summed,
            square: &mut square,
            index: &mut index,
            product: &mut product,
            until: &Until::default(),
        };
        let done = front.factorize(is_root, &mut pivots);
        let columns = square.chunks_exact(stride).map(|c| c[..rows].to_vec());
        (done, pivots, columns.collect())
    }

    #[test]
    fn factorize_positive_diagonal_gives_the_schur_complement() {
        // [4 2; 2 3] with one summed column: L = 1/2, complement 3 - 1 = 2
        let (done, pivots, columns) = factorize(&[&[4.0, 2.0], &[2.0, 3.0]], 1, false);
        assert_eq!(done, 1);
        assert_eq!(pivots, [Pivot::One(4.0)]);
        assert_eq!(columns[0][1], 0.5);
        assert_eq!(columns[1][1], 2.0);
    }

    #[test]
    fn factorize_zero_diagonal_takes_a_pair() {
        // [0 1; 1 0] needs a 2x2 pivot
        let (done, pivots, _) = factorize(&[&[0.0, 1.0], &[1.0, 0.0]], 2, true);
        assert_eq!(done, 2);
        assert_eq!(pivots, [Pivot::Two(0.0, 1.0, 0.0), Pivot::Second]);
    }

    #[test]
    fn factorize_column_coupled_only_to_unsummed_rows_is_postponed() {
        // the summed column has a zero diagonal and its partner is not summed yet
        let (done, pivots, _) = factorize(&[&[0.0, 1.0], &[1.0, 0.0]], 1, false);
        assert_eq!(done, 0);
        assert!(pivots.is_empty());
    }

    #[test]
    fn factorize_singular_root_counts_zero_pivots() {
        // [1 1; 1 1]
        let (_, pivots, _) = factorize(&[&[1.0, 1.0], &[1.0, 1.0]], 2, true);
        assert_eq!(pivots, [Pivot::One(1.0), Pivot::Zero]);
    }

    #[test]
    fn factorize_any_split_of_the_rows_multiplies_back_to_the_matrix() {
        // seven rows, three of them with a zero diagonal: 1x1 and 2x2 pivots across the blocks of four
        let n = 7;
        let entry = |i: usize, j: usize| {
            let (a, b) = (i.min(j) as f64, i.max(j) as f64);
            if i == j && i % 2 == 1 {
                0.0
            } else {
                (1.0 + a + 2.3 * b * b).sin() + if i == j { 1.5 } else { 0.0 }
            }
        };
        let full: Vec<Vec<f64>> = (0..n)
            .map(|j| (0..n).map(|i| entry(i, j)).collect())
            .collect();
        let columns: Vec<&[f64]> = full.iter().map(|c| &c[..]).collect();
        for summed in 1..=n {
            let (done, pivots, factors) = factorize(&columns, summed, summed == n);
            // the Schur complement is what elimination in any order leaves: compare the quadratic form of the rest,
            // min over the eliminated part, by solving A11 y = A12 with a dense factorization
            if done < summed || done == n {
                continue;
            }
            let a = DMatrix::from_fn(done, done, entry).lu();
            assert_eq!(pivots.len(), done);
            for (j, column) in factors.iter().enumerate().skip(done) {
                let y = a
                    .solve(&DVector::from_fn(done, |i, _| entry(i, j)))
                    .unwrap();
                for (i, found) in column.iter().enumerate().take(n).skip(j) {
                    let product: f64 = (0..done).map(|k| entry(i, k) * y[k]).sum();
                    let expected = entry(i, j) - product;
                    assert!(
                        (found - expected).abs() < 1e-10,
                        "{summed}: {i}, {j}: {found} instead of {expected}"
                    );
                }
            }
        }
    }
}
