//! The stepping loop: elements, switches, impacts, and what is recorded of them.

use super::settings::{Fesd, StepFormulation};
use super::stop::Stop;
use super::switch::Detector;
use crate::fesd::active_contact::{ActiveContact, force_count};
use crate::fesd::contacts::{Contacts, ModeError, dot};
use crate::fesd::finite_element::{ElementError, FiniteElement, MotionSize, State};
use crate::model::{ControlPiece, ImpactLaw, Model};
use crate::rk::ButcherTableau;
use crate::simulation::watch::Watch;
use crate::simulation::{
    ContactMode, ControlSignal, Counts, Event, InitialValueProblem, ProblemSize, Residuals,
    Seconds, Simulation, SimulationStatus, Trajectory,
};
use crate::time_freezing::clock;
use cpu_time::ThreadTime;

/// Halvings of the elements of a step before it counts as failed.
const MAX_HALVINGS: usize = 8;
/// The same under error control, where each halves the length that lasts.
const MAX_CONTROLLED_HALVINGS: usize = 24;
/// Switches within a hundredth of the horizon before the contact mode counts as ambiguous. A ball that keeps
/// all but a hundredth of its speed takes about 1,400 bounces to rest.
pub(super) const MAX_SWITCHES: usize = 5_000;

/// Attempts at a segment within a hundredth of the horizon: of them some are rejected, some lead to a switch.
const MAX_ATTEMPTS: usize = 20_000;

/// Largest share of the horizon that an element may take under error control: a flight has no error, but
/// passes over ground.
const LONGEST: f64 = 0.1;
/// Largest share of the horizon that the first element may take, for a tolerance of one.
const FIRST: f64 = 0.25;
/// Share of the horizon below which slow starts do not shorten the first element.
const LEAST_FIRST: f64 = 1e-9;
/// Error estimate of a run without error control above which it says so: what a curve in a figure shows.
const SUSPECT_ESTIMATE: f64 = 1e-3;
/// Largest and smallest change of the element length by the error control.
const LENGTH_CHANGE: (f64, f64) = (0.2, 4.0);

