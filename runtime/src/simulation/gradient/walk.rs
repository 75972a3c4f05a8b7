//! Along a motion that is known: derivatives over its smooth arcs, and across its events.
//!
//! With a [`Tape`] the walk carries one direction of all quantities, which the checks look at, and records what is linear on the
//! way; [`adjoint`](super::adjoint) goes back along that.

use super::cause::{self, Before};
use super::front::{Front, shift};
use super::joint_rows::JointRows;
use super::jump::{Impact, jump};
use super::margins::{Of, margins};
use super::matrix::{Matrix, add, largest};
use super::outputs::{Instant, outputs};
use super::place::{DRIFT, HELD, Place, ROUNDING};
use super::projection::project;
use super::ranges::{Ranges, SequenceRange};
use super::reset;
use super::samples::Samples;
use super::tape::Tape;
use super::wanted::Wanted;
use crate::model::{Model, Switching};
use crate::simulation::{ContactMode, Event, EventKind, InitialValueProblem, Simulation};

/// Distance of a step from the known motion, relative to the largest values of that, above which it is another motion.
const ANOTHER: f64 = 1e-5;
/// Share of the largest velocity that what conditions and impacts change may miss.
const MISSED: f64 = 1e-6;
/// Share of accelerations that balance which rounding may leave.
const BALANCED: f64 = 1e-12;

/// The derivatives along a motion.
pub(super) struct Walk<'w> {
    pub(super) at: Place<'w>,
    joints: Option<JointRows<'w>>,
    /// Whether what has no derivative is refused.
    checked: bool,
    /// Derivatives of the times of the events passed.
    pub(super) event_times: Vec<Vec<f64>>,
    /// Derivatives of `(q, v)` at the instants passed.
    pub(super) states: Vec<Matrix>,
    /// The same of the outputs.
    pub(super) outputs: Vec<Matrix>,
    /// What is looked at between the instants, if anything is.
    pub(super) samples: Option<Samples<'w>>,
    /// How far quantities may go, if that is asked for.
    pub(super) ranges: Option<Ranges>,
    /// What is linear on the way, where the walk goes back.
    pub(super) tape: Option<Tape<'w>>,
}

impl<'w> Walk<'w> {
    pub(super) fn new(
        model: &'w dyn Model,
        problem: &'w InitialValueProblem,
        run: &'w Simulation,
        wanted: &'w Wanted,
    ) -> Option<Self> {
        Some(Self {
            at: Place::at_start(model, problem, run, wanted)?,
            joints: JointRows::of(model, wanted.columns()),
            checked: true,
            event_times: Vec::with_capacity(run.events.len()),
            states: Vec::with_capacity(run.trajectory.time.len()),
            outputs: Vec::new(),
            samples: None,
            ranges: None,
            tape: None,
        })
    }

    /// Walks to the end.
    ///
    /// # Errors
    /// Why there are no derivatives from some instant on.
    pub(super) fn run(&mut self) -> Result<(), String> {
        let times = &self.at.run.trajectory.time;
        let mut first = 0;
        let mut passed = 0;
        self.at.enter(0)?;
        if let Some(samples) = &mut self.samples {
            let front = &self.at.front;
            let state = (&front.state, &front.impulses);
            samples.begin(&self.at.acceleration, (front.wanted, self.at.run), state);
        }
        loop {
            let time = times[first];
            let last = times.partition_point(|&t| t <= time) - 1;
            let events = &self.at.run.events[passed..];
            let here = events.partition_point(|event| event.time <= time);
            let events = &events[..here];
            passed += here;
            if last > first {
                self.at.evaluate(first)?;
                self.record(first..last);
            }
            if self.ranges.is_some() && events.is_empty() {
                self.at.evaluate(first)?;
                let ends = (last + 1 == times.len()).then(|| self.at.horizon_moves());
                self.end_range(first, ends.as_deref())?;
            }
            if events.is_empty() {
                self.at.evaluate(last)?;
            } else {
                self.pass_recorded(events, (first, last))?;
            }
            let begins = first == 0 || !events.is_empty();
            if first == 0 && events.is_empty() {
                self.check_all(last)?;
            }
            self.at
                .check_holds(last, if begins { HELD } else { DRIFT })?;
            self.put_back(last)?;
            self.record(last..last + 1);
            if last + 1 == times.len() {
                return self.check_end(last);
            }
            if let Some(ranges) = &mut self.ranges {
                let times = self.event_times.last().filter(|_| last > 0);
                let times = times.map_or(&[][..], |times| times);
                ranges.begin(&mut self.at, (last, begins), times);
            }
            self.step(last)?;
            first = last + 1;
        }
    }

