//! One step between two known states of a smooth motion, and how its end changes with its start and with what the motion
//! is differentiated by: collocation of `q' = v`, `v' = A(q, v, u, t)` and of its variational equations
//!
//! ```text
//! dA_m = A_q dq_m + A_v dv_m + A_p        dv_m = dv_0 + h sum_j a_mj dA_j        dq_m = dq_0 + h c_m dv_0 + h^2 sum_j (a^2)_mj dA_j
//! ```
//!
//! in which each column is one right-hand side of the system of the last Newton iteration, forwards and backwards.

use super::cost::Cost;
use super::mode::{Acceleration, input};
use super::tangent::{Factors, Layout, Matrix, Tangent, add};
use crate::linalg::products::largest;
use crate::model::ControlPiece;
use crate::rk::{ButcherTableau, Scheme};
use crate::yardstick;

/// Stages of a step: one more than the finest elements of a run have, so that the error of the run is what counts.
pub(super) const STAGES: usize = 7;
/// Newton iterations of a step with derivatives of all stages.
const MOST_ITERATIONS: usize = 8;
/// Iterations without new derivatives between two of them: each costs a fraction of one with.
const MOST_REPEATED: usize = 6;
/// Ratio of the changes of two of them above which new derivatives are worth their cost.
const CONTRACTS: f64 = 0.1;
/// A state with its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct At<'s> {
    pub(super) time: f64,
    pub(super) q: &'s [f64],
    pub(super) v: &'s [f64],
}

/// One step, in the mode of an acceleration and under controls that are smooth in it.
#[derive(Clone, Copy)]
pub(super) struct Step<'s> {
    pub(super) from: At<'s>,
    pub(super) to: At<'s>,
    pub(super) controls: &'s ControlPiece,
}

impl Step<'_> {
    pub(super) fn length(&self) -> f64 {
        self.to.time - self.from.time
    }
}

/// The steps of a motion.
pub(super) struct Steps {
    tableau: ButcherTableau,
    /// Stages of which the last is no end, for steps to where a root vanishes, whose slope is infinite there; taken while it is `inside`.
    other: ButcherTableau,
    inside: bool,
    /// Accelerations of the stages, and of each the input vector and the derivatives of the acceleration.
    stages: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    by: Vec<Matrix>,
    residual: Vec<f64>,
    /// Derivatives of the accelerations of the stages, by stage and component.
    change: Matrix,
    /// Factors of the last Newton matrix.
    factors: Factors,
}

/// What is linear in a step that was solved: its Newton matrix, and the derivatives of its stages.
pub(super) struct Linear {
    h: f64,
    inside: bool,
    factors: Factors,
    /// Of the acceleration, by stage.
    by: Vec<Matrix>,
    /// Of the running cost, by stage; none without one.
    cost_by: Vec<Vec<f64>>,
}

impl Steps {
    /// With so many stages a step.
    pub(super) fn of(stages: usize) -> Option<Self> {
        Some(Self {
            tableau: ButcherTableau::new(Scheme::RadauIia, stages)?,
            other: ButcherTableau::new(Scheme::GaussLegendre, stages)?,
            inside: false,
            stages: Vec::new(),
            inputs: Vec::new(),
            by: Vec::new(),
            residual: Vec::new(),
            change: Matrix::default(),
            factors: Default::default(),
        })
    }

