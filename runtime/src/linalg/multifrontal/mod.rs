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
//! computed once; only fronts that inherit columns look places up.

mod assembly_tree;
mod front;
mod symbolic;

use front::{Front, Pivot};
use symbolic::{Node, Symbolic};

use super::{FactorizationError, Inertia, KktFactorization, SymmetricPattern};

/// Multifrontal factorization with pivoting, `S P' L B L' P S` for a matrix equilibrated by a diagonal `S`.
///
/// # Examples
/// The inertia of `[1 2; 2 0]`, one primal and one dual row, and a solve:
///
/// ```
/// use hangtime::linalg::{KktFactorization, MultifrontalLdl, SymmetricPattern};
///
/// let (pattern, map) = SymmetricPattern::new(2, &[(0, 0), (1, 0)]).ok_or("an entry outside")?;
/// let mut values = vec![0.0; pattern.stored()];
/// values[map[0]] = 1.0;
/// values[map[1]] = 2.0;
/// let mut factorization = MultifrontalLdl::new(&pattern, 1)?;
/// let inertia = factorization.factor(&values, 0.0, 0.0)?;
/// assert_eq!((inertia.positive, inertia.negative, inertia.zero), (1, 1, 0));
/// let mut x = [5.0, 2.0];
/// factorization.solve(&mut x);
/// assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct MultifrontalLdl {
    primal: usize,
    symbolic: Symbolic,
    /// Equilibration of permuted rows, kept from one matrix to the next; whether there is one, and a work array.
    scale: Vec<f64>,
    is_scaled: bool,
    work: Vec<f64>,
    /// Shifted values in the order of the entries.
    entries: Vec<f64>,
    /// Permuted row to row of the current front, for fronts that inherit columns.
    local: Vec<u32>,
    // front in work: what is below its panel, and arrays of its rows
    rest: Vec<f64>,
    index: Vec<u32>,
    product: Vec<f64>,
    gathered: Vec<f64>,
    // stack of Schur complements: full square blocks, the names of their postponed columns, and one record for each
    blocks: Vec<f64>,
    postponed: Vec<u32>,
    records: Vec<Block>,
    // factors: panels with what is above their diagonals, and the names of their rows
    pivots: Vec<Pivot>,
    factor: Vec<f64>,
    factor_rows: Vec<u32>,
    fronts: Vec<FrontRecord>,
}

