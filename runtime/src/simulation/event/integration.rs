//! The run: steps, events, records.

mod hidden;
mod journal;
mod outputs;
mod step_size;

use crate::yardstick;
use hangtime_solver::clock::ThreadTime;

use self::journal::Journal;
use self::outputs::Outputs;
use self::step_size::{Attempts, Rejected, StepEnds};
use super::audit::{self, Checks};
use super::contact_mode::{self, Outlook};
use super::diagnosis::Place;
use super::dop853::{Dop853, System};
use super::dynamics::{Dynamics, Switch, motion, switching};
use super::ending::Ending;
use super::error_scale::ErrorScale;
use super::forces::Forces;
use super::here::{Here, LowestBounce};
use super::search::{EventSearch, Found, Made, Outcome, Step};
use super::settings::EventDriven;
use crate::contact::ContactState;
use crate::enclosure::hide;
use crate::model::Model;
use crate::run::impact::Impact;
use crate::run::remarks::Remarks;
use crate::run::{resets, rest};
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::watch::Watch;
use crate::simulation::{InitialValueProblem, Simulation, SimulationStatus, changes};

/// Steps shorter than this share of the time reached do not change it.
const SHORTEST: f64 = 1e-15;
/// Factor of the step size if events within the step cannot be found.
const UNRESOLVED: f64 = 0.25;
/// Share of the longest step after which accelerations are compared for the first step size.
const GLANCE: f64 = 1e-6;
/// Steps shorter than this share of the time reached stay at the same instant.
const SAME_INSTANT: f64 = 1e-14;
/// Steps at the same instant, for each contact, before the contact mode counts as undetermined.
const REPEATS: usize = 20;
/// Steps that an event takes, which do not count against the limit on steps: events have their own.
const STEPS_AN_EVENT: usize = 4;
/// Steps at the same instant after which a contact mode is chosen by what follows later.
const PATIENCE: usize = 2;

/// A run.
pub(super) struct Integration<'a> {
    settings: &'a EventDriven,
    problem: &'a InitialValueProblem,
    dynamics: Dynamics<'a>,
    method: Dop853,
    /// The method that looks ahead where a contact mode is chosen.
    probe: Dop853,
    search: EventSearch<'a>,
    /// Time \[s\], state `(q, v, numerical time)`, and length of the next step \[s\].
    t: f64,
    y: Vec<f64>,
    h: f64,
    step: StepEnds,
    forces: Forces,
    dense: Outputs,
    counts: Attempts,
    checks: Checks<'a>,
    journal: Journal,
}

impl<'a> Integration<'a> {
    pub(super) fn new(
        settings: &'a EventDriven,
        model: &'a dyn Model,
        problem: &'a InitialValueProblem,
        explicit_time: Option<ExplicitTime<'a>>,
    ) -> Self {
        let dynamics = Dynamics::new(model, settings.auxiliary_acceleration);
        let (n, contacts, functions) = (dynamics.n, dynamics.contacts, dynamics.functions());
        let dimension = 2 * n + 1;
        let mut y = vec![0.0; dimension];
        y[..n].copy_from_slice(&problem.q);
        y[n..2 * n].copy_from_slice(&problem.v);
        Self {
            settings,
            problem,
            method: Dop853::new(dimension, 2 * n),
            probe: Dop853::new(dimension, 2 * n),
            search: EventSearch::new(&dynamics),
            t: 0.0,
            y,
            h: 0.0,
            step: StepEnds {
                error_scale: ErrorScale::new(model.declaration()),
                start_values: vec![0.0; functions],
                end_values: vec![0.0; functions],
                at_end: audit::verdict(settings.tolerance),
                orientation: 1.0,
                rejected: Rejected::default(),
            },
            forces: Forces::new(contacts),
            dense: Outputs::new(dimension, problem.horizon, settings.output_times),
            counts: Attempts::default(),
            checks: Checks {
                remarks: Remarks::default(),
                verdict: audit::verdict(settings.tolerance),
                explicit_time,
            },
            journal: Journal::of(dynamics.empty_result()),
            dynamics,
        }
    }