    /// The motion does not end with an event, nor right before one, that moves away from its last instant, where the acceleration is
    /// evaluated.
    fn check_end(&mut self, last: usize) -> Result<(), String> {
        let times = &self.at.run.trajectory.time;
        let (time, begin) = (times[last], times[0]);
        let ends = self.at.horizon_moves();
        let late = |event: &&Event| event.time > begin && event.time >= time * (1.0 - ROUNDING);
        let happened = self.at.run.events.last().filter(late);
        let moves = self.event_times.last().is_some_and(|times| {
            let least = ROUNDING * largest(times).max(largest(&ends));
            let mut both = times.iter().zip(&ends);
            both.any(|(own, end)| (own - end).abs() > least)
        });
        let name = happened.filter(|_| moves).map(|event| event.contact_name);
        match name.or_else(|| self.about_to_happen(last, &ends)) {
            None => Ok(()),
            Some(name) => Err(format!(
                "the motion ends at t = {time} s with an event at `{name}`, so that its end has different derivatives to both \
                 sides; take another horizon"
            )),
        }
    }

    /// Where an event happens within rounding of an instant, from which it moves away if that moves by `ends`.
    fn about_to_happen(&mut self, k: usize, ends: &[f64]) -> Option<&'static str> {
        let x = self.at.input(k);
        let controls = self.at.controls(self.at.run.trajectory.time[k]);
        let at = (&x[..], controls.slopes());
        let margins = margins(&mut self.at.acceleration, &self.at.modes, at);
        let declared = self.at.acceleration.model.declaration().contacts;
        let (wanted, state) = (self.at.front.wanted, &self.at.front.state);
        for margin in &margins {
            let resets = declared[margin.contact].switch == Some(Switching::Resets);
            let (size, rate) = match margin.of {
                Of::Gap => (self.at.gap_sizes[margin.contact], margin.rate),
                // A condition that ceases to hold is no event.
                Of::Sliding(sense) if resets => (margin.size, sense * margin.rate),
                Of::Sliding(_) => (margin.size.max(self.at.sizes[1]), margin.rate),
                Of::Force | Of::Left(_) => continue,
            };
            let moves = |(column, end): (usize, &f64)| {
                let terms = (0..2 * self.at.acceleration.n)
                    .map(|i| (margin.by[i] * state.row(i)[column]).abs());
                let along = (margin.rate * end).abs() + wanted.own(&margin.by, column).abs();
                let change = wanted.along(&margin.by, state, column) + margin.rate * end;
                change.abs() > ROUNDING * (terms.sum::<f64>() + along)
            };
            let close = rate < 0.0 && margin.value <= ROUNDING * size;
            if close && ends.iter().enumerate().any(moves) {
                return Some(declared[margin.contact].name);
            }
        }
        None
    }

    /// Keeps what is known at some instants.
    fn record(&mut self, instants: std::ops::Range<usize>) {
        if self.tape.is_some() {
            return;
        }
        for k in instants {
            let front = &self.at.front;
            self.states.push(front.state.clone());
            if !self.at.acceleration.model.outputs().is_empty() {
                let at = Instant::recorded(self.at.acceleration.model, &self.at.run.trajectory, k);
                let (state, impulses) = (&front.state, &front.impulses);
                let by = outputs(&self.at.acceleration, front.wanted, &at, state, impulses);
                self.outputs.push(by);
            }
        }
    }

    /// Goes from an instant to the next one.
    fn step(&mut self, k: usize) -> Result<(), String> {
        let trajectory = &self.at.run.trajectory;
        let controls = self.at.controls(trajectory.time[k]);
        let step = self.at.step_to(k + 1, &controls);
        let before = self.samples.is_some().then(|| self.at.front.state.clone());
        let front = &mut self.at.front;
        let (state, cost) = (&mut front.state, front.cost.as_mut());
        let lean = self.tape.as_mut().map(|tape| &mut tape.lean);
        let acceleration = (&mut self.at.acceleration, lean);
        let missed = self
            .at
            .arc
            .step(acceleration, front.wanted, step, state, cost);
        let missed = missed.ok_or_else(|| self.at.undetermined(k))?;
        let h = trajectory.time[k + 1] - trajectory.time[k];
        // What balances leaves its rounding.
        let balanced = BALANCED * h * largest(&self.at.acceleration.free);
        let limits = [
            ANOTHER * self.at.sizes[0] + h * balanced,
            ANOTHER * self.at.sizes[1] + balanced,
        ];
        let mut pairs = missed.iter().zip(limits);
        if pairs.any(|(missed, limit)| missed.is_nan() || *missed > limit) {
            return Err(format!(
                "between t = {} s and {} s the motion is not that of one contact mode without events; simulate with a smaller \
                 tolerance",
                trajectory.time[k],
                trajectory.time[k + 1]
            ));
        }
        if let Some(tape) = &mut self.tape {
            let cost = self.at.front.cost.as_ref();
            tape.step(self.at.arc.linear(&self.at.acceleration, step, cost));
        }
        self.at.check_touches(step, k)?;
        if let (Some(samples), Some(before)) = (&mut self.samples, before) {
            let acceleration = (&mut self.at.acceleration, self.at.front.wanted);
            samples.within(
                acceleration,
                (&self.at.arc, step),
                (&before, &self.at.front.impulses),
                (self.at.run, k),
            );
        }
        Ok(())
    }

    /// Looks at how far quantities may go within the step that ends at instant `k`.
    fn end_range(&mut self, k: usize, arc_ends: Option<&[f64]>) -> Result<(), String> {
        match &mut self.ranges {
            Some(ranges) => ranges.end(&mut self.at, k, arc_ends),
            None => Ok(()),
        }
    }

    /// Puts derivatives back onto what joints and contacts hold at an instant, where the acceleration is evaluated.
    fn put_back(&mut self, k: usize) -> Result<(), String> {
        let x = self.at.input(k);
        let closed = match &mut self.joints {
            Some(joints) => joints.evaluate(self.at.front.wanted, &x),
            None if self.at.acceleration.holds.is_empty() => return Ok(()),
            None => true,
        };
        if !closed {
            return Err(format!(
                "at t = {} s equations of joints depend on each other, so that the motion has no derivatives there",
                self.at.run.trajectory.time[k]
            ));
        }
        let (acceleration, joints) = (&self.at.acceleration, &self.joints);
        let back = |front: &mut Front<'_>| {
            if let Some(joints) = joints {
                joints.project(front.wanted, &mut front.state);
            }
            project(acceleration, front.wanted, &mut front.state);
        };
        if let Some(tape) = &mut self.tape {
            let mut present = tape.present();
            back(&mut present);
            tape.event(present);
        }
        back(&mut self.at.front);
        Ok(())
    }

    /// With a tape, checks at the start what contacts hold for each quantity.
    fn check_all(&mut self, k: usize) -> Result<(), String> {
        let Some(asked) = self.tape.as_ref().map(|tape| tape.asked) else {
            return Ok(());
        };
        let all = Front::at_start(self.at.acceleration.model, self.at.problem, asked);
        let front = std::mem::replace(&mut self.at.front, all);
        let checked = self.at.check_holds(k, HELD);
        self.at.front = front;
        checked
    }

    /// Passes events; with a tape, once for what that changes of each derivative, and at the start once for all quantities, whose
    /// checks look at each of them there.
    fn pass_recorded(&mut self, events: &[Event], range: (usize, usize)) -> Result<(), String> {
        let Some(mut tape) = self.tape.take() else {
            return self.pass(events, range);
        };
        let (holds, given) = (
            self.at.acceleration.holds.clone(),
            self.at.acceleration.given.clone(),
        );
        let modes = self.at.modes.clone();
        let model = self.at.acceleration.model;
        let again = |walk: &mut Self| {
            walk.at.modes.clone_from(&modes);
            walk.at.acceleration.holds.clone_from(&holds);
            walk.at.acceleration.given.clone_from(&given);
            walk.event_times
                .truncate(walk.event_times.len() - events.len());
        };
        let front = std::mem::replace(&mut self.at.front, tape.present());
        self.checked = false;
        let passed = self.pass(events, range);
        self.checked = true;
        passed?;
        tape.times(&self.event_times[self.event_times.len() - events.len()..]);
        again(self);
        if range.0 == 0 {
            let all = Front::at_start(model, self.at.problem, tape.asked);
            tape.event(std::mem::replace(&mut self.at.front, all));
            self.pass(events, range)?;
            self.at.check_holds(range.1, HELD)?;
            again(self);
            self.at.front = front;
        } else {
            tape.event(std::mem::replace(&mut self.at.front, front));
        }
        self.tape = Some(tape);
        self.pass(events, range)
    }

    /// Passes the events between two instants of the same time.
    fn pass(&mut self, events: &[Event], (first, last): (usize, usize)) -> Result<(), String> {
        let (n, m) = (self.at.acceleration.n, self.at.front.wanted.count());
        let (x_before, x_after) = (self.at.input(first), self.at.input(last));
        let mut times = vec![0.0; m];
        let mut before = vec![0.0; n];
        if first > 0 {
            self.at.evaluate(first)?;
            before.clone_from(&self.at.acceleration.value);
            times = self.time_of(events, first)?;
            self.end_range(first, Some(&times))?;
            if let Some(ranges) = &mut self.ranges {
                ranges.pass(&self.at, events, &times);
            }
        }
        let mut moved = self.at.front.state.clone();
        let v = &self.at.run.trajectory.v;
        shift(&mut moved, (&v[first], &before), &times, 1.0);
        self.change(events, (&x_before, &x_after), (&mut moved, &times), first)?;
        if let Some(event) = events.last() {
            self.at.modes.clone_from(&event.modes);
        }
        self.at.enter(last)?;
        let after = (&v[last][..], &self.at.acceleration.value[..]);
        shift(&mut moved, after, &times, -1.0);
        self.at.front.state = moved;
        if let Some(cost) = &mut self.at.front.cost {
            let model = self.at.acceleration.model;
            for (x, sense) in [(&x_before, 1.0), (&x_after, -1.0)] {
                cost.move_limit(model, x, &times, sense);
            }
        }
        self.event_times
            .extend(events.iter().map(|_| times.clone()));
        Ok(())
    }

    /// What events at instant `k` change of the velocities, from one input vector to the other, with the derivatives `moved` of `(q, v)`
    /// where they happen: conditions set what they ask for, contacts are struck, and so come true what other conditions wait for.
    fn change(
        &mut self,
        events: &[Event],
        (x_before, x_after): (&[f64], &[f64]),
        (moved, times): (&mut Matrix, &[f64]),
        k: usize,
    ) -> Result<(), String> {
        let time = self.at.run.trajectory.time[k];
        let when = |event: &&Event| event.kind == EventKind::When;
        let conditions: Vec<usize> = events.iter().filter(when).map(|e| e.contact).collect();
        let mut x = x_before.to_vec();
        let mut first = 0;
        while let Some(&condition) = conditions.get(first) {
            if !self.at.holds(condition, (&x, time)) {
                break;
            }
            self.set(condition, (&mut x, moved), times, k);
            first += 1;
        }
        let late = &conditions[first..];
        let (model, wanted) = (self.at.acceleration.model, self.at.front.wanted);
        let behind = reset::before(model, wanted, late, (&x, x_after));
        let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
        if jumps || self.at.velocities_differ(&x, &behind, ROUNDING) {
            self.strike(events, (&x, &behind), (moved, times), k)?;
            x = behind;
        }
        for &condition in late {
            self.set(condition, (&mut x, moved), times, k);
        }
        if self.at.velocities_differ(&x, x_after, MISSED) {
            return Err(format!(
                "at t = {time} s `{}` sets something together with another event: which of them is first for other parameters is not known",
                self.at.acceleration.model.declaration().contacts[conditions[0]].name
            ));
        }
        Ok(())
    }

    /// Sets what a condition asks for.
    fn set(
        &mut self,
        condition: usize,
        (x, moved): (&mut [f64], &mut Matrix),
        times: &[f64],
        k: usize,
    ) {
        let controls = self.at.controls(self.at.run.trajectory.time[k]);
        let (model, wanted) = (self.at.acceleration.model, self.at.front.wanted);
        let of = (condition, controls.slopes());
        reset::set(model, wanted, of, (x, moved), times);
    }

    /// What an impact at instant `k` changes.
    fn strike(
        &mut self,
        events: &[Event],
        (x_before, x_after): (&[f64], &[f64]),
        (moved, times): (&mut Matrix, &[f64]),
        k: usize,
    ) -> Result<(), String> {
        let after_modes = events.last().map_or(&[][..], |event| &event.modes);
        let struck = self.struck(events, after_modes);
        if k == 0 && self.checked {
            self.at.check_start(&struck)?;
        }
        for &contact in struck.iter().filter(|_| self.checked) {
            self.at.check_laws(contact, k)?;
        }
        let impact = Impact {
            before: x_before,
            after: x_after,
            struck: &struck,
            time: self.at.run.trajectory.time[k],
            moved,
            times,
        };
        let jump = jump(&mut self.at.acceleration, self.at.front.wanted, &impact)?;
        if let Some(ranges) = &mut self.ranges {
            let impact = (&struck[..], events);
            let by = (&*moved, &jump.velocities);
            let impulses = (times, &jump.impulses);
            ranges.strike(&mut self.at, impact, (x_before, x_after), by, impulses);
        }
        let first = moved.values.len() / 2;
        moved.values[first..].copy_from_slice(&jump.velocities.values);
        let impulses = &mut self.at.front.impulses.values;
        add(impulses, 1.0, &jump.impulses.values);
        Ok(())
    }

    /// Derivatives of the time of events; the motion is evaluated right before.
    fn time_of(&mut self, events: &[Event], k: usize) -> Result<Vec<f64>, String> {
        let x = self.at.input(k);
        let time = self.at.run.trajectory.time[k];
        let controls = self.at.controls(time);
        let before = Before {
            modes: &self.at.modes,
            v: &self.at.run.trajectory.v[k],
            control_rates: controls.slopes(),
            state: &self.at.front.state,
            closing_speeds: &self.at.closing_speeds,
            sizes: self.at.sizes,
            checked: self.checked,
        };
        let wanted = self.at.front.wanted;
        let times = cause::time(&mut self.at.acceleration, wanted, &x, events, &before)?;
        let switches = || {
            let before = self
                .at
                .problem
                .controls
                .next_break(time * (1.0 - f64::EPSILON) - f64::MIN_POSITIVE);
            before == Some(time)
        };
        match times {
            Some(times) => Ok(times),
            // Controls change at times that nothing moves.
            None if switches() => Ok(vec![0.0; wanted.count()]),
            None => Err(format!(
                "at t = {time} s nothing vanishes that says when the {} at `{}` happens for other parameters",
                events[0].kind, events[0].contact_name
            )),
        }
    }

    /// Contacts that take part in a jump: those with impulses, and those that close.
    fn struck(&self, events: &[Event], after: &[ContactMode]) -> Vec<usize> {
        let impulses = events
            .iter()
            .find(|event| !event.contact_impulse.is_empty());
        let impulses = impulses.map_or(&[][..], |event| &event.contact_impulse);
        let least = ROUNDING * largest(impulses);
        let declared = self.at.acceleration.model.declaration().contacts;
        (0..declared.len())
            .filter(|&i| {
                let closes = self.at.modes.get(i) == Some(&ContactMode::Open)
                    && after.get(i).is_some_and(|mode| *mode != ContactMode::Open);
                let strikes = impulses.get(i).is_some_and(|impulse| *impulse > least);
                !declared[i].dry && (closes || strikes)
            })
            .collect()
    }

    /// How far quantities may go, at the end.
    pub(super) fn ranges(&mut self) -> Vec<SequenceRange> {
        let ranges = self.ranges.take();
        ranges.map_or_else(Vec::new, |ranges| ranges.finish(&self.at))
    }

    /// What was looked at, to the end of the motion.
    pub(super) fn observed(&mut self) -> Option<Samples<'w>> {
        let mut samples = self.samples.take()?;
        let motion = (self.at.problem, self.at.run);
        samples.go_on(&mut self.at.acceleration, &mut self.at.arc, motion);
        Some(samples)
    }

    /// Derivatives at the end, which moves with the horizon: of `(q, v)`; of the outputs; and of the objective, if they are known.
    pub(super) fn end(&mut self) -> End {
        let last = self.at.run.trajectory.time.len() - 1;
        let (x, at) = (
            self.at.input(last),
            Instant::recorded(self.at.acceleration.model, &self.at.run.trajectory, last),
        );
        let controls = self.at.controls(self.at.run.trajectory.time[last]);
        let (model, front) = (self.at.acceleration.model, &mut self.at.front);
        let moves = front.wanted.of_horizon(model, self.at.problem);
        let (q, v) = (
            &self.at.run.trajectory.q[last],
            &self.at.run.trajectory.v[last],
        );
        let mut recorded = Matrix::zeros(model.outputs().len(), front.wanted.count());
        if !model.outputs().is_empty() {
            let by = (&front.state, &front.impulses);
            recorded = outputs(&self.at.acceleration, front.wanted, &at, by.0, by.1);
            if moves.iter().any(|moves| *moves != 0.0) {
                let time = front.wanted.in_time(controls.slopes().to_vec());
                let rates = Matrix {
                    columns: 1,
                    values: [v, &self.at.acceleration.value[..]].concat(),
                };
                let impulses = Matrix::zeros(front.impulses.values.len() / moves.len(), 1);
                let rates = outputs(&self.at.acceleration, &time, &at, &rates, &impulses);
                for (output, rate) in rates.values.iter().enumerate() {
                    add(recorded.row_mut(output), *rate, &moves);
                }
            }
        }
        let mut state = front.state.clone();
        shift(&mut state, (v, &self.at.acceleration.value), &moves, 1.0);
        let objective = front.cost.as_mut().map(|cost| {
            cost.move_limit(model, &x, &moves, 1.0);
            let z = [q, v, &[self.at.run.trajectory.time[last]][..]].concat();
            cost.at_the_end(&z, &state, &moves)
        });
        End {
            state,
            outputs: recorded,
            objective,
            event_times: self.event_times.clone(),
        }
    }
}

/// Derivatives at the end of a motion.
pub(super) struct End {
    pub(super) state: Matrix,
    pub(super) outputs: Matrix,
    pub(super) objective: Option<Vec<f64>>,
    /// Of the times of all events.
    pub(super) event_times: Vec<Vec<f64>>,
}
