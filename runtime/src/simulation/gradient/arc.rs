//! One step between two known states of a smooth motion, and how its end changes with its start and with what the motion
//! is differentiated by: collocation of `q' = v`, `v' = A(q, v, u, t)` and of its variational equations
//!
//! ```text
//! dA_m = A_q dq_m + A_v dv_m + A_p        dv_m = dv_0 + h sum_j a_mj dA_j        dq_m = dq_0 + h c_m dv_0 + h^2 sum_j (a^2)_mj dA_j
//! ```
//!
//! in which each quantity is one right-hand side of the system of the last Newton iteration.

use super::acceleration::{Acceleration, input, solved};
use super::matrix::{Matrix, add, largest};
use super::wanted::Wanted;
use crate::linalg::dense;
use crate::model::ControlPiece;
use crate::rk::{ButcherTableau, Scheme};

/// Stages of a step: one more than the finest elements of a run have, so that the error of the run is what counts.
const STAGES: usize = 7;
/// Newton iterations of a step.
const MOST_ITERATIONS: usize = 8;
/// Change of the velocity, relative to its size, that leaves nothing but rounding in derivatives.
const CONVERGED: f64 = 1e-12;

/// A state with its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct At<'s> {
    pub(super) time: f64,
    pub(super) q: &'s [f64],
    pub(super) v: &'s [f64],
}

/// The steps of a walk.
pub(super) struct Arc {
    tableau: ButcherTableau,
    /// Accelerations of the stages, and of each the acceleration and its derivatives.
    stages: Vec<f64>,
    by: Vec<Matrix>,
    residual: Vec<f64>,
}

impl Arc {
    pub(super) fn new() -> Option<Self> {
        Some(Self {
            tableau: ButcherTableau::new(Scheme::RadauIia, STAGES)?,
            stages: Vec::new(),
            by: Vec::new(),
            residual: Vec::new(),
        })
    }

    /// Carries the derivatives `state` of `(q, v)` over the step. The largest distances of coordinates and velocities at its end
    /// from the known ones; none if it has no solution.
    pub(super) fn step(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        wanted: &Wanted,
        (from, to): (At<'_>, At<'_>),
        controls: &ControlPiece,
        state: &mut Matrix,
    ) -> Option<[f64; 2]> {
        let n = acceleration.n;
        let h = to.time - from.time;
        self.guess(acceleration, (from, to), controls)?;
        let speed = largest(from.v)
            .max(largest(to.v))
            .max(h * largest(&self.stages));
        let mut system = None;
        for _ in 0..MOST_ITERATIONS {
            let (matrix, pivots) = self.linearize(acceleration, (from, h), controls)?;
            dense::solve(&matrix.values, &pivots, &mut self.residual);
            add(&mut self.stages, -1.0, &self.residual);
            let change = h * largest(&self.residual);
            if change.is_nan() {
                return None;
            }
            system = Some((matrix, pivots));
            if change <= CONVERGED * speed {
                break;
            }
        }
        let (matrix, pivots) = system?;
        let right = self.right(wanted, (n, h), state);
        let change = solved(&matrix, &pivots, right);
        let weights = (self.tableau.b(), self.tableau.b_times_a());
        let mut missed = [0.0_f64; 2];
        for k in 0..n {
            let column = |weights: &[f64]| -> f64 {
                let stages = self.stages.chunks_exact(n).zip(weights);
                stages.map(|(stage, weight)| stage[k] * weight).sum()
            };
            let v = from.v[k] + h * column(weights.0);
            let q = from.q[k] + h * from.v[k] + h * h * column(weights.1);
            missed[0] = missed[0].max((q - to.q[k]).abs());
            missed[1] = missed[1].max((v - to.v[k]).abs());
        }
        for k in 0..n {
            let (coordinates, velocities) = state.values.split_at_mut(n * change.columns);
            let own = k * change.columns..(k + 1) * change.columns;
            let (coordinates, velocities) = (&mut coordinates[own.clone()], &mut velocities[own]);
            add(coordinates, h, velocities);
            for j in 0..self.tableau.stages() {
                add(coordinates, h * h * weights.1[j], change.row(j * n + k));
                add(velocities, h * weights.0[j], change.row(j * n + k));
            }
        }
        Some(missed)
    }

