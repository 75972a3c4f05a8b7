//! The stepping loop: elements, switches, impacts, and what is recorded of them.

use super::mode_change::EnergyGains;
use super::switch::Detector;
use super::{Fesd, StepFormulation};
use crate::fesd::active_contact::{ActiveContact, force_count};
use crate::fesd::contacts::{Contacts, ModeError, Touching};
use crate::fesd::finite_element::{ElementError, FiniteElement, State};
use crate::model::{ControlPiece, ImpactLaw, Model};
use crate::rk::ButcherTableau;
use crate::simulation::watch::Watch;
use crate::simulation::{
    ContactMode, ControlSignal, Counts, Event, InitialValueProblem, ProblemSize, Residuals,
    Seconds, Simulation, SimulationStatus, Trajectory,
};
use crate::time_freezing::clock;
use cpu_time::ThreadTime;

/// Gap within which a contact takes part in an impact or a mode, relative to the largest coordinate.
pub(super) const TOUCHING_GAP: f64 = 1e-9;
/// Normal velocity that counts as zero, relative to the largest velocity.
const TOUCHING_VELOCITY: f64 = 1e-9;
/// Sliding velocity that counts as zero, relative to the largest velocity: where it vanishes is located to
/// rounding error.
const AT_REST: f64 = 1e-12;
/// Halvings of the elements of a step before it counts as failed.
const MAX_HALVINGS: usize = 8;
/// The same under error control, where each halves the length that lasts.
const MAX_CONTROLLED_HALVINGS: usize = 24;
/// Switches within a hundredth of the horizon before the contact mode counts as ambiguous.
const MAX_SWITCHES: usize = 200;

/// Attempts at a segment within a hundredth of the horizon: of them some are rejected, some lead to a switch.
const MAX_ATTEMPTS: usize = 10_000;

/// Largest share of the horizon that an element may take under error control: a flight has no error, but
/// passes over ground.
const LONGEST: f64 = 0.1;
/// Relative error estimate of an element above which a run without error control says so. The estimate has
/// order `s`, the result about twice that.
const SUSPECT_ESTIMATE: f64 = 1e-1;
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

/// Why a segment could not be completed.
pub(super) enum Stop {
    /// An element has no solution; shorter elements may have.
    Element(ElementError),
    /// The contact mode could not be determined.
    Mode(ModeError),
    /// A switch could not be located; shorter elements may help.
    Location,
    /// A gap varies too fast for the samples of an element; shorter elements help.
    Unresolved,
    /// The complementarity problem of the step was not solved.
    Program(&'static str),
}

impl From<ElementError> for Stop {
    fn from(error: ElementError) -> Self {
        Self::Element(error)
    }
}

impl From<ModeError> for Stop {
    fn from(error: ModeError) -> Self {
        Self::Mode(error)
    }
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
    /// Largest error estimate of an element without error control, relative.
    pub(super) largest_estimate: f64,
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
            largest_estimate: 0.0,
            proposed_length: 0.05 * problem.horizon,
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

