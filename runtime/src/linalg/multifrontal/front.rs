//! Partial factorization of one dense front.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};

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

/// A dense symmetric front whose first `summed` columns may be eliminated.
///
/// `panel` holds all rows of those columns (column-major, leading dimension `rows`), `rest` the lower
/// triangle of the other columns as full columns of length `rows - summed`.
pub(crate) struct Front<'m> {
    pub(crate) rows: usize,
    pub(crate) summed: usize,
    pub(crate) panel: &'m mut [f64],
    pub(crate) rest: &'m mut [f64],
    /// Names of the rows; reordered with them.
    pub(crate) index: &'m mut [u32],
    /// Work array.
    pub(crate) product: &'m mut Vec<f64>,
}

impl Front<'_> {
    fn at(&self, row: usize, column: usize) -> f64 {
        self.panel[column * self.rows + row]
    }

    /// Largest entry of a column below the `done` eliminated rows, its diagonal left out.
    fn largest_off_diagonal(&self, column: usize, done: usize) -> f64 {
        let entries = &self.panel[column * self.rows..(column + 1) * self.rows];
        largest(&entries[done..column]).max(largest(&entries[column + 1..]))
    }

    /// As [`Front::largest_off_diagonal`], over the summed rows only, with its row.
    fn largest_summed(&self, column: usize, done: usize) -> (f64, usize) {
        let entries = &self.panel[column * self.rows..(column + 1) * self.rows];
        let (mut summed, mut position) = (0.0, done);
        for (row, a) in entries.iter().enumerate().take(self.summed).skip(done) {
            if row != column && a.abs() > summed {
                summed = a.abs();
                position = row;
            }
        }
        (summed, position)
    }

    /// Largest entry of column `k` below the `done` eliminated rows outside the rows `k` and `r`.
    fn largest_outside(&self, k: usize, r: usize, done: usize) -> f64 {
        let entries = &self.panel[k * self.rows..(k + 1) * self.rows];
        let (a, b) = (k.min(r), k.max(r));
        largest(&entries[done..a])
            .max(largest(&entries[a + 1..b]))
            .max(largest(&entries[b + 1..]))
    }

    /// Exchanges summed rows and columns `a` and `b`.
    fn swap(&mut self, a: usize, b: usize) {
        if a == b {
            return;
        }
        let rows = self.rows;
        for row in 0..rows {
            self.panel.swap(a * rows + row, b * rows + row);
        }
        for column in 0..self.summed {
            self.panel.swap(column * rows + a, column * rows + b);
        }
        self.index.swap(a, b);
    }

    /// Eliminates as many summed columns as threshold pivoting allows and returns their number; with
    /// `is_root` all of them. Pivots are appended to `pivots`.
    ///
    /// Afterwards the eliminated columns hold `L` below the diagonal blocks, and the other summed columns and
    /// `rest` the Schur complement.
    pub(crate) fn factorize(&mut self, is_root: bool, pivots: &mut Vec<Pivot>) -> usize {
        let first_pivot = pivots.len();
        let mut done = 0;
        // columns tried since the last success; success makes the others worth another try
        let mut tried = 0;
        while done < self.summed {
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
            let all = self.largest_off_diagonal(column, done);
            if all.max(diagonal) <= ZERO {
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
            if diagonal >= 0.1 * all {
                self.swap(done, column);
                pivots.push(self.eliminate_one(done));
                done += 1;
                tried = 0;
                continue;
            }
            let (summed, partner) = self.largest_summed(column, done);
            let admissible = diagonal > ZERO && diagonal >= THRESHOLD * all;
            if admissible && !self.prefers_pair(column, partner, done, (all, summed)) {
                self.swap(done, column);
                pivots.push(self.eliminate_one(done));
                done += 1;
                tried = 0;
                continue;
            }
            if summed > ZERO && self.is_good_pair(column, partner, done) {
                self.swap(done, column);
                let partner = if partner == done { column } else { partner };
                self.swap(done + 1, partner);
                let pivot = self.eliminate_two(done);
                pivots.push(pivot);
                pivots.push(Pivot::Second);
                done += 2;
                tried = 0;
                continue;
            }
            tried += 1;
        }
        self.update_rest(done, &pivots[first_pivot..]);
        done
    }

    /// Growth factors of the 2x2 pivot (`k`, `r`): the larger row sum of
    /// `|P^-1| (max_k, max_r)'`.
    fn pair_growth(&self, k: usize, r: usize, done: usize) -> f64 {
        let (a, b, c) = (self.at(k, k), self.at(r, k), self.at(r, r));
        let determinant = (a * c - b * b).abs();
        let k_max = self.largest_outside(k, r, done);
        let r_max = self.largest_outside(r, k, done);
        if determinant == 0.0 {
            return f64::INFINITY;
        }
        ((c.abs() * k_max + b.abs() * r_max) / determinant)
            .max((b.abs() * k_max + a.abs() * r_max) / determinant)
    }

    fn is_good_pair(&self, k: usize, r: usize, done: usize) -> bool {
        let (a, b, c) = (self.at(k, k), self.at(r, k), self.at(r, r));
        let size = a.abs().max(b.abs()).max(c.abs());
        let determinant = (a * c - b * b).abs();
        // a determinant lost in cancellation says nothing
        determinant > 1e-10 * size * size && self.pair_growth(k, r, done) <= 1.0 / THRESHOLD
    }

    /// Whether the pair grows entries less than the weak 1x1 pivot `k` would.
    fn prefers_pair(&self, k: usize, r: usize, done: usize, (all, summed): (f64, f64)) -> bool {
        if summed <= ZERO || !self.is_good_pair(k, r, done) {
            return false;
        }
        self.pair_growth(k, r, done) < all / self.at(k, k).abs()
    }

    /// At a root nothing can be postponed: the pivot with the largest diagonal or pair among what is left.
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
            self.swap(done, column);
            let partner = if partner == done { column } else { partner };
            self.swap(done + 1, partner);
            pivots.push(self.eliminate_two(done));
            pivots.push(Pivot::Second);
        }
    }

    fn eliminate_zero(&mut self, p: usize) {
        for row in p..self.rows {
            self.panel[p * self.rows + row] = 0.0;
        }
        for column in p..self.summed {
            self.panel[column * self.rows + p] = 0.0;
        }
    }

    fn eliminate_one(&mut self, p: usize) -> Pivot {
        let rows = self.rows;
        let d = self.at(p, p);
        let inverse = 1.0 / d;
        let (head, tail) = self.panel.split_at_mut((p + 1) * rows);
        let pivot_column = &mut head[p * rows..];
        for column in tail[..(self.summed - p - 1) * rows].chunks_exact_mut(rows) {
            let factor = column[p] * inverse;
            if factor != 0.0 {
                for (c, l) in column[p + 1..].iter_mut().zip(&pivot_column[p + 1..]) {
                    *c -= factor * l;
                }
            }
        }
        for l in &mut pivot_column[p + 1..] {
            *l *= inverse;
        }
        Pivot::One(d)
    }

    fn eliminate_two(&mut self, p: usize) -> Pivot {
        let rows = self.rows;
        let (a, b, c) = (self.at(p, p), self.at(p + 1, p), self.at(p + 1, p + 1));
        let determinant = a * c - b * b;
        // the inverse of the block is [i, j; j, k]
        let (i, j, k) = (c / determinant, -b / determinant, a / determinant);
        let (head, tail) = self.panel.split_at_mut((p + 2) * rows);
        let (first, second) = head[p * rows..].split_at_mut(rows);
        for column in tail[..(self.summed - p - 2) * rows].chunks_exact_mut(rows) {
            let (u, v) = (column[p], column[p + 1]);
            let (f, g) = (i * u + j * v, j * u + k * v);
            if f != 0.0 || g != 0.0 {
                for ((x, l), m) in column[p + 2..]
                    .iter_mut()
                    .zip(&first[p + 2..])
                    .zip(&second[p + 2..])
                {
                    *x -= f * l + g * m;
                }
            }
        }
        for (l, m) in first[p + 2..].iter_mut().zip(&mut second[p + 2..]) {
            let (u, v) = (*l, *m);
            *l = i * u + j * v;
            *m = j * u + k * v;
        }
        // the coupling belongs to the block, not to L
        first[p + 1] = 0.0;
        Pivot::Two(a, b, c)
    }

    /// `rest <- rest - L B L'`.
    fn update_rest(&mut self, done: usize, pivots: &[Pivot]) {
        let (rows, summed) = (self.rows, self.summed);
        let length = rows - summed;
        if done == 0 || length == 0 {
            return;
        }
        self.scale_rows(done, pivots);
        if done >= 8 && length >= 32 {
            let l = &self.panel[summed..];
            let l = MatRef::from_column_major_slice_with_stride(l, length, done, rows);
            let product = MatRef::from_column_major_slice(&*self.product, done, length);
            let rest = MatMut::from_column_major_slice_mut(&mut *self.rest, length, length);
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
        for (j, (target, factors)) in self
            .rest
            .chunks_exact_mut(length)
            .zip(self.product.chunks_exact(done))
            .enumerate()
        {
            let target = &mut target[j..];
            let row = summed + j;
            let column = |k: usize| &self.panel[k * rows + row..(k + 1) * rows];
            // four columns at a time quarter the traffic of the target
            let (fours, others) = factors.as_chunks::<4>();
            for (block, factors) in fours.iter().enumerate() {
                let columns = [0, 1, 2, 3].map(|k| column(4 * block + k));
                subtract_four(target, factors, columns);
            }
            for (k, f) in others.iter().enumerate() {
                for (t, l) in target.iter_mut().zip(column(4 * fours.len() + k)) {
                    *t -= f * l;
                }
            }
        }
    }

    /// `B L'` of the rows below into `product`, column-major with `done` rows.
    fn scale_rows(&mut self, done: usize, pivots: &[Pivot]) {
        let (rows, summed) = (self.rows, self.summed);
        self.product.clear();
        self.product.resize(done * (rows - summed), 0.0);
        for (k, pivot) in pivots.iter().enumerate() {
            let row = |k: usize| &self.panel[k * rows + summed..(k + 1) * rows];
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

/// Largest absolute entry, in four lanes.
fn largest(entries: &[f64]) -> f64 {
    let (fours, others) = entries.as_chunks::<4>();
    let mut lanes = [0.0_f64; 4];
    for four in fours {
        for (lane, a) in lanes.iter_mut().zip(four) {
            // a plain comparison costs less than `f64::max`
            if a.abs() > *lane {
                *lane = a.abs();
            }
        }
    }
    lanes
        .iter()
        .chain(others)
        .fold(0.0, |m: f64, a| if a.abs() > m { a.abs() } else { m })
}

fn subtract_four(target: &mut [f64], f: &[f64; 4], l: [&[f64]; 4]) {
    let [a, b, c, d] = l;
    for ((((t, a), b), c), d) in target.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *t -= (f[0] * a + f[1] * b) + (f[2] * c + f[3] * d);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn front<'m>(
        rows: usize,
        summed: usize,
        panel: &'m mut [f64],
        rest: &'m mut [f64],
        index: &'m mut [u32],
    ) -> Front<'m> {
        Front {
            rows,
            summed,
            panel,
            rest,
            index,
            product: Box::leak(Box::default()),
        }
    }

    #[test]
    fn factorize_positive_diagonal_gives_the_schur_complement() {
        // [4 2; 2 3] with one summed column: L = 1/2, complement 3 - 1 = 2
        let mut panel = [4.0, 2.0];
        let mut rest = [3.0];
        let mut index = [0, 1];
        let mut pivots = Vec::new();
        let done = front(2, 1, &mut panel, &mut rest, &mut index).factorize(false, &mut pivots);
        assert_eq!(done, 1);
        assert_eq!(pivots, [Pivot::One(4.0)]);
        assert_eq!(panel, [4.0, 0.5]);
        assert_eq!(rest, [2.0]);
    }

    #[test]
    fn factorize_zero_diagonal_takes_a_pair() {
        // [0 1; 1 0] needs a 2x2 pivot
        let mut panel = [0.0, 1.0, 1.0, 0.0];
        let mut index = [0, 1];
        let mut pivots = Vec::new();
        let done = front(2, 2, &mut panel, &mut [], &mut index).factorize(true, &mut pivots);
        assert_eq!(done, 2);
        assert_eq!(pivots, [Pivot::Two(0.0, 1.0, 0.0), Pivot::Second]);
    }

    #[test]
    fn factorize_column_coupled_only_to_unsummed_rows_is_postponed() {
        // the summed column has a zero diagonal and its partner is not summed yet
        let mut panel = [0.0, 1.0];
        let mut rest = [0.0];
        let mut index = [0, 1];
        let mut pivots = Vec::new();
        let done = front(2, 1, &mut panel, &mut rest, &mut index).factorize(false, &mut pivots);
        assert_eq!(done, 0);
        assert!(pivots.is_empty());
    }

    #[test]
    fn factorize_singular_root_counts_zero_pivots() {
        // [1 1; 1 1]
        let mut panel = [1.0, 1.0, 1.0, 1.0];
        let mut index = [0, 1];
        let mut pivots = Vec::new();
        front(2, 2, &mut panel, &mut [], &mut index).factorize(true, &mut pivots);
        assert_eq!(pivots, [Pivot::One(1.0), Pivot::Zero]);
    }
}
