//! Multifrontal `L B L'` with threshold pivoting.
//!
//! The matrix is eliminated along its assembly tree (Duff and Reid 1983): each supernode gathers its
//! entries and the Schur complements of its children in a dense front, eliminates what threshold pivoting
//! with 1x1 and 2x2 blocks allows, and passes the rest on; columns without a good pivot are postponed to
//! the parent. The inertia is that of `B` and hence, up to rounding, that of the matrix; no shifts are
//! needed. Matrices are equilibrated before.

mod front;
mod symbolic;

use front::{Front, Pivot};
use symbolic::Symbolic;

use super::{FactorizationError, Inertia, KktFactorization, SymmetricPattern};

/// Multifrontal factorization with pivoting; see the module documentation.
pub struct MultifrontalLdl {
    primal: usize,
    symbolic: Symbolic,
    /// Positions of the diagonal in the pattern.
    diagonal: Vec<usize>,
    /// Equilibration of permuted rows, and its work array.
    scale: Vec<f64>,
    work: Vec<f64>,
    /// Permuted row to row of the current front.
    local: Vec<usize>,
    shifted: Vec<f64>,
    // front in work
    panel: Vec<f64>,
    rest: Vec<f64>,
    index: Vec<usize>,
    product: Vec<f64>,
    // stack of Schur complements: full square blocks, their row names, and one record for each
    blocks: Vec<f64>,
    block_rows: Vec<usize>,
    records: Vec<Block>,
    // factors
    pivots: Vec<Pivot>,
    factor: Vec<f64>,
    factor_rows: Vec<usize>,
    fronts: Vec<FrontRecord>,
}

/// A Schur complement on the stack.
#[derive(Debug, Clone, Copy)]
struct Block {
    size: usize,
    /// Its first rows are postponed columns.
    postponed: usize,
}

/// A front of the factor.
#[derive(Debug, Clone, Copy)]
struct FrontRecord {
    pivots: usize,
    rows: usize,
}