    pub(super) fn run(mut self, watch: &mut Watch<'_>) -> Simulation {
        let clock = ThreadTime::now();
        let status = match self.steps(watch) {
            Ok(()) => SimulationStatus::Solved,
            Err(status) => status,
        };
        if self.largest_estimate > SUSPECT_ESTIMATE {
            self.note(&format!(
                "the error estimate of an element reached {:.0e} (relative): take more steps or give a \
                 tolerance",
                self.largest_estimate
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
        Simulation {
            declaration: self.model.declaration(),
            status,
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
        }
    }

    fn steps(&mut self, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
        self.take_piece(0.0);
        self.active.clear();
        if let Err(error) = self.settle(&[]) {
            return Err(self.stopped(0, &Stop::Mode(error)));
        }
        self.initial_modes = self.modes();
        self.record();
        for step in 0..self.settings.steps {
            let end = if step + 1 == self.settings.steps {
                self.horizon
            } else {
                self.horizon * (step + 1) as f64 / self.settings.steps as f64
            };
            self.step(step, end, watch)?;
            watch.reach(self.state.time, self.counts.elements, &mut self.trajectory)?;
        }
        Ok(())
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
            let vanishes = self.settings.tolerance.is_some() && self.proposed_length <= shortest;
            if attempts > MAX_ATTEMPTS || vanishes {
                return Err(self.too_short(step, segment_end));
            }
            match self.segment(segment_end, elements, shortest, &mut size) {
                Ok(Segment::Rejected) => {}
                Ok(Segment::Completed) if self.settings.tolerance.is_some() => halvings = 0,
                Ok(Segment::Completed) => halvings = halvings.saturating_sub(1),
                Ok(Segment::Switched) => {
                    switches += 1;
                    if switches > MAX_SWITCHES {
                        return Err(SimulationStatus::AmbiguousContact(self.diagnosis(
                            step,
                            None,
                            format!(
                                "more than {MAX_SWITCHES} switches within {} s; the contact \
                                 mode does not settle: take more steps, or look at the \
                                 surfaces that meet here",
                                0.01 * self.horizon
                            ),
                        )));
                    }
                }
                Err(stop @ Stop::Mode(_)) => return Err(self.stopped(step, &stop)),
                Err(_) if halvings < self.most_halvings() => {
                    halvings += 1;
                    if self.settings.tolerance.is_some() {
                        self.proposed_length = 0.5 * (segment_end - self.segment_start.time);
                    }
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

    /// Halvings before a segment counts as failed.
    fn most_halvings(&self) -> usize {
        match self.settings.tolerance {
            None => MAX_HALVINGS,
            Some(_) => MAX_CONTROLLED_HALVINGS,
        }
    }

    /// End and number of elements of the next segment: equal elements up to `segment_end`, or the length
    /// that the error control proposes.
    fn plan(&self, begin: f64, segment_end: f64, end: f64, halvings: usize) -> (f64, usize) {
        let remaining = segment_end - self.state.time;
        if self.settings.tolerance.is_none() {
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
    /// element must be shorter. The tolerance of the estimate, which has order `s`, is raised to the power
    /// `(s + 1) / (2 s)`, as in the code RADAU of Hairer and Wanner, since the result has about twice its
    /// order.
    fn control_error(&mut self) -> bool {
        let Some(tolerance) = self.settings.tolerance else {
            return false;
        };
        let stages = self.tableau.stages() as f64;
        let estimated = 0.1 * tolerance.powf((stages + 1.0) / (2.0 * stages));
        let ratio = self.element.error_ratio(&self.acceleration, estimated);
        let factor = 0.9 * ratio.max(1e-12).powf(-1.0 / (stages + 1.0));
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
        self.state.copy_from(&self.segment_start);
        let offset = (count - 1) as f64 + switch.theta;
        if offset * length <= shortest {
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

    pub(super) fn touching(&self) -> Touching {
        let largest = |values: &[f64]| values.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
        let speed = largest(&self.state.v);
        Touching {
            gap: TOUCHING_GAP * largest(&self.state.q),
            velocity: TOUCHING_VELOCITY * speed,
            sliding: AT_REST * speed,
        }
    }

    /// Remembers the largest error estimate where no tolerance controls it.
    fn watch_error(&mut self) {
        if self.settings.tolerance.is_none() {
            let estimate = self.element.error_ratio(&self.acceleration, 1.0);
            self.largest_estimate = self.largest_estimate.max(estimate);
        }
    }

    /// Makes the solved element part of the trajectory.
    pub(super) fn accept_element(&mut self) -> Result<(), Stop> {
        let weights = self.tableau.b();
        let mut numerical = 0.0;
        for (m, weight) in weights.iter().enumerate() {
            numerical += weight
                * clock::rate(
                    self.element.stage_forces(m),
                    self.settings.auxiliary_acceleration,
                );
        }
        self.numerical_time += numerical * self.element.length();
        self.watch_error();
        self.state.copy_from(&self.element.end);
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
        self.forces.resize(force_count(&self.active), 0.0);
        self.contacts
            .contact_forces(&self.active, &mut self.forces)?;
        self.contacts
            .constrained_acceleration(&self.active, &self.forces, &mut self.acceleration);
        for &i in &self.all_contacts {
            self.gaps[i] = self.contacts.gap(i);
            self.velocities[i] = self.contacts.normal_velocity(i);
            if self.contacts.friction(i) > 0.0 {
                self.sliding[i] = self.contacts.sliding_velocity(i);
            }
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

    pub(super) fn record(&mut self) {
        self.piece.write(self.state.time, &mut self.u);
        self.force_row.fill(0.0);
        for (held, &r) in self.active.iter().zip(&self.forces) {
            self.force_row[held.contact] = self.contacts.force(held.contact, r);
        }
        self.trajectory.push(
            self.state.time,
            self.numerical_time,
            &self.state.q,
            &self.state.v,
            &self.u,
            &self.force_row,
        );
        if self.rough {
            let mut row = vec![0.0; self.all_contacts.len()];
            let frictions = self.contacts.frictions(&self.active, &self.forces);
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
