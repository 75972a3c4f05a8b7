//! The state of a run, its evaluation, and what is recorded of it.

use super::detector::Detector;
use super::settings::Fesd;
use super::stop::Stop;
use crate::fesd::active_contact::{ActiveContact, force_count};
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::{FiniteElement, MotionSize, State};
use crate::model::{ControlPiece, ImpactLaw, Model};
use crate::rk::ButcherTableau;
use crate::simulation::{
    ContactMode, ControlSignal, Counts, Event, InitialValueProblem, ProblemSize, Residuals,
    Trajectory,
};

/// Impacts that raised the kinetic energy.
#[derive(Debug, Clone, Copy)]
pub(super) struct EnergyGains {
    pub(super) count: usize,
    /// Time \[s\] and contact of the first one.
    pub(super) first: (f64, usize),
    /// Kinetic energies before and after the first one \[J\].
    pub(super) energies: (f64, f64),
}

/// Bounce cascades of one contact that were ended.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cascades {
    pub(super) count: usize,
    /// Time of the first one \[s\].
    pub(super) first: f64,
    /// Largest height that a bounce left out would have reached.
    pub(super) height: f64,
}

fn restitution(model: &dyn Model, contact: usize) -> f64 {
    match model.declaration().contacts[contact].law {
        ImpactLaw::Inelastic => 0.0,
        ImpactLaw::Restitution => model.restitution(contact),
    }
}

pub(super) struct Driver<'a> {
    pub(super) settings: &'a Fesd,
    pub(super) model: &'a dyn Model,
    pub(super) controls: &'a ControlSignal,
    pub(super) horizon: f64,
    pub(super) n: usize,
    pub(super) all_contacts: Vec<usize>,
    pub(super) element: FiniteElement<'a>,
    /// Element used to look at the one after a take-off.
    pub(super) next_element: FiniteElement<'a>,
    pub(super) contacts: Contacts<'a>,
    pub(super) detector: Detector<'a>,
    pub(super) tableau: &'a ButcherTableau,
    pub(super) state: State,
    pub(super) segment_start: State,
    pub(super) numerical_time: f64,
    pub(super) active: Vec<ActiveContact>,
    /// Controls at the present state.
    pub(super) u: Vec<f64>,
    /// The controls over time, until they jump or change their slope.
    pub(super) piece: ControlPiece,
    pub(super) x: Vec<f64>,
    pub(super) gaps: Vec<f64>,
    /// Normal velocities of all contacts at the present state.
    pub(super) velocities: Vec<f64>,
    /// Sliding velocities of all contacts at the present state, 0 for those without friction.
    pub(super) sliding: Vec<f64>,
    /// Forces of the active contacts at the present state: `r` of each, then `s` of those that stick.
    pub(super) forces: Vec<f64>,
    /// Acceleration with contact forces at the present state.
    pub(super) acceleration: Vec<f64>,
    /// Acceleration at the start of the segment.
    pub(super) segment_acceleration: Vec<f64>,
    /// Largest values of the motion so far.
    pub(super) motion: MotionSize,
    /// Sum of the errors of the elements, estimated, relative to the motion.
    pub(super) error_estimate: f64,
    /// Error estimate that an element may have; none: elements of equal length.
    pub(super) local_tolerance: Option<f64>,
    /// Whether the trajectory is kept, or its end only.
    pub(super) keeps_trajectory: bool,
    /// Why the last attempt at a segment failed for the model's sake.
    pub(super) not_finite: bool,
    /// Element length that the error control proposes.
    pub(super) proposed_length: f64,
    pub(super) force_row: Vec<f64>,
    /// Whether a contact declares friction.
    pub(super) rough: bool,
    /// Coefficients of restitution.
    pub(super) restitution: Vec<f64>,
    /// Ends of bounce cascades, one entry a contact.
    pub(super) cascades: Vec<Cascades>,
    pub(super) energy_gains: Option<EnergyGains>,
    /// Modes of the contacts right after the start.
    pub(super) initial_modes: Vec<ContactMode>,
    pub(super) events: Vec<Event>,
    pub(super) trajectory: Trajectory,
    pub(super) residuals: Residuals,
    pub(super) size: ProblemSize,
    pub(super) counts: Counts,
    pub(super) notes: Vec<String>,
}