impl MultifrontalLdl {
    /// Analyses the pattern; the first `primal` rows are primal, the others dual.
    ///
    /// # Errors
    /// [`FactorizationError::Analysis`] when memory or the index range does not suffice.
    pub fn new(pattern: &SymmetricPattern, primal: usize) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        Ok(Self {
            primal,
            symbolic: Symbolic::new(pattern)?,
            diagonal: (0..n).map(|j| pattern.diagonal(j)).collect(),
            scale: vec![1.0; n],
            work: vec![0.0; n],
            local: vec![0; n],
            shifted: vec![0.0; pattern.stored()],
            panel: Vec::new(),
            rest: Vec::new(),
            index: Vec::new(),
            product: Vec::new(),
            blocks: Vec::new(),
            block_rows: Vec::new(),
            records: Vec::new(),
            pivots: Vec::with_capacity(n),
            factor: Vec::new(),
            factor_rows: Vec::new(),
            fronts: Vec::new(),
        })
    }

    /// Two sweeps of symmetric equilibration in the infinity norm.
    fn equilibrate(&mut self) {
        self.scale.fill(1.0);
        for _ in 0..2 {
            self.work.fill(0.0);
            for entry in &self.symbolic.entries {
                let (row, column) = (entry.row as usize, entry.column as usize);
                let a =
                    (self.shifted[entry.position as usize] * self.scale[row] * self.scale[column])
                        .abs();
                // entries are finite here; plain comparisons cost less than `f64::max`
                if a > self.work[row] {
                    self.work[row] = a;
                }
                if a > self.work[column] {
                    self.work[column] = a;
                }
            }
            for (scale, largest) in self.scale.iter_mut().zip(&self.work) {
                if *largest > 0.0 {
                    *scale /= largest.sqrt();
                }
            }
        }
    }

    /// Builds the front of node `k` from its entries and its children.
    fn assemble(&mut self, k: usize) -> (usize, usize) {
        let node = &self.symbolic.nodes[k];
        let columns = node.end - node.first;
        let first_child = self.records.len() - node.children;
        let children = &self.records[first_child..];
        let child_rows: usize = children.iter().map(|block| block.size).sum();
        let child_entries: usize = children.iter().map(|block| block.size * block.size).sum();
        let rows_start = self.block_rows.len() - child_rows;
        let entries_start = self.blocks.len() - child_entries;

        self.index.clear();
        self.index.extend(node.first..node.end);
        let mut start = rows_start;
        for block in children {
            self.index
                .extend_from_slice(&self.block_rows[start..start + block.postponed]);
            start += block.size;
        }
        let summed = self.index.len();
        self.index.extend_from_slice(&node.rows);
        let rows = self.index.len();
        for (place, &row) in self.index.iter().enumerate() {
            self.local[row] = place;
        }
        let length = rows - summed;
        self.panel.clear();
        self.panel.resize(rows * summed, 0.0);
        self.rest.clear();
        self.rest.resize(length * length, 0.0);

        let entry_range =
            self.symbolic.entry_starts[node.first]..self.symbolic.entry_starts[node.end];
        for entry in &self.symbolic.entries[entry_range] {
            let (row, column) = (entry.row as usize, entry.column as usize);
            let a = self.shifted[entry.position as usize] * self.scale[row] * self.scale[column];
            let (i, j) = (self.local[row], self.local[column]);
            self.panel[j * rows + i] += a;
            if i != j && i < columns {
                self.panel[i * rows + j] += a;
            }
        }

        let (mut start, mut entry) = (rows_start, entries_start);
        for block in children {
            let names = &self.block_rows[start..start + block.size];
            for (c, &column_name) in names.iter().enumerate() {
                let j = self.local[column_name];
                let column = &self.blocks[entry + c * block.size..entry + (c + 1) * block.size];
                for (r, &row_name) in names.iter().enumerate().skip(c) {
                    let i = self.local[row_name];
                    let a = column[r];
                    let (low, high) = (i.min(j), i.max(j));
                    if low < summed {
                        self.panel[low * rows + high] += a;
                        if high < summed && high != low {
                            self.panel[high * rows + low] += a;
                        }
                    } else {
                        self.rest[(low - summed) * length + high - summed] += a;
                    }
                }
            }
            start += block.size;
            entry += block.size * block.size;
        }
        self.block_rows.truncate(rows_start);
        self.blocks.truncate(entries_start);
        self.records.truncate(first_child);
        (rows, summed)
    }

    /// Stores the eliminated columns and pushes the Schur complement.
    fn store(&mut self, rows: usize, summed: usize, done: usize, is_root: bool) {
        self.fronts.push(FrontRecord { pivots: done, rows });
        self.factor_rows.extend_from_slice(&self.index);
        for column in 0..done {
            self.factor
                .extend_from_slice(&self.panel[column * rows + column + 1..(column + 1) * rows]);
        }
        if is_root {
            return;
        }
        let size = rows - done;
        let postponed = summed - done;
        let length = rows - summed;
        self.block_rows.extend_from_slice(&self.index[done..]);
        for column in done..summed {
            self.blocks
                .extend_from_slice(&self.panel[column * rows + done..(column + 1) * rows]);
        }
        for column in 0..length {
            self.blocks.extend(std::iter::repeat_n(0.0, postponed));
            self.blocks
                .extend_from_slice(&self.rest[column * length..(column + 1) * length]);
        }
        self.records.push(Block { size, postponed });
    }
}

