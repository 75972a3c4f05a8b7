//! Vectors that solve a linear system `K(x) y = b(x)` whose coefficients are formulas, and what is
//! needed to differentiate them without inverting `K` symbolically.
//!
//! With the residual `F(x, y) = K y - b` and multipliers `mu = K^-T lambda`,
//!
//! ```text
//! dy/dx = A = -K^-1 F_x          d2(lambda' y)/dx2 = -(mu' F)_xx - P' A - A' P          P = d(K' mu)/dx
//! ```
//!
//! because `F` is linear in `y`.

use super::explicit::{Sparse, hessian, jacobian};
use super::joint_row::Row;
use super::ldl::Factorization;
use super::stepwise;
use crate::graph::{self, Sweeps, Sym, Variable};
use crate::tape;
use std::collections::BTreeSet;

/// Largest number of coordinates for which elimination is written out; above, loops over dense matrices
/// are faster, and much shorter to compile.
pub(crate) const WRITTEN_OUT: usize = 8;

/// Largest mass matrix that is factorized by formulas: some n^3/3 operations, which pivoting and loops
/// would about double.
const FORMULAS: usize = 16;

/// Largest system with joints whose factors are looked at: those of links in a chain are mostly zeros, some 100 operations a link.
const MOST_SPARSE: usize = 250;

/// A linear system with everything that its solution's derivatives need. In its formulas,
/// `Multiplier(i)` stands for `mu[i]` and `Unknown(size + i)` for `y[i]`.
pub(crate) struct Implicit {
    pub(crate) size: usize,
    /// `K`, row-major.
    pub(crate) matrix: Vec<Sym>,
    /// `b`.
    pub(crate) right: Vec<Sym>,
    /// `y` as formulas, where those are cheaper than elimination at run time.
    pub(crate) solution: Option<Vec<Sym>>,
    /// `F_x`.
    pub(crate) residual_jacobian: Sparse,
    /// `(mu' F)_xx`, lower triangle.
    pub(crate) residual_hessian: Sparse,
    /// `P`.
    pub(crate) cross: Sparse,
}

impl Implicit {
    /// `residual` is `F` in the unknowns of [`Self::unknown`]; `transposed` is `K' mu`.
    pub(crate) fn new(
        matrix: Vec<Sym>,
        right: Vec<Sym>,
        residual: &[Sym],
        transposed: &[Sym],
        (inputs, in_steps): (&[Variable], bool),
    ) -> Self {
        let (jacobian, hessian) = derivatives(in_steps);
        Self {
            size: right.len(),
            matrix,
            right,
            solution: None,
            residual_jacobian: jacobian(residual, inputs),
            residual_hessian: hessian(residual, inputs),
            cross: jacobian(transposed, inputs),
        }
    }

    /// Component `i` of the solution of a system of this size.
    pub(crate) fn unknown(size: usize, i: usize) -> Sym {
        Sym::variable(Variable::Unknown((size + i) as u16))
    }

    /// Multiplier of row `i`.
    pub(crate) fn multiplier(i: usize) -> Sym {
        Sym::variable(Variable::Multiplier(i as u16))
    }

    /// Positions at which `dy/dx` may be nonzero, for the first `rows` components.
    pub(crate) fn jacobian_pattern(&self, rows: usize) -> Vec<(usize, usize)> {
        let blocks = blocks(&self.matrix, self.size);
        let touched: BTreeSet<(usize, usize)> = self
            .residual_jacobian
            .entries
            .iter()
            .map(|&(row, column)| (blocks[row], column))
            .collect();
        let mut entries = Vec::new();
        for (row, block) in blocks.iter().enumerate().take(rows) {
            for column in 0..self.residual_jacobian.columns {
                if touched.contains(&(*block, column)) {
                    entries.push((row, column));
                }
            }
        }
        entries
    }

    /// Positions (lower triangle) at which the Hessian of a weighted sum of the solution may be nonzero.
    pub(crate) fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        let mut entries: BTreeSet<(usize, usize)> =
            self.residual_hessian.entries.iter().copied().collect();
        let sensitivity = self.jacobian_pattern(self.size);
        for &(k, i) in &self.cross.entries {
            for &(row, j) in &sensitivity {
                if row == k {
                    entries.insert((i.max(j), i.min(j)));
                }
            }
        }
        entries.into_iter().collect()
    }
}

/// How Jacobians and Hessians are derived.
type Derivatives = (
    fn(&[Sym], &[Variable]) -> Sparse,
    fn(&[Sym], &[Variable]) -> Sparse,
);

