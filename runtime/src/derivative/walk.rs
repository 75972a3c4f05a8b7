//! Along a motion that is known: derivatives over its smooth arcs, and across its events.
//!
//! With a [`Tape`] the walk carries one direction of all quantities, which the checks look at, and records what is linear on the
//! way; [`adjoint`](super::adjoint) goes back along that. What an event changes is linear as well, and is found by carrying the derivatives of
//! everything by itself beside that direction.

use super::crossing::{Crossing, apart, contacts_of};
use super::event::{Cause, causes};
use super::existence::Existence;
use super::joint_rows::JointRows;
use super::margins::{Margin, least, margins};
use super::mode::Acceleration;
use super::outputs::outputs;
use super::place::Place;
use super::projection::project;
use super::quantities::Quantities;
use super::ranges::Ranges;
use super::samples::Samples;
use super::step::stage_input;
use super::tangent::{Layout, Matrix, Tangent, add};
use super::tape::Tape;
use crate::linalg::products::largest;
use crate::model::Model;
use crate::simulation::{Event, InitialValueProblem, Simulation};
use crate::yardstick;

/// Distance of a step from the known motion, relative to the largest values of that, above which it is another motion.
const ANOTHER: f64 = 1e-5;
/// The derivatives along a motion.
pub(super) struct Walk<'w> {
    pub(super) at: Place<'w>,
    /// Derivatives at present, at a fixed time.
    pub(super) tangent: Tangent,
    /// Rates of everything along the motion, carried as one more column of derivatives: what steps miss where forces have roots of what
    /// vanishes at an event they miss of both, and nothing of derivatives at an instant that moves with the event.
    flow: Tangent,
    pub(super) existence: Existence,
    joints: Option<JointRows<'w>>,
    /// How the horizon changes with the parameters.
    horizon: Vec<f64>,
    /// What the motion itself is off, as a share of the largest values: distances of steps from it, which add like those of a random walk.
    pub(super) missed: f64,
    /// Margins at the start of the step that comes, and the derivatives there.
    begin: Option<(Vec<Margin>, Tangent)>,
    /// Derivatives of the times of the events passed.
    pub(super) event_times: Vec<Vec<f64>>,
    /// Derivatives of `(q, v)` at the instants passed.
    pub(super) states: Vec<Matrix>,
    /// Derivatives of the outputs at the instants passed.
    pub(super) outputs: Vec<Matrix>,
    /// What is looked at between the instants, if anything is.
    pub(super) samples: Option<Samples<'w>>,
    /// How far quantities may go, if that is asked for.
    pub(super) ranges: Option<Ranges>,
    /// What is linear on the way, where the walk goes back.
    pub(super) tape: Option<Tape>,
    /// Acceleration that knows its derivatives by the state only, for Newton's method, if that pays.
    lean: Option<Acceleration<'w>>,
}

impl<'w> Walk<'w> {
    /// At the start, with the derivatives there, a column for each of these names.
    pub(super) fn new(
        model: &'w dyn Model,
        (problem, run): (&'w InitialValueProblem, &'w Simulation),
        quantities: &Quantities,
        (tangent, names): (Tangent, &[String]),
    ) -> Option<Self> {
        let at = Place::at_start(model, (problem, run), quantities)?;
        // Of one column few derivatives are asked for.
        let lean = (tangent.all.columns == 1).then(|| quantities.lean(model));
        let lean = lean.flatten();
        Some(Self {
            joints: JointRows::of(model, at.acceleration.columns),
            at,
            horizon: quantities.horizon(model, problem),
            missed: 0.0,
            flow: Tangent::zeros(tangent.layout, 1),
            tangent,
            existence: Existence::of(names),
            begin: None,
            event_times: Vec::with_capacity(run.events.len()),
            states: Vec::with_capacity(run.trajectory.time.len()),
            outputs: Vec::new(),
            samples: None,
            ranges: None,
            tape: None,
            lean: lean.map(|known| Acceleration::new(model, (known, Layout::of(model, 1)))),
        })
    }

