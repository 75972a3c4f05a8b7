//! The stepping loop: elements, switches, impacts, and what is recorded of them.

use super::switch::{Detector, ElementStart, Switch, SwitchKind};
use super::{Fesd, StepFormulation};
use crate::fesd::contact_mode::{Contacts, ModeError, Touching};
use crate::fesd::finite_element::{ElementError, FiniteElement, State};
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::simulation::{
    ControlSignal, Counts, Diagnosis, Event, EventKind, InitialValueProblem, ProblemSize,
    Residuals, Seconds, Simulation, SimulationStatus, Trajectory,
};
use crate::time_freezing::clock;

/// Rounding error of a gap or a normal velocity, relative to the largest coordinate or velocity.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Gap within which a contact takes part in an impact or a mode, relative to the largest coordinate.
const TOUCHING_GAP: f64 = 1e-9;
/// Normal velocity that counts as zero, relative to the largest velocity.
const TOUCHING_VELOCITY: f64 = 1e-9;
/// Halvings of the elements of a step before it counts as failed.
const MAX_HALVINGS: usize = 8;
/// Switches within one step before the contact mode counts as ambiguous.
const MAX_SWITCHES: usize = 200;
/// Evaluations of the switch condition that locate one switch.
const MAX_LOCATIONS: usize = 60;

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