/// Jacobians and Hessians, of evaluations in steps or of formulas.
pub(super) fn derivatives(in_steps: bool) -> Derivatives {
    if in_steps {
        (stepwise::jacobian, stepwise::hessian)
    } else {
        (jacobian, hessian)
    }
}

/// Number of the connected block of a square matrix that each row belongs to.
pub(super) fn blocks(matrix: &[Sym], n: usize) -> Vec<usize> {
    let mut blocks: Vec<usize> = (0..n).collect();
    // The smallest number is passed on along the nonzeros, until nothing changes.
    let mut changed = true;
    while changed {
        changed = false;
        let entries = matrix.iter().enumerate();
        for (k, _) in entries.filter(|(_, entry)| !entry.is_structural_zero()) {
            let (i, j) = (k / n, k % n);
            let least = blocks[i].min(blocks[j]);
            changed |= blocks[i] != blocks[j];
            (blocks[i], blocks[j]) = (least, least);
        }
    }
    blocks
}

/// The motion without contact: `M a = r`. The residual is built from the momenta along the motion,
/// which takes far fewer operations than the entries of `M` if those are many. Coordinates from `moving` on are held.
///
/// Joints add their equations and, with the other sign, their forces among the unknowns.
pub(super) fn motion(
    inertia: &Locked<'_>,
    right: Vec<Sym>,
    factorization: Option<&Factorization>,
    (applied, moving): (&[Sym], usize),
    inputs: &[Variable],
) -> Implicit {
    let (mass, n) = (inertia.mass, right.len());
    let size = inertia.size();
    let rates = inertia.rates(stepwise::along_unknowns(size, moving));
    let residual: Vec<Sym> = rates
        .iter()
        .zip(applied)
        .map(|(&rate, &force)| rate - force)
        .collect();
    let transposed = inertia.rates(|variable| match variable {
        Variable::Velocity(i) => Implicit::multiplier(usize::from(i)),
        _ => Sym::ZERO,
    });
    // From the entries of the mass matrix instead, where that is shorter.
    let times = |unknown: &dyn Fn(usize) -> Sym| product(mass, n, unknown);
    let (mut residual, mut transposed) = (residual, transposed);
    if !inertia.in_steps {
        let by_entries = times(&|j| Implicit::unknown(size, j)).into_iter();
        let by_entries = by_entries.zip(&right);
        let by_entries = by_entries.map(|(inertial, &right)| inertial - right);
        residual = shorter(residual, by_entries.collect());
        transposed = shorter(transposed, times(&Implicit::multiplier));
    }
    let right = inertia.right(&right);
    inertia.add_joints(&mut residual, &|i| Implicit::unknown(size, i));
    for (residual, right) in residual[n..].iter_mut().zip(&right[n..]) {
        *residual -= *right;
    }
    inertia.add_joints(&mut transposed, &Implicit::multiplier);
    let solution = factorization.map(|factorization| factorization.solve(&right));
    let how = (inputs, inertia.in_steps);
    let mut motion = Implicit::new(inertia.matrix(), right, &residual, &transposed, how);
    motion.solution = solution;
    motion
}

/// The product of a square matrix with a vector, by its entries.
fn product(matrix: &[Sym], n: usize, vector: impl Fn(usize) -> Sym) -> Vec<Sym> {
    let rows = matrix.chunks(n);
    rows.map(|row| (0..n).map(|j| row[j] * vector(j)).sum())
        .collect()
}

/// Whether the product of the mass matrix with a vector takes fewer operations by its entries than by the momenta.
pub(super) fn is_simpler_than(mass: &[Sym], momenta: &[Sym]) -> bool {
    let by_entries = product(mass, momenta.len(), Implicit::multiplier);
    let by_momenta = graph::directional(momenta, |variable| match variable {
        Variable::Velocity(i) => Implicit::multiplier(usize::from(i)),
        _ => Sym::ZERO,
    });
    tape::operations(&by_entries) < tape::operations(&by_momenta)
}

fn shorter(one: Vec<Sym>, other: Vec<Sym>) -> Vec<Sym> {
    if tape::operations(&other) < tape::operations(&one) {
        other
    } else {
        one
    }
}

