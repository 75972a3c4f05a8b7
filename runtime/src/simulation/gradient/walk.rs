//! Along a motion that is known: derivatives over its smooth arcs, and across its events.

use super::acceleration::{Acceleration, Hold, input};
use super::arc::{Arc, At, Step, stage_input};
use super::cause::{self, Before};
use super::cost::Cost;
use super::jump::{Impact, jump};
use super::matrix::{Matrix, add, largest};
use super::outputs::{Instant, outputs};
use super::projection::project;
use super::samples::Samples;
use super::wanted::Wanted;
use crate::model::{ControlPiece, Model, contact_point, tangent_point};
use crate::simulation::{ContactMode, Event, EventKind, InitialValueProblem, Simulation};

/// Distance of a step from the known motion, relative to the largest values of that, above which it is another motion.
const ANOTHER: f64 = 1e-5;
/// Share of accelerations that balance which rounding may leave.
const BALANCED: f64 = 1e-12;
/// Share of its terms that the derivative of what a contact holds may have.
const HELD: f64 = 1e-6;
/// The same after a step, which has the error of the motion.
const DRIFT: f64 = 1e-3;
/// Share of the largest derivative that rounding may leave of one.
const ROUNDING: f64 = 1e-9;
/// Share of the largest gap that counts as none where a contact passes its surface.
const TOUCHED: f64 = 1e-9;
/// Halvings of a step in search of the least gap: its value changes with their square.
const BISECTIONS: usize = 30;

