//! Along a motion that is known: derivatives over its smooth arcs, and across its events.
//!
//! With a [`Tape`] the walk carries one direction of all quantities, which the checks look at, and records what is linear on the
//! way; [`adjoint`](super::adjoint) goes back along that.

use super::acceleration::{Acceleration, input};
use super::arc::{Arc, At, Step};
use super::cause::{self, Before};
use super::front::{Front, shift};
use super::joint_rows::JointRows;
use super::jump::{Impact, jump};
use super::margins::Ranges;
use super::matrix::{Matrix, add, largest};
use super::outputs::{Instant, outputs};
use super::projection::project;
use super::samples::Samples;
use super::tape::Tape;
use super::wanted::Wanted;
use crate::model::{ControlPiece, Model, contact_point};
use crate::simulation::{ContactMode, Event, EventKind, InitialValueProblem, Simulation};

/// Distance of a step from the known motion, relative to the largest values of that, above which it is another motion.
const ANOTHER: f64 = 1e-5;
/// Share of accelerations that balance which rounding may leave.
const BALANCED: f64 = 1e-12;
/// Share of its terms that the derivative of what a contact holds may have.
pub(super) const HELD: f64 = 1e-6;
/// The same after a step, which has the error of the motion.
pub(super) const DRIFT: f64 = 1e-3;
/// Share of the largest derivative that rounding may leave of one.
pub(super) const ROUNDING: f64 = 1e-9;