/// The mass matrix with the rows and columns of held coordinates replaced by those of the identity, bordered by the
/// equations of joints.
#[derive(Clone, Copy)]
pub(super) struct Locked<'a> {
    /// Mass matrix, row-major.
    pub(super) mass: &'a [Sym],
    /// Momenta, whose derivatives along velocities multiply by the mass matrix.
    pub(super) momenta: &'a [Sym],
    /// Whether its entries multiply a vector in fewer operations than those.
    pub(super) by_entries: bool,
    /// Whether the momenta are evaluated in steps, and all that is derived of them.
    pub(super) in_steps: bool,
    /// The coordinates that its rows belong to, increasing.
    pub(super) coordinates: &'a [usize],
    /// Rows that are held.
    pub(super) held: &'a [usize],
    /// Joints, whose equations border it.
    pub(super) joints: &'a [Row],
}

impl Locked<'_> {
    /// Number of coordinates.
    fn coordinates(&self) -> usize {
        self.momenta.len()
    }

    /// Number of coordinates and of equations of joints.
    pub(super) fn size(&self) -> usize {
        self.coordinates() + self.joints.len()
    }

    fn is_held(&self, i: usize) -> bool {
        self.held.contains(&i)
    }

    fn entry(&self, i: usize, j: usize) -> Sym {
        let n = self.coordinates();
        match (i.min(j), i.max(j)) {
            (_, last) if last < n => {}
            (first, last) if first < n => return self.joints[last - n].entry(first, self.held),
            (first, last) if first == last => return self.joints[last - n].own(self.held),
            _ => return Sym::ZERO,
        }
        match (self.is_held(i) || self.is_held(j), i == j) {
            (false, _) => self.mass[i * n + j],
            (true, true) => Sym::ONE,
            (true, false) => Sym::ZERO,
        }
    }

    /// Rates of the momenta where each variable moves by `direction`.
    fn rates(&self, direction: impl Fn(Variable) -> Sym) -> Vec<Sym> {
        let sweeps = match self.in_steps {
            true => graph::stepwise::sweeps(self.momenta),
            false => Sweeps::over(self.momenta),
        };
        sweeps.directional(direction)
    }

    /// Product with a vector, by the momenta if that takes fewer operations.
    pub(super) fn times(&self, of: impl Fn(usize) -> Sym) -> Vec<Sym> {
        if self.by_entries {
            let n = self.coordinates();
            let mut rows = Vec::with_capacity(self.size());
            rows.extend((0..n).map(|i| (0..n).map(|j| self.entry(i, j) * of(j)).sum::<Sym>()));
            self.add_joints(&mut rows, &of);
            return rows;
        }
        let row = |i: u16| self.coordinates.binary_search(&usize::from(i)).ok();
        let mut rows = self.rates(|variable| match variable {
            Variable::Velocity(i) => match row(i) {
                Some(row) if !self.is_held(row) => of(row),
                _ => Sym::ZERO,
            },
            _ => Sym::ZERO,
        });
        for &i in self.held {
            rows[i] = of(i);
        }
        self.add_joints(&mut rows, &of);
        rows
    }

    /// Adds what joints add to a product with a vector, in the rows of the coordinates and in their own behind those.
    fn add_joints(&self, rows: &mut Vec<Sym>, of: &dyn Fn(usize) -> Sym) {
        let n = self.coordinates();
        for (k, joint) in self.joints.iter().enumerate() {
            let mut own = joint.own(self.held) * of(n + k);
            for (i, row) in rows[..n].iter_mut().enumerate() {
                let entry = joint.entry(i, self.held);
                *row += entry * of(n + k);
                own += entry * of(i);
            }
            rows.push(own);
        }
    }

    /// Generalized forces, followed by the right-hand sides of the joints.
    pub(super) fn right(&self, forces: &[Sym]) -> Vec<Sym> {
        let joints = self.joints.iter().map(Row::right);
        forces.iter().copied().chain(joints).collect()
    }

    /// Its factors, with every intermediate result as one quantity.
    ///
    /// # Errors
    /// The coordinate whose pivot is structurally zero.
    pub(super) fn factorized(&self) -> Result<Factorization, usize> {
        let (matrix, order) = (self.matrix(), self.size());
        if self.joints.is_empty() {
            Factorization::stepwise(&matrix, order)
        } else {
            Factorization::saddle(&matrix, order)
        }
    }

    /// The factors of the matrix, where they take fewer operations than loops over a full matrix.
    ///
    /// # Errors
    /// The coordinate whose pivot is structurally zero.
    pub(super) fn cheaply_factorized(&self) -> Result<Option<Factorization>, usize> {
        let small = self.size() <= FORMULAS;
        let sparse = match self.joints {
            [] => self.largest_block() <= WRITTEN_OUT,
            _ => self.size() <= MOST_SPARSE,
        };
        let factors = (small || sparse).then(|| self.factorized()).transpose()?;
        Ok(factors.filter(|factors| small || factors.is_sparse()))
    }

    /// Most coordinates that inertia couples to each other, as those of one body of many.
    fn largest_block(&self) -> usize {
        let n = self.coordinates();
        let blocks = blocks(self.mass, n);
        let size = |block| blocks.iter().filter(|own| **own == block).count();
        (0..n).map(size).max().unwrap_or(0)
    }

    /// Row-major.
    pub(super) fn matrix(&self) -> Vec<Sym> {
        let n = self.size();
        (0..n * n).map(|k| self.entry(k / n, k % n)).collect()
    }

    /// A vector with zeros for the held coordinates and the joints.
    pub(super) fn free_part(&self, vector: &[Sym]) -> Vec<Sym> {
        let component = |(i, &component)| {
            if self.is_held(i) {
                Sym::ZERO
            } else {
                component
            }
        };
        let mut part: Vec<Sym> = vector.iter().enumerate().map(component).collect();
        part.resize(self.size(), Sym::ZERO);
        part
    }
}