    /// Carries derivatives over the step, and counts its cost. The largest distances of coordinates and velocities at its end from the known
    /// ones; none if it has no solution. Newton's method asks the `lean` acceleration, if there is one, which knows fewer derivatives.
    pub(super) fn step(
        &mut self,
        (acceleration, lean): (&mut Acceleration<'_>, Option<&mut Acceleration<'_>>),
        step: Step<'_>,
        tangent: &mut Tangent,
        cost: Option<&Cost<'_>>,
    ) -> Option<[f64; 2]> {
        let factors = match lean {
            None => self.solve_inside(acceleration, step)?,
            Some(lean) => {
                lean.lines.clone_from(&acceleration.lines);
                let factors = self.solve_inside(lean, step)?;
                self.by.clear();
                for x in &self.inputs {
                    if !acceleration.evaluate(x) {
                        return None;
                    }
                    self.by.push(acceleration.by.clone());
                }
                factors
            }
        };
        let (n, h) = (acceleration.n, step.length());
        let right = self.right((n, h), tangent);
        self.change = factors.solve_all(right);
        if let Some(cost) = cost {
            let row = tangent.layout.cost();
            for (m, x) in self.inputs.iter().enumerate() {
                if let Some(by) = cost.running(x) {
                    let theta = self.tableau.c()[m];
                    let running = self.derivatives_within((n, h), tangent, theta).of(&by);
                    add(tangent.all.row_mut(row), h * self.tableau.b()[m], &running);
                }
            }
        }
        let missed = self.missed(n, step);
        *tangent = self.derivatives_within((n, h), tangent, 1.0);
        self.factors = factors;
        Some(missed)
    }

    /// What is linear in the step that was passed last.
    pub(super) fn linear(&mut self, step: Step<'_>, cost: Option<&Cost<'_>>) -> Linear {
        let inputs = self.inputs.iter();
        let cost_by = cost.map(|cost| inputs.filter_map(|x| cost.running(x)));
        Linear {
            h: step.length(),
            inside: self.inside,
            factors: std::mem::take(&mut self.factors),
            by: std::mem::take(&mut self.by),
            cost_by: cost_by.map(Iterator::collect).unwrap_or_default(),
        }
    }

    /// Carries what depends on everything at the end of a step, a number for each row of a [`Tangent`], back to its start: the transpose of
    /// [`step`](Self::step).
    ///
    /// ```text
    /// mu_j = h^2 (b a)_j lambda_q + h b_j lambda_v        (I - dA)' nu = mu
    /// lambda_q <- lambda_q + sum_m A_q' nu_m              lambda_v <- lambda_v + h lambda_q + sum_m (h c_m A_q + A_v)' nu_m
    /// ```
    ///
    /// and what else accelerations read gains its own part; running costs add their own terms to each.
    pub(super) fn back(&self, linear: &Linear, layout: Layout, to: &mut [f64]) {
        let known = linear.inside == self.inside;
        let tableau = if known { &self.tableau } else { &self.other };
        let (n, h, stages) = (layout.n, linear.h, tableau.stages());
        let (b, b_times_a, c) = (tableau.b(), tableau.b_times_a(), tableau.c());
        let cost = to[layout.cost()];
        let mut nu = vec![0.0; n * stages];
        for (j, nu) in nu.chunks_exact_mut(n).enumerate() {
            add(nu, h * h * b_times_a[j], &to[..n]);
            add(nu, h * b[j], &to[n..2 * n]);
            for (m, by) in linear.cost_by.iter().enumerate() {
                let weight = cost * h * b[m];
                add(nu, weight * h * h * tableau.a_squared(m, j), &by[..n]);
                add(nu, weight * h * tableau.a(m, j), &by[n..2 * n]);
            }
        }
        linear.factors.solve_transposed(&mut nu);
        let (of_q, rest) = to.split_at_mut(n);
        add(&mut rest[..n], h, of_q);
        let mut pass = |factor: f64, by: &[f64], m: usize| {
            for (row, by) in layout.read().zip(by) {
                to[row] += factor * by;
                if row < n {
                    to[n + row] += factor * c[m] * h * by;
                }
            }
        };
        for (m, by) in linear.by.iter().enumerate() {
            for k in 0..n {
                pass(nu[m * n + k], by.row(k), m);
            }
        }
        for (m, by) in linear.cost_by.iter().enumerate() {
            pass(cost * h * b[m], by, m);
        }
    }