impl<'a> Driver<'a> {
    pub(super) fn new(
        settings: &'a Fesd,
        tableau: &'a ButcherTableau,
        model: &'a dyn Model,
        problem: &'a InitialValueProblem,
    ) -> Self {
        let declaration = model.declaration();
        let contacts = declaration.contacts.len();
        let state = State {
            time: 0.0,
            q: problem.q.clone(),
            v: problem.v.clone(),
        };
        Self {
            settings,
            model,
            controls: &problem.controls,
            horizon: problem.horizon,
            n: declaration.coordinates.len(),
            all_contacts: (0..contacts).collect(),
            element: settings.element(model, tableau),
            next_element: settings.element(model, tableau),
            contacts: Contacts::new(model),
            detector: Detector::new(model, tableau),
            tableau,
            segment_start: state.clone(),
            state,
            numerical_time: 0.0,
            active: Vec::with_capacity(contacts),
            u: vec![0.0; declaration.controls.len()],
            piece: ControlPiece::default(),
            x: problem.input(model),
            gaps: vec![0.0; contacts],
            velocities: vec![0.0; contacts],
            sliding: vec![0.0; contacts],
            forces: Vec::with_capacity(contacts),
            acceleration: vec![0.0; declaration.coordinates.len()],
            segment_acceleration: vec![0.0; declaration.coordinates.len()],
            motion: MotionSize::new(&problem.q, &problem.v),
            error_estimate: 0.0,
            local_tolerance: None,
            keeps_trajectory: true,
            not_finite: false,
            proposed_length: problem.horizon,
            force_row: vec![0.0; contacts],
            rough: declaration.contacts.iter().any(|c| c.friction.is_some()),
            restitution: (0..contacts).map(|i| restitution(model, i)).collect(),
            cascades: vec![Cascades::default(); contacts],
            energy_gains: None,
            initial_modes: Vec::new(),
            events: Vec::new(),
            trajectory: Trajectory::default(),
            residuals: Residuals::default(),
            size: ProblemSize::default(),
            counts: Counts::default(),
            notes: Vec::new(),
        }
    }

    /// The same run with element lengths that keep the error estimate of each element below `local_tolerance`.
    pub(super) fn controlled(mut self, local_tolerance: f64) -> Self {
        self.local_tolerance = Some(local_tolerance);
        self
    }

    /// The same run without a trajectory but its end.
    pub(super) fn forgetful(mut self) -> Self {
        self.keeps_trajectory = false;
        self
    }

    pub(super) fn take_piece(&mut self, time: f64) {
        self.controls
            .take_piece(time, self.u.len(), &mut self.piece);
        self.piece.write(time, &mut self.u);
        self.contacts.set_control_slopes(self.piece.slopes());
    }

    /// Adds the error of the solved element where no tolerance controls it. Its estimate has order `s`, the
    /// result about twice that, as in the code RADAU of Hairer and Wanner.
    fn add_error(&mut self) {
        if self.local_tolerance.is_none() {
            let error = self
                .element
                .relative_error(&self.acceleration, &self.motion);
            self.error_estimate += reached(error, self.tableau.stages());
        }
    }

    /// Makes the solved element part of the trajectory.
    pub(super) fn accept_element(&mut self) -> Result<(), Stop> {
        let stages = self.tableau.stages();
        let mut rates = [0.0; ButcherTableau::MAX_STAGES];
        for (m, rate) in rates[..stages].iter_mut().enumerate() {
            *rate = self
                .element
                .numerical_rate(m, self.settings.auxiliary_acceleration);
        }
        if self.local_tolerance.is_some() && self.keeps_trajectory {
            self.record_stages(&rates[..stages]);
        }
        let weights = self.tableau.b().iter().copied();
        let length = self.element.length();
        self.numerical_time += length * self.element.numerical_length(&rates[..stages], weights);
        self.add_error();
        self.state.copy_from(&self.element.end);
        self.motion.include(&self.state.q, &self.state.v);
        self.residuals.primal = self.residuals.primal.max(self.element.residual_norm);
        self.counts.elements += 1;
        self.evaluate_state()?;
        self.record();
        Ok(())
    }