/// The derivatives along a motion.
// Many fields: what is known of the motion, and where in it the walk is.
pub(super) struct Walk<'w> {
    pub(super) run: &'w Simulation,
    pub(super) problem: &'w InitialValueProblem,
    pub(super) front: Front<'w>,
    pub(super) acceleration: Acceleration<'w>,
    joints: Option<JointRows<'w>>,
    pub(super) arc: Arc,
    pub(super) modes: Vec<ContactMode>,
    /// Whether what has no derivative is refused.
    checked: bool,
    pub(super) closing_speeds: Vec<f64>,
    pub(super) gap_sizes: Vec<f64>,
    /// Gap and normal velocity of each contact at each instant.
    pub(super) open_sides: Vec<Vec<[f64; 2]>>,
    /// Largest coordinate and velocity of the motion.
    pub(super) sizes: [f64; 2],
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
        let n = problem.q.len();
        let contacts = model.declaration().contacts.len();
        let size = |rows: &[Vec<f64>]| rows.iter().map(|row| largest(row)).fold(0.0, f64::max);
        let trajectory = &run.trajectory;
        let open_sides = sides(model, run);
        let most = |side: usize| -> Vec<f64> {
            let contact = |i: usize| {
                open_sides
                    .iter()
                    .map(move |row: &Vec<[f64; 2]>| row[i][side].abs())
            };
            (0..contacts)
                .map(|i| contact(i).fold(0.0, f64::max))
                .collect()
        };
        Some(Self {
            acceleration: Acceleration::new(model, wanted),
            joints: JointRows::of(model, wanted.columns()),
            arc: Arc::new()?,
            modes: run.initial_modes.clone(),
            front: Front::at_start(model, problem, wanted),
            checked: true,
            gap_sizes: most(0),
            closing_speeds: most(1),
            open_sides,
            sizes: [
                size(&trajectory.q).max(f64::MIN_POSITIVE),
                size(&trajectory.v),
            ],
            event_times: Vec::with_capacity(run.events.len()),
            states: Vec::with_capacity(trajectory.time.len()),
            outputs: Vec::new(),
            samples: None,
            tape: None,
            ranges: None,
            run,
            problem,
        })
        .filter(|_| n > 0)
    }

    /// Walks to the end.
    ///
    /// # Errors
    /// Why there are no derivatives from some instant on.
    pub(super) fn run(&mut self) -> Result<(), String> {
        let times = &self.run.trajectory.time;
        let mut first = 0;
        let mut passed = 0;
        self.enter(0)?;
        if let Some(samples) = &mut self.samples {
            let front = &self.front;
            let state = (&front.state, &front.impulses);
            samples.begin(&self.acceleration, (front.wanted, self.run), state);
        }
        loop {
            let time = times[first];
            let last = times.partition_point(|&t| t <= time) - 1;
            let events = &self.run.events[passed..];
            let here = events.partition_point(|event| event.time <= time);
            let events = &events[..here];
            passed += here;
            if last > first {
                self.evaluate(first)?;
                self.record(first..last);
            }
            if self.ranges.is_some() && events.is_empty() {
                self.evaluate(first)?;
                let ends = (last + 1 == times.len()).then(|| self.horizon_moves());
                self.end_range(first, ends.as_deref())?;
            }
            if events.is_empty() {
                self.evaluate(last)?;
            } else {
                self.pass_recorded(events, (first, last))?;
            }
            let begins = first == 0 || !events.is_empty();
            if first == 0 && events.is_empty() {
                self.check_all(last)?;
            }
            self.check_holds(last, if begins { HELD } else { DRIFT })?;
            self.put_back(last)?;
            self.record(last..last + 1);
            if last + 1 == times.len() {
                return if here > 0 && first > 0 {
                    Err(self.at_the_end(time))
                } else {
                    Ok(())
                };
            }
            self.begin_range(last, begins);
            self.step(last)?;
            first = last + 1;
        }
    }

    fn at_the_end(&self, time: f64) -> String {
        format!(
            "the motion ends at t = {time} s with an event, so that its end has different derivatives to both sides; take \
             another horizon"
        )
    }

    fn undetermined(&self, k: usize) -> String {
        format!(
            "at t = {} s the contact forces are not determined, so that neither are their derivatives",
            self.run.trajectory.time[k]
        )
    }

    /// The input vector at an instant.
    pub(super) fn input(&self, k: usize) -> Vec<f64> {
        let trajectory = &self.run.trajectory;
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        input(self.acceleration.model, (q, v, u), trajectory.time[k])
    }

    /// The controls around an instant.
    pub(super) fn controls(&self, time: f64) -> ControlPiece {
        let count = self.acceleration.model.declaration().controls.len();
        let mut piece = ControlPiece::default();
        self.problem.controls.take_piece(time, count, &mut piece);
        piece
    }

    /// Enters the present mode at an instant.
    fn enter(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        self.acceleration.set_mode(&self.modes);
        self.acceleration.keep_independent(&x);
        self.evaluate(k)
    }

    /// Evaluates the motion at an instant in the mode that was entered.
    pub(super) fn evaluate(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        if self.acceleration.evaluate(&x) {
            Ok(())
        } else {
            Err(self.undetermined(k))
        }
    }

    /// Keeps what is known at some instants.
    fn record(&mut self, instants: std::ops::Range<usize>) {
        if self.tape.is_some() {
            return;
        }
        for k in instants {
            let front = &self.front;
            self.states.push(front.state.clone());
            if !self.acceleration.model.outputs().is_empty() {
                let at = Instant::recorded(self.acceleration.model, &self.run.trajectory, k);
                let (state, impulses) = (&front.state, &front.impulses);
                let by = outputs(&self.acceleration, front.wanted, &at, state, impulses);
                self.outputs.push(by);
            }
        }
    }

    /// The step that ends at instant `k`.
    pub(super) fn step_to<'s>(&self, k: usize, controls: &'s ControlPiece) -> Step<'s>
    where
        'w: 's,
    {
        let trajectory = &self.run.trajectory;
        let at = |k: usize| At {
            time: trajectory.time[k],
            q: &trajectory.q[k],
            v: &trajectory.v[k],
        };
        Step {
            from: at(k - 1),
            to: at(k),
            controls,
        }
    }

    /// Derivatives of the horizon.
    pub(super) fn horizon_moves(&self) -> Vec<f64> {
        self.front
            .wanted
            .of_horizon(self.acceleration.model, self.problem)
    }

    /// Goes from an instant to the next one.
    fn step(&mut self, k: usize) -> Result<(), String> {
        let trajectory = &self.run.trajectory;
        let controls = self.controls(trajectory.time[k]);
        let step = self.step_to(k + 1, &controls);
        let before = self.samples.is_some().then(|| self.front.state.clone());
        let front = &mut self.front;
        let (state, cost) = (&mut front.state, front.cost.as_mut());
        let lean = self.tape.as_mut().map(|tape| &mut tape.lean);
        let acceleration = (&mut self.acceleration, lean);
        let missed = self.arc.step(acceleration, front.wanted, step, state, cost);
        let missed = missed.ok_or_else(|| self.undetermined(k))?;
        let h = trajectory.time[k + 1] - trajectory.time[k];
        // What balances leaves its rounding.
        let balanced = BALANCED * h * largest(&self.acceleration.free);
        let limits = [
            ANOTHER * self.sizes[0] + h * balanced,
            ANOTHER * self.sizes[1] + balanced,
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
            let cost = self.front.cost.as_ref();
            tape.step(self.arc.linear(&self.acceleration, step, cost));
        }
        self.check_touches(step, k)?;
        if let (Some(samples), Some(before)) = (&mut self.samples, before) {
            let acceleration = (&mut self.acceleration, self.front.wanted);
            samples.within(
                acceleration,
                (&self.arc, step),
                (&before, &self.front.impulses),
                (self.run, k),
            );
        }
        Ok(())
    }

    /// Puts derivatives back onto what joints and contacts hold at an instant, where the acceleration is evaluated.
    fn put_back(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        let closed = match &mut self.joints {
            Some(joints) => joints.evaluate(self.front.wanted, &x),
            None if self.acceleration.holds.is_empty() => return Ok(()),
            None => true,
        };
        if !closed {
            return Err(format!(
                "at t = {} s equations of joints depend on each other, so that the motion has no derivatives there",
                self.run.trajectory.time[k]
            ));
        }
        let (acceleration, joints) = (&self.acceleration, &self.joints);
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
        back(&mut self.front);
        Ok(())
    }

    /// Passes events; with a tape, once for what that changes of each derivative, and at the start once for all quantities, whose
    /// checks look at each of them there.
    fn pass_recorded(&mut self, events: &[Event], range: (usize, usize)) -> Result<(), String> {
        let Some(mut tape) = self.tape.take() else {
            return self.pass(events, range);
        };
        let (holds, given) = (
            self.acceleration.holds.clone(),
            self.acceleration.given.clone(),
        );
        let modes = self.modes.clone();
        let model = self.acceleration.model;
        let again = |walk: &mut Self| {
            walk.modes.clone_from(&modes);
            walk.acceleration.holds.clone_from(&holds);
            walk.acceleration.given.clone_from(&given);
            walk.event_times
                .truncate(walk.event_times.len() - events.len());
        };
        let front = std::mem::replace(&mut self.front, tape.present());
        self.checked = false;
        let passed = self.pass(events, range);
        self.checked = true;
        passed?;
        again(self);
        if range.0 == 0 {
            let all = Front::at_start(model, self.problem, tape.asked);
            tape.event(std::mem::replace(&mut self.front, all));
            self.pass(events, range)?;
            self.check_holds(range.1, HELD)?;
            again(self);
            self.front = front;
        } else {
            tape.event(std::mem::replace(&mut self.front, front));
        }
        self.tape = Some(tape);
        self.pass(events, range)
    }

    /// Passes the events between two instants of the same time.
    fn pass(&mut self, events: &[Event], (first, last): (usize, usize)) -> Result<(), String> {
        let (n, m) = (self.acceleration.n, self.front.wanted.count());
        let time = self.run.trajectory.time[first];
        let (x_before, x_after) = (self.input(first), self.input(last));
        let mut times = vec![0.0; m];
        let mut before = vec![0.0; n];
        if first > 0 {
            self.evaluate(first)?;
            before.clone_from(&self.acceleration.value);
            times = self.time_of(events, first)?;
            self.end_range(first, Some(&times))?;
            self.pass_range(events, &times);
        }
        let mut moved = self.front.state.clone();
        let v = &self.run.trajectory.v;
        shift(&mut moved, (&v[first], &before), &times, 1.0);
        let after_modes = events.last().map(|event| event.modes.clone());
        let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
        if jumps || self.velocities_jump(first, last) {
            let struck = self.struck(events, after_modes.as_deref().unwrap_or_default());
            if first == 0 && self.checked {
                self.check_start(&struck)?;
            }
            for &contact in struck.iter().filter(|_| self.checked) {
                self.check_laws(contact, first)?;
            }
            let impact = Impact {
                before: &x_before,
                after: &x_after,
                struck: &struck,
                time,
                moved: &moved,
                times: &times,
            };
            let jump = jump(&mut self.acceleration, self.front.wanted, &impact)?;
            self.impact_range(
                (&struck, events),
                (&x_before, &x_after),
                (&moved, &jump.velocities),
                (&times, &jump.impulses),
            );
            moved.values[n * m..].copy_from_slice(&jump.velocities.values);
            add(&mut self.front.impulses.values, 1.0, &jump.impulses.values);
        }
        if let Some(modes) = after_modes {
            self.modes = modes;
        }
        self.enter(last)?;
        let after = (&v[last][..], &self.acceleration.value[..]);
        shift(&mut moved, after, &times, -1.0);
        self.front.state = moved;
        if let Some(cost) = &mut self.front.cost {
            let model = self.acceleration.model;
            for (x, sense) in [(&x_before, 1.0), (&x_after, -1.0)] {
                cost.move_limit(model, x, &times, sense);
            }
        }
        self.event_times
            .extend(events.iter().map(|_| times.clone()));
        Ok(())
    }

    /// Derivatives of the time of events; the motion is evaluated right before.
    fn time_of(&mut self, events: &[Event], k: usize) -> Result<Vec<f64>, String> {
        let x = self.input(k);
        let time = self.run.trajectory.time[k];
        let controls = self.controls(time);
        let before = Before {
            modes: &self.modes,
            v: &self.run.trajectory.v[k],
            control_rates: controls.slopes(),
            state: &self.front.state,
            closing_speeds: &self.closing_speeds,
            sizes: self.sizes,
            checked: self.checked,
        };
        let wanted = self.front.wanted;
        let times = cause::time(&mut self.acceleration, wanted, &x, events, &before)?;
        let switches = || {
            let before = self
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

    /// Whether velocities change by more than rounding between two instants of the same time.
    fn velocities_jump(&self, first: usize, last: usize) -> bool {
        let v = &self.run.trajectory.v;
        let mut pairs = v[first].iter().zip(&v[last]);
        pairs.any(|(before, after)| (after - before).abs() > ROUNDING * self.sizes[1])
    }

    /// Contacts that take part in a jump: those with impulses, and those that close.
    fn struck(&self, events: &[Event], after: &[ContactMode]) -> Vec<usize> {
        let impulses = events
            .iter()
            .find(|event| !event.contact_impulse.is_empty());
        let impulses = impulses.map_or(&[][..], |event| &event.contact_impulse);
        let least = ROUNDING * largest(impulses);
        let declared = self.acceleration.model.declaration().contacts;
        (0..declared.len())
            .filter(|&i| {
                let closes = self.modes.get(i) == Some(&ContactMode::Open)
                    && after.get(i).is_some_and(|mode| *mode != ContactMode::Open);
                let strikes = impulses.get(i).is_some_and(|impulse| *impulse > least);
                !declared[i].dry && (closes || strikes)
            })
            .collect()
    }

    /// What was looked at, to the end of the motion.
    pub(super) fn observed(&mut self) -> Option<Samples<'w>> {
        let mut samples = self.samples.take()?;
        let motion = (self.problem, self.run);
        samples.go_on(&mut self.acceleration, &mut self.arc, motion);
        Some(samples)
    }

    /// Derivatives at the end, which moves with the horizon: of `(q, v)`; of the outputs; and of the objective, if they are known.
    pub(super) fn end(&mut self) -> End {
        let last = self.run.trajectory.time.len() - 1;
        let (x, at) = (
            self.input(last),
            Instant::recorded(self.acceleration.model, &self.run.trajectory, last),
        );
        let controls = self.controls(self.run.trajectory.time[last]);
        let (model, front) = (self.acceleration.model, &mut self.front);
        let moves = front.wanted.of_horizon(model, self.problem);
        let (q, v) = (&self.run.trajectory.q[last], &self.run.trajectory.v[last]);
        let mut recorded = Matrix::zeros(model.outputs().len(), front.wanted.count());
        if !model.outputs().is_empty() {
            let by = (&front.state, &front.impulses);
            recorded = outputs(&self.acceleration, front.wanted, &at, by.0, by.1);
            if moves.iter().any(|moves| *moves != 0.0) {
                let time = front.wanted.in_time(controls.slopes().to_vec());
                let rates = Matrix {
                    columns: 1,
                    values: [v, &self.acceleration.value[..]].concat(),
                };
                let impulses = Matrix::zeros(front.impulses.values.len() / moves.len(), 1);
                let rates = outputs(&self.acceleration, &time, &at, &rates, &impulses);
                for (output, rate) in rates.values.iter().enumerate() {
                    add(recorded.row_mut(output), *rate, &moves);
                }
            }
        }
        let mut state = front.state.clone();
        shift(&mut state, (v, &self.acceleration.value), &moves, 1.0);
        let objective = front.cost.as_mut().map(|cost| {
            cost.move_limit(model, &x, &moves, 1.0);
            let z = [q, v, &[self.run.trajectory.time[last]][..]].concat();
            cost.at_the_end(&z, &state, &moves)
        });
        End {
            state,
            outputs: recorded,
            objective,
        }
    }
}

/// Derivatives at the end of a motion.
pub(super) struct End {
    pub(super) state: Matrix,
    pub(super) outputs: Matrix,
    pub(super) objective: Option<Vec<f64>>,
}

/// Gap and normal velocity of each contact at each instant of a motion.
fn sides(model: &dyn Model, run: &Simulation) -> Vec<Vec<[f64; 2]>> {
    let declaration = model.declaration();
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    let trajectory = &run.trajectory;
    let instants = 0..trajectory.time.len();
    let mut of = |k: usize| {
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        let x = input(model, (q, v, u), trajectory.time[k]);
        let contacts = 0..declaration.contacts.len();
        let sides = contacts.map(|contact| {
            model.contact(contact, &x, &mut point);
            [contact_point::GAP, contact_point::NORMAL_VELOCITY].map(|side| point[side])
        });
        sides.collect()
    };
    instants.map(&mut of).collect()
}
