//! The run: steps, events, records.

use cpu_time::ThreadTime;

use super::EventDriven;
use super::contact_mode::{self, Undetermined};
use super::dop853::Dop853;
use super::dynamics::Dynamics;
use super::search::{EventSearch, Outcome, Step};
use crate::model::{Model, contact_point};
use crate::simulation::{
    Diagnosis, Event, EventKind, InitialValueProblem, Residuals, Simulation, SimulationStatus,
};

/// Steps shorter than this share of the time reached do not change it.
const SHORTEST: f64 = 1e-15;
/// Factor of the step size if events within the step cannot be found.
const UNRESOLVED: f64 = 0.25;
/// Steps shorter than this share of the time reached stay at the same instant.
const SAME_INSTANT: f64 = 1e-14;
/// Steps at the same instant, for each contact, before the contact mode counts as undetermined.
const REPEATS: usize = 20;

/// State of a run.
pub(super) struct Integration<'a> {
    settings: &'a EventDriven,
    problem: &'a InitialValueProblem,
    dynamics: Dynamics<'a>,
    method: Dop853,
    probe: Dop853,
    search: EventSearch,
    t: f64,
    y: Vec<f64>,
    h: f64,
    start_values: Vec<f64>,
    end_values: Vec<f64>,
    forces: Vec<f64>,
    /// Residuals at the end of the last step, which count unless it turns out to contain an event.
    at_end: Residuals,
    output: Vec<f64>,
    slope: Vec<f64>,
    next_output: usize,
    steps: usize,
    repeats: usize,
    result: Simulation,
}

impl<'a> Integration<'a> {
    pub(super) fn new(
        settings: &'a EventDriven,
        model: &'a dyn Model,
        problem: &'a InitialValueProblem,
    ) -> Self {
        let dynamics = Dynamics::new(model, settings.auxiliary_acceleration);
        let (n, contacts) = (dynamics.n, dynamics.contacts);
        let dimension = 2 * n + 1;
        let mut y = vec![0.0; dimension];
        y[..n].copy_from_slice(&problem.q);
        y[n..2 * n].copy_from_slice(&problem.v);
        Self {
            settings,
            problem,
            method: Dop853::new(dimension, 2 * n),
            probe: Dop853::new(dimension, 2 * n),
            search: EventSearch::new(dimension, contacts),
            t: 0.0,
            y,
            h: 0.0,
            start_values: vec![0.0; contacts],
            end_values: vec![0.0; contacts],
            forces: vec![0.0; contacts],
            at_end: Residuals::default(),
            output: vec![0.0; dimension],
            slope: vec![0.0; dimension],
            next_output: 1,
            steps: 0,
            repeats: 0,
            result: dynamics.empty_result(),
            dynamics,
        }
    }