/// How a segment ended.
enum Segment {
    /// At its planned end.
    Completed,
    /// At a switch, which was carried out.
    Switched,
    /// Nowhere: the error estimate asks for a shorter element.
    Rejected,
}

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
    /// Time of the last impact of each contact [s].
    pub(super) struck: Vec<f64>,
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
            element: FiniteElement::new(model, tableau),
            next_element: FiniteElement::new(model, tableau),
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
            struck: vec![f64::NEG_INFINITY; contacts],
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

    /// Runs to the horizon, or until it fails; returns the result and the size of its motion.
    pub(super) fn run(mut self, watch: &mut Watch<'_>) -> (Simulation, MotionSize) {
        let clock = ThreadTime::now();
        let status = match self.steps(watch) {
            Ok(()) => SimulationStatus::Solved,
            Err(status) => status,
        };
        if !self.keeps_trajectory {
            self.keeps_trajectory = true;
            self.record();
        }
        let controlled = self.local_tolerance.is_some();
        if !controlled && self.error_estimate > SUSPECT_ESTIMATE {
            self.note(&format!(
                "the error is estimated at {:.0e} of the largest values: take more steps, or leave the number \
                 of steps to the error control",
                self.error_estimate
            ));
        }
        self.note_cascades();
        self.note_energy_gains();
        let newton = self.element.counts;
        let other = self.next_element.counts;
        self.counts.newton = newton.iterations + other.iterations;
        self.counts.factorizations = newton.factorizations + other.factorizations;
        self.counts.evaluations =
            newton.evaluations + other.evaluations + self.contacts.evaluations;
        let simulation = Simulation {
            declaration: self.model.declaration(),
            status,
            error_estimate: (!controlled).then_some(self.error_estimate),
            initial_modes: self.initial_modes,
            events: self.events,
            trajectory: self.trajectory,
            residuals: self.residuals,
            size: self.size,
            counts: self.counts,
            seconds: Seconds {
                total: clock.elapsed().as_secs_f64(),
                ..Seconds::default()
            },
            notes: self.notes,
        };
        (simulation, self.motion)
    }

    /// Steps over the horizon.
    fn step_count(&self) -> usize {
        match self.local_tolerance {
            None => self.settings.steps.unwrap_or(Fesd::DEFAULT_STEPS),
            Some(_) => self.settings.steps.unwrap_or(1),
        }
    }

    fn steps(&mut self, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
        self.take_piece(0.0);
        self.active.clear();
        if let Err(error) = self.settle(&[]) {
            self.record();
            return Err(self.stopped(0, &Stop::Mode(error)));
        }
        self.initial_modes = self.modes();
        self.record();
        self.propose_first_length();
        let steps = self.step_count();
        for step in 0..steps {
            let end = if step + 1 == steps {
                self.horizon
            } else {
                self.horizon * (step + 1) as f64 / steps as f64
            };
            self.step(step, end, watch)?;
            watch.reach(self.state.time, self.counts.elements, &mut self.trajectory)?;
        }
        Ok(())
    }

    /// First element length: a share of the horizon and of the time in which the velocity changes, which falls
    /// with the tolerance, so that two runs do not share their first elements.
    fn propose_first_length(&mut self) {
        let Some(tolerance) = self.local_tolerance else {
            return;
        };
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let share = tolerance.powf(1.0 / (self.tableau.stages() as f64 + 1.0));
        let mut length = FIRST * self.horizon;
        let (speed, acceleration) = (largest(&self.state.v), largest(&self.acceleration));
        if speed > 0.0 && acceleration > 0.0 {
            // What an impact leaves of a velocity may be rounding error, which says nothing of the motion that follows.
            length = length.min((speed / acceleration).max(LEAST_FIRST * self.horizon));
        }
        self.proposed_length = share * length;
    }

    /// Advances to `end`, with as many segments as there are switches and pieces of the controls.
    fn step(
        &mut self,
        step: usize,
        end: f64,
        watch: &mut Watch<'_>,
    ) -> Result<(), SimulationStatus> {
        let begin = self.state.time;
        let shortest = 1e-14 * self.horizon;
        let mut halvings = 0;
        let (mut switches, mut attempts) = (0, 0);
        let mut counted_from = begin;
        let mut size = ProblemSize::default();
        while end - self.state.time > shortest {
            watch.reach(self.state.time, self.counts.elements, &mut self.trajectory)?;
            self.take_up_controls(step)?;
            let segment_end = self
                .controls
                .next_break(self.state.time)
                .map_or(end, |next| next.min(end));
            if self.settings.formulation == StepFormulation::TimeFreezing {
                if let Err(stop) = self.solve_program(segment_end) {
                    return Err(self.stopped(step, &stop));
                }
                continue;
            }
            let (segment_end, elements) = self.plan(begin, segment_end, end, halvings);
            if self.state.time - counted_from > 0.01 * self.horizon {
                (switches, attempts) = (0, 0);
                counted_from = self.state.time;
            }
            attempts += 1;
            if self.counts.elements >= self.settings.most_elements {
                return Err(self.too_many(step));
            }
            let vanishes = self.local_tolerance.is_some() && self.proposed_length <= shortest;
            if attempts > MAX_ATTEMPTS || vanishes {
                return Err(self.too_short(step, segment_end));
            }
            match self.segment(segment_end, elements, shortest, &mut size) {
                Ok(Segment::Rejected) => {}
                Ok(Segment::Completed) if self.local_tolerance.is_some() => halvings = 0,
                Ok(Segment::Completed) => halvings = halvings.saturating_sub(1),
                Ok(Segment::Switched) => {
                    self.not_finite = false;
                    switches += 1;
                    if switches > MAX_SWITCHES {
                        return Err(self.unsettled(step));
                    }
                }
                Err(Stop::Mode(ModeError::NotFinite))
                | Err(Stop::Element(ElementError::NotFinite))
                    if halvings < self.most_halvings() =>
                {
                    halvings += 1;
                    self.not_finite = true;
                    self.shorten(segment_end);
                }
                Err(stop @ Stop::Mode(_)) => return Err(self.stopped(step, &stop)),
                Err(_) if halvings < self.most_halvings() => {
                    halvings += 1;
                    self.shorten(segment_end);
                }
                Err(_) if self.nearly_jams() => {
                    return Err(self.stopped(step, &Stop::Mode(ModeError::Jammed)));
                }
                Err(stop @ Stop::Element(ElementError::NotFinite)) => {
                    return Err(self.stopped(step, &stop));
                }
                Err(_) => {
                    if let Err(stop) = self.solve_program(segment_end) {
                        return Err(self.stopped(step, &stop));
                    }
                    halvings = 0;
                }
            }
        }
        self.state.time = end;
        if let Some(time) = self.trajectory.time.last_mut() {
            *time = end;
        }
        if size.variables > self.size.variables {
            self.size = size;
        }
        Ok(())
    }

    /// Halves the proposed length after a failed segment that ended at `end`.
    fn shorten(&mut self, end: f64) {
        if self.local_tolerance.is_some() {
            self.proposed_length = 0.5 * (end - self.segment_start.time);
        }
    }

    /// Halvings before a segment counts as failed.
    fn most_halvings(&self) -> usize {
        match self.local_tolerance {
            None => MAX_HALVINGS,
            Some(_) => MAX_CONTROLLED_HALVINGS,
        }
    }

    /// End and number of elements of the next segment: equal elements up to `segment_end`, or the length
    /// that the error control proposes.
    fn plan(&self, begin: f64, segment_end: f64, end: f64, halvings: usize) -> (f64, usize) {
        let remaining = segment_end - self.state.time;
        if self.local_tolerance.is_none() {
            let share = remaining / (end - begin);
            let elements = (self.settings.elements as f64 * share).round() as usize;
            return (segment_end, elements.max(1) << halvings);
        }
        let length = self.proposed_length;
        if remaining <= 1.01 * length {
            (segment_end, 1)
        } else {
            // Two nearly equal elements rather than one and a sliver.
            (self.state.time + length.min(0.5 * remaining), 1)
        }
    }

    /// Updates the proposed element length from the error estimate of the solved element; true if the
    /// element must be shorter.
    fn control_error(&mut self) -> bool {
        let Some(tolerance) = self.local_tolerance else {
            return false;
        };
        let error = self
            .element
            .relative_error(&self.acceleration, &self.motion);
        let ratio = error / tolerance;
        let order = self.tableau.stages() as f64 + 1.0;
        let factor = 0.9 * ratio.max(1e-12).powf(-1.0 / order);
        let proposed = self.element.length() * factor.clamp(LENGTH_CHANGE.0, LENGTH_CHANGE.1);
        self.proposed_length = proposed.min(LONGEST * self.horizon);
        ratio > 1.0
    }

    fn take_piece(&mut self, time: f64) {
        self.controls
            .take_piece(time, self.u.len(), &mut self.piece);
        self.piece.write(time, &mut self.u);
        self.contacts.set_control_slopes(self.piece.slopes());
    }

    /// Controls that hold from now on; a jump of theirs may change the contact mode.
    fn take_up_controls(&mut self, step: usize) -> Result<(), SimulationStatus> {
        if self.u.is_empty() {
            return Ok(());
        }
        let before = self.u.clone();
        // A jump within rounding error of the present time has been reached.
        let now = self.state.time + 4.0 * f64::EPSILON * self.horizon;
        self.take_piece(now);
        if self.controls.jumps() && before != self.u && self.state.time > 0.0 {
            if let Err(error) = self.settle(&[]) {
                return Err(self.stopped(step, &Stop::Mode(error)));
            }
            self.record();
        }
        Ok(())
    }

    /// Solves `elements` elements of equal length up to `end`, or up to the first switch, which is then
    /// located, with the elements before it of equal length again, and carried out.
    fn segment(
        &mut self,
        end: f64,
        elements: usize,
        shortest: f64,
        size: &mut ProblemSize,
    ) -> Result<Segment, Stop> {
        self.segment_start.copy_from(&self.state);
        self.segment_acceleration.clone_from(&self.acceleration);
        let error_estimate = self.error_estimate;
        let recorded = self.trajectory.time.len();
        let start_numerical_time = self.numerical_time;
        let length = (end - self.state.time) / elements as f64;
        let mut violation = None;
        for count in 1..=elements {
            self.element.solve(&self.state, length, &self.piece)?;
            if self.control_error() {
                return Ok(Segment::Rejected);
            }
            if let Some(switch) = self.violation()? {
                violation = Some((switch, count));
                break;
            }
            self.accept_element()?;
        }
        let Some((switch, count)) = violation else {
            self.add_size(elements, false, size);
            return Ok(Segment::Completed);
        };
        self.trajectory.truncate(recorded);
        self.numerical_time = start_numerical_time;
        self.error_estimate = error_estimate;
        self.state.copy_from(&self.segment_start);
        self.acceleration.clone_from(&self.segment_acceleration);
        let offset = (count - 1) as f64 + switch.theta;
        if offset * length <= shortest && self.holds_at_start(switch) {
            self.carry_out(switch)?;
            return Ok(Segment::Switched);
        }
        let located = match self.locate(switch, length, count, recorded) {
            Ok(located) => located,
            Err(stop) => {
                // Whoever tries again starts where this segment did.
                self.trajectory.truncate(recorded);
                self.numerical_time = start_numerical_time;
                self.state.copy_from(&self.segment_start);
                self.evaluate_state()?;
                return Err(stop);
            }
        };
        self.add_size(count, true, size);
        self.carry_out(located)?;
        Ok(Segment::Switched)
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
            let forces = self.element.stage_forces(m);
            *rate = clock::rate(forces, self.settings.auxiliary_acceleration);
        }
        if self.local_tolerance.is_some() && self.keeps_trajectory {
            self.record_stages(&rates[..stages]);
        }
        self.numerical_time += dot(self.tableau.b(), &rates[..stages]) * self.element.length();
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
        let (start, length) = (self.state.time, self.element.length());
        let present = self.numerical_time;
        for m in 0..self.tableau.stages() {
            let c = self.tableau.c()[m];
            if c >= 1.0 {
                break;
            }
            let past: f64 = (0..rates.len())
                .map(|j| self.tableau.a(m, j) * rates[j])
                .sum();
            self.x.copy_from_slice(self.element.stage_input(m));
            let held = self.active.iter().map(|held| held.contact);
            self.contacts.evaluate_contacts(&self.x, held);
            let forces = self.element.stage_constraint_forces(m).to_vec();
            self.numerical_time = present + past * length;
            self.push_instant(start + c * length, &forces);
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

    /// Size of the step's system: stage unknowns and one length an element.
    fn add_size(&self, elements: usize, switched: bool, size: &mut ProblemSize) {
        let stages = self.tableau.stages();
        let unknowns = elements * self.element.variables();
        let block = self.element.variables() / stages;
        let cones = (0..self.all_contacts.len()).filter(|&i| self.contacts.friction(i) > 0.0);
        // One condition on the force or the gap of each contact, one on friction or sliding velocity.
        let conditions = self.all_contacts.len() + cones.count();
        size.variables += unknowns + elements;
        // Equal lengths but one, which the end of the segment or the switch condition determines.
        size.equalities += unknowns + elements;
        size.inequalities += elements * stages * conditions;
        size.complementarities += elements * conditions;
        size.jacobian_nonzeros +=
            elements * stages * stages * block * block + elements + usize::from(switched);
    }
}

/// Error of an element with `stages` stages whose estimate, which has order `s`, is `estimate`: the tenth power
/// of ten in hand, and the power `2 s / (s + 1)` since the result has about twice the order.
pub(super) fn reached(estimate: f64, stages: usize) -> f64 {
    let s = stages as f64;
    (10.0 * estimate).powf(2.0 * s / (s + 1.0))
}