/// The derivatives along a motion.
// Many fields: what is known of the motion, and where in it the walk is.
pub(super) struct Walk<'w> {
    run: &'w Simulation,
    problem: &'w InitialValueProblem,
    wanted: &'w Wanted,
    acceleration: Acceleration<'w>,
    arc: Arc,
    modes: Vec<ContactMode>,
    /// Derivatives of `(q, v)` at a fixed time, where the walk is.
    state: Matrix,
    /// The same of the impulses of all impacts so far.
    impulses: Matrix,
    closing_speeds: Vec<f64>,
    gap_sizes: Vec<f64>,
    /// Gap and normal velocity of each contact at each instant.
    open_sides: Vec<Vec<[f64; 2]>>,
    /// The objective, if its derivatives are known.
    cost: Option<Cost<'w>>,
    /// Largest coordinate and velocity of the motion.
    sizes: [f64; 2],
    /// Derivatives of the times of the events passed.
    pub(super) event_times: Vec<Vec<f64>>,
    /// Derivatives of `(q, v)` at the instants passed.
    pub(super) states: Vec<Matrix>,
    /// The same of the outputs.
    pub(super) outputs: Vec<Matrix>,
    /// What is looked at between the instants, if anything is.
    pub(super) samples: Option<Samples<'w>>,
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
            arc: Arc::new()?,
            modes: run.initial_modes.clone(),
            state: start(model, problem, wanted),
            impulses: Matrix::zeros(2 * contacts, wanted.count()),
            gap_sizes: most(0),
            closing_speeds: most(1),
            cost: Cost::of(model, wanted),
            open_sides,
            sizes: [
                size(&trajectory.q).max(f64::MIN_POSITIVE),
                size(&trajectory.v),
            ],
            event_times: Vec::with_capacity(run.events.len()),
            states: Vec::with_capacity(trajectory.time.len()),
            outputs: Vec::new(),
            samples: None,
            run,
            problem,
            wanted,
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
            let state = (&self.state, &self.impulses);
            samples.begin(&self.acceleration, (self.wanted, self.run), state);
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
            if events.is_empty() {
                self.evaluate(last)?;
            } else {
                self.pass(events, (first, last))?;
            }
            let begins = first == 0 || !events.is_empty();
            self.check_holds(last, if begins { HELD } else { DRIFT })?;
            project(&self.acceleration, self.wanted, &mut self.state);
            self.record(last..last + 1);
            if last + 1 == times.len() {
                return if here > 0 && first > 0 {
                    Err(self.at_the_end(time))
                } else {
                    Ok(())
                };
            }
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
    fn input(&self, k: usize) -> Vec<f64> {
        let trajectory = &self.run.trajectory;
        let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
        input(self.acceleration.model, (q, v, u), trajectory.time[k])
    }

    /// The controls around an instant.
    fn controls(&self, time: f64) -> ControlPiece {
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
    fn evaluate(&mut self, k: usize) -> Result<(), String> {
        let x = self.input(k);
        if self.acceleration.evaluate(&x) {
            Ok(())
        } else {
            Err(self.undetermined(k))
        }
    }

    /// Keeps what is known at some instants.
    fn record(&mut self, instants: std::ops::Range<usize>) {
        for k in instants {
            self.states.push(self.state.clone());
            if !self.acceleration.model.outputs().is_empty() {
                let at = Instant::recorded(&self.run.trajectory, k);
                let (state, impulses) = (&self.state, &self.impulses);
                let by = outputs(&self.acceleration, self.wanted, &at, state, impulses);
                self.outputs.push(by);
            }
        }
    }

    /// Goes from an instant to the next one.
    fn step(&mut self, k: usize) -> Result<(), String> {
        let trajectory = &self.run.trajectory;
        let at = |k: usize| At {
            time: trajectory.time[k],
            q: &trajectory.q[k],
            v: &trajectory.v[k],
        };
        let controls = self.controls(trajectory.time[k]);
        let step = Step {
            from: at(k),
            to: at(k + 1),
            controls: &controls,
        };
        let before = self.samples.is_some().then(|| self.state.clone());
        let (acceleration, state) = (&mut self.acceleration, &mut self.state);
        let cost = self.cost.as_mut();
        let missed = self.arc.step(acceleration, self.wanted, step, state, cost);
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
        self.check_touches(step, k)?;
        if let (Some(samples), Some(before)) = (&mut self.samples, before) {
            let acceleration = (&mut self.acceleration, self.wanted);
            samples.within(
                acceleration,
                (&self.arc, step),
                (&before, &self.impulses),
                (self.run, k),
            );
        }
        Ok(())
    }

    /// No open contact touches its surface within the step that was solved last and opens again: a neighbouring motion
    /// would strike it.
    fn check_touches(&mut self, step: Step<'_>, k: usize) -> Result<(), String> {
        let declared = self.acceleration.model.declaration().contacts;
        for (contact, declared) in declared.iter().enumerate() {
            let open = self.modes.get(contact) == Some(&ContactMode::Open);
            let sides = &self.open_sides;
            let ([gap, speed], [next_gap, next]) = (sides[k][contact], sides[k + 1][contact]);
            let least = ROUNDING * self.closing_speeds[contact];
            if !open || !declared.alternatives.is_empty() || speed >= -least || next < -least {
                continue;
            }
            // The gap falls no faster than it ever does.
            let fall = (step.to.time - step.from.time) * self.closing_speeds[contact];
            let lowest = gap.min(next_gap) - fall;
            let touched = TOUCHED * self.gap_sizes[contact];
            if lowest > touched {
                continue;
            }
            let (time, gap) = self.least_gap(step, contact);
            if gap.abs() <= touched {
                return Err(format!(
                    "at t = {time} s `{}` only grazes: it touches and is not struck, but is so for other parameters",
                    declared.name
                ));
            }
        }
        Ok(())
    }

    /// Where the gap of a contact that closes at the start of a step and opens at its end is the least, and that.
    fn least_gap(&mut self, step: Step<'_>, contact: usize) -> (f64, f64) {
        let model = self.acceleration.model;
        let mut point = vec![0.0; contact_point::length(self.acceleration.n)];
        let (mut low, mut high) = (0.0, 1.0);
        let mut found = (step.from.time, f64::INFINITY);
        for _ in 0..BISECTIONS {
            let theta = 0.5 * (low + high);
            let (q, v) = self.arc.within(step, theta);
            let time = step.from.time + theta * (step.to.time - step.from.time);
            let x = stage_input(&self.acceleration, (&q, &v), time, step.controls);
            model.contact(contact, &x, &mut point);
            found = (time, point[contact_point::GAP]);
            if point[contact_point::NORMAL_VELOCITY] < 0.0 {
                low = theta;
            } else {
                high = theta;
            }
        }
        found
    }

    /// Passes the events between two instants of the same time.
    fn pass(&mut self, events: &[Event], (first, last): (usize, usize)) -> Result<(), String> {
        let (n, m) = (self.acceleration.n, self.wanted.count());
        let time = self.run.trajectory.time[first];
        let (x_before, x_after) = (self.input(first), self.input(last));
        let mut times = vec![0.0; m];
        let mut before = vec![0.0; n];
        if first > 0 {
            self.evaluate(first)?;
            before.clone_from(&self.acceleration.value);
            times = self.time_of(events, first)?;
        }
        let mut moved = self.state.clone();
        let v = &self.run.trajectory.v;
        shift(&mut moved, (&v[first], &before), &times, 1.0);
        let after_modes = events.last().map(|event| event.modes.clone());
        let jumps = events.iter().any(|event| event.kind == EventKind::Impact);
        if jumps || self.velocities_jump(first, last) {
            let struck = self.struck(events, after_modes.as_deref().unwrap_or_default());
            if first == 0 {
                self.check_start(&struck)?;
            }
            for &contact in &struck {
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
            let jump = jump(&mut self.acceleration, self.wanted, &impact)?;
            moved.values[n * m..].copy_from_slice(&jump.velocities.values);
            add(&mut self.impulses.values, 1.0, &jump.impulses.values);
        }
        if let Some(modes) = after_modes {
            self.modes = modes;
        }
        self.enter(last)?;
        let after = (&v[last][..], &self.acceleration.value[..]);
        shift(&mut moved, after, &times, -1.0);
        self.state = moved;
        if let Some(cost) = &mut self.cost {
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
            state: &self.state,
            closing_speeds: &self.closing_speeds,
            speed: self.sizes[1],
        };
        let times = cause::time(&mut self.acceleration, self.wanted, &x, events, &before)?;
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
            None if switches() => Ok(vec![0.0; self.wanted.count()]),
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

    /// Contacts that are struck at the start are so for all neighbouring starts.
    fn check_start(&mut self, struck: &[usize]) -> Result<(), String> {
        let x = self.input(0);
        for &contact in struck {
            self.acceleration.load_contact(contact, &x);
            self.check_zero(contact, contact_point::GAP, (0, HELD))?;
        }
        Ok(())
    }

    /// What contacts hold does not change with what the motion is differentiated by.
    fn check_holds(&self, k: usize, share: f64) -> Result<(), String> {
        for &hold in &self.acceleration.holds {
            match hold {
                Hold::Normal { contact, .. } => {
                    self.check_laws(contact, k)?;
                    self.check_zero(contact, contact_point::GAP, (k, share))?;
                    self.check_zero(contact, contact_point::NORMAL_VELOCITY, (k, share))?;
                }
                Hold::Tangent { contact } => {
                    let (_, by) = self
                        .acceleration
                        .tangent(contact, tangent_point::SLIDING_VELOCITY);
                    self.check_row(contact, by, (k, share))?;
                }
            }
        }
        Ok(())
    }

    /// No coefficient of a law stands at its limit of 0 and is moved from there: what follows differs on both sides.
    fn check_laws(&self, contact: usize, k: usize) -> Result<(), String> {
        let model = self.acceleration.model;
        let declared = &model.declaration().contacts[contact];
        let (mu, friction_by) = self.acceleration.friction(contact);
        let mut restitution_by = vec![0.0; self.wanted.parameters];
        self.wanted
            .derivatives
            .restitution(contact, &mut restitution_by);
        let e = model.restitution(contact);
        for column in 0..self.wanted.count() {
            let Some(parameter) = self.wanted.parameter(column) else {
                continue;
            };
            let laws = [
                ("restitution", e, restitution_by[parameter]),
                ("friction", mu, friction_by[parameter]),
            ];
            for (law, value, by) in laws {
                if value == 0.0 && by != 0.0 {
                    return Err(format!(
                        "at t = {} s `{}` has a coefficient of {law} of 0, below which there is nothing: by `{}` there is a \
                         derivative to one side only",
                        self.run.trajectory.time[k], declared.name, self.wanted.names[column]
                    ));
                }
            }
        }
        Ok(())
    }

    fn check_zero(&self, contact: usize, component: usize, at: (usize, f64)) -> Result<(), String> {
        self.check_row(contact, self.acceleration.point(contact, component).1, at)
    }

    fn check_row(
        &self,
        contact: usize,
        by: &[f64],
        (k, share): (usize, f64),
    ) -> Result<(), String> {
        let most = largest(&self.state.values) * largest(by);
        for column in 0..self.wanted.count() {
            let change = self.acceleration.along(by, &self.state, column);
            let terms = (0..self.state.values.len() / self.state.columns)
                .map(|i| (by[i] * self.state.row(i)[column]).abs());
            let own = self.wanted.column(column).map_or(0.0, |own| by[own].abs());
            let size = terms.sum::<f64>() + own;
            if change.abs() > (share * size).max(ROUNDING * most) {
                let name = self.acceleration.model.declaration().contacts[contact].name;
                return Err(format!(
                    "at t = {} s `{name}` is closed, or struck, for these values only: another `{}` opens it or presses it in",
                    self.run.trajectory.time[k], self.wanted.names[column]
                ));
            }
        }
        Ok(())
    }

    /// What was looked at, to the end of the motion.
    pub(super) fn observed(&mut self) -> Option<Samples<'w>> {
        let mut samples = self.samples.take()?;
        let motion = (self.problem, self.run);
        samples.go_on(&mut self.acceleration, &mut self.arc, motion);
        Some(samples)
    }

    /// Derivatives of `(q, v)` at the end, which moves with the horizon, and of the objective, if they are known.
    pub(super) fn end(&mut self) -> (Matrix, Option<Vec<f64>>) {
        let mut state = self.state.clone();
        let moves = self
            .wanted
            .of_horizon(self.acceleration.model, self.problem);
        let last = self.run.trajectory.time.len() - 1;
        let (q, v) = (&self.run.trajectory.q[last], &self.run.trajectory.v[last]);
        shift(&mut state, (v, &self.acceleration.value), &moves, 1.0);
        let x = self.input(last);
        let objective = self.cost.as_mut().map(|cost| {
            cost.move_limit(self.acceleration.model, &x, &moves, 1.0);
            let z = [q, v, &[self.run.trajectory.time[last]][..]].concat();
            cost.at_the_end(&z, &state, &moves)
        });
        (state, objective)
    }
}

/// Moves the instant of derivatives of `(q, v)` along a motion with these rates.
fn shift(state: &mut Matrix, (v, a): (&[f64], &[f64]), moves: &[f64], sense: f64) {
    for (k, rate) in v.iter().chain(a).enumerate() {
        add(state.row_mut(k), sense * rate, moves);
    }
}

/// Derivatives of the initial `(q, v)`.
fn start(model: &dyn Model, problem: &InitialValueProblem, wanted: &Wanted) -> Matrix {
    let n = problem.q.len();
    let mut by_parameters = vec![0.0; 2 * n * wanted.parameters];
    wanted.derivatives.start(&mut by_parameters);
    let mut declared = vec![0.0; 2 * n];
    let (q, v) = declared.split_at_mut(n);
    model.start(q, v);
    let given = problem.q.iter().chain(&problem.v);
    let mut state = Matrix::zeros(2 * n, wanted.count());
    for (i, (given, declared)) in given.zip(&declared).enumerate() {
        for (k, value) in state.row_mut(i).iter_mut().enumerate() {
            *value = wanted.of_start(&by_parameters, i, k, given == declared);
        }
    }
    state
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