    /// Solves for the accelerations of the stages, of others where they are not finite at the end.
    fn solve_inside(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        step: Step<'_>,
    ) -> Option<Factors> {
        for inside in [false, true] {
            if self.inside != inside {
                std::mem::swap(&mut self.tableau, &mut self.other);
                self.inside = inside;
            }
            let factors = self.solve(acceleration, step);
            if factors.is_some() {
                return factors;
            }
        }
        None
    }

    /// Solves the motion of the step without derivatives. The largest distances at its end as of [`step`](Self::step).
    pub(super) fn values(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        step: Step<'_>,
    ) -> Option<[f64; 2]> {
        self.solve_inside(acceleration, step)?;
        Some(self.missed(acceleration.n, step))
    }

    /// Solves for the accelerations of the stages; the factors of the last Newton matrix.
    fn solve(&mut self, acceleration: &mut Acceleration<'_>, step: Step<'_>) -> Option<Factors> {
        let h = step.length();
        self.guess(acceleration, step)?;
        let reached = h * largest(&self.stages).max(largest(acceleration.free_acceleration()));
        let speed = largest(step.from.v).max(largest(step.to.v)).max(reached);
        let mut system = None;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let factors = self.linearize(acceleration, step)?;
            factors.solve(&mut self.residual);
            add(&mut self.stages, -1.0, &self.residual);
            let change = h * largest(&self.residual);
            if change.is_nan() {
                return None;
            }
            // Where rounding is more than that, changes stay as large as they are.
            if change <= yardstick::ROUNDING * speed
                || (change <= yardstick::NOTHING * speed && change >= last)
            {
                system = Some(factors);
                break;
            }
            last = change;
            self.repeat(
                acceleration,
                step,
                &factors,
                (change, yardstick::ROUNDING * speed),
            )?;
            system = Some(factors);
        }
        system
    }

    /// Goes on with the factors of the last Newton matrix, behind a `change` of the velocity, as long as that pays; the derivatives
    /// are those of the stages where these factors come from.
    fn repeat(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        step: Step<'_>,
        factors: &Factors,
        (mut change, enough): (f64, f64),
    ) -> Option<()> {
        let (from, h, n) = (step.from, step.length(), acceleration.n);
        for _ in 0..MOST_REPEATED {
            self.residual.clear();
            for m in 0..self.tableau.stages() {
                let x = self.stage_input((acceleration, step), (from, h), m);
                if !acceleration.evaluate_values(&x) {
                    return None;
                }
                let own = &self.stages[m * n..][..n];
                let values = own.iter().zip(&acceleration.value);
                self.residual.extend(values.map(|(own, value)| own - value));
            }
            factors.solve(&mut self.residual);
            add(&mut self.stages, -1.0, &self.residual);
            let next = h * largest(&self.residual);
            if next.is_nan() {
                return None;
            }
            if next <= enough || next > CONTRACTS * change {
                break;
            }
            change = next;
        }
        Some(())
    }

    /// The input vector of stage `m`.
    fn stage_input(
        &self,
        (acceleration, step): (&Acceleration<'_>, Step<'_>),
        (from, h): (At<'_>, f64),
        m: usize,
    ) -> Vec<f64> {
        let n = acceleration.n;
        let c = self.tableau.c()[m];
        let (mut q, mut v) = (from.q.to_vec(), from.v.to_vec());
        add(&mut q, c * h, from.v);
        for (j, stage) in self.stages.chunks_exact(n).enumerate() {
            add(&mut v, h * self.tableau.a(m, j), stage);
            add(&mut q, h * h * self.tableau.a_squared(m, j), stage);
        }
        stage_input(acceleration, (&q, &v), from.time + c * h, step.controls)
    }

    /// Distances of the end from the known one.
    fn missed(&self, n: usize, Step { from, to, .. }: Step<'_>) -> [f64; 2] {
        let h = to.time - from.time;
        let mut missed = [0.0_f64; 2];
        for k in 0..n {
            let sum = |weights: &[f64]| -> f64 {
                let stages = self.stages.chunks_exact(n).zip(weights);
                stages.map(|(stage, weight)| stage[k] * weight).sum()
            };
            let v = from.v[k] + h * sum(self.tableau.b());
            let q = from.q[k] + h * from.v[k] + h * h * sum(self.tableau.b_times_a());
            missed[0] = missed[0].max((q - to.q[k]).abs());
            missed[1] = missed[1].max((v - to.v[k]).abs());
        }
        missed
    }

    /// The state at the share `theta` of the step that was solved last.
    pub(super) fn within(&self, step: Step<'_>, theta: f64) -> (Vec<f64>, Vec<f64>) {
        let (n, h, stages) = (step.from.q.len(), step.length(), self.tableau.stages());
        let mut weights = vec![0.0; stages];
        self.tableau.dense_weights(theta, &mut weights);
        let (mut q, mut v) = (step.from.q.to_vec(), step.from.v.to_vec());
        for (j, weight) in weights.iter().enumerate() {
            add(&mut v, h * weight, &self.stages[j * n..][..n]);
            let mut rate = step.from.v.to_vec();
            for (i, stage) in self.stages.chunks_exact(n).enumerate() {
                add(&mut rate, h * self.tableau.a(j, i), stage);
            }
            add(&mut q, h * weight, &rate);
        }
        (q, v)
    }

    /// Derivatives at the share `theta` of the step that was solved last, of length `h`, from those at its start.
    pub(super) fn derivatives_within(
        &self,
        (n, h): (usize, f64),
        start: &Tangent,
        theta: f64,
    ) -> Tangent {
        let stages = self.tableau.stages();
        let mut weights = vec![0.0; stages];
        self.tableau.dense_weights(theta, &mut weights);
        // Of velocities by accelerations, and of coordinates by them.
        let twice = |j: usize| (0..stages).map(|m| weights[m] * self.tableau.a(m, j)).sum();
        let twice: Vec<f64> = (0..stages).map(twice).collect();
        let mut tangent = start.clone();
        for k in 0..n {
            add(tangent.all.row_mut(k), theta * h, start.all.row(n + k));
            for j in 0..stages {
                let change = self.change.row(j * n + k);
                add(tangent.all.row_mut(k), h * h * twice[j], change);
                add(tangent.all.row_mut(n + k), h * weights[j], change);
            }
        }
        tangent
    }

    /// Accelerations of the stages on the cubic through both ends.
    fn guess(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        Step { from, to, controls }: Step<'_>,
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
        step: Step<'_>,
    ) -> Option<Factors> {
        let (from, h) = (step.from, step.length());
        let (n, stages) = (acceleration.n, self.tableau.stages());
        let order = n * stages;
        let mut matrix = Matrix::zeros(order, order);
        self.residual.clear();
        self.by.clear();
        self.inputs.clear();
        for m in 0..stages {
            let x = self.stage_input((acceleration, step), (from, h), m);
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
            self.inputs.push(x);
        }
        Factors::of(matrix.values)
    }

    /// Right-hand sides of the variational equations of the stages.
    fn right(&self, (n, h): (usize, f64), tangent: &Tangent) -> Matrix {
        let stages = self.tableau.stages();
        let mut right = Matrix::zeros(n * stages, tangent.all.columns);
        for (m, by) in self.by.iter().enumerate() {
            let c = self.tableau.c()[m];
            for k in 0..n {
                let row = right.row_mut(m * n + k);
                for (of, by) in tangent.layout.read().zip(by.row(k)) {
                    if *by == 0.0 {
                        continue;
                    }
                    add(row, *by, tangent.all.row(of));
                    if of < n {
                        add(row, c * h * by, tangent.all.row(n + of));
                    }
                }
            }
        }
        right
    }
}

/// The input vector at a state under some controls.
pub(super) fn stage_input(
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