/// A Schur complement on the stack: its postponed columns, then the rows below its node.
#[derive(Debug, Clone, Copy)]
struct Block {
    node: usize,
    size: usize,
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
        let symbolic = Symbolic::new(pattern)?;
        let panel = |node: &Node| node.columns * node.rows.len();
        let factor = symbolic.nodes.iter().map(panel).sum();
        let largest = symbolic.nodes.iter().map(|node| node.rows.len()).max();
        let largest = largest.unwrap_or(0);
        let below = |node: &Node| node.rows.len() - node.columns;
        let rest = symbolic.nodes.iter().map(below).max().unwrap_or(0).pow(2);
        Ok(Self {
            primal,
            scale: vec![1.0; n],
            is_scaled: false,
            work: vec![0.0; n],
            entries: vec![0.0; pattern.stored()],
            local: vec![0; n],
            rest: Vec::with_capacity(rest),
            index: Vec::with_capacity(largest),
            product: Vec::new(),
            gathered: Vec::with_capacity(largest),
            blocks: Vec::with_capacity(symbolic.stack()),
            postponed: Vec::new(),
            records: Vec::new(),
            pivots: Vec::with_capacity(n),
            factor: Vec::with_capacity(factor),
            factor_rows: Vec::with_capacity(symbolic.rows.len()),
            fronts: Vec::with_capacity(symbolic.nodes.len()),
            symbolic,
        })
    }

    /// Brings the shifted values into the order of the entries.
    fn take_values(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<(), FactorizationError> {
        let mut is_finite = true;
        for (value, entry) in self.entries.iter_mut().zip(&self.symbolic.entries) {
            *value = values[entry.position as usize];
            is_finite &= value.is_finite();
        }
        for (row, &entry) in self.symbolic.diagonal.iter().enumerate() {
            self.entries[entry as usize] += if row < self.primal { delta_w } else { -delta_c };
        }
        if is_finite && delta_w.is_finite() && delta_c.is_finite() {
            return Ok(());
        }
        let entry = self.entries.iter().position(|a| !a.is_finite());
        let row = entry.map_or(0, |k| self.symbolic.entries[k].row as usize);
        Err(FactorizationError::NotFinite(
            self.symbolic.permutation[row] as usize,
        ))
    }

    /// Symmetric equilibration in the infinity norm (Ruiz 2001), two sweeps for the first matrix. Those of an interior
    /// point method change little from one to the next, so that one sweep mends the scales of the last.
    fn equilibrate(&mut self) {
        let sweeps = if self.is_scaled { 1 } else { 2 };
        self.is_scaled = true;
        for _ in 0..sweeps {
            self.work.fill(0.0);
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
            for (scale, largest) in self.scale.iter_mut().zip(&self.work) {
                // a row of zeros says nothing, and a scale that overflowed may not stay
                *scale = if *largest > 0.0 && largest.is_finite() {
                    *scale / largest.sqrt()
                } else {
                    1.0
                };
            }
        }
    }

    /// Builds the front of node `k` from its entries and its children: the panel at the end of `factor`, its rows at the
    /// end of `factor_rows`. Returns the numbers of rows and of summed columns.
    fn assemble(&mut self, k: usize) -> (usize, usize) {
        let node = self.symbolic.nodes[k].clone();
        let first_child = self.records.len() - node.children;
        let inherited: usize = self.records[first_child..]
            .iter()
            .map(|block| block.postponed)
            .sum();
        let names = &self.symbolic.rows[node.rows.clone()];
        let summed = node.columns + inherited;
        let rows = names.len() + inherited;
        let length = rows - summed;
        let start = self.factor.len();
        self.factor.resize(start + rows * summed, 0.0);
        self.rest.clear();
        self.rest.resize(length * length, 0.0);
        self.index.clear();
        self.index.extend_from_slice(&names[..node.columns]);
        self.index
            .extend_from_slice(&self.postponed[self.postponed.len() - inherited..]);
        self.index.extend_from_slice(&names[node.columns..]);
        if inherited == 0 {
            self.gather(&node, start, rows);
        } else {
            self.gather_inherited(&node, start, rows, summed);
        }
        // the panel is symmetric in its summed rows, so that pivoting can exchange them
        let panel = &mut self.factor[start..];
        for column in 0..summed {
            for row in column + 1..summed {
                panel[row * rows + column] = panel[column * rows + row];
            }
        }
        (rows, summed)
    }

    /// Adds entries and children at the places known from the pattern.
    fn gather(&mut self, node: &Node, start: usize, rows: usize) {
        let (summed, length) = (node.columns, rows - node.columns);
        let panel = &mut self.factor[start..];
        let values = &self.entries[node.entries.clone()];
        for (value, entry) in values
            .iter()
            .zip(&self.symbolic.entries[node.entries.clone()])
        {
            panel[entry.place as usize] =
                value * self.scale[entry.row as usize] * self.scale[entry.column as usize];
        }
        for _ in 0..node.children {
            let Some(block) = self.records.pop() else {
                return;
            };
            let size = block.size;
            let first = self.symbolic.nodes[block.node].parent_places;
            let places = &self.symbolic.parent_places[first..first + size];
            let from = self.blocks.len() - size * size;
            for (c, column) in self.blocks[from..].chunks_exact(size).enumerate() {
                let j = places[c] as usize;
                // places increase: everything from the diagonal down stays there
                let target = if j < summed {
                    &mut panel[j * rows..(j + 1) * rows]
                } else {
                    &mut self.rest[(j - summed) * length..(j - summed + 1) * length]
                };
                let offset = if j < summed { 0 } else { summed };
                for (a, &place) in column[c..].iter().zip(&places[c..]) {
                    target[place as usize - offset] += a;
                }
            }
            self.blocks.truncate(from);
        }
    }

    /// As [`MultifrontalLdl::gather`], for a front with postponed columns, whose places are looked up.
    fn gather_inherited(&mut self, node: &Node, start: usize, rows: usize, summed: usize) {
        let length = rows - summed;
        for (place, &row) in self.index.iter().enumerate() {
            self.local[row as usize] = place as u32;
        }
        let panel = &mut self.factor[start..];
        let values = &self.entries[node.entries.clone()];
        for (value, entry) in values
            .iter()
            .zip(&self.symbolic.entries[node.entries.clone()])
        {
            let (row, column) = (entry.row as usize, entry.column as usize);
            let (i, j) = (self.local[row] as usize, self.local[column] as usize);
            panel[j * rows + i] = value * self.scale[row] * self.scale[column];
        }
        for _ in 0..node.children {
            let Some(block) = self.records.pop() else {
                return;
            };
            let size = block.size;
            let child = &self.symbolic.nodes[block.node];
            let below = &self.symbolic.rows[child.rows.clone()][child.columns..];
            let names = self.postponed.len() - block.postponed;
            let name = |k: usize| match k.checked_sub(block.postponed) {
                None => self.postponed[names + k],
                Some(k) => below[k],
            };
            let from = self.blocks.len() - size * size;
            for (c, column) in self.blocks[from..].chunks_exact(size).enumerate() {
                let j = self.local[name(c) as usize] as usize;
                for (r, a) in column.iter().enumerate().skip(c) {
                    let i = self.local[name(r) as usize] as usize;
                    let (low, high) = (i.min(j), i.max(j));
                    if low < summed {
                        panel[low * rows + high] += a;
                    } else {
                        self.rest[(low - summed) * length + high - summed] += a;
                    }
                }
            }
            self.postponed.truncate(names);
            self.blocks.truncate(from);
        }
    }

    /// Keeps the eliminated columns of the front and pushes the Schur complement.
    fn store(&mut self, k: usize, rows: usize, summed: usize, done: usize) {
        let start = self.factor.len() - rows * summed;
        self.fronts.push(FrontRecord { pivots: done, rows });
        self.factor_rows.extend_from_slice(&self.index);
        if !self.symbolic.nodes[k].is_root {
            let (size, postponed, length) = (rows - done, summed - done, rows - summed);
            self.postponed.extend_from_slice(&self.index[done..summed]);
            for column in self.factor[start..].chunks_exact(rows).skip(done) {
                self.blocks.extend_from_slice(&column[done..]);
            }
            if postponed == 0 {
                self.blocks.extend_from_slice(&self.rest);
            } else {
                for column in 0..length {
                    self.blocks.extend(std::iter::repeat_n(0.0, postponed));
                    self.blocks
                        .extend_from_slice(&self.rest[column * length..(column + 1) * length]);
                }
            }
            self.records.push(Block {
                node: k,
                size,
                postponed,
            });
        }
        self.factor.truncate(start + rows * done);
    }
}