    /// The motion, which may be known to have an `ending`.
    pub(super) fn run(mut self, watch: &mut Watch<'_>, ending: Option<Ending>) -> Simulation {
        let clock = ThreadTime::try_now();
        let ended = self.integrate(watch, ending).err();
        if self.journal.result.trajectory.time.is_empty() {
            self.record_start();
        }
        let told = (&self.dynamics, &self.search, self.checks);
        let mut result = self.journal.closed(told, ended);
        if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
            result.seconds.total = elapsed.as_secs_f64();
        }
        result
    }

    fn integrate(
        &mut self,
        watch: &mut Watch<'_>,
        ending: Option<Ending>,
    ) -> Result<(), SimulationStatus> {
        let horizon = self.problem.horizon;
        let longest = self.settings.max_step.unwrap_or(horizon / 16.0);
        // What is closed at the start is told by a moment of the horizon: accelerations make a gap of any size small
        // beside what a step may cover.
        self.h = GLANCE * longest;
        self.dynamics.set_controls(&self.problem.controls, 0.0);
        self.dynamics.load(0.0, &self.y);
        self.dynamics.choose_pieces();
        let now = (self.t, &self.y[..], self.h);
        step_size::expect(&mut self.dynamics, &self.step.error_scale, now, longest);
        self.enter_mode(None, true)?;
        let (now, sizes) = (
            (self.t, &self.y[..], self.method.slope()),
            (GLANCE * longest, longest, self.settings.tolerance),
        );
        let (dynamics, dense) = (&mut self.dynamics, &mut self.dense);
        self.h = step_size::first(dynamics, dense, &self.step.error_scale, now, sizes);
        self.observe();
        while self.t < horizon {
            let limit = self
                .problem
                .controls
                .next_break(self.t)
                .map_or(horizon, |next| next.min(horizon));
            if self.rest(limit)? {
                continue;
            }
            let remaining = limit - self.t;
            let wanted = self.foreseen(self.h.min(longest).min(remaining));
            // A step that would leave a sliver behind takes it along.
            let lands = wanted >= remaining * (1.0 - 1e-6);
            let h = if lands { remaining } else { wanted };
            if !self.try_step(h)? {
                continue;
            }
            let Some(event) = self.searched(h)? else {
                continue;
            };
            let until = event.map_or(h, |event| event.h);
            self.journal.result.counts.elements += 1;
            let switch = event.map(|event| self.dynamics.switch(event.function));
            match self.guard_progress(switch, until) {
                Err(_) if self.comes_to_rest() => continue,
                progress => progress?,
            }
            self.write_outputs(h, until);
            if event.is_some() || self.search.has_suspects() {
                self.audit_inside(h, until);
            }
            match event {
                Some(event) => match self.pass(event.h, switch, ending) {
                    Err(_) if self.comes_to_rest() => continue,
                    over => {
                        if over? {
                            break;
                        }
                    }
                },
                None => self.go_on(h, lands.then_some(limit))?,
            }
            let count = self.journal.result.counts.elements;
            watch.reach(self.t, count, &mut self.journal.result.trajectory)?;
        }
        self.strike_at_the_end(ending)
    }

    /// Goes to the end of a step of length `h` without an event, which may be a `limit` where the controls jump.
    fn go_on(&mut self, h: f64, limit: Option<f64>) -> Result<(), SimulationStatus> {
        self.t = limit.unwrap_or(self.t + h);
        self.y.copy_from_slice(self.method.end());
        self.method.advance();
        self.checks.verdict.include(&self.step.at_end);
        let place = (self.t, self.journal.result.counts.elements);
        let values = &self.step.end_values;
        audit::look(&mut self.checks.verdict, &self.dynamics, values, place);
        std::mem::swap(&mut self.step.start_values, &mut self.step.end_values);
        self.record();
        self.observe();
        self.take_up_controls(limit)
    }

    /// Takes up the controls after a `limit` of theirs before the horizon, and the mode that they make.
    fn take_up_controls(&mut self, limit: Option<f64>) -> Result<(), SimulationStatus> {
        if limit.is_some_and(|limit| limit < self.problem.horizon) {
            self.dynamics.set_controls(&self.problem.controls, self.t);
            self.enter_mode(None, false)?;
        }
        Ok(())
    }

    /// Rests until `limit`, where the controls may jump, or until what acts is balanced no more, if the motion does.
    fn rest(&mut self, limit: f64) -> Result<bool, SimulationStatus> {
        let longest = limit - self.t;
        let Some((lasts, over)) = rest::lasts(&mut self.here(), longest) else {
            return Ok(false);
        };
        self.y[2 * self.dynamics.n] += lasts;
        self.t = if over { self.t + lasts } else { limit };
        self.journal.result.counts.elements += 1;
        if over {
            self.enter_mode(None, false)?;
        } else {
            self.begin()?;
            self.record();
            self.take_up_controls(Some(limit))?;
        }
        Ok(true)
    }

    /// Whether the switches of the last moment have led to a rest, into which the motion is put.
    fn comes_to_rest(&mut self) -> bool {
        let n = self.dynamics.n;
        let largest = self.method.slope()[n..2 * n].iter();
        let largest = largest.fold(0.0_f64, |size, a| size.max(a.abs()));
        let before = self.y.clone();
        let events = std::mem::take(&mut self.journal.result.events);
        let listed = events.iter().rev().map(|event| (event.time, event.contact));
        let within = (self.problem.horizon, largest);
        let switches = rest::comes_to_rest(&mut self.here(), listed, within);
        self.journal.result.events = events;
        let Some(switches) = switches else {
            return false;
        };
        // Where no mode was found all are open, but a switch always acts.
        let mut mode = self.dynamics.mode().to_vec();
        for i in switches {
            if mode[i].is_open() {
                mode[i] = ContactState::slip(1.0);
            }
        }
        self.dynamics.set_mode(&mode);
        if self.enter_mode(None, false).is_ok() && self.dynamics.rest.is_some() {
            return true;
        }
        self.dynamics.rest = None;
        self.y = before;
        false
    }

    /// Goes to the event after `h`, where the switching function vanishes, and into the mode after it, unless the motion is over there.
    fn pass(
        &mut self,
        h: f64,
        switch: Option<Switch>,
        ending: Option<Ending>,
    ) -> Result<bool, SimulationStatus> {
        self.t += h;
        let before = self.problem.horizon - self.t;
        let over = ending.is_some_and(|ending| ending.is_over(&self.dynamics, switch, before));
        if over {
            self.t = self.problem.horizon;
        }
        self.y.copy_from_slice(self.method.end());
        // What is rounding error of a gap here, steps that ended elsewhere do not tell.
        self.dynamics.observe(self.t, &self.y, self.h);
        self.method.finish(&mut self.dynamics, self.t, 0.0);
        self.audit_now();
        self.record();
        if !over {
            self.enter_mode(switch, false)?;
        }
        Ok(over)
    }

    /// Carries out the impacts that are known to end the motion, where rounding has put them behind its end.
    fn strike_at_the_end(&mut self, ending: Option<Ending>) -> Result<(), SimulationStatus> {
        let Some(ending) = ending else {
            return Ok(());
        };
        for &contact in ending.struck {
            if ending.is_due(&mut self.dynamics, contact, (self.t, &self.y)) {
                self.enter_mode(Some(Switch::Gap(contact)), false)?;
            }
        }
        Ok(())
    }

    /// Tells the measures of errors and zeros of the present state, whose derivative is known.
    fn observe(&mut self) {
        let n = self.dynamics.n;
        self.dynamics.observe(self.t, &self.y, self.h);
        let mass = self.dynamics.mass(self.t, &self.y);
        let slope = self.method.slope();
        self.step
            .error_scale
            .observe(mass, &self.y[n..2 * n], &slope[n..2 * n]);
    }

    /// Length of a step of at most `wanted` that tells what depends on time.
    fn foreseen(&mut self, wanted: f64) -> f64 {
        let Some(explicit_time) = &mut self.checks.explicit_time else {
            return wanted;
        };
        self.dynamics.load(self.t, &self.y);
        let longest = explicit_time.longest(self.dynamics.input(), wanted);
        if longest < wanted {
            self.h = longest;
        }
        longest
    }

    /// Tries a step of length `h`; `false` if it was rejected and `self.h` reduced.
    fn try_step(&mut self, h: f64) -> Result<bool, SimulationStatus> {
        let most = self.settings.max_steps + STEPS_AN_EVENT * self.journal.events();
        if self.counts.steps >= most {
            return Err(self.place().step_limit(self.counts.steps, h));
        }
        self.counts.steps += 1;
        self.dynamics.sample_from(&self.step.start_values);
        self.dynamics.prepare_step(self.t, &self.y, h);
        self.method.step(&mut self.dynamics, self.t, &self.y, h);
        let n = self.dynamics.n;
        let free = self.dynamics.free_acceleration().to_vec();
        let mass = self.dynamics.mass(self.t, &self.y);
        self.step
            .error_scale
            .try_end(mass, &self.method.end()[n..2 * n], &free);
        let (tolerance, scale) = (self.settings.tolerance, &self.step.error_scale);
        let allowed = |component, _| scale.allowed(component, h, tolerance);
        let mut error = self.method.error(h, allowed);
        if error <= 1.0 {
            let joined = self.dynamics.has_joints();
            let integrated = joined.then(|| self.method.end()[..2 * n].to_vec());
            if motion::project(&mut self.dynamics, self.t + h, self.method.end_mut()) {
                if let Some(integrated) = integrated {
                    let (scale, end) = (&mut self.step.error_scale, self.method.end());
                    let (moved, at) = ((&integrated[..], end), (self.t, &self.y[..], h));
                    let known = (error, tolerance);
                    error = step_size::with_joints(&mut self.dynamics, scale, known, moved, at);
                }
                self.method.finish(&mut self.dynamics, self.t, h);
            } else {
                error = f64::NAN;
            }
            // Beyond a pole of the contact forces lies another motion.
            if self.dynamics.orientation != self.step.orientation {
                error = f64::NAN;
            }
            let mut numbers = self
                .method
                .end_slope()
                .iter()
                .chain(&self.dynamics.switching.values);
            if self.dynamics.switching.undefined.is_some()
                || numbers.any(|number| !number.is_finite())
            {
                error = f64::NAN;
            }
        }
        if error > 1.0 || error.is_nan() {
            if self.step.rejected.hardly_falls((self.t, h), error) {
                let now = (self.t, &self.y[..], self.method.slope());
                let scale = &mut self.step.error_scale;
                step_size::observe_rounding(&mut self.dynamics, &mut self.dense, scale, now);
            }
            self.h = Dop853::smaller_size(h, error);
            if self.h <= SHORTEST * self.t.max(self.problem.horizon) {
                return Err(self.step_failure(error));
            }
            return Ok(false);
        }
        self.step
            .end_values
            .copy_from_slice(&self.dynamics.switching.values);
        self.step.at_end = audit::verdict(self.settings.tolerance);
        self.step.at_end.place = (self.t + h, self.journal.result.counts.elements);
        self.forces.measure(&self.dynamics, &mut self.step.at_end);
        // A step that was cut short says nothing against longer ones.
        let next = self.method.next_size(h, error);
        self.h = if h < self.h { next.max(self.h) } else { next };
        Ok(true)
    }

    fn write_outputs(&mut self, h: f64, until: f64) {
        let run = (&mut self.dynamics, &self.method);
        let trajectory = &mut self.journal.result.trajectory;
        self.dense.write(run, trajectory, (self.t, h, until));
    }

    /// The event of the step of length `h`, if there is one; none at all where the step has to be shorter.
    fn searched(&mut self, h: f64) -> Result<Option<Option<Found>>, SimulationStatus> {
        match self.find_event(h) {
            Outcome::Nothing => return Ok(Some(None)),
            Outcome::Event(event) => return Ok(Some(Some(event))),
            Outcome::Pole(found) => {
                let switch = self.dynamics.switch(found.function);
                return Err(self.place().pole(switch, found.h));
            }
            Outcome::Hidden => {
                self.h = 0.5 * h;
                if self.h <= SHORTEST * self.t.max(self.problem.horizon) {
                    return Err(self.place().unbounded(self.method.slope()));
                }
            }
            Outcome::Unresolved(function) => {
                self.shorten(h, self.dynamics.switch(function).contact())?;
            }
        }
        Ok(None)
    }

    fn find_event(&mut self, h: f64) -> Outcome {
        let outputs_due = self.dense.are_due(self.t, h);
        let step = Step {
            t: self.t,
            h,
            y: &self.y,
            start_values: &self.step.start_values,
            end_values: &self.step.end_values,
        };
        let explicit_time = self.checks.explicit_time.as_ref();
        self.search.too_fast = explicit_time.is_some_and(ExplicitTime::is_too_fast);
        let (dynamics, method) = (&mut self.dynamics, &mut self.method);
        let search = self.search.suspect(dynamics, method, step);
        let looks = self.settings.tolerance <= yardstick::PROMISE && !self.search.is_calm(dynamics);
        if !search && !outputs_due && !looks {
            return Outcome::Nothing;
        }
        method.extend(dynamics, self.t, &self.y, h);
        if search || looks {
            self.search.follow(method);
        }
        if looks {
            let Some(parts) = self.search.calm_parts() else {
                return Outcome::Hidden;
            };
            let (scale, known) = (
                &self.step.error_scale,
                (&parts[..], self.settings.tolerance),
            );
            if hide(&parts) && hidden::acts(dynamics, method, scale, (self.t, h), known) {
                return Outcome::Hidden;
            }
        }
        if !search {
            return Outcome::Nothing;
        }
        self.search.earliest(&mut Made {
            dynamics,
            method,
            step,
        })
    }

    /// Makes the next try shorter than the step of length `h`, in which the events of `contact` cannot be found.
    fn shorten(&mut self, h: f64, contact: usize) -> Result<(), SimulationStatus> {
        self.h = UNRESOLVED * h;
        if self.h > SHORTEST * self.t.max(self.problem.horizon) {
            return Ok(());
        }
        Err(self.place().events_too_close(contact))
    }

    /// Refuses endless switching at one instant.
    fn guard_progress(
        &mut self,
        switch: Option<Switch>,
        until: f64,
    ) -> Result<(), SimulationStatus> {
        if until > SAME_INSTANT * self.problem.horizon.max(self.t) {
            self.counts.repeats = 0;
            return Ok(());
        }
        self.counts.repeats += 1;
        if self.counts.repeats <= REPEATS * (1 + self.dynamics.contacts) {
            return Ok(());
        }
        if let Some(status) = self.jamming() {
            return Err(status);
        }
        let place = self.place();
        Err(match switch {
            None => place.unbounded(self.method.slope()),
            Some(switch) => place.unsettled(switch, self.counts.repeats),
        })
    }

    /// Applies the impact law and finds the contact mode right after the present instant, records both
    /// sides, and prepares the next step. `vanished` is the switching function that has just vanished.
    fn enter_mode(
        &mut self,
        vanished: Option<Switch>,
        at_start: bool,
    ) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let before = self.y[n..2 * n].to_vec();
        let previously = self.dynamics.mode().to_vec();
        let outlook = Outlook {
            moment: self.h,
            longest: self.problem.horizon,
            skipped: self.counts.repeats / PATIENCE,
        };
        let vanished = self.dynamics.pass_edge(vanished);
        self.dynamics
            .observe_rounding(self.t, &self.y, self.h, at_start);
        let set = self.here().conditions(vanished);
        let (mut set, vanished) = set.map_err(|problem| self.place().undetermined(problem))?;
        let (mut impact, mut resting) = self.impact(vanished)?;
        if !impact.struck.is_empty() {
            let made_true = resets::set(&mut self.here(), Vec::new());
            set.extend(made_true.map_err(|problem| self.place().undetermined(problem))?);
        }
        if at_start && !impact.struck.is_empty() {
            let after = self.y[n..2 * n].to_vec();
            self.y[n..2 * n].copy_from_slice(&before);
            self.record();
            self.y[n..2 * n].copy_from_slice(&after);
        }
        // An impact changes velocities and forces: what has vanished before it may not have done so after.
        let mut vanished = vanished.filter(|_| impact.struck.is_empty());
        loop {
            let (dynamics, probe, y) = (&mut self.dynamics, &mut self.probe, &mut self.y);
            contact_mode::change(dynamics, probe, self.t, y, &resting, vanished, outlook)
                .map_err(|problem| self.place().undetermined(problem))?;
            if at_start {
                break;
            }
            let turned = resets::set_turned(&mut self.here(), &previously, &mut set);
            if !turned.map_err(|problem| self.place().undetermined(problem))? {
                break;
            }
            // What was set may lead into a surface.
            let (next, rests) = self.impact(None)?;
            impact.struck.extend(next.struck);
            resting = rests;
            vanished = None;
        }
        if at_start {
            self.journal.result.initial_modes = self.dynamics.contact_modes();
        }
        self.begin()?;
        switching::accept_forces(&mut self.dynamics);
        self.record();
        self.observe();
        let happened = changes::of(
            self.dynamics.model.declaration().contacts,
            (&previously, self.dynamics.mode()),
            (&impact.struck, &set),
            at_start,
        );
        let last = happened.last().map(|(_, contact)| *contact);
        let instant = ((self.t, &self.y[..]), &before[..]);
        self.journal
            .list(&self.dynamics, happened, instant, self.problem.horizon)?;
        let count = self.journal.events();
        if count > self.settings.max_events {
            return Err(self.place().too_many_events(count, last));
        }
        Ok(())
    }

    /// The present instant, as what happens there reads it.
    fn here(&mut self) -> Here<'_, 'a> {
        Here {
            dynamics: &mut self.dynamics,
            time: self.t,
            y: &mut self.y,
            lowest: LowestBounce {
                velocity: self.settings.rest_velocity,
                height: self.settings.tolerance.powi(2),
            },
        }
    }

    /// Applies the impact law, and remembers what a user should know of it. Returns the contacts at rest after it as well.
    fn impact(
        &mut self,
        vanished: Option<Switch>,
    ) -> Result<(Impact, Vec<usize>), SimulationStatus> {
        let closing = match vanished {
            Some(Switch::Gap(contact)) => Some(contact),
            _ => None,
        };
        let impact = self.here().impact(closing);
        let (impact, resting) = impact.map_err(|problem| self.place().undetermined(problem))?;
        self.y[2 * self.dynamics.n] += impact.impulse / self.settings.auxiliary_acceleration;
        self.checks.remarks.add(self.t, &impact);
        Ok((impact, resting))
    }

    /// Evaluates derivative, values and forces at the present state.
    fn begin(&mut self) -> Result<(), SimulationStatus> {
        self.method.begin(&mut self.dynamics, self.t, &self.y);
        self.step
            .start_values
            .copy_from_slice(&self.dynamics.switching.values);
        self.audit_now();
        if self.method.slope().iter().all(|slope| slope.is_finite()) {
            self.step.orientation = self.dynamics.orientation;
            Ok(())
        } else {
            Err(self.place().not_finite(self.method.slope()))
        }
    }

    /// Takes the forces last evaluated, and looks at the conditions of all contacts there.
    fn audit_now(&mut self) {
        let place = (self.t, self.journal.result.counts.elements);
        let (verdict, dynamics) = (&mut self.checks.verdict, &self.dynamics);
        audit::look(verdict, dynamics, &dynamics.switching.values, place);
        self.forces.measure(dynamics, verdict);
    }

    /// Records the start of a run that never left it.
    fn record_start(&mut self) {
        let n = self.dynamics.n;
        self.y[..n].copy_from_slice(&self.problem.q);
        self.y[n..2 * n].copy_from_slice(&self.problem.v);
        self.forces.normal.fill(0.0);
        self.forces.tangential.fill(0.0);
        self.record();
    }

    fn record(&mut self) {
        self.dynamics.write_controls(self.t);
        let (now, forces) = ((self.t, &self.y[..]), &self.forces);
        let forces = (&forces.normal[..], &forces.tangential[..]);
        outputs::record(
            &mut self.journal.result.trajectory,
            &self.dynamics,
            now,
            forces,
        );
    }

    /// Looks at forces and gaps inside the first `until` of the step of length `h`, whose continuous extension is
    /// ready.
    fn audit_inside(&mut self, h: f64, until: f64) {
        let (step, dense) = (self.journal.result.counts.elements, &mut self.dense);
        let run = (&mut self.dynamics, &self.method);
        let memory = (&mut dense.state[..], &mut dense.slope[..]);
        let verdict = &mut self.checks.verdict;
        audit::look_inside(verdict, run, memory, (self.t, h, until), step);
    }

    /// The present place, for what has to be said of it.
    fn place(&self) -> Place<'_, 'a> {
        Place {
            dynamics: &self.dynamics,
            time: self.t,
            step: self.journal.result.counts.elements,
        }
    }

    /// The status where the force of a sliding contact grows beyond all bounds.
    fn jamming(&mut self) -> Option<SimulationStatus> {
        self.dynamics
            .derivative(self.t, &self.y, &mut self.dense.slope);
        self.place().jamming()
    }

    fn step_failure(&mut self, error: f64) -> SimulationStatus {
        if let Some(status) = self.jamming() {
            return status;
        }
        self.dynamics.load(self.t, &self.y);
        let start = self.problem.input(self.dynamics.model);
        let step = (self.h, self.settings.tolerance, error);
        let slope = self.method.slope();
        self.place().step_too_short(step, &start, slope)
    }
}