pub(super) struct Driver<'a> {
    pub(super) settings: &'a Fesd,
    pub(super) model: &'a dyn Model,
    controls: &'a ControlSignal,
    horizon: f64,
    n: usize,
    pub(super) all_contacts: Vec<usize>,
    element: FiniteElement<'a>,
    /// Element used to look at the one after a take-off.
    next_element: FiniteElement<'a>,
    contacts: Contacts<'a>,
    detector: Detector<'a>,
    pub(super) tableau: &'a ButcherTableau,
    pub(super) state: State,
    segment_start: State,
    pub(super) numerical_time: f64,
    pub(super) active: Vec<usize>,
    pub(super) u: Vec<f64>,
    x: Vec<f64>,
    gaps: Vec<f64>,
    /// Normal velocities of all contacts at the present state.
    velocities: Vec<f64>,
    /// Normal contact accelerations of the active contacts at the present state.
    forces: Vec<f64>,
    /// Acceleration with contact forces at the present state.
    acceleration: Vec<f64>,
    /// Element length that the error control proposes.
    proposed_length: f64,
    force_row: Vec<f64>,
    events: Vec<Event>,
    trajectory: Trajectory,
    pub(super) residuals: Residuals,
    size: ProblemSize,
    pub(super) counts: Counts,
    notes: Vec<String>,
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
            x: problem.input(model),
            gaps: vec![0.0; contacts],
            velocities: vec![0.0; contacts],
            forces: Vec::with_capacity(contacts),
            acceleration: vec![0.0; declaration.coordinates.len()],
            proposed_length: problem.horizon / 20.0,
            force_row: vec![0.0; contacts],
            events: Vec::new(),
            trajectory: Trajectory::default(),
            residuals: Residuals::default(),
            size: ProblemSize::default(),
            counts: Counts::default(),
            notes: Vec::new(),
        }
    }

    pub(super) fn run(mut self, progress: &mut dyn FnMut(f64)) -> Simulation {
        let clock = std::time::Instant::now();
        let status = self.steps(progress);
        let newton = self.element.counts;
        let other = self.next_element.counts;
        self.counts.newton = newton.iterations + other.iterations;
        self.counts.factorizations = newton.factorizations + other.factorizations;
        self.counts.evaluations =
            newton.evaluations + other.evaluations + self.contacts.evaluations;
        Simulation {
            status,
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

    fn steps(&mut self, progress: &mut dyn FnMut(f64)) -> SimulationStatus {
        self.controls.write(0.0, &mut self.u);
        self.active.clear();
        if let Err(error) = self.settle(&[]) {
            return self.stopped(0, &Stop::Mode(error));
        }
        self.record();
        for step in 0..self.settings.steps {
            let end = if step + 1 == self.settings.steps {
                self.horizon
            } else {
                self.horizon * (step + 1) as f64 / self.settings.steps as f64
            };
            if let Err(status) = self.step(step, end) {
                return status;
            }
            progress(self.state.time);
        }
        SimulationStatus::Solved
    }

    /// Advances to `end`, with as many segments as there are switches and control jumps.
    fn step(&mut self, step: usize, end: f64) -> Result<(), SimulationStatus> {
        let begin = self.state.time;
        let shortest = 1e-14 * self.horizon;
        let mut halvings = 0;
        let mut switches = 0;
        let mut size = ProblemSize::default();
        while end - self.state.time > shortest {
            self.take_up_controls(step)?;
            let segment_end = self
                .controls
                .next_jump(self.state.time)
                .map_or(end, |jump| jump.min(end));
            if self.settings.formulation == StepFormulation::TimeFreezing {
                if let Err(stop) = self.solve_program(segment_end) {
                    return Err(self.stopped(step, &stop));
                }
                continue;
            }
            let (segment_end, elements) = self.plan(begin, segment_end, end, halvings);
            match self.segment(segment_end, elements, shortest, &mut size) {
                Ok(Segment::Rejected) => {}
                Ok(Segment::Completed) => halvings = halvings.saturating_sub(1),
                Ok(Segment::Switched) => {
                    switches += 1;
                    if switches > MAX_SWITCHES {
                        return Err(SimulationStatus::AmbiguousContact(self.diagnosis(
                            step,
                            None,
                            format!(
                                "more than {MAX_SWITCHES} switches within one step; the contact \
                                 mode does not settle: look at the surfaces that meet here"
                            ),
                        )));
                    }
                }
                Err(stop @ (Stop::Element(ElementError::NotFinite) | Stop::Mode(_))) => {
                    return Err(self.stopped(step, &stop));
                }
                Err(_) if halvings < MAX_HALVINGS => halvings += 1,
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

    /// End and number of elements of the next segment: equal elements up to `segment_end`, or the length
    /// that the error control proposes.
    fn plan(&self, begin: f64, segment_end: f64, end: f64, halvings: usize) -> (f64, usize) {
        let remaining = segment_end - self.state.time;
        if self.settings.tolerance.is_none() {
            let share = remaining / (end - begin);
            let elements = (self.settings.elements as f64 * share).round() as usize;
            return (segment_end, elements.max(1) << halvings);
        }
        let length = self.proposed_length / (1 << halvings) as f64;
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
        self.proposed_length =
            self.element.length() * factor.clamp(LENGTH_CHANGE.0, LENGTH_CHANGE.1);
        ratio > 1.0
    }

    /// Controls that hold from now on; a jump of theirs may change the contact mode.
    fn take_up_controls(&mut self, step: usize) -> Result<(), SimulationStatus> {
        if self.u.is_empty() {
            return Ok(());
        }
        let before = self.u.clone();
        // A jump within rounding error of the present time has been reached.
        let now = self.state.time + 4.0 * f64::EPSILON * self.horizon;
        self.controls.write(now, &mut self.u);
        if before != self.u && self.state.time > 0.0 {
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
            self.element.solve(&self.state, length, &self.u)?;
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
        let located = self.locate(switch, length, count, recorded)?;
        self.add_size(count, true, size);
        self.carry_out(located)?;
        Ok(Segment::Switched)
    }

    fn violation(&mut self) -> Result<Option<Switch>, Stop> {
        let largest = |values: &[f64]| values.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
        let start = ElementStart {
            x: &self.x,
            gaps: &self.gaps,
            velocities: &self.velocities,
            forces: &self.forces,
            rounding: Touching {
                gap: ROUNDING * largest(&self.state.q),
                velocity: ROUNDING * largest(&self.state.v),
            },
            touching_gap: TOUCHING_GAP * largest(&self.state.q),
        };
        Ok(self
            .detector
            .first_violation(&self.element, &mut self.contacts, &start)?)
    }

    fn touching(&self) -> Touching {
        let largest = |values: &[f64]| values.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
        Touching {
            gap: TOUCHING_GAP * largest(&self.state.q),
            velocity: TOUCHING_VELOCITY * largest(&self.state.v),
        }
    }

    /// Makes the solved element part of the trajectory.
    fn accept_element(&mut self) -> Result<(), Stop> {
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
        self.contacts.evaluate(&self.x, &self.all_contacts);
        self.forces.resize(self.active.len(), 0.0);
        self.contacts
            .contact_accelerations(&self.active, &mut self.forces)?;
        self.contacts
            .constrained_acceleration(&self.active, &self.forces, &mut self.acceleration);
        for &i in &self.all_contacts {
            self.gaps[i] = self.contacts.gap(i);
            self.velocities[i] = self.contacts.normal_velocity(i);
        }
        for (&i, &r) in self.active.iter().zip(&self.forces) {
            let (gap, velocity) = (self.gaps[i].abs(), self.velocities[i].abs());
            self.residuals.primal = self.residuals.primal.max(gap).max(velocity);
            self.residuals.complementarity = self.residuals.complementarity.max(gap * r.abs());
            self.residuals.dual = self.residuals.dual.max(-r);
        }
        for &gap in &self.gaps {
            self.residuals.dual = self.residuals.dual.max(-gap);
        }
        Ok(())
    }

    fn write_input(&mut self) {
        let n = self.n;
        self.x[..n].copy_from_slice(&self.state.q);
        self.x[n..2 * n].copy_from_slice(&self.state.v);
        self.x[2 * n..2 * n + self.u.len()].copy_from_slice(&self.u);
        if self.model.declaration().explicit_time
            && let Some(time) = self.x.last_mut()
        {
            *time = self.state.time;
        }
    }

    pub(super) fn record(&mut self) {
        self.force_row.fill(0.0);
        for (&i, &r) in self.active.iter().zip(&self.forces) {
            self.force_row[i] = self.contacts.force(i, r);
        }
        self.trajectory.push(
            self.state.time,
            self.numerical_time,
            &self.state.q,
            &self.state.v,
            &self.u,
            &self.force_row,
        );
    }

    /// Finds the common length of `count` elements at whose end the switch condition holds, and makes
    /// them part of the trajectory. Another contact that turns out to switch earlier takes over.
    fn locate(
        &mut self,
        mut switch: Switch,
        longest: f64,
        count: usize,
        recorded: usize,
    ) -> Result<Switch, Stop> {
        let start_numerical_time = self.numerical_time;
        for _ in 0..=2 * self.all_contacts.len() {
            self.locate_one(switch, longest, count)?;
            self.trajectory.truncate(recorded);
            self.numerical_time = start_numerical_time;
            let mut length = self.element.length();
            if switch.kind == SwitchKind::Exit && !self.settings.exit_condition {
                length = self.earliest_release(switch.contact, length, longest, count)?;
            }
            // Solve once more along the located length, now recording.
            self.state.copy_from(&self.segment_start);
            for _ in 0..count {
                self.element.solve(&self.state, length, &self.u)?;
                self.accept_element()?;
            }
            match self.earlier_violation(switch) {
                None => return Ok(switch),
                Some(other) => {
                    switch = other;
                    let ratio = length / longest;
                    switch.theta = ratio * count as f64 - (count - 1) as f64;
                    switch.violated = switch.theta;
                    self.trajectory.truncate(recorded);
                    self.numerical_time = start_numerical_time;
                    self.state.copy_from(&self.segment_start);
                }
            }
        }
        Err(Stop::Location)
    }

    /// A sign condition other than the located one that is violated at the present state.
    fn earlier_violation(&self, located: Switch) -> Option<Switch> {
        let other = |kind, contact, slope| {
            (contact != located.contact).then_some(Switch {
                kind,
                contact,
                theta: 1.0,
                violated: 1.0,
                slope,
            })
        };
        let closed = self
            .all_contacts
            .iter()
            .filter(|i| !self.active.contains(i))
            .find(|&&i| self.gaps[i] < -self.touching().gap)
            .and_then(|&i| {
                other(
                    SwitchKind::Entry,
                    i,
                    self.contacts.normal_velocity(i).min(-f64::MIN_POSITIVE),
                )
            });
        closed.or_else(|| {
            self.active
                .iter()
                .zip(&self.forces)
                .find(|&(&i, &r)| r < -TOUCHING_GAP * self.contacts.phi_scale(i))
                .and_then(|(&i, _)| other(SwitchKind::Exit, i, located.slope))
        })
    }

    /// Newton's method with secant slopes on the common element length, kept inside a bracket.
    fn locate_one(&mut self, switch: Switch, longest: f64, count: usize) -> Result<(), Stop> {
        let tolerance = 2.0 * f64::EPSILON * self.segment_start.time.max(longest * count as f64);
        let length_at = |theta: f64| ((count - 1) as f64 + theta) * longest / count as f64;
        // A little room beyond the violated place, which the dense output of another element named.
        let (mut before, mut after) = (0.0, length_at(switch.violated) + 0.01 * longest);
        let mut length = length_at(switch.theta);
        let mut slope = switch.slope * count as f64;
        let mut previous: Option<(f64, f64)> = None;
        for _ in 0..MAX_LOCATIONS {
            let value = self.switch_condition(switch, length, count)?;
            if let Some((earlier, earlier_value)) = previous {
                let secant = (value - earlier_value) / (length - earlier);
                if secant.is_finite() && secant != 0.0 {
                    slope = secant;
                }
            }
            previous = Some((length, value));
            if value > 0.0 {
                before = length;
            } else {
                after = length;
            }
            let step = value / slope;
            if value == 0.0 || step.abs() <= tolerance || after - before <= tolerance {
                return Ok(());
            }
            length -= step;
            if !(before < length && length < after) {
                length = 0.5 * (before + after);
            }
        }
        Err(Stop::Location)
    }

    /// Solves `count` elements of `length` from the segment's start, without recording.
    fn solve_elements(&mut self, length: f64, count: usize) -> Result<(), Stop> {
        self.state.copy_from(&self.segment_start);
        for _ in 0..count {
            self.element.solve(&self.state, length, &self.u)?;
            self.state.copy_from(&self.element.end);
        }
        Ok(())
    }

    /// Value of the switching function after `count` elements of `length` from the segment's start.
    fn switch_condition(&mut self, switch: Switch, length: f64, count: usize) -> Result<f64, Stop> {
        self.solve_elements(length, count)?;
        self.write_input();
        match switch.kind {
            SwitchKind::Entry => Ok(self.model.gap(switch.contact, &self.x)),
            SwitchKind::Reentry => {
                self.contacts.evaluate_contacts(&self.x, &[switch.contact]);
                let gap = self.contacts.gap(switch.contact);
                Ok(gap.max(self.contacts.normal_velocity(switch.contact)))
            }
            SwitchKind::Exit => {
                self.contacts.evaluate(&self.x, &self.active);
                self.forces.resize(self.active.len(), 0.0);
                self.contacts
                    .contact_accelerations(&self.active, &mut self.forces)?;
                let slot = self.active.iter().position(|&i| i == switch.contact);
                Ok(slot.map_or(f64::NAN, |slot| self.forces[slot]))
            }
        }
    }

    /// Without the exit condition the published method also admits earlier take-offs: down to the common
    /// element length at which the gap at the first stage of the following element vanishes. Returns that
    /// length, by bisection, or `latest` where the scheme admits no earlier one.
    fn earliest_release(
        &mut self,
        contact: usize,
        latest: f64,
        next_length: f64,
        count: usize,
    ) -> Result<f64, Stop> {
        let (mut early, mut late) = (0.0, latest);
        for _ in 0..52 {
            let middle = 0.5 * (early + late);
            self.solve_elements(middle, count)?;
            if self.first_gap_after_release(contact, next_length)? >= 0.0 {
                late = middle;
            } else {
                early = middle;
            }
        }
        Ok(late)
    }

    /// Gap at the first stage of an element of length `h` from the present state without `contact`.
    fn first_gap_after_release(&mut self, contact: usize, h: f64) -> Result<f64, Stop> {
        let released: Vec<usize> = self
            .active
            .iter()
            .copied()
            .filter(|&i| i != contact)
            .collect();
        self.next_element.set_mode(&released);
        self.next_element.solve(&self.state, h, &self.u)?;
        Ok(self.model.gap(contact, self.next_element.stage_input(0)))
    }

    /// Carries out a located switch at the present state.
    fn carry_out(&mut self, switch: Switch) -> Result<(), ModeError> {
        if switch.kind == SwitchKind::Exit && !self.settings.exit_condition {
            self.release(switch.contact)?;
        } else {
            self.settle(&[switch.contact])?;
        }
        self.record();
        Ok(())
    }

    /// Ends the contact although its force has not vanished (no exit condition).
    fn release(&mut self, contact: usize) -> Result<(), ModeError> {
        self.active.retain(|&i| i != contact);
        self.element.set_mode(&self.active);
        self.push_event(EventKind::LiftOff, contact, self.state.v.clone());
        self.evaluate_state()
    }

    pub(super) fn push_event(&mut self, kind: EventKind, contact: usize, v_before: Vec<f64>) {
        self.events.push(Event {
            time: self.state.time,
            kind,
            contact,
            q: self.state.q.clone(),
            v_before,
            v_after: self.state.v.clone(),
        });
    }

    /// Impact of everything that touches and closes, then the contact mode; records the events. The
    /// contacts that `switched` touch whatever the discretization error of their gaps.
    pub(super) fn settle(&mut self, switched: &[usize]) -> Result<(), ModeError> {
        self.write_input();
        self.contacts.evaluate_contacts(&self.x, &self.all_contacts);
        let tolerance = self.touching();
        let touching: Vec<usize> = self
            .all_contacts
            .iter()
            .copied()
            .filter(|&i| self.contacts.gap(i).abs() <= tolerance.gap || switched.contains(&i))
            .collect();
        let closing: Vec<usize> = touching
            .iter()
            .copied()
            .filter(|&i| self.contacts.normal_velocity(i) < -tolerance.velocity)
            .collect();
        let v_before = self.state.v.clone();
        let mut impulses = Vec::new();
        if !closing.is_empty() {
            self.contacts
                .impact(&touching, &mut impulses, &mut self.state.v)?;
            self.numerical_time += clock::jump(&impulses, self.settings.auxiliary_acceleration);
            self.write_input();
            if touching.len() > 1 {
                self.note("simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)");
            }
        }
        let previous = self.active.clone();
        let mut active = std::mem::take(&mut self.active);
        let selected = self
            .contacts
            .select(&self.x, &touching, tolerance.velocity, &mut active);
        self.active = active;
        selected?;
        for i in self.all_contacts.clone() {
            // A contact that already carried a force takes part in the impact without one of its own.
            let struck = closing.contains(&i);
            let (before, after) = (previous.contains(&i), self.active.contains(&i));
            if struck {
                self.push_event(EventKind::Impact, i, v_before.clone());
            }
            if before && !after {
                self.push_event(EventKind::LiftOff, i, v_before.clone());
            } else if after && !before && !struck && self.state.time > 0.0 {
                self.push_event(EventKind::Contact, i, v_before.clone());
            }
        }
        self.element.set_mode(&self.active);
        self.evaluate_state()
    }

    /// Moves the present positions onto the surfaces of `close` contacts, along their directions.
    pub(super) fn project(&mut self, close: &[usize]) -> Result<(), ModeError> {
        for _ in 0..3 {
            self.write_input();
            self.contacts.evaluate_contacts(&self.x, close);
            self.contacts.close_gaps(close, &mut self.state.q)?;
        }
        Ok(())
    }

    pub(super) fn note(&mut self, text: &str) {
        if !self.notes.iter().any(|note| note == text) {
            self.notes.push(text.into());
        }
    }

    /// Size of the step's system: stage unknowns and one length an element.
    fn add_size(&self, elements: usize, switched: bool, size: &mut ProblemSize) {
        let (n, contacts) = (self.n, self.element.active().len());
        let stages = self.tableau.stages();
        let unknowns = elements * self.element.variables();
        let block = n + 2 * contacts;
        size.variables += unknowns + elements;
        // Equal lengths but one, which the end of the segment or the switch condition determines.
        size.equalities += unknowns + elements;
        size.inequalities += elements * stages * self.all_contacts.len();
        size.complementarities += elements * self.all_contacts.len();
        size.jacobian_nonzeros +=
            elements * stages * stages * block * block + elements + usize::from(switched);
    }

    fn diagnosis(&self, step: usize, contact: Option<usize>, message: String) -> Diagnosis {
        Diagnosis {
            time: self.state.time,
            step,
            contact,
            message,
        }
    }

    fn stopped(&self, step: usize, stop: &Stop) -> SimulationStatus {
        let names: Vec<&str> = self
            .active
            .iter()
            .map(|&i| self.model.declaration().contacts[i].name)
            .collect();
        let mode = if names.is_empty() {
            "in free motion".to_string()
        } else {
            format!("in contact with {}", names.join(", "))
        };
        let contact = self.active.first().copied();
        let describe =
            |what: &str| format!("step {step} at t = {} s {mode}: {what}", self.state.time);
        match stop {
            Stop::Element(ElementError::NotFinite) | Stop::Mode(ModeError::NotFinite) => {
                SimulationStatus::NotFinite(self.diagnosis(
                    step,
                    contact,
                    describe(
                        "the model is infinite or not a number here; look for a division by zero \
                         or a root of a negative number",
                    ),
                ))
            }
            Stop::Mode(ModeError::Jammed) => SimulationStatus::AmbiguousContact(self.diagnosis(
                step,
                contact,
                describe(
                    "no impulse or force satisfies the contact law (jamming); look at the impulse \
                     direction of the contacts that touch",
                ),
            )),
            Stop::Mode(ModeError::Dependent) => SimulationStatus::AmbiguousContact(self.diagnosis(
                step,
                contact,
                describe("the normals of the active contacts are dependent"),
            )),
            Stop::Element(ElementError::Singular) => SimulationStatus::StepFailed(self.diagnosis(
                step,
                contact,
                describe("singular element matrix; the active contacts may be dependent"),
            )),
            Stop::Element(ElementError::NotConverged) => {
                SimulationStatus::StepFailed(self.diagnosis(
                    step,
                    contact,
                    describe("Newton's method did not converge; take more steps"),
                ))
            }
            Stop::Program(what) => {
                SimulationStatus::StepFailed(self.diagnosis(step, contact, describe(what)))
            }
            Stop::Location => SimulationStatus::StepFailed(self.diagnosis(
                step,
                contact,
                describe("a switch could not be located; take more steps"),
            )),
        }
    }
}
