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
//! which has index 2 as well, so that the order stays. The force `r_i` of dry friction is given, `r_i = D_i f(q, t)`; it has
//! neither `d_i` nor `eta_i`.
//!
//! *Joints* add no unknowns: the acceleration `a` contains their forces, so that they hold but for what collocation misses of `a`, and
//! the end state is projected onto them in the metric of the mass matrix, by no more than that.
//!
//! In *numerical time* ([`FiniteElement::in_numerical_time`]) the same equations are those of the time-freezing system in
//! a sliding mode, whose right-hand side a contact slows down by the speed of the clock (`numerical_time`).
//!
//! Unknowns of stage `m`: accelerations `A_m` (`n_q`), then the forces: `r_m` of each active contact and
//! `s_m` of each that sticks; then `eta_m`, one an active surface. [`newton`] solves for them, with the matrix of `assembly`
//! the end state of `end`, and its error by `local_error`.

mod assembly;
mod decoupled;
mod end;
pub(crate) mod local_error;
mod motion_size;
pub(crate) mod newton;
mod numerical_time;
pub(crate) mod size;
mod stage_clock;

pub(crate) use motion_size::MotionSize;

use super::constraints::Constraints;
use crate::contact::ActiveContact;
use crate::joints::Joints;
use crate::linalg::banded::{Banded, Entry};
use crate::linalg::products::largest;
use crate::model::{ControlPiece, Frame, Model};
use crate::rk::ButcherTableau;
use crate::time_freezing::clock;
use decoupled::Decoupled;
use stage_clock::StageClock;