    /// Contacts and forces at the present state; measures the residuals there.
    pub(super) fn evaluate_state(&mut self) -> Result<(), ModeError> {
        self.write_input();
        self.contacts.evaluate(&self.x, 0..self.all_contacts.len());
        self.contacts.remember_sizes(&self.x);
        self.contacts.remember_scales();
        self.forces.resize(force_count(&self.active), 0.0);
        self.contacts
            .contact_forces(&self.active, &mut self.forces)?;
        self.contacts
            .constrained_acceleration(&self.active, &self.forces, &mut self.acceleration);
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        if !finite(&self.acceleration) || !finite(&self.forces) {
            return Err(ModeError::NotFinite);
        }
        for &i in &self.all_contacts {
            self.gaps[i] = self.contacts.gap(i);
            self.velocities[i] = self.contacts.normal_velocity(i);
            if self.contacts.friction(i) > 0.0 {
                self.sliding[i] = self.contacts.sliding_velocity(i);
            }
        }
        if !finite(&self.gaps) || !finite(&self.velocities) {
            return Err(ModeError::NotFinite);
        }
        let frictions = self.contacts.frictions(&self.active, &self.forces);
        for ((held, &r), s) in self.active.iter().zip(&self.forces).zip(frictions) {
            let i = held.contact;
            let (gap, velocity) = (self.gaps[i].abs(), self.velocities[i].abs());
            let residuals = &mut self.residuals;
            residuals.primal = residuals.primal.max(gap).max(velocity);
            residuals.complementarity = residuals.complementarity.max(gap * r.abs());
            residuals.dual = residuals.dual.max(-r);
            if self.contacts.friction(i) > 0.0 {
                let sense = held.tangential.sense();
                if held.sticks() {
                    residuals.primal = residuals.primal.max(self.sliding[i].abs());
                }
                residuals.dual = residuals
                    .dual
                    .max(s.abs() - self.contacts.friction(i) * r)
                    .max(-sense * self.sliding[i]);
            }
        }
        for &gap in &self.gaps {
            self.residuals.dual = self.residuals.dual.max(-gap);
        }
        Ok(())
    }

    pub(super) fn write_input(&mut self) {
        let n = self.n;
        self.x[..n].copy_from_slice(&self.state.q);
        self.x[n..2 * n].copy_from_slice(&self.state.v);
        self.piece.write(self.state.time, &mut self.u);
        self.x[2 * n..2 * n + self.u.len()].copy_from_slice(&self.u);
        if self.model.declaration().explicit_time
            && let Some(time) = self.x.last_mut()
        {
            *time = self.state.time;
        }
    }

    /// Records the inner stages of the solved element; `rates` are those of numerical time.
    fn record_stages(&mut self, rates: &[f64]) {
        let (present, length) = (self.numerical_time, self.element.length());
        for m in 0..self.tableau.stages() {
            let c = self.tableau.c()[m];
            if c >= 1.0 {
                break;
            }
            let weights = (0..rates.len()).map(|j| self.tableau.a(m, j));
            let past = length * self.element.numerical_length(rates, weights);
            self.x.copy_from_slice(self.element.stage_input(m));
            let held = self.active.iter().map(|held| held.contact);
            self.contacts.evaluate_contacts(&self.x, held);
            let forces = self.element.stage_constraint_forces(m).to_vec();
            self.numerical_time = present + past;
            self.push_instant(self.element.stage_time(m), &forces);
        }
        self.numerical_time = present;
    }

    /// Records the present state.
    pub(super) fn record(&mut self) {
        if self.keeps_trajectory {
            self.write_input();
            let forces = std::mem::take(&mut self.forces);
            self.push_instant(self.state.time, &forces);
            self.forces = forces;
        }
    }

    /// Appends the instant of the input vector, at which the active contacts carry `forces`.
    fn push_instant(&mut self, time: f64, forces: &[f64]) {
        let n = self.n;
        self.force_row.fill(0.0);
        for (held, &r) in self.active.iter().zip(forces) {
            self.force_row[held.contact] = self.contacts.force(held.contact, r);
        }
        self.trajectory.push(
            time,
            self.numerical_time,
            &self.x[..n],
            &self.x[n..2 * n],
            &self.x[2 * n..2 * n + self.u.len()],
            &self.force_row,
        );
        if self.rough {
            let mut row = vec![0.0; self.all_contacts.len()];
            let frictions = self.contacts.frictions(&self.active, forces);
            for (held, s) in self.active.iter().zip(frictions) {
                row[held.contact] = self.contacts.force(held.contact, s);
            }
            self.trajectory.friction_force.push(row);
        }
    }

    pub(super) fn note(&mut self, text: &str) {
        if !self.notes.iter().any(|note| note == text) {
            self.notes.push(text.into());
        }
    }
}

/// Error of an element with `stages` stages whose estimate, which has order `s`, is `estimate`: the tenth power
/// of ten in hand, and the power `2 s / (s + 1)` since the result has about twice the order.
pub(super) fn reached(estimate: f64, stages: usize) -> f64 {
    let s = stages as f64;
    (10.0 * estimate).powf(2.0 * s / (s + 1.0))
}
