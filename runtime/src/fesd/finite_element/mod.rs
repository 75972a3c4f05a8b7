//! One finite element in a fixed contact mode: a smooth square system, solved by Newton's method.
//!
//! With the active contacts `I`, start `(q_0, v_0)` and length `h` the element is the collocation of the
//! stabilised index-2 system
//!
//! ```text
//! q' = v + h sum_I d_i(q_0) eta_i         0 = g_i(q)
//! v' = a(q, v, u, t) + sum_I d_i(q) r_i   0 = v_n,i(q, v)
//! ```
//!
//! (Gear, Gupta, Leimkuhler 1985), in which gap and normal velocity both vanish at every stage and Radau
//! IIA keeps order `2 s - 1` in `q` and `v`. `eta` [1/s^2 times the unit of the coordinates] vanishes with
//! the step length; its direction may be frozen at the start of the element since `eta = 0` solves the
//! differential equation exactly.
//!
//! A contact that slips acts along `d_i -+ mu_i e_i` instead of `d_i`. One that sticks adds
//!
//! ```text
//! v' = ... + e_i(q) s_i                           0 = v_t,i(q, v)
//! ```
//!
//! which has index 2 as well, so that the order stays.
//!
//! Unknowns of stage `m`: accelerations `A_m` (`n_q`), then the forces: `r_m` of each active contact and
//! `s_m` of each that sticks; then `eta_m`, one an active contact.

mod assembly;
mod end;
mod motion_size;
mod output;

pub(crate) use motion_size::MotionSize;

use super::active_contact::ActiveContact;
use super::constraints::Constraints;
use crate::linalg::dense;
use crate::model::{ControlPiece, Model};
use crate::rk::ButcherTableau;

/// Newton iterations after which an element counts as not converged.
const MAX_ITERATIONS: usize = 15;
/// Relative change of the state that ends Newton's method.
const CONVERGED: f64 = 2e-16;
/// Relative change below which an iteration that no longer contracts has reached rounding error.
const ROUNDING: f64 = 1e-12;
/// Contraction above which the Jacobian is evaluated anew.
const SLOW: f64 = 0.05;

/// Most times longer than the previous element that an element may be to be predicted from it.
const MOST_GROWTH: f64 = 16.0;

/// Why an element has no solution here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ElementError {
    /// The Jacobian is singular: dependent contact normals, or a mode that cannot hold.
    Singular,
    /// Newton's method did not contract.
    NotConverged,
    /// A model value is infinite or not a number.
    NotFinite,
}

/// Counts of the Newton iterations.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct NewtonCounts {
    pub(crate) iterations: usize,
    pub(crate) factorizations: usize,
    pub(crate) evaluations: usize,
}

/// State at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) time: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

impl State {
    /// Copies without allocating.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.q.clone_from(&other.q);
        self.v.clone_from(&other.v);
    }
}

/// The element with its stages, its Newton matrix and its memory.
pub(crate) struct FiniteElement<'a> {
    model: &'a dyn Model,
    tableau: &'a ButcherTableau,
    n: usize,
    inputs: usize,
    controls: ControlPiece,
    /// Input vector at the start.
    first: Vec<f64>,
    constraints: Constraints<'a>,
    start: State,
    length: f64,
    /// Correction directions: those of the forces at `q_0`, one row an active contact.
    corrections: Vec<f64>,
    /// Unknowns of all stages, `stages * block`.
    unknowns: Vec<f64>,
    /// Inputs `x = (q, v, u[, t])` of all stages.
    inputs_of_stages: Vec<f64>,
    acceleration: Vec<f64>,
    free_jacobian: Vec<f64>,
    /// `d(a + sum d r)/dq` and `d a/dv` of one stage, row-major `n x n`.
    by_q: Vec<f64>,
    by_v: Vec<f64>,
    matrix: Vec<f64>,
    pivots: Vec<usize>,
    residual: Vec<f64>,
    /// Whether `matrix` holds factors for the present mode.
    factorized: bool,
    /// Whether `unknowns` holds a solution of the same mode to extrapolate from.
    has_previous: bool,
    previous: Vec<f64>,
    previous_length: f64,
    pub(crate) end: State,
    /// Largest term that the stage accelerations sum up, the scale of their rounding error.
    acceleration_scale: f64,
    /// Largest rounding error of a gap at the stages.
    gap_rounding: f64,
    /// Largest stage residual seen before the last correction, in units of velocity.
    pub(crate) residual_norm: f64,
    pub(crate) counts: NewtonCounts,
}