    pub(super) fn run(mut self, progress: &mut dyn FnMut(f64)) -> Simulation {
        let clock = ThreadTime::try_now();
        if let Err(status) = self.integrate(progress) {
            self.result.status = status;
        }
        self.result.counts.evaluations = self.dynamics.evaluations;
        if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
            self.result.seconds.total = elapsed.as_secs_f64();
        }
        self.result
    }

    fn integrate(&mut self, progress: &mut dyn FnMut(f64)) -> Result<(), SimulationStatus> {
        let horizon = self.problem.horizon;
        let longest = self.settings.max_step.unwrap_or(horizon / 16.0);
        self.h = longest;
        self.dynamics.set_controls(&self.problem.controls, 0.0);
        self.enter_mode(None, true)?;
        self.h = self.method.initial_size(
            &mut self.dynamics,
            self.t,
            &self.y,
            longest,
            self.settings.tolerance,
        );
        while self.t < horizon {
            let limit = self
                .problem
                .controls
                .next_jump(self.t)
                .map_or(horizon, |jump| jump.min(horizon));
            let remaining = limit - self.t;
            let wanted = self.h.min(longest);
            // A step that would leave a sliver behind takes it along.
            let lands = wanted >= remaining * (1.0 - 1e-6);
            let h = if lands { remaining } else { wanted };
            if !self.try_step(h)? {
                continue;
            }
            let event = match self.find_event(h) {
                Outcome::Nothing => None,
                Outcome::Event(event) => Some(event),
                Outcome::Unresolved(contact) => {
                    self.shorten(h, contact)?;
                    continue;
                }
            };
            self.result.counts.elements += 1;
            let until = event.map_or(h, |event| event.h);
            self.guard_progress(event.map(|event| event.contact), until)?;
            self.write_outputs(h, until);
            match event {
                Some(event) => {
                    self.t += event.h;
                    self.y.copy_from_slice(self.method.end());
                    self.method.finish(&mut self.dynamics, self.t, 0.0);
                    let measured = self.measure();
                    self.keep(measured);
                    self.record();
                    self.enter_mode(Some(event.contact), false)?;
                }
                None => {
                    self.t = if lands { limit } else { self.t + h };
                    self.y.copy_from_slice(self.method.end());
                    self.method.advance();
                    self.keep(self.at_end);
                    std::mem::swap(&mut self.start_values, &mut self.end_values);
                    self.record();
                    if lands && limit < horizon {
                        self.dynamics.set_controls(&self.problem.controls, self.t);
                        self.enter_mode(None, false)?;
                    }
                }
            }
            progress(self.t);
        }
        Ok(())
    }

    /// Tries a step of length `h`; `false` if it was rejected and `self.h` reduced.
    fn try_step(&mut self, h: f64) -> Result<bool, SimulationStatus> {
        if self.steps >= self.settings.max_steps {
            return Err(SimulationStatus::StepLimit(self.diagnosis(
                None,
                format!(
                    "{} steps taken, the last of {h:.1e} s; raise the limit or the tolerance",
                    self.steps
                ),
            )));
        }
        self.steps += 1;
        self.dynamics.sample_from(&self.start_values);
        self.method.step(&mut self.dynamics, self.t, &self.y, h);
        let mut error = self.method.error(&self.y, h, self.settings.tolerance);
        if error <= 1.0 {
            if self.dynamics.project(self.t + h, self.method.end_mut()) {
                self.method.finish(&mut self.dynamics, self.t, h);
            } else {
                error = f64::NAN;
            }
            let mut numbers = self.method.end_slope().iter().chain(&self.dynamics.values);
            if numbers.any(|number| !number.is_finite()) {
                error = f64::NAN;
            }
        }
        if error > 1.0 || error.is_nan() {
            self.h = Dop853::smaller_size(h, error);
            if self.h <= SHORTEST * self.t.max(self.problem.horizon) {
                return Err(self.step_failure(error));
            }
            return Ok(false);
        }
        self.end_values.copy_from_slice(&self.dynamics.values);
        self.at_end = self.measure();
        // A step that was cut short says nothing against longer ones.
        let next = self.method.next_size(h, error);
        self.h = if h < self.h { next.max(self.h) } else { next };
        Ok(true)
    }

    fn find_event(&mut self, h: f64) -> Outcome {
        let outputs_due = self.output_due(h);
        let search = EventSearch::is_needed(&self.dynamics);
        if !search && !outputs_due {
            return Outcome::Nothing;
        }
        self.method.extend(&mut self.dynamics, self.t, &self.y, h);
        if !search {
            return Outcome::Nothing;
        }
        let step = Step {
            t: self.t,
            h,
            y: &self.y,
            start_values: &self.start_values,
            end_values: &self.end_values,
        };
        self.search
            .earliest(&mut self.dynamics, &mut self.method, step)
    }

    /// Makes the next try shorter than the step of length `h`, in which the events of `contact` cannot be found.
    fn shorten(&mut self, h: f64, contact: usize) -> Result<(), SimulationStatus> {
        self.h = UNRESOLVED * h;
        if self.h > SHORTEST * self.t.max(self.problem.horizon) {
            return Ok(());
        }
        Err(SimulationStatus::StepFailed(self.diagnosis(
            Some(contact),
            "the events of this contact cannot be told apart; lower the tolerance".into(),
        )))
    }

    /// Refuses endless switching at one instant.
    fn guard_progress(
        &mut self,
        contact: Option<usize>,
        until: f64,
    ) -> Result<(), SimulationStatus> {
        if until > SAME_INSTANT * self.problem.horizon.max(self.t) {
            self.repeats = 0;
            return Ok(());
        }
        self.repeats += 1;
        if self.repeats <= REPEATS * (1 + self.dynamics.contacts) {
            return Ok(());
        }
        Err(SimulationStatus::AmbiguousContact(self.diagnosis(
            contact,
            format!(
                "{} changes of the contact mode at one instant",
                self.repeats
            ),
        )))
    }

    /// Applies the impact law and finds the contact mode right after the present instant, records both
    /// sides, and prepares the next step. `at_zero` is the contact whose gap or force has just vanished.
    fn enter_mode(
        &mut self,
        at_zero: Option<usize>,
        at_start: bool,
    ) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let before = self.y[n..2 * n].to_vec();
        let previously = self.dynamics.active.clone();
        let moment = self.h;
        let (vanished, closing): (Option<usize>, Option<usize>) = match at_zero {
            Some(contact) if self.dynamics.is_active(contact) => (at_zero, None),
            _ => (None, at_zero),
        };
        let impact = contact_mode::impact(&mut self.dynamics, self.t, &mut self.y, closing)
            .map_err(|problem| self.undetermined(problem))?;
        if at_start && !impact.struck.is_empty() {
            let after = self.y[n..2 * n].to_vec();
            self.y[n..2 * n].copy_from_slice(&before);
            self.record();
            self.y[n..2 * n].copy_from_slice(&after);
        }
        self.y[2 * n] += impact.impulse / self.settings.auxiliary_acceleration;
        contact_mode::select(
            &mut self.dynamics,
            &mut self.probe,
            self.t,
            &self.y,
            &impact.resting,
            vanished,
            moment,
        )
        .map_err(|problem| self.undetermined(problem))?;
        if !self.dynamics.project(self.t, &mut self.y) {
            let contact = self.dynamics.active.first().copied();
            return Err(SimulationStatus::AmbiguousContact(
                self.diagnosis(
                    contact,
                    "the state cannot be moved onto the surfaces in contact: their normals are \
                 dependent"
                        .into(),
                ),
            ));
        }
        self.begin()?;
        self.dynamics.accept_forces();
        self.record();
        if impact.struck.len() > 1 {
            self.note(
                "simultaneous impacts are resolved by Moreau's law, all closed contacts at once",
            );
        }
        self.write_events(&before, &previously, &impact.struck, at_start)
    }

    /// Lists what happened to each contact, impacts first, and guards against endless switching.
    fn write_events(
        &mut self,
        before: &[f64],
        previously: &[usize],
        struck: &[usize],
        at_start: bool,
    ) -> Result<(), SimulationStatus> {
        let count = self.result.events.len();
        for &i in struck {
            self.write_event(EventKind::Impact, i, before);
        }
        for i in 0..self.dynamics.contacts {
            let (was, is) = (previously.contains(&i), self.dynamics.is_active(i));
            if is && !was && !at_start && !struck.contains(&i) {
                self.write_event(EventKind::Contact, i, before);
            } else if was && !is {
                self.write_event(EventKind::LiftOff, i, before);
            }
        }
        let contact = self.result.events.get(count).map(|event| event.contact);
        let events = &self.result.events;
        if events.len() > self.settings.max_events {
            let tenth = events[events.len() - 1 - events.len() / 10].time;
            return Err(SimulationStatus::AmbiguousContact(self.diagnosis(
                contact,
                format!(
                    "{} switches of the contact mode, the last tenth within {:.1e} s; raise the limit \
                     on events unless they accumulate",
                    events.len(),
                    self.t - tenth
                ),
            )));
        }
        Ok(())
    }

    fn write_event(&mut self, kind: EventKind, contact: usize, before: &[f64]) {
        let n = self.dynamics.n;
        self.result.events.push(Event {
            time: self.t,
            kind,
            contact,
            q: self.y[..n].to_vec(),
            v_before: before.to_vec(),
            v_after: self.y[n..2 * n].to_vec(),
        });
    }

    /// Evaluates derivative, values and forces at the present state.
    fn begin(&mut self) -> Result<(), SimulationStatus> {
        self.method.begin(&mut self.dynamics, self.t, &self.y);
        self.start_values.copy_from_slice(&self.dynamics.values);
        let measured = self.measure();
        self.keep(measured);
        if self.method.slope().iter().all(|slope| slope.is_finite()) {
            Ok(())
        } else {
            Err(self.not_finite())
        }
    }

    /// Forces at the last evaluation, and the residuals there.
    fn measure(&mut self) -> Residuals {
        self.dynamics.forces(&mut self.forces);
        let mut residuals = Residuals::default();
        for i in 0..self.dynamics.contacts {
            let value = self.dynamics.values[i];
            residuals.dual = residuals.dual.max(-value);
            if self.dynamics.is_active(i) {
                let point = self.dynamics.point(i);
                let gap = point[contact_point::GAP].abs();
                residuals.primal = residuals
                    .primal
                    .max(gap)
                    .max(point[contact_point::NORMAL_VELOCITY].abs());
                residuals.complementarity = residuals.complementarity.max(gap * value.abs());
            }
        }
        residuals
    }

    fn keep(&mut self, measured: Residuals) {
        let residuals = &mut self.result.residuals;
        residuals.primal = residuals.primal.max(measured.primal);
        residuals.dual = residuals.dual.max(measured.dual);
        residuals.complementarity = residuals.complementarity.max(measured.complementarity);
    }

    fn record(&mut self) {
        let n = self.dynamics.n;
        self.result.trajectory.push(
            self.t,
            self.y[2 * n],
            &self.y[..n],
            &self.y[n..2 * n],
            &self.dynamics.u,
            &self.forces,
        );
    }

    fn output_time(&self, index: usize) -> f64 {
        self.problem.horizon * index as f64 / self.settings.output_times as f64
    }

    /// Whether an output time lies inside the next `h`.
    fn output_due(&self, h: f64) -> bool {
        self.next_output < self.settings.output_times
            && self.output_time(self.next_output) < self.t + h
    }

    /// Writes the output times inside the first `until` of the step of length `h` just made.
    fn write_outputs(&mut self, h: f64, until: f64) {
        let n = self.dynamics.n;
        while self.output_due(until) {
            let time = self.output_time(self.next_output);
            self.next_output += 1;
            if time <= self.t {
                continue;
            }
            self.method
                .interpolate((time - self.t) / h, &mut self.output);
            if !self.dynamics.project(time, &mut self.output) {
                continue;
            }
            super::dop853::System::derivative(
                &mut self.dynamics,
                time,
                &self.output,
                &mut self.slope,
            );
            let mut forces = vec![0.0; self.forces.len()];
            self.dynamics.forces(&mut forces);
            self.result.trajectory.push(
                time,
                self.output[2 * n],
                &self.output[..n],
                &self.output[n..2 * n],
                &self.dynamics.u,
                &forces,
            );
        }
    }

    fn note(&mut self, text: &str) {
        if !self.result.notes.iter().any(|note| note == text) {
            self.result.notes.push(text.into());
        }
    }

    fn diagnosis(&self, contact: Option<usize>, message: String) -> Diagnosis {
        Diagnosis {
            time: self.t,
            step: self.result.counts.elements,
            contact,
            message,
        }
    }

    fn undetermined(&self, problem: Undetermined) -> SimulationStatus {
        SimulationStatus::AmbiguousContact(self.diagnosis(Some(problem.contact), problem.message))
    }

    fn step_failure(&self, error: f64) -> SimulationStatus {
        if error.is_finite() {
            SimulationStatus::StepFailed(self.diagnosis(
                self.dynamics.active.first().copied(),
                format!(
                    "steps of {:.1e} s do not meet the tolerance {:e}; the motion is not smooth here, \
                     or the tolerance too small",
                    self.h, self.settings.tolerance
                ),
            ))
        } else {
            self.not_finite()
        }
    }

    fn not_finite(&self) -> SimulationStatus {
        let n = self.dynamics.n;
        let declaration = self.dynamics.model.declaration();
        let contact = (0..self.dynamics.contacts).find(|&i| !self.dynamics.values[i].is_finite());
        let slope = self.method.slope();
        let what = match (0..n).find(|&k| !slope[n + k].is_finite()) {
            Some(k) => format!("the acceleration of `{}`", declaration.coordinates[k].name),
            None => match contact {
                Some(i) => format!("the contact `{}`", declaration.contacts[i].name),
                None => "the acceleration a moment later".into(),
            },
        };
        SimulationStatus::NotFinite(self.diagnosis(
            contact,
            format!(
                "{what} is not a finite number; check roots, divisions and parameters of the scene"
            ),
        ))
    }
}
