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
//! Unknowns of stage `m`: accelerations `A_m` (`n_q`), then `r_m` and `eta_m` (one each an active contact).

use crate::linalg::dense;
use crate::model::{Model, contact_point};
use crate::rk::ButcherTableau;

/// Newton iterations after which an element counts as not converged.
const MAX_ITERATIONS: usize = 15;
/// Relative change of the state that ends Newton's method.
const CONVERGED: f64 = 2e-16;
/// Relative change below which an iteration that no longer contracts has reached rounding error.
const ROUNDING: f64 = 1e-12;
/// Contraction above which the Jacobian is evaluated anew.
const SLOW: f64 = 0.05;

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
    active: Vec<usize>,
    start: State,
    length: f64,
    /// Correction directions `d_i(q_0)`, one row an active contact.
    corrections: Vec<f64>,
    /// Unknowns of all stages, `stages * block` with `block = n + 2 n_a`.
    unknowns: Vec<f64>,
    /// Inputs `x = (q, v, u[, t])` of all stages.
    inputs_of_stages: Vec<f64>,
    /// Contact points of the stage in work, one row an active contact.
    points: Vec<f64>,
    acceleration: Vec<f64>,
    free_jacobian: Vec<f64>,
    contact_jacobian: Vec<f64>,
    /// `d(a + sum d r)/dq` and `d a/dv` of one stage, row-major `n x n`.
    by_q: Vec<f64>,
    by_v: Vec<f64>,
    /// `d v_n / d q` of one stage, one row an active contact.
    normal_velocity_by_q: Vec<f64>,
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
    /// Largest stage residual seen before the last correction, in units of velocity.
    pub(crate) residual_norm: f64,
    pub(crate) counts: NewtonCounts,
}