impl<'a> FiniteElement<'a> {
    pub(crate) fn new(model: &'a dyn Model, tableau: &'a ButcherTableau) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        Self {
            model,
            tableau,
            n,
            inputs: declaration.inputs(),
            controls: ControlPiece::default(),
            first: vec![0.0; declaration.inputs()],
            constraints: Constraints::new(model),
            start: State::default(),
            length: 0.0,
            corrections: Vec::new(),
            unknowns: Vec::new(),
            inputs_of_stages: vec![0.0; declaration.inputs() * tableau.stages()],
            acceleration: vec![0.0; n],
            free_jacobian: vec![0.0; declaration.free_jacobian.entries.len()],
            by_q: vec![0.0; n * n],
            by_v: vec![0.0; n * n],
            matrix: Vec::new(),
            pivots: Vec::new(),
            residual: Vec::new(),
            factorized: false,
            has_previous: false,
            previous: Vec::new(),
            previous_length: 0.0,
            end: State {
                time: 0.0,
                q: vec![0.0; n],
                v: vec![0.0; n],
            },
            acceleration_scale: 0.0,
            gap_rounding: 0.0,
            residual_norm: 0.0,
            counts: NewtonCounts::default(),
        }
    }

    /// Unknowns of one stage.
    fn block(&self) -> usize {
        self.n + self.constraints.count() + self.active().len()
    }

    /// Unknowns of the element without its length.
    pub(crate) fn variables(&self) -> usize {
        self.tableau.stages() * self.block()
    }

    /// Active contacts.
    pub(crate) fn active(&self) -> &[ActiveContact] {
        self.constraints.active()
    }

    /// Length of the solved element [s].
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Normal contact accelerations of the active contacts at stage `m`.
    pub(crate) fn stage_forces(&self, m: usize) -> &[f64] {
        let begin = m * self.block() + self.n;
        &self.unknowns[begin..begin + self.active().len()]
    }

    /// Forces of all constraints at stage `m`: normals, then the friction of contacts that stick.
    pub(crate) fn stage_constraint_forces(&self, m: usize) -> &[f64] {
        let begin = m * self.block() + self.n;
        &self.unknowns[begin..begin + self.constraints.count()]
    }

    /// Input vector of stage `m` of the solved element.
    pub(crate) fn stage_input(&self, m: usize) -> &[f64] {
        &self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs]
    }

    /// Changes the contact mode; what was solved before no longer helps.
    pub(crate) fn set_mode(&mut self, active: &[ActiveContact]) {
        self.constraints.set_mode(active);
        let size = self.variables();
        self.unknowns.clear();
        self.unknowns.resize(size, 0.0);
        self.residual.resize(size, 0.0);
        self.pivots.resize(size, 0);
        self.corrections.resize(active.len() * self.n, 0.0);
        self.has_previous = false;
        self.factorized = false;
    }

    /// Solves the element of length `h` from `start` under `controls`; the end state is in `end`.
    pub(crate) fn solve(
        &mut self,
        start: &State,
        h: f64,
        controls: &ControlPiece,
    ) -> Result<(), ElementError> {
        self.start.copy_from(start);
        if (h - self.length).abs() > 0.2 * h {
            self.factorized = false;
        }
        self.length = h;
        self.constraints.set_length(h);
        // What a much shorter element says of its rates is rounding error, multiplied.
        self.has_previous &= h <= MOST_GROWTH * self.previous_length;
        self.controls.clone_from(controls);
        let place = self.place_of_controls();
        for (stage, c) in self
            .inputs_of_stages
            .chunks_exact_mut(self.inputs)
            .zip(self.tableau.c())
        {
            controls.write(start.time + c * h, &mut stage[place.clone()]);
        }
        self.evaluate_start();
        self.predict(h);
        let predicted = self.has_previous;
        let mut outcome = self.iterate();
        if outcome.is_err() {
            self.factorized = false;
            if predicted {
                // The prediction may have led astray.
                self.has_previous = false;
                self.evaluate_start();
                self.predict(h);
                outcome = self.iterate();
            }
        }
        outcome?;
        self.finish()?;
        self.previous.clone_from(&self.unknowns);
        self.previous_length = h;
        self.has_previous = true;
        Ok(())
    }

    /// Starts from the previous element's stage polynomials, extrapolated, or else from the free
    /// acceleration at the start.
    fn predict(&mut self, h: f64) {
        let stages = self.tableau.stages();
        let block = self.block();
        if !self.has_previous {
            for stage in self.unknowns.chunks_exact_mut(block) {
                stage[..self.n].copy_from_slice(&self.acceleration);
                stage[self.n..].fill(0.0);
            }
            return;
        }
        let continues = self.start.time >= self.end.time - 0.5 * self.previous_length;
        let offset = if continues { 1.0 } else { 0.0 };
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        for m in 0..stages {
            // Extrapolating far beyond the previous element does more harm than good.
            let theta = (offset + self.tableau.c()[m] * h / self.previous_length).min(2.0);
            self.tableau.lagrange_values(theta, &mut values[..stages]);
            for k in 0..block {
                self.unknowns[m * block + k] = (0..stages)
                    .map(|j| values[j] * self.previous[j * block + k])
                    .sum();
            }
        }
    }

    /// Where the controls are in the input vector.
    fn place_of_controls(&self) -> std::ops::Range<usize> {
        2 * self.n..2 * self.n + self.model.declaration().controls.len()
    }

    /// Writes the controls at `time`, and the time where the model depends on it, into an input vector.
    fn write_time(&self, time: f64, x: &mut [f64]) {
        if self.controls.varies() {
            self.controls.write(time, &mut x[self.place_of_controls()]);
        }
        if self.model.declaration().explicit_time {
            x[self.inputs - 1] = time;
        }
    }

    /// Evaluates the directions of the position corrections, and the free acceleration at the start where no
    /// previous element helps.
    fn evaluate_start(&mut self) {
        if self.active().is_empty() && self.has_previous {
            return;
        }
        let n = self.n;
        let mut first = std::mem::take(&mut self.first);
        let controls = self.place_of_controls();
        first[controls.clone()].copy_from_slice(&self.stage_input(0)[controls]);
        first[..n].copy_from_slice(&self.start.q);
        first[n..2 * n].copy_from_slice(&self.start.v);
        self.write_time(self.start.time, &mut first);
        if !self.has_previous {
            self.model.free_acceleration(&first, &mut self.acceleration);
        }
        self.constraints.evaluate(&first);
        self.first = first;
        let length = self.corrections.len();
        self.corrections
            .copy_from_slice(&self.constraints.directions[..length]);
    }

    /// Simplified Newton iterations: the factors are kept as long as they contract well.
    fn iterate(&mut self) -> Result<(), ElementError> {
        let mut last_change = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            self.evaluate_residual().map_err(|error| {
                // Far from its start the iteration diverged; that says nothing of the model.
                if iteration <= 1 {
                    error
                } else {
                    ElementError::NotConverged
                }
            })?;
            if iteration == 0 && self.active().is_empty() && self.is_solved() {
                // The prediction already satisfies the stage equations (constant acceleration).
                return Ok(());
            }
            if !self.factorized {
                self.assemble();
                dense::factorize(&mut self.matrix, &mut self.pivots)
                    .map_err(|_| ElementError::Singular)?;
                self.counts.factorizations += 1;
                self.factorized = true;
            }
            dense::solve(&self.matrix, &self.pivots, &mut self.residual);
            for (unknown, step) in self.unknowns.iter_mut().zip(&self.residual) {
                *unknown -= step;
            }
            self.counts.iterations += 1;
            let change = self.relative_change();
            if !change.is_finite() {
                return Err(ElementError::NotConverged);
            }
            let contraction = change / last_change;
            if change <= CONVERGED
                || (iteration > 0 && contraction < 1.0 && change * contraction <= 0.1 * CONVERGED)
                || (change <= ROUNDING && contraction >= 0.3)
                || change <= self.rounding_of_gaps()
            {
                self.update_stages();
                return Ok(());
            }
            if contraction > SLOW {
                self.factorized = false;
            }
            last_change = change;
        }
        Err(ElementError::NotConverged)
    }

    /// Whether the stage residual is at the rounding error of the accelerations.
    fn is_solved(&self) -> bool {
        self.residual
            .iter()
            .zip(&self.unknowns)
            .all(|(residual, unknown)| residual.abs() <= 4.0 * f64::EPSILON * unknown.abs())
    }

    /// Stage states from the unknowns.
    fn update_stages(&mut self) {
        let (n, h, block) = (self.n, self.length, self.block());
        let multipliers = n + self.constraints.count();
        let stages = self.tableau.stages();
        for m in 0..stages {
            let x = &mut self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs];
            let c = self.tableau.c()[m];
            for k in 0..n {
                let (mut first, mut second, mut correction) = (0.0, 0.0, 0.0);
                for j in 0..stages {
                    let unknown = &self.unknowns[j * block..(j + 1) * block];
                    let a = self.tableau.a(m, j);
                    first += a * unknown[k];
                    second += self.tableau.a_squared(m, j) * unknown[k];
                    for (i, eta) in unknown[multipliers..].iter().enumerate() {
                        correction += a * eta * self.corrections[i * n + k];
                    }
                }
                x[n + k] = self.start.v[k] + h * first;
                x[k] = self.start.q[k] + h * (c * self.start.v[k] + h * (second + correction));
            }
            if self.model.declaration().explicit_time {
                x[self.inputs - 1] = self.start.time + c * h;
            }
        }
    }

    /// Residuals of all stages: `A - a - sum d r - sum e s`, `v_n / h`, `v_t / h`, `g / h^2`.
    fn evaluate_residual(&mut self) -> Result<(), ElementError> {
        self.update_stages();
        let (n, h, block, forces) = (self.n, self.length, self.block(), self.constraints.count());
        self.residual_norm = 0.0;
        self.acceleration_scale = 0.0;
        self.gap_rounding = 0.0;
        for m in 0..self.tableau.stages() {
            let x = &self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs];
            self.model.free_acceleration(x, &mut self.acceleration);
            self.counts.evaluations += 1;
            let unknown = &self.unknowns[m * block..(m + 1) * block];
            let residual = &mut self.residual[m * block..(m + 1) * block];
            for k in 0..n {
                residual[k] = unknown[k] - self.acceleration[k];
                self.acceleration_scale = self.acceleration_scale.max(self.acceleration[k].abs());
            }
            self.constraints.evaluate(x);
            self.gap_rounding = self.gap_rounding.max(self.constraints.gap_rounding);
            for (i, direction) in self.constraints.directions.chunks_exact(n).enumerate() {
                for k in 0..n {
                    let force = direction[k] * unknown[n + i];
                    residual[k] -= force;
                    self.acceleration_scale = self.acceleration_scale.max(force.abs());
                }
                residual[n + i] = self.constraints.velocities[i] / h;
            }
            for (target, gap) in residual[n + forces..]
                .iter_mut()
                .zip(&self.constraints.gaps)
            {
                *target = gap / (h * h);
            }
            for value in residual {
                if !value.is_finite() {
                    return Err(ElementError::NotFinite);
                }
                self.residual_norm = self.residual_norm.max(h * value.abs());
            }
        }
        Ok(())
    }

    /// Relative change of the stage states that the rounding errors of the gaps cause, where it hides the
    /// convergence: far from the origin, and in short elements.
    fn rounding_of_gaps(&self) -> f64 {
        let rounding = 8.0 * self.gap_rounding / (self.length * self.speed());
        if rounding > ROUNDING { rounding } else { 0.0 }
    }

    /// Largest velocity of the element, about.
    fn speed(&self) -> f64 {
        let start = largest(&self.start.v);
        start.max(self.length * self.acceleration_scale) + f64::MIN_POSITIVE
    }

    /// Relative change of the stage states by the last Newton step (in `residual`).
    fn relative_change(&self) -> f64 {
        let (n, h, block) = (self.n, self.length, self.block());
        let multipliers = n + self.constraints.count();
        let (mut step, mut correction) = (0.0_f64, 0.0_f64);
        for change in self.residual.chunks_exact(block) {
            // Comparisons that let NaN through to the caller's test.
            for value in &change[..n] {
                step = if value.abs() <= step {
                    step
                } else {
                    value.abs()
                };
            }
            for eta in &change[multipliers..] {
                correction = if eta.abs() <= correction {
                    correction
                } else {
                    eta.abs()
                };
            }
        }
        let reach = largest(&self.corrections);
        let speed = self.speed();
        let position = largest(&self.start.q).max(h * speed) + f64::MIN_POSITIVE;
        let by_velocity = h * step / speed;
        let by_position = h * h * (step + reach * correction) / position;
        if by_velocity >= by_position {
            by_velocity
        } else {
            by_position
        }
    }
}

/// The largest size in `values`.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
}