    /// Accelerations of the stages on the cubic through both ends.
    fn guess(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        (from, to): (At<'_>, At<'_>),
        controls: &ControlPiece,
    ) -> Option<()> {
        let (n, h) = (acceleration.n, to.time - from.time);
        self.stages.clear();
        let mut q = vec![0.0; n];
        let mut v = vec![0.0; n];
        for &s in self.tableau.c() {
            for k in 0..n {
                let rise = to.q[k] - from.q[k];
                let (a, b) = (h * from.v[k] - rise, rise - h * to.v[k]);
                q[k] = from.q[k] + s * (rise + (1.0 - s) * ((1.0 - s) * a + s * b));
                v[k] = from.v[k] + s * (to.v[k] - from.v[k]);
            }
            let x = stage_input(acceleration, (&q, &v), from.time + s * h, controls);
            if !acceleration.evaluate_values(&x) {
                return None;
            }
            self.stages.extend(&acceleration.value);
        }
        Some(())
    }

    /// Evaluates all stages: their residuals, and the factors of the Newton matrix.
    fn linearize(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        (from, h): (At<'_>, f64),
        controls: &ControlPiece,
    ) -> Option<(Matrix, Vec<usize>)> {
        let (n, stages) = (acceleration.n, self.tableau.stages());
        let order = n * stages;
        let mut matrix = Matrix::zeros(order, order);
        self.residual.clear();
        self.by.clear();
        for m in 0..stages {
            let c = self.tableau.c()[m];
            let (mut q, mut v) = (from.q.to_vec(), from.v.to_vec());
            add(&mut q, c * h, from.v);
            for (j, stage) in self.stages.chunks_exact(n).enumerate() {
                add(&mut v, h * self.tableau.a(m, j), stage);
                add(&mut q, h * h * self.tableau.a_squared(m, j), stage);
            }
            let x = stage_input(acceleration, (&q, &v), from.time + c * h, controls);
            if !acceleration.evaluate(&x) {
                return None;
            }
            for k in 0..n {
                let own = m * n + k;
                self.residual.push(self.stages[own] - acceleration.value[k]);
                let by = acceleration.by.row(k);
                let row = matrix.row_mut(own);
                for j in 0..stages {
                    let (first, second) = (self.tableau.a(m, j), self.tableau.a_squared(m, j));
                    for i in 0..n {
                        row[j * n + i] = -h * (first * by[n + i] + h * second * by[i]);
                    }
                }
                row[own] += 1.0;
            }
            self.by.push(acceleration.by.clone());
        }
        let mut pivots = vec![0; order];
        dense::factorize(&mut matrix.values, &mut pivots).ok()?;
        Some((matrix, pivots))
    }

    /// Right-hand sides of the variational equations of the stages.
    fn right(&self, wanted: &Wanted, (n, h): (usize, f64), state: &Matrix) -> Matrix {
        let stages = self.tableau.stages();
        let mut right = Matrix::zeros(n * stages, state.columns);
        for (m, by) in self.by.iter().enumerate() {
            let c = self.tableau.c()[m];
            for k in 0..n {
                let by = by.row(k);
                let row = right.row_mut(m * n + k);
                for i in 0..n {
                    add(row, by[i], state.row(i));
                    add(row, c * h * by[i] + by[n + i], state.row(n + i));
                }
                for (column, value) in row.iter_mut().enumerate() {
                    *value += wanted.column(column).map_or(0.0, |column| by[column]);
                }
            }
        }
        right
    }
}

fn stage_input(
    acceleration: &Acceleration<'_>,
    (q, v): (&[f64], &[f64]),
    time: f64,
    controls: &ControlPiece,
) -> Vec<f64> {
    let model = acceleration.model;
    let mut u = vec![0.0; model.declaration().controls.len()];
    controls.write(time, &mut u);
    input(model, (q, v, &u), time)
}