    /// Walks to the end, or to where no derivative is left; `false` there.
    pub(super) fn run(&mut self) -> bool {
        if let Err(why) = self.walk() {
            self.existence.lose_all(&why);
        }
        !self.existence.is_over()
    }

    fn walk(&mut self) -> Result<(), String> {
        let run = self.at.run;
        let times = &run.trajectory.time;
        let (mut first, mut passed, mut middle) = (0, 0, 0.0);
        self.at.enter(0)?;
        if let Some(samples) = &mut self.samples {
            samples.begin(&self.at, &self.tangent);
        }
        while !self.existence.is_over() {
            let time = times[first];
            let last = times.partition_point(|&t| t <= time) - 1;
            let here = run.events[passed..].partition_point(|event| event.time <= time);
            let events = &run.events[passed..passed + here];
            passed += here;
            if last > first {
                self.record(first..last);
            }
            let ends = last + 1 == times.len();
            if events.is_empty() {
                let moves = ends.then(|| self.ends());
                self.end_step(first, &[], (moves.as_deref(), ends));
                if last > first {
                    self.at.evaluate(last)?;
                }
            } else {
                self.pass_recorded(events, (first, last))?;
            }
            let begins = first == 0 || !events.is_empty();
            let share = if begins {
                yardstick::PROMISE
            } else {
                yardstick::VISIBLE
            };
            let here = (&mut self.at, &self.tangent);
            self.existence.check_holds(here, (last, share));
            self.put_back(last)?;
            if ends {
                let (times, moves) = (self.event_times.last(), self.ends());
                let times = times.map(Vec::as_slice);
                self.existence.check_end(&self.at, times, (last, &moves));
                self.record(last..last + 1);
                return Ok(());
            }
            self.record(last..last + 1);
            if last > first {
                self.begin = None;
            }
            self.begin_step(last, begins, events);
            first = last + 1;
            if begins {
                let next = run.events.get(passed).map(|event| event.time);
                middle = (time + next.unwrap_or(times[times.len() - 1])) / 2.0;
            }
            self.step(last, (begins || time < middle, times[first] <= middle))?;
        }
        Ok(())
    }

    /// How the horizon changes, by column.
    pub(super) fn ends(&self) -> Vec<f64> {
        self.tangent.of_parameters(&self.horizon)
    }

    /// Keeps what is known at some instants.
    fn record(&mut self, instants: std::ops::Range<usize>) {
        if self.tape.is_some() {
            return;
        }
        for k in instants {
            let n = self.tangent.layout.n;
            let mut state = Matrix {
                columns: self.tangent.all.columns,
                values: self.tangent.state().to_vec(),
            };
            (0..2 * n).for_each(|i| self.existence.mask(state.row_mut(i)));
            self.states.push(state);
            let count = self.at.acceleration.model.outputs().len();
            if count > 0 {
                let trajectory = &self.at.run.trajectory;
                let impulses = trajectory.impulses(k);
                let instant = trajectory.instant(k, &impulses);
                let mut by = outputs(&self.at.acceleration, instant, &self.tangent);
                (0..count).for_each(|i| self.existence.mask(by.row_mut(i)));
                self.outputs.push(by);
            }
        }
    }

    /// Looks at margins where a step begins, right behind `events` if there are some.
    fn begin_step(&mut self, k: usize, begins: bool, events: &[Event]) {
        let margins = match self.begin.take() {
            Some((margins, _)) if !begins => margins,
            _ => {
                let margins = margins(&mut self.at, k);
                self.existence.vanished.clear();
                let (here, own) = ((&mut self.at, &self.tangent), contacts_of(events));
                self.existence
                    .check_margins(here, &margins, (k, &own), None);
                margins
            }
        };
        if let Some(ranges) = self.ranges.as_mut().filter(|_| begins) {
            let times = self.event_times.last().filter(|_| k > 0);
            let times = times.map_or(&[][..], |times| times);
            let growing = margins.iter().filter(|margin| margin.rate >= 0.0);
            ranges.count_at(&self.at, &self.tangent, k, growing, times);
        }
        self.begin = Some((margins, self.tangent.clone()));
    }