/// Newton iterations after which an element counts as not converged.
const MAX_ITERATIONS: usize = 15;

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
    clock: StageClock,
    /// Input vector at the start.
    first: Vec<f64>,
    constraints: Constraints<'a>,
    /// None in a scene without.
    joints: Option<Joints<'a>>,
    /// Of scenes with joints.
    decoupled: Option<Decoupled>,
    /// Whether the present factors are those of stages taken apart.
    apart: bool,
    start: State,
    pub(crate) length: f64,
    /// Correction directions: those of the forces at `q_0`, one row a position that is held.
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
    /// The factors of a large matrix, if it `is_banded`, and its entries.
    band: Banded,
    is_banded: bool,
    entries: Vec<Entry>,
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
            clock: StageClock::default(),
            first: vec![0.0; declaration.inputs()],
            constraints: Constraints::new(model),
            joints: Joints::of(model),
            decoupled: declaration.joints.and_then(|_| Decoupled::of(tableau)),
            apart: false,
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
            band: Banded::default(),
            is_banded: false,
            entries: Vec::new(),
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

    /// This element in numerical time, with the acceleration `a_bar` of the auxiliary dynamics.
    pub(crate) fn in_numerical_time(mut self, auxiliary_acceleration: f64) -> Self {
        self.clock = StageClock::slowed(auxiliary_acceleration);
        self
    }

    /// Unknowns of one stage.
    fn block(&self) -> usize {
        self.n + self.constraints.count() + self.constraints.positions()
    }

    /// Unknowns of the element without its length.
    pub(crate) fn variables(&self) -> usize {
        self.tableau.stages() * self.block()
    }

    /// Active contacts.
    pub(crate) fn active(&self) -> &[ActiveContact] {
        self.constraints.active()
    }

    /// Normal contact accelerations of the active surfaces at stage `m`.
    pub(crate) fn stage_forces(&self, m: usize) -> &[f64] {
        let begin = m * self.block() + self.n;
        &self.unknowns[begin..begin + self.constraints.normals]
    }

    /// Forces of all constraints of contacts at stage `m`: normals, then the friction of contacts that stick.
    pub(crate) fn stage_constraint_forces(&self, m: usize) -> &[f64] {
        let begin = m * self.block() + self.n;
        &self.unknowns[begin..begin + self.constraints.count()]
    }

    /// Physical time of stage `m` of the solved element \[s\].
    pub(crate) fn stage_time(&self, m: usize) -> f64 {
        let passed = self.clock.passed(self.tableau, m);
        self.start.time + passed * self.length
    }

    /// Rate `d tau / d t` of numerical time at stage `m` of the solved element.
    pub(crate) fn numerical_rate(&self, m: usize, auxiliary_acceleration: f64) -> f64 {
        clock::rate(self.stage_forces(m), auxiliary_acceleration)
    }

    /// Numerical length of the solved element for a physical one of 1, weighted by `weights` of the stages (those of the
    /// scheme, or of one of its stages), where numerical time advances at the `rates`.
    pub(crate) fn numerical_length(
        &self,
        rates: &[f64],
        weights: impl Iterator<Item = f64>,
    ) -> f64 {
        let terms = weights.zip(rates).enumerate();
        terms
            .map(|(j, (w, rate))| w * self.clock.share(j) * rate)
            .sum()
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
        let normals = self.constraints.normals;
        let positions = self.constraints.positions();
        self.corrections.resize(positions * self.n, 0.0);
        self.clock.set_mode(self.tableau.stages(), normals);
        self.has_previous = false;
        self.factorized = false;
    }

    /// Sets the frames in which contacts in space slide.
    pub(crate) fn set_frames(&mut self, frames: &[Frame]) {
        self.constraints.set_frames(frames);
    }

    /// Lets the next solution start from the acceleration at the start alone, not from this one.
    pub(crate) fn forget(&mut self) {
        self.has_previous = false;
        self.factorized = false;
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

    /// Largest velocity of the element, about.
    fn speed(&self) -> f64 {
        let start = largest(&self.start.v);
        start.max(self.length * self.acceleration_scale) + f64::MIN_POSITIVE
    }

    /// Embedded error estimate of order `s`: the defect of the collocation polynomials at the start of the
    /// element, `h (k_0 - p(0)) / s^2`, relative to the `motion` with the element.
    /// `acceleration` is the true acceleration at the start. Source: Hairer, Wanner, Solving ODEs II,
    /// section IV.8, for any number of stages.
    pub(crate) fn relative_error(&self, acceleration: &[f64], motion: &MotionSize) -> f64 {
        let (n, stages, block, h) = (self.n, self.tableau.stages(), self.block(), self.length);
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        self.tableau.lagrange_values(0.0, &mut values[..stages]);
        let weight = h / (stages * stages) as f64;
        let (mut velocity, mut position, mut states) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mechanical = n - motion.states.len();
        let (rounding, cancelled) = (motion.rounding, self.cancelled_velocity());
        let beyond = |error: f64, rounding: f64, size: f64| (error - rounding).max(0.0) / size;
        for (k, &start) in acceleration.iter().enumerate() {
            let (mut by_velocity, mut by_position) = (-start, -self.start.v[k]);
            for (j, value) in values[..stages].iter().enumerate() {
                by_velocity += value * self.unknowns[j * block + k];
                by_position += value * self.inputs_of_stages[j * self.inputs + n + k];
            }
            if let Some(size) = k.checked_sub(mechanical).map(|state| motion.states[state]) {
                // A state is measured by itself, and nothing reads its integral.
                let size = size.max(self.end.v[k].abs()) + f64::MIN_POSITIVE;
                states = states.max(beyond(weight * by_velocity.abs(), cancelled, size));
                continue;
            }
            velocity = velocity.max(weight * by_velocity.abs());
            position = position.max(weight * by_position.abs());
        }
        // A start from rest is measured by the velocity that the element itself reaches.
        let speed = motion.speed.max(largest(&self.end.v[..mechanical])) + f64::MIN_POSITIVE;
        let distance = motion.distance.max(h * speed);
        beyond(velocity, rounding / h + cancelled, speed)
            .max(beyond(position, self.position_rounding(motion), distance))
            .max(states)
    }

    /// Velocity that rounding errors of accelerations that cancel leave.
    fn cancelled_velocity(&self) -> f64 {
        64.0 * f64::EPSILON * self.length * self.acceleration_scale
    }

    /// Rounding error of the coordinates of the solved element in the `motion`.
    pub(crate) fn position_rounding(&self, motion: &MotionSize) -> f64 {
        motion.rounding + self.length * self.cancelled_velocity()
    }

    /// State inside the solved element by its collocation polynomials; `weights` are the dense output
    /// weights at that place.
    ///
    /// In numerical time the place is that of the clock: the share of the physical length that has passed there.
    pub(crate) fn interpolate(&self, theta: f64, weights: &[f64], x: &mut [f64]) {
        let (n, h, block) = (self.n, self.length, self.block());
        let mut placed = [0.0; ButcherTableau::MAX_STAGES];
        let placed = &mut placed[..weights.len()];
        let weights = self.clock.weights_at(self.tableau, theta, weights, placed);
        let multipliers = n + self.constraints.count();
        x.copy_from_slice(self.stage_input(0));
        for k in 0..n {
            let (mut velocity, mut position) = (0.0, 0.0);
            for (j, weight) in weights.iter().enumerate() {
                let unknown = &self.unknowns[j * block..(j + 1) * block];
                let share = weight * self.clock.share(j);
                velocity += share * unknown[k];
                position += share * self.inputs_of_stages[j * self.inputs + n + k];
                for (i, eta) in unknown[multipliers..].iter().enumerate() {
                    position += weight * h * eta * self.corrections[i * n + k];
                }
            }
            x[k] = self.start.q[k] + h * position;
            x[n + k] = self.start.v[k] + h * velocity;
        }
        self.write_time(self.start.time + theta * h, x);
    }
}