impl<'a> FiniteElement<'a> {
    pub(crate) fn new(model: &'a dyn Model, tableau: &'a ButcherTableau) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contact_nonzeros = declaration
            .contacts
            .iter()
            .map(|contact| contact.jacobian.entries.len())
            .max()
            .unwrap_or(0);
        Self {
            model,
            tableau,
            n,
            inputs: declaration.inputs(),
            active: Vec::new(),
            start: State::default(),
            length: 0.0,
            corrections: Vec::new(),
            unknowns: Vec::new(),
            inputs_of_stages: vec![0.0; declaration.inputs() * tableau.stages()],
            points: Vec::new(),
            acceleration: vec![0.0; n],
            free_jacobian: vec![0.0; declaration.free_jacobian.entries.len()],
            contact_jacobian: vec![0.0; contact_nonzeros],
            by_q: vec![0.0; n * n],
            by_v: vec![0.0; n * n],
            normal_velocity_by_q: Vec::new(),
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
            residual_norm: 0.0,
            counts: NewtonCounts::default(),
        }
    }

    /// Unknowns of one stage.
    fn block(&self) -> usize {
        self.n + 2 * self.active.len()
    }

    /// Unknowns of the element without its length.
    pub(crate) fn variables(&self) -> usize {
        self.tableau.stages() * self.block()
    }

    /// Active contacts.
    pub(crate) fn active(&self) -> &[usize] {
        &self.active
    }

    /// Length of the solved element [s].
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Normal contact accelerations of the active contacts at stage `m`.
    pub(crate) fn stage_forces(&self, m: usize) -> &[f64] {
        let begin = m * self.block() + self.n;
        &self.unknowns[begin..begin + self.active.len()]
    }

    /// Input vector of stage `m` of the solved element.
    pub(crate) fn stage_input(&self, m: usize) -> &[f64] {
        &self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs]
    }

    /// Changes the contact mode; what was solved before no longer helps.
    pub(crate) fn set_mode(&mut self, active: &[usize]) {
        if self.active != active {
            self.active.clear();
            self.active.extend_from_slice(active);
        }
        let contacts = self.active.len();
        let block = self.n + 2 * contacts;
        let size = self.tableau.stages() * block;
        self.unknowns.clear();
        self.unknowns.resize(size, 0.0);
        self.residual.resize(size, 0.0);
        self.pivots.resize(size, 0);
        self.corrections.resize(contacts * self.n, 0.0);
        self.points
            .resize(contacts * contact_point::length(self.n), 0.0);
        self.normal_velocity_by_q.resize(contacts * self.n, 0.0);
        self.has_previous = false;
        self.factorized = false;
    }

    /// Solves the element of length `h` from `start` with controls `u`; the end state is in `end`.
    pub(crate) fn solve(&mut self, start: &State, h: f64, u: &[f64]) -> Result<(), ElementError> {
        self.start.copy_from(start);
        if (h - self.length).abs() > 0.2 * h {
            self.factorized = false;
        }
        self.length = h;
        for stage in self.inputs_of_stages.chunks_exact_mut(self.inputs) {
            stage[2 * self.n..2 * self.n + u.len()].copy_from_slice(u);
        }
        self.evaluate_start(u);
        self.predict(h);
        self.iterate()?;
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

    /// Evaluates the directions `d_i(q_0)` of the position corrections, and the free acceleration at the
    /// start where no previous element helps.
    fn evaluate_start(&mut self, u: &[f64]) {
        if self.active.is_empty() && self.has_previous {
            return;
        }
        let n = self.n;
        let mut x = std::mem::take(&mut self.inputs_of_stages);
        let first = &mut x[..self.inputs];
        first[..n].copy_from_slice(&self.start.q);
        first[n..2 * n].copy_from_slice(&self.start.v);
        if self.model.declaration().explicit_time {
            first[2 * n + u.len()] = self.start.time;
        }
        if !self.has_previous {
            self.model.free_acceleration(first, &mut self.acceleration);
        }
        let length = contact_point::length(n);
        for (k, &contact) in self.active.iter().enumerate() {
            let point = &mut self.points[k * length..(k + 1) * length];
            self.model.contact(contact, first, point);
            self.corrections[k * n..(k + 1) * n]
                .copy_from_slice(&point[contact_point::direction(n)..]);
        }
        self.inputs_of_stages = x;
    }

    /// Simplified Newton iterations: the factors are kept as long as they contract well.
    fn iterate(&mut self) -> Result<(), ElementError> {
        let mut last_change = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            self.evaluate_residual()?;
            if iteration == 0 && self.active.is_empty() && self.is_solved() {
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
                return Err(ElementError::NotFinite);
            }
            let contraction = change / last_change;
            if change <= CONVERGED
                || (iteration > 0 && contraction < 1.0 && change * contraction <= 0.1 * CONVERGED)
                || (change <= ROUNDING && contraction >= 0.3)
            {
                self.update_stages();
                return Ok(());
            }
            if contraction > SLOW {
                self.factorized = false;
            }
            last_change = change;
        }
        self.factorized = false;
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
        let (n, h, contacts) = (self.n, self.length, self.active.len());
        let block = n + 2 * contacts;
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
                    for (i, eta) in unknown[n + contacts..].iter().enumerate() {
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

    /// Residuals of all stages: `A - a - sum d r`, `v_n / h`, `g / h^2`.
    fn evaluate_residual(&mut self) -> Result<(), ElementError> {
        self.update_stages();
        let (n, h, contacts) = (self.n, self.length, self.active.len());
        let block = n + 2 * contacts;
        let length = contact_point::length(n);
        self.residual_norm = 0.0;
        self.acceleration_scale = 0.0;
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
            for (i, &contact) in self.active.iter().enumerate() {
                let point = &mut self.points[i * length..(i + 1) * length];
                self.model.contact(contact, x, point);
                let direction = &point[contact_point::direction(n)..];
                for k in 0..n {
                    let force = direction[k] * unknown[n + i];
                    residual[k] -= force;
                    self.acceleration_scale = self.acceleration_scale.max(force.abs());
                }
                residual[n + i] = point[contact_point::NORMAL_VELOCITY] / h;
                residual[n + contacts + i] = point[contact_point::GAP] / (h * h);
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

    /// The Newton matrix at the present stages.
    fn assemble(&mut self) {
        let (n, h, contacts) = (self.n, self.length, self.active.len());
        let block = n + 2 * contacts;
        let stages = self.tableau.stages();
        let size = stages * block;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        for m in 0..stages {
            self.evaluate_stage_jacobian(m);
            let length = contact_point::length(n);
            for j in 0..stages {
                let first = h * self.tableau.a(m, j);
                let second = h * h * self.tableau.a_squared(m, j);
                let rows = m * block;
                let columns = j * block;
                for row in 0..n {
                    let line = &mut self.matrix[(rows + row) * size + columns..][..block];
                    let by_q = &self.by_q[row * n..(row + 1) * n];
                    let by_v = &self.by_v[row * n..(row + 1) * n];
                    for (entry, (q, v)) in line.iter_mut().zip(by_q.iter().zip(by_v)) {
                        *entry -= second * q + first * v;
                    }
                    for i in 0..contacts {
                        let correction: f64 = (0..n)
                            .map(|k| self.by_q[row * n + k] * self.corrections[i * n + k])
                            .sum();
                        line[n + contacts + i] -= h * first * correction;
                    }
                    if m == j {
                        line[row] += 1.0;
                        for (i, point) in self.points.chunks_exact(length).enumerate() {
                            line[n + i] -= point[contact_point::direction(n) + row];
                        }
                    }
                }
                for i in 0..contacts {
                    let normal = &self.points[i * length + contact_point::NORMAL..][..n];
                    let turning = &self.normal_velocity_by_q[i * n..(i + 1) * n];
                    for k in 0..n {
                        let velocity_row = (rows + n + i) * size + columns;
                        let gap_row = (rows + n + contacts + i) * size + columns;
                        self.matrix[velocity_row + k] =
                            (second * turning[k] + first * normal[k]) / h;
                        self.matrix[gap_row + k] = second * normal[k] / (h * h);
                    }
                    for other in 0..contacts {
                        let correction = &self.corrections[other * n..(other + 1) * n];
                        let along: f64 = normal.iter().zip(correction).map(|(a, b)| a * b).sum();
                        let turned: f64 = turning.iter().zip(correction).map(|(a, b)| a * b).sum();
                        let column = columns + n + contacts + other;
                        self.matrix[(rows + n + i) * size + column] = first * turned;
                        self.matrix[(rows + n + contacts + i) * size + column] =
                            self.tableau.a(m, j) * along;
                    }
                }
            }
        }
    }

    /// Derivatives of the right-hand side and the contact rows at stage `m`.
    fn evaluate_stage_jacobian(&mut self, m: usize) {
        let n = self.n;
        let declaration = self.model.declaration();
        let x = &self.inputs_of_stages[m * self.inputs..(m + 1) * self.inputs];
        self.by_q.fill(0.0);
        self.by_v.fill(0.0);
        self.model.free_jacobian(x, &mut self.free_jacobian);
        for (&(row, column), value) in declaration
            .free_jacobian
            .entries
            .iter()
            .zip(&self.free_jacobian)
        {
            let (row, column) = (row as usize, column as usize);
            if column < n {
                self.by_q[row * n + column] += value;
            } else if column < 2 * n {
                self.by_v[row * n + column - n] += value;
            }
        }
        let length = contact_point::length(n);
        self.normal_velocity_by_q.fill(0.0);
        for (i, &contact) in self.active.iter().enumerate() {
            self.model
                .contact(contact, x, &mut self.points[i * length..(i + 1) * length]);
            let entries = declaration.contacts[contact].jacobian.entries;
            let values = &mut self.contact_jacobian[..entries.len()];
            self.model.contact_jacobian(contact, x, values);
            let r = self.unknowns[m * (n + 2 * self.active.len()) + n + i];
            for (&(row, column), value) in entries.iter().zip(&*values) {
                let (row, column) = (row as usize, column as usize);
                if column >= n {
                    continue;
                }
                match row {
                    0 => {}
                    1 => self.normal_velocity_by_q[i * n + column] = *value,
                    _ => self.by_q[(row - 2) * n + column] += r * value,
                }
            }
        }
    }

    /// Relative change of the stage states by the last Newton step (in `residual`).
    fn relative_change(&self) -> f64 {
        let (n, h, contacts) = (self.n, self.length, self.active.len());
        let block = n + 2 * contacts;
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
            for eta in &change[n + contacts..] {
                correction = if eta.abs() <= correction {
                    correction
                } else {
                    eta.abs()
                };
            }
        }
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let reach = largest(&self.corrections);
        let speed = largest(&self.start.v).max(h * self.acceleration_scale) + f64::MIN_POSITIVE;
        let position = largest(&self.start.q).max(h * speed) + f64::MIN_POSITIVE;
        let by_velocity = h * step / speed;
        let by_position = h * h * (step + reach * correction) / position;
        if by_velocity >= by_position {
            by_velocity
        } else {
            by_position
        }
    }

    /// The end state; without a stage at the end of the element it is projected on the constraints, which
    /// is the boundary variable of the scheme and restores its order (Ascher, Petzold 1991).
    fn finish(&mut self) -> Result<(), ElementError> {
        let n = self.n;
        let stages = self.tableau.stages();
        self.end.time = self.start.time + self.length;
        if self.tableau.stiffly_accurate() {
            let last = &self.inputs_of_stages[(stages - 1) * self.inputs..];
            self.end.q.copy_from_slice(&last[..n]);
            self.end.v.copy_from_slice(&last[n..2 * n]);
            return Ok(());
        }
        let block = self.block();
        let contacts = self.active.len();
        for k in 0..n {
            let (mut first, mut second) = (0.0, 0.0);
            for j in 0..stages {
                let unknown = &self.unknowns[j * block..(j + 1) * block];
                first += self.tableau.b()[j] * unknown[k];
                second += self.tableau.b_times_a()[j] * unknown[k];
                for (i, eta) in unknown[n + contacts..].iter().enumerate() {
                    second += self.tableau.b()[j] * eta * self.corrections[i * n + k];
                }
            }
            let h = self.length;
            self.end.v[k] = self.start.v[k] + h * first;
            self.end.q[k] = self.start.q[k] + h * (self.start.v[k] + h * second);
        }
        if contacts > 0 {
            self.project_end()?;
        }
        Ok(())
    }

    /// Moves the end state onto `g = 0`, `v_n = 0` along the contact directions.
    fn project_end(&mut self) -> Result<(), ElementError> {
        let (n, contacts) = (self.n, self.active.len());
        let length = contact_point::length(n);
        let mut x = self.stage_input(self.tableau.stages() - 1).to_vec();
        if self.model.declaration().explicit_time {
            x[self.inputs - 1] = self.end.time;
        }
        let mut matrix = vec![0.0; contacts * contacts];
        let mut pivots = vec![0; contacts];
        let mut shift = vec![0.0; contacts];
        let scale = self.end.q.iter().fold(1.0_f64, |s, q| s.max(q.abs()));
        for iteration in 0..MAX_ITERATIONS {
            x[..n].copy_from_slice(&self.end.q);
            x[n..2 * n].copy_from_slice(&self.end.v);
            let mut gap = 0.0_f64;
            for (i, &contact) in self.active.iter().enumerate() {
                let point = &mut self.points[i * length..(i + 1) * length];
                self.model.contact(contact, &x, point);
                shift[i] = point[contact_point::GAP];
                gap = gap.max(shift[i].abs());
            }
            for i in 0..contacts {
                for j in 0..contacts {
                    let normal = &self.points[i * length + contact_point::NORMAL..][..n];
                    let direction = &self.points[j * length + contact_point::direction(n)..][..n];
                    matrix[i * contacts + j] =
                        normal.iter().zip(direction).map(|(a, b)| a * b).sum();
                }
            }
            dense::factorize(&mut matrix, &mut pivots).map_err(|_| ElementError::Singular)?;
            if gap <= 4.0 * f64::EPSILON * scale || iteration + 1 == MAX_ITERATIONS {
                for (i, value) in shift.iter_mut().enumerate() {
                    *value = self.points[i * length + contact_point::NORMAL_VELOCITY];
                }
                dense::solve(&matrix, &pivots, &mut shift);
                self.subtract_along_directions(&shift, false);
                return Ok(());
            }
            dense::solve(&matrix, &pivots, &mut shift);
            self.subtract_along_directions(&shift, true);
        }
        Ok(())
    }

    fn subtract_along_directions(&mut self, shift: &[f64], positions: bool) {
        let n = self.n;
        let length = contact_point::length(n);
        let target = if positions {
            &mut self.end.q
        } else {
            &mut self.end.v
        };
        for (i, value) in shift.iter().enumerate() {
            let direction = &self.points[i * length + contact_point::direction(n)..][..n];
            for (component, d) in target.iter_mut().zip(direction) {
                *component -= d * value;
            }
        }
    }

    /// Embedded error estimate of order `s`: the defect of the collocation polynomials at the start of the
    /// element, `h (k_0 - p(0)) / s^2`, relative to `tolerance` times one plus the size of the component.
    /// `acceleration` is the true acceleration at the start. Source: Hairer, Wanner, Solving ODEs II,
    /// section IV.8, for any number of stages.
    pub(crate) fn error_ratio(&self, acceleration: &[f64], tolerance: f64) -> f64 {
        let (n, stages, block) = (self.n, self.tableau.stages(), self.block());
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        self.tableau.lagrange_values(0.0, &mut values[..stages]);
        let weight = self.length / (stages * stages) as f64;
        let mut ratio = 0.0_f64;
        for (k, &start) in acceleration.iter().enumerate() {
            let (mut by_velocity, mut by_position) = (-start, -self.start.v[k]);
            for (j, value) in values[..stages].iter().enumerate() {
                by_velocity += value * self.unknowns[j * block + k];
                by_position += value * self.inputs_of_stages[j * self.inputs + n + k];
            }
            ratio = ratio
                .max(weight * by_velocity.abs() / (1.0 + self.start.v[k].abs()))
                .max(weight * by_position.abs() / (1.0 + self.start.q[k].abs()));
        }
        ratio / tolerance
    }

    /// State inside the solved element by its collocation polynomials; `weights` are the dense output
    /// weights at that place.
    pub(crate) fn interpolate(&self, theta: f64, weights: &[f64], x: &mut [f64]) {
        let (n, h, contacts) = (self.n, self.length, self.active.len());
        let block = n + 2 * contacts;
        x.copy_from_slice(self.stage_input(0));
        for k in 0..n {
            let (mut velocity, mut position) = (0.0, 0.0);
            for (j, weight) in weights.iter().enumerate() {
                let unknown = &self.unknowns[j * block..(j + 1) * block];
                velocity += weight * unknown[k];
                position += weight * self.inputs_of_stages[j * self.inputs + n + k];
                for (i, eta) in unknown[n + contacts..].iter().enumerate() {
                    position += weight * h * eta * self.corrections[i * n + k];
                }
            }
            x[k] = self.start.q[k] + h * position;
            x[n + k] = self.start.v[k] + h * velocity;
        }
        if self.model.declaration().explicit_time {
            x[self.inputs - 1] = self.start.time + theta * h;
        }
    }
}