    /// Looks at margins where a step has ended, at instant `k`, right before `events` or the end of the motion, which move by `times`.
    fn end_step(&mut self, k: usize, events: &[Event], (times, ends): (Option<&[f64]>, bool)) {
        let Some((begin, before)) = self.begin.take() else {
            return;
        };
        let end = margins(&mut self.at, k);
        self.look_within(k, [&begin, &end], &before);
        if self.at.time(k - 1) <= self.at.time(0) {
            let sides = [&begin[..], &end];
            (self.existence).check_edges(&mut self.at, sides, (k, &before));
        }
        let (here, own) = ((&mut self.at, &self.tangent), contacts_of(events));
        let moves = times.filter(|_| ends);
        self.existence.check_margins(here, &end, (k, &own), moves);
        if let (Some(times), Some(ranges)) = (times, &mut self.ranges) {
            let falling = end.iter().filter(|margin| margin.rate <= 0.0);
            ranges.count_at(&self.at, &self.tangent, k, falling, times);
        }
        self.begin = Some((end, before));
    }

    /// Looks at the least values of margins within the step to instant `k`.
    fn look_within(&mut self, k: usize, [begin, end]: [&[Margin]; 2], before: &Tangent) {
        // What vanishes at its start was looked at there.
        let turns = |(from, to): &(&Margin, &Margin)| {
            let falls = from.rate < 0.0 && from.value > yardstick::NOTHING * from.size;
            from.of == to.of && falls && to.rate >= 0.0
        };
        let mut looked = false;
        for (from, to) in begin.iter().zip(end).filter(turns) {
            looked = true;
            let Some(least) = least(&mut self.at, k, [from, to], before) else {
                continue;
            };
            let vanishes = self.existence.check_least(&self.at, &least);
            if let Some(ranges) = self
                .ranges
                .as_mut()
                .filter(|_| !vanishes && least.margin.value > 0.0)
            {
                ranges.count(&self.at, &least.margin, &least.changes, least.time);
            }
        }
        if looked {
            // What was evaluated within the step.
            let x = self.at.input(k);
            self.at.acceleration.evaluate(&x);
        }
    }

    /// Goes from an instant to the next one. In the first half of an arc, whether the step begins or also ends there, derivatives keep to an
    /// instant that moves with the event before, and then to one that moves with the event behind.
    fn step(&mut self, k: usize, (begins, ends): (bool, bool)) -> Result<(), String> {
        let trajectory = &self.at.run.trajectory;
        let controls = self.at.controls(trajectory.time[k]);
        let step = self.at.step_to(k + 1, &controls);
        if begins {
            let x = self.at.input(k);
            self.flow.all.values = self.at.rates(&x, controls.slopes());
        }
        let before = self.samples.is_some().then(|| self.tangent.clone());
        let own = self.tangent.all.columns;
        self.tangent = self.tangent.beside(&self.flow);
        let lean = self.lean.as_mut();
        let (acceleration, cost) = (&mut self.at.acceleration, self.at.cost.as_ref());
        let missed = self
            .at
            .steps
            .step((acceleration, lean), step, &mut self.tangent, cost);
        [self.tangent, self.flow] = self.tangent.split(own);
        let missed = missed.ok_or_else(|| self.at.undetermined(k))?;
        let h = trajectory.time[k + 1] - trajectory.time[k];
        // What balances leaves its rounding.
        let balanced = yardstick::ROUNDING * h * largest(self.at.acceleration.free_acceleration());
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
        let sizes = self.at.sizes.iter();
        let shares = missed.iter().zip(sizes).map(|(missed, size)| missed / size);
        self.missed = self.missed.hypot(shares.fold(0.0, f64::max));
        if let (Some(samples), Some(before)) = (&mut self.samples, before) {
            let whole = self.existence.lost.iter().all(Option::is_none);
            samples.within(&mut self.at, (k + 1, true), whole.then_some(&before));
        }
        if let Some(tape) = &mut self.tape {
            tape.step(self.at.steps.linear(step, self.at.cost.as_ref()));
        }
        let x = &stage_input(
            &self.at.acceleration,
            (step.to.q, step.to.v),
            step.to.time,
            &controls,
        );
        if !self.at.acceleration.evaluate(x) {
            return Err(self.at.undetermined(k + 1));
        }
        if ends && !self.event_times.is_empty() {
            let mut missed = self.flow.all.values.clone();
            add(&mut missed, -1.0, &self.at.rates(x, controls.slopes()));
            let last_event = self.tangent.layout.last_event();
            let moves = self.tangent.all.row(last_event).to_vec();
            self.tangent.shift(&missed, &moves, 1.0);
            if let Some(tape) = &mut self.tape {
                tape.moved(missed);
            }
        }
        Ok(())
    }