impl KktFactorization for MultifrontalLdl {
    fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        self.take_values(values, delta_w, delta_c)?;
        self.equilibrate();
        self.blocks.clear();
        self.postponed.clear();
        self.records.clear();
        self.pivots.clear();
        self.factor.clear();
        self.factor_rows.clear();
        self.fronts.clear();
        for k in 0..self.symbolic.nodes.len() {
            let (rows, summed) = self.assemble(k);
            let start = self.factor.len() - rows * summed;
            let mut front = Front {
                rows,
                summed,
                panel: &mut self.factor[start..],
                rest: &mut self.rest,
                index: &mut self.index,
                product: &mut self.product,
            };
            let done = front.factorize(self.symbolic.nodes[k].is_root, &mut self.pivots);
            self.store(k, rows, summed, done);
        }
        inertia(&self.pivots).ok_or(FactorizationError::NotFinite(
            self.scale.len().saturating_sub(1),
        ))
    }

    fn solve(&mut self, right_hand_side: &mut [f64]) {
        for ((x, &old), scale) in self
            .work
            .iter_mut()
            .zip(&self.symbolic.permutation)
            .zip(&self.scale)
        {
            *x = right_hand_side[old as usize] * scale;
        }
        let x = &mut self.work;
        let w = &mut self.gathered;
        let (mut entry, mut name, mut pivot) = (0, 0, 0);
        for front in &self.fronts {
            let names = &self.factor_rows[name..name + front.rows];
            let panel = &self.factor[entry..entry + front.rows * front.pivots];
            w.clear();
            w.extend(names.iter().map(|&name| x[name as usize]));
            for (k, column) in panel.chunks_exact(front.rows).enumerate() {
                let w_k = w[k];
                for (w, l) in w[k + 1..].iter_mut().zip(&column[k + 1..]) {
                    *w -= l * w_k;
                }
            }
            let pivots = &self.pivots[pivot..pivot + front.pivots];
            divide(pivots, &mut w[..front.pivots]);
            for (&name, w) in names.iter().zip(&*w) {
                x[name as usize] = *w;
            }
            entry += panel.len();
            name += front.rows;
            pivot += front.pivots;
        }
        for front in self.fronts.iter().rev() {
            name -= front.rows;
            entry -= front.rows * front.pivots;
            let names = &self.factor_rows[name..name + front.rows];
            let panel = &self.factor[entry..entry + front.rows * front.pivots];
            w.clear();
            w.extend(names.iter().map(|&name| x[name as usize]));
            for (k, column) in panel.chunks_exact(front.rows).enumerate().rev() {
                w[k] -= dot(&column[k + 1..], &w[k + 1..]);
            }
            for (&name, w) in names.iter().zip(&w[..front.pivots]) {
                x[name as usize] = *w;
            }
        }
        for ((x, &old), scale) in self
            .work
            .iter()
            .zip(&self.symbolic.permutation)
            .zip(&self.scale)
        {
            right_hand_side[old as usize] = x * scale;
        }
    }

    fn factor_entries(&self) -> usize {
        let entries = |front: &FrontRecord| {
            front.pivots * front.rows - front.pivots * (front.pivots.saturating_sub(1)) / 2
        };
        self.fronts.iter().map(entries).sum()
    }
}

/// `B^-1 w`.
fn divide(pivots: &[Pivot], w: &mut [f64]) {
    for (k, pivot) in pivots.iter().enumerate() {
        match *pivot {
            Pivot::One(d) => w[k] /= d,
            Pivot::Zero => w[k] = 0.0,
            Pivot::Second => {}
            Pivot::Two(a, b, c) => {
                let (u, v) = (w[k], w[k + 1]);
                let determinant = a * c - b * b;
                w[k] = (c * u - b * v) / determinant;
                w[k + 1] = (a * v - b * u) / determinant;
            }
        }
    }
}

/// Scalar product in four lanes.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_fours, a_others) = a.as_chunks::<4>();
    let (b_fours, b_others) = b.as_chunks::<4>();
    let mut lanes = [0.0; 4];
    for (a, b) in a_fours.iter().zip(b_fours) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    let others: f64 = a_others.iter().zip(b_others).map(|(a, b)| a * b).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + others
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