impl KktFactorization for MultifrontalLdl {
    fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        let n = self.diagonal.len();
        self.shifted.copy_from_slice(values);
        for (row, &position) in self.diagonal.iter().enumerate() {
            self.shifted[position] += if row < self.primal { delta_w } else { -delta_c };
        }
        if let Some(position) = self.shifted.iter().position(|a| !a.is_finite()) {
            let row = self
                .symbolic
                .entries
                .iter()
                .find(|entry| entry.position as usize == position)
                .map_or(0, |entry| self.symbolic.permutation[entry.row as usize]);
            return Err(FactorizationError::NotFinite(row));
        }
        self.equilibrate();
        self.blocks.clear();
        self.block_rows.clear();
        self.records.clear();
        self.pivots.clear();
        self.factor.clear();
        self.factor_rows.clear();
        self.fronts.clear();
        for k in 0..self.symbolic.nodes.len() {
            let (rows, summed) = self.assemble(k);
            let is_root = self.symbolic.nodes[k].is_root;
            let mut front = Front {
                rows,
                summed,
                panel: &mut self.panel,
                rest: &mut self.rest,
                index: &mut self.index,
                product: &mut self.product,
            };
            let done = front.factorize(is_root, &mut self.pivots);
            self.store(rows, summed, done, is_root);
        }
        let mut inertia = Inertia {
            positive: 0,
            negative: 0,
            zero: 0,
        };
        for pivot in &self.pivots {
            match *pivot {
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
        if self.pivots.iter().any(|pivot| match pivot {
            Pivot::One(d) => !d.is_finite(),
            Pivot::Two(a, b, c) => !(a.is_finite() && b.is_finite() && c.is_finite()),
            Pivot::Second | Pivot::Zero => false,
        }) {
            return Err(FactorizationError::NotFinite(n.saturating_sub(1)));
        }
        Ok(inertia)
    }

    fn solve(&mut self, right_hand_side: &mut [f64]) {
        for (new, &old) in self.symbolic.permutation.iter().enumerate() {
            self.work[new] = right_hand_side[old] * self.scale[new];
        }
        let x = &mut self.work;
        let (mut entry, mut row_start) = (0, 0);
        for front in &self.fronts {
            let names = &self.factor_rows[row_start..row_start + front.rows];
            for column in 0..front.pivots {
                let length = front.rows - column - 1;
                let x_k = x[names[column]];
                if x_k != 0.0 {
                    let l = &self.factor[entry..entry + length];
                    for (&name, l) in names[column + 1..].iter().zip(l) {
                        x[name] -= l * x_k;
                    }
                }
                entry += length;
            }
            row_start += front.rows;
        }
        let mut pivot = self.pivots.len();
        for front in self.fronts.iter().rev() {
            row_start -= front.rows;
            let names = &self.factor_rows[row_start..row_start + front.rows];
            for column in (0..front.pivots).rev() {
                pivot -= 1;
                match self.pivots[pivot] {
                    Pivot::One(d) => x[names[column]] /= d,
                    Pivot::Zero => x[names[column]] = 0.0,
                    Pivot::Second => {}
                    Pivot::Two(a, b, c) => {
                        let (u, v) = (x[names[column]], x[names[column + 1]]);
                        let determinant = a * c - b * b;
                        x[names[column]] = (c * u - b * v) / determinant;
                        x[names[column + 1]] = (a * v - b * u) / determinant;
                    }
                }
            }
        }
        row_start = self.factor_rows.len();
        for front in self.fronts.iter().rev() {
            row_start -= front.rows;
            let names = &self.factor_rows[row_start..row_start + front.rows];
            for column in (0..front.pivots).rev() {
                let length = front.rows - column - 1;
                entry -= length;
                let l = &self.factor[entry..entry + length];
                let sum: f64 = names[column + 1..]
                    .iter()
                    .zip(l)
                    .map(|(&name, l)| l * x[name])
                    .sum();
                x[names[column]] -= sum;
            }
        }
        for (new, &old) in self.symbolic.permutation.iter().enumerate() {
            right_hand_side[old] = self.work[new] * self.scale[new];
        }
    }

    fn factor_entries(&self) -> usize {
        self.factor.len() + self.pivots.len()
    }
}