/// The contact direction `d` and `r = 1 / (n' H n)` as unknowns of `M d - n r = 0`, `n' d = 1`.
pub(super) fn direction(inertia: &Locked<'_>, normal: &[Sym], inputs: &[Variable]) -> Implicit {
    bordered(inertia, normal, &[], inputs)
}

/// The friction direction `e`, then `d` and `r`, as unknowns of `M e - b r = 0` and of the equations for
/// the contact direction.
pub(super) fn friction(
    inertia: &Locked<'_>,
    normal: &[Sym],
    tangent: &[Sym],
    inputs: &[Variable],
) -> Implicit {
    bordered(inertia, normal, &[tangent], inputs)
}

/// The acceleration `a` by a generalized force: `M a = f`.
pub(super) fn of_force(inertia: &Locked<'_>, force: Vec<Sym>, inputs: &[Variable]) -> Implicit {
    let n = inertia.size();
    let force = inertia.free_part(&force);
    let products = inertia.times(|i| Implicit::unknown(n, i));
    let residual: Vec<Sym> = products.iter().zip(&force).map(|(&a, &f)| a - f).collect();
    let transposed = inertia.times(Implicit::multiplier);
    let how = (inputs, inertia.in_steps);
    Implicit::new(inertia.matrix(), force, &residual, &transposed, how)
}

/// Unknowns `e` for each of the tangents, then `d` and `r`.
fn bordered(
    inertia: &Locked<'_>,
    normal: &[Sym],
    tangents: &[&[Sym]],
    inputs: &[Variable],
) -> Implicit {
    let n = inertia.size();
    // What multiplies `r` in each block of rows; the normal comes last.
    let columns: Vec<Vec<Sym>> = tangents
        .iter()
        .copied()
        .chain([normal])
        .map(|vector| inertia.free_part(vector))
        .collect();
    let last = columns.len() * n;
    let closing = last - n;
    let size = last + 1;
    let normal = &columns[columns.len() - 1];
    let mut matrix = vec![Sym::ZERO; size * size];
    for (block, column) in columns.iter().enumerate() {
        for (i, &component) in column.iter().enumerate() {
            let row = (block * n + i) * size;
            for j in 0..n {
                matrix[row + block * n + j] = inertia.entry(i, j);
            }
            matrix[row + last] = -component;
        }
    }
    matrix[last * size + closing..last * size + last].copy_from_slice(normal);
    let mut right = vec![Sym::ZERO; size];
    right[last] = Sym::ONE;

    let r = Implicit::unknown(size, last);
    let (mut residual, mut transposed) = (Vec::with_capacity(size), Vec::with_capacity(size));
    let mut last_column = Sym::ZERO;
    for (block, column) in columns.iter().enumerate() {
        let begin = block * n;
        let products = inertia.times(|i| Implicit::unknown(size, begin + i));
        residual.extend(products.iter().zip(column).map(|(&row, &c)| row - c * r));
        transposed.extend(inertia.times(|i| Implicit::multiplier(begin + i)));
        for (i, &c) in column.iter().enumerate() {
            last_column -= c * Implicit::multiplier(begin + i);
        }
    }
    for (i, &component) in normal.iter().enumerate() {
        transposed[closing + i] += component * Implicit::multiplier(last);
    }
    transposed.push(last_column);
    let closure: Sym = (0..n)
        .map(|i| normal[i] * Implicit::unknown(size, closing + i))
        .sum();
    residual.push(closure - Sym::ONE);
    let how = (inputs, inertia.in_steps);
    Implicit::new(matrix, right, &residual, &transposed, how)
}