    /// Puts derivatives back onto what joints and contacts hold at an instant, where the acceleration is evaluated.
    fn put_back(&mut self, k: usize) -> Result<(), String> {
        let x = self.at.input(k);
        let closed = match &mut self.joints {
            Some(joints) => joints.evaluate(&self.at.acceleration.derivatives, &x),
            None if self.at.acceleration.lines.is_empty() => return Ok(()),
            None => true,
        };
        if !closed {
            return Err(format!(
                "at t = {} s equations of joints depend on each other, so that the motion has no derivatives there",
                self.at.run.trajectory.time[k]
            ));
        }
        let own = self.widen();
        if let Some(joints) = &self.joints {
            joints.project(&mut self.tangent);
            joints.project(&mut self.flow);
        }
        project(&self.at.acceleration, &mut self.tangent);
        project(&self.at.acceleration, &mut self.flow);
        self.record_change(own);
        Ok(())
    }

    /// With a tape, carries the derivatives of everything by itself beside the columns from now on; how many of these there are.
    fn widen(&mut self) -> usize {
        let own = self.tangent.all.columns;
        if self.tape.is_some() {
            let identity = Tangent::identity(self.tangent.layout);
            self.tangent = self.tangent.beside(&identity);
        }
        own
    }

    /// With a tape, keeps what has become of the derivatives of everything by itself.
    fn record_change(&mut self, own: usize) {
        if let Some(tape) = &mut self.tape {
            let [tangent, change] = self.tangent.split(own);
            self.tangent = tangent;
            tape.change(change.all);
        }
    }

    /// Passes events.
    fn pass_recorded(&mut self, events: &[Event], range: (usize, usize)) -> Result<(), String> {
        let own = self.widen();
        let known = self.event_times.len();
        self.pass(events, range)?;
        if let Some(tape) = &mut self.tape {
            for times in &mut self.event_times[known..] {
                tape.time(times.split_off(own));
            }
        }
        self.record_change(own);
        Ok(())
    }

    /// Passes the events between two instants of the same time.
    fn pass(&mut self, events: &[Event], (first, last): (usize, usize)) -> Result<(), String> {
        let inputs = [self.at.input(first), self.at.input(last)];
        let [x_before, x_after] = [&inputs[0][..], &inputs[1]];
        let controls = self.at.controls(self.at.run.trajectory.time[first]);
        let mut times = vec![0.0; self.tangent.all.columns];
        let mut rates = vec![0.0; self.tangent.layout.rows()];
        let mut found = Vec::new();
        if first > 0 {
            rates = self.at.rates(x_before, controls.slopes());
            found = self.causes(events, x_before, &rates);
            rates.clone_from(&self.flow.all.values);
            times = self.time_of(events, &found, first)?;
            let now = (self.at.time(first), &times[..]);
            let layout = self.tangent.layout;
            self.existence
                .check_controls((x_before, x_after), layout, now);
            self.end_step(first, events, (Some(&times), false));
            if let Some(ranges) = &mut self.ranges {
                ranges.pass(&self.at, events, &times);
            }
        }
        let apart = apart(&found);
        let (modes, before) = (self.at.modes.clone(), self.tangent.clone());
        self.tangent.shift(&rates, &times, 1.0);
        let mut crossing = Crossing {
            at: &mut self.at,
            tangent: &mut self.tangent,
            existence: &mut self.existence,
            ranges: self.ranges.as_mut(),
            events,
            inputs: [x_before, x_after],
            control_rates: controls.slopes(),
            k: first,
        };
        crossing.change()?;
        if !apart.is_empty() {
            crossing.at.modes = modes;
            crossing.take_apart((&found, &apart), &before);
        }
        if let Some(event) = events.last() {
            self.at.modes.clone_from(&event.modes);
        }
        self.at.enter(last)?;
        let after = self.at.rates(x_after, controls.slopes());
        let mut moves = times.clone();
        // What happens in two orders is at a fixed time already.
        apart.iter().for_each(|&column| moves[column] = 0.0);
        self.tangent.shift(&after, &moves, -1.0);
        let last_event = self.tangent.layout.last_event();
        self.tangent.all.row_mut(last_event).copy_from_slice(&moves);
        for event in events {
            let own = found.iter().find(|cause| std::ptr::eq(cause.event, event));
            let mut times = own.map_or(&times, |cause| &cause.times).clone();
            self.existence.mask(&mut times);
            self.event_times.push(times);
        }
        Ok(())
    }

