//! What acts on a mechanism besides the forces that a scene declares, from the entries of its mass matrix.
//!
//! With `L = v' M v / 2 + a' v - V` of `(q, t)`,
//!
//! ```text
//! dL/dq_i - d/dt (dL/dv_i) without accelerations
//!     = -dV/dq_i - da_i/dt + sum_k (da_k/dq_i - da_i/dq_k - dM_ik/dt) v_k - sum_jk c_ijk v_j v_k
//! c_ijk = (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2
//! ```
//!
//! with the Christoffel symbols of the first kind `c_ijk`. A mass matrix that is simpler than the kinetic energy from which
//! it comes, as that of a body in space by its rotation matrix is, gives far fewer operations so than the momenta, whose
//! derivatives hold again all that cancels in it.

use super::explicit::columns;
use super::simplify;
use crate::graph::{self, Compose, Sweeps, Sym, Variable};

/// What the formula above reads.
pub(super) struct Bias<'a> {
    pub(super) lagrangian: Sym,
    /// `dL/dv`.
    pub(super) momenta: &'a [Sym],
    /// Mass matrix, row-major.
    pub(super) mass: &'a [Sym],
    /// Number of coordinates that move; those behind them have no velocity and no equation.
    pub(super) moving: usize,
}

impl Bias<'_> {
    /// The right-hand side of each coordinate but for declared forces.
    pub(super) fn forces(&self) -> Vec<Sym> {
        let n = self.momenta.len();
        let coordinates = Variable::coordinates(n);
        let velocity = |k: usize| Sym::variable(Variable::Velocity(k as u16));
        let at_rest = |values: &[Sym]| {
            graph::substitute(values, |variable| match variable {
                Variable::Velocity(_) => Some(Sym::ZERO),
                _ => None,
            })
        };
        let potential = graph::gradient(at_rest(&[self.lagrangian])[0], &coordinates);
        // The part of the momenta that no velocity is in; most scenes have none.
        let linear = at_rest(self.momenta);
        let by_time = graph::partial(&linear, Variable::Time);
        let slopes: Vec<Vec<Sym>> = coordinates[..self.moving]
            .iter()
            .map(|&coordinate| graph::partial(&linear, coordinate))
            .collect();
        let inertia = Inertia::of(self.mass, n, self.moving);
        let force = |i: usize| {
            let mut terms = vec![(potential[i], 1.0), (by_time[i], -1.0)];
            for (k, slope) in slopes.iter().enumerate() {
                let gyroscopic = simplify(slopes[i][k] - slope[i] - inertia.by_time(i, k));
                terms.push((gyroscopic * velocity(k), 1.0));
            }
            for (j, k, coefficient) in inertia.symbols(i) {
                terms.push((coefficient * velocity(j) * velocity(k), -1.0));
            }
            graph::sum(terms)
        };
        let moving = (0..self.moving).map(force);
        moving
            .chain(std::iter::repeat_n(Sym::ZERO, n - self.moving))
            .collect()
    }
}

/// Derivatives of the entries of a mass matrix.
struct Inertia {
    moving: usize,
    /// `dM_ij/dq_k` of `i >= j`, for each `k` at `i (i + 1) / 2 + j`.
    slopes: Vec<Vec<Sym>>,
    /// `dM_ij/dt` at `i (i + 1) / 2 + j`.
    by_time: Vec<Sym>,
}

impl Inertia {
    fn of(mass: &[Sym], n: usize, moving: usize) -> Self {
        let lower = (0..moving).flat_map(|i| (0..=i).map(move |j| i * n + j));
        let entries: Vec<Sym> = lower.map(|place| mass[place]).collect();
        let mut by: Vec<Variable> = (0..moving)
            .map(|k| Variable::Coordinate(k as u16))
            .collect();
        by.push(Variable::Time);
        let mut slopes = columns(&Sweeps::over(&entries), &entries, &by);
        let by_time = slopes.pop().unwrap_or_default();
        Self {
            moving,
            slopes,
            by_time,
        }
    }

    fn place(i: usize, j: usize) -> usize {
        let (row, column) = (i.max(j), i.min(j));
        row * (row + 1) / 2 + column
    }

    fn slope(&self, i: usize, j: usize, k: usize) -> Sym {
        self.slopes[k][Self::place(i, j)]
    }

    fn by_time(&self, i: usize, k: usize) -> Sym {
        self.by_time[Self::place(i, k)]
    }

    /// `j >= k` and what multiplies `v_j v_k` in row `i`, where that is not zero.
    fn symbols(&self, i: usize) -> Vec<(usize, usize, Sym)> {
        let mut all = Vec::new();
        for j in 0..self.moving {
            for k in 0..=j {
                let (by_k, by_j) = (self.slope(i, j, k), self.slope(i, k, j));
                let by_i = self.slope(j, k, i);
                if [by_k, by_j, by_i]
                    .iter()
                    .all(|slope| slope.is_structural_zero())
                {
                    continue;
                }
                // Pairs of different velocities stand twice in the sum.
                let weight = if j == k { 0.5 } else { 1.0 };
                let symbol = simplify(by_k + by_j - by_i).scaled(weight);
                if !symbol.is_structural_zero() {
                    all.push((j, k, symbol));
                }
            }
        }
        all
    }
}