    fn causes<'e>(&mut self, events: &'e [Event], x: &[f64], rates: &[f64]) -> Vec<Cause<'e>> {
        let found = causes(
            &mut self.at,
            x,
            events,
            ([rates, &self.flow.all.values], &self.tangent),
        );
        found
            .iter()
            .for_each(|cause| self.existence.check_grazes(cause));
        found
    }

    /// Derivatives of the time of events that happen together.
    fn time_of(&self, events: &[Event], found: &[Cause<'_>], k: usize) -> Result<Vec<f64>, String> {
        if let Some(cause) = found.first() {
            return Ok(cause.times.clone());
        }
        let time = self.at.run.trajectory.time[k];
        let just_before = time * (1.0 - f64::EPSILON) - f64::MIN_POSITIVE;
        if self.at.problem.controls.next_break(just_before) == Some(time) {
            // Controls change at times that nothing moves.
            return Ok(vec![0.0; self.tangent.all.columns]);
        }
        Err(format!(
            "at t = {time} s nothing vanishes that says when the {} at `{}` happens for other parameters",
            events[0].kind, events[0].contact_name
        ))
    }

    /// What was looked at, to the end of the motion.
    pub(super) fn observed(&mut self) -> Option<Samples<'w>> {
        let mut samples = self.samples.take()?;
        samples.go_on(&mut self.at);
        Some(samples)
    }

    /// Derivatives at the end, which moves with the horizon: of everything; of the outputs; and of the objective, if they are known. With a
    /// tape they are by everything at the last instant.
    pub(super) fn end(&mut self) -> End {
        let last = self.at.run.trajectory.time.len() - 1;
        let (model, trajectory) = (self.at.acceleration.model, &self.at.run.trajectory);
        let x = self.at.input(last);
        let controls = self.at.controls(trajectory.time[last]);
        let rates = self.at.rates(&x, controls.slopes());
        let own = self.widen();
        let mut tangent = self.tangent.clone();
        tangent.shift(&rates, &self.ends(), 1.0);
        let impulses = trajectory.impulses(last);
        let instant = trajectory.instant(last, &impulses);
        let outputs = match model.outputs().is_empty() {
            true => Matrix::default(),
            false => outputs(&self.at.acceleration, instant, &tangent),
        };
        let objective = self.at.cost.as_ref().map(|cost| {
            let (q, v) = (&trajectory.q[last], &trajectory.v[last]);
            let z = [q, v, &[trajectory.time[last]][..]].concat();
            cost.at_the_end(&z, &tangent)
        });
        self.tangent = self.tangent.split(own)[0].clone();
        End {
            tangent,
            outputs,
            objective,
        }
    }
}

/// Derivatives at the end of a motion.
pub(super) struct End {
    pub(super) tangent: Tangent,
    pub(super) outputs: Matrix,
    pub(super) objective: Option<Vec<f64>>,
}
