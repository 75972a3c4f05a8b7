//! A motion with its controls: what one phase of the solution hands to the next.

use super::control_grid::ControlGrid;
use super::problem::{Horizon, Problem};
use super::settings::Guess;
use crate::model::{Model, contact_point};
use crate::simulation::{ControlSignal, EventDriven, InputError, Simulation, Simulator as _};

/// Instants nearer to each other than this share of the horizon are one.
const SAME_TIME: f64 = 1e-12;
/// Samples of a guess in each interval.
const SAMPLES: usize = 4;

/// States over time, piecewise linear, with controls on equal intervals.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Path {
    /// Length \[s\].
    pub(super) horizon: f64,
    /// Controls on equal intervals.
    pub(super) controls: ControlGrid,
    /// Instants \[s\], not decreasing; twice at a jump.
    pub(super) time: Vec<f64>,
    /// `(q, v, r)` at each instant, where `r` are the normal accelerations that the contacts provide.
    pub(super) states: Vec<Vec<f64>>,
}

impl Path {
    /// The start of the global phase.
    pub(super) fn guess(
        model: &dyn Model,
        problem: &Problem,
        guess: &Guess,
        bounds: (&[f64], &[f64]),
    ) -> Result<Self, InputError> {
        let straight = Self::straight(model, problem, bounds);
        match guess {
            Guess::Straight => Ok(straight),
            Guess::Rest => Ok(straight.at_rest(model, problem)),
            Guess::Ride => straight.ride(model, problem),
            Guess::Perturbed { seed } => Ok(straight.perturbed(model, problem, *seed, bounds)),
            Guess::Previous(previous) => previous.path(model, problem),
        }
    }

    /// Coordinates with a goal move to it at constant speed, the others rest; controls are 0, or as near to
    /// it as their bounds allow.
    fn straight(model: &dyn Model, problem: &Problem, bounds: (&[f64], &[f64])) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let horizon = problem.horizon_guess(model);
        let targets = problem.targets(model);
        let controls: Vec<f64> = (n..n + declaration.controls.len())
            .map(|k| 0.0_f64.clamp(bounds.0[k], bounds.1[k]))
            .collect();
        let samples = SAMPLES * problem.intervals;
        let states = (0..=samples).map(|i| {
            let share = i as f64 / samples as f64;
            let mut x = problem.q.clone();
            x.resize(2 * n, 0.0);
            for k in 0..n {
                if let Some(target) = targets[k] {
                    x[n + k] = (target - problem.q[k]) / horizon;
                    x[k] += share * (target - problem.q[k]);
                }
            }
            with_forces(model, x, &drive(model, &controls, share * horizon))
        });
        Self {
            horizon,
            states: states.collect(),
            time: (0..=samples)
                .map(|i| horizon * i as f64 / samples as f64)
                .collect(),
            controls: ControlGrid::constant(vec![controls.clone(); problem.intervals]),
        }
    }

    /// All states as at the start, over 1 s unless the horizon is fixed.
    fn at_rest(mut self, model: &dyn Model, problem: &Problem) -> Self {
        let driven = drive(model, self.controls.start(), 0.0);
        let state = with_forces(model, problem.start(), &driven);
        self.states.fill(state);
        if let Horizon::Free { guess: None } = problem.horizon {
            for time in &mut self.time {
                *time /= self.horizon;
            }
            self.horizon = 1.0;
        }
        self
    }

    /// The motion under these controls; as far as it goes.
    fn ride(self, model: &dyn Model, problem: &Problem) -> Result<Self, InputError> {
        let simulator = EventDriven {
            output_times: SAMPLES * problem.intervals,
            ..EventDriven::default()
        };
        let motion = problem.initial_value_problem(&problem.start(), self.horizon, self.signal());
        let simulation = simulator.simulate(model, &motion, &mut |_| true)?;
        if simulation.trajectory.time.is_empty() {
            return Ok(self);
        }
        Ok(Self::of_simulation(
            model,
            &simulation,
            self.horizon,
            self.controls,
        ))
    }

    /// Random controls within a quarter of their range, the horizon scaled by up to 15 %, and every coordinate
    /// bent by up to a twentieth of the distance to its goal.
    fn perturbed(
        mut self,
        model: &dyn Model,
        problem: &Problem,
        seed: u64,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        let n = problem.q.len();
        let mut state = seed;
        // SplitMix64 (Steele, Lea, Flood 2014), mapped to [-1, 1).
        let mut random = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        if let Horizon::Free { .. } = problem.horizon {
            let factor = (0.15 * random()).exp();
            self.horizon *= factor;
            self.time.iter_mut().for_each(|time| *time *= factor);
        }
        let mut values = self.controls.values().to_vec();
        for controls in &mut values {
            for (u, k) in controls.iter_mut().zip(n..) {
                let range = bounds.1[k] - bounds.0[k];
                let size = if range.is_finite() { 0.25 * range } else { 0.1 };
                *u = (*u + size * random()).clamp(bounds.0[k], bounds.1[k]);
            }
        }
        self.controls = ControlGrid::constant(values);
        let last = (self.states.len() - 1) as f64;
        for (k, target) in problem.targets(model).into_iter().enumerate() {
            let bend = 0.05 * random() * target.map_or(0.0, |target| target - problem.q[k]);
            for (i, x) in self.states.iter_mut().enumerate() {
                x[k] += bend * (std::f64::consts::PI * i as f64 / last).sin();
            }
        }
        for (i, x) in self.states.iter_mut().enumerate() {
            let controls = self.controls.at(i as f64 / SAMPLES as f64);
            let driven = drive(model, &controls, self.time[i]);
            *x = with_forces(model, x[..2 * n].to_vec(), &driven);
        }
        self
    }

    /// The motion of a simulation.
    pub(super) fn of_simulation(
        model: &dyn Model,
        simulation: &Simulation,
        horizon: f64,
        controls: ControlGrid,
    ) -> Self {
        let declaration = model.declaration();
        let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
        let trajectory = &simulation.trajectory;
        let states = (0..trajectory.time.len()).map(|i| {
            let mut x = trajectory.q[i].clone();
            x.extend(&trajectory.v[i]);
            let plain = x.len();
            x.extend(drive(model, &trajectory.u[i], trajectory.time[i]));
            let forces: Vec<f64> = (0..declaration.contacts.len())
                .map(|contact| {
                    model.contact(contact, &x, &mut point);
                    trajectory.contact_force[i][contact] * point[contact_point::INVERSE_INERTIA]
                })
                .collect();
            x.truncate(plain);
            x.extend(forces);
            x
        });
        Self {
            horizon,
            controls,
            time: trajectory.time.clone(),
            states: states.collect(),
        }
    }

    /// The motion up to its last jump, stretched to the whole length, if that is a jump in the last interval: a
    /// start for a motion that ends with an impact.
    pub(super) fn up_to_last_jump(&self, intervals: usize) -> Self {
        let mut path = self.clone();
        let jumps = |k: &usize| {
            let passed = self.time[*k] - self.time[k - 1];
            passed <= SAME_TIME * self.horizon && self.states[k - 1] != self.states[*k]
        };
        let late = |k: &usize| {
            self.time[*k] > 0.0 && self.horizon - self.time[*k] < self.horizon / intervals as f64
        };
        let Some(last) = (1..self.time.len()).rev().find(jumps).filter(late) else {
            return path;
        };
        let factor = self.horizon / self.time[last];
        path.time.truncate(last + 1);
        path.states.truncate(last + 1);
        path.time.iter_mut().for_each(|time| *time *= factor);
        path.time[last - 1] = self.horizon;
        path.time[last] = self.horizon;
        path
    }

    /// The controls as a signal.
    pub(super) fn signal(&self) -> ControlSignal {
        self.controls.signal(self.horizon)
    }

    /// `(q, v, r)` at time `t`, on the later side of a jump if `after`.
    pub(super) fn at(&self, t: f64, after: bool) -> Vec<f64> {
        let next = if after {
            self.time.partition_point(|&time| time <= t)
        } else {
            self.time.partition_point(|&time| time < t)
        };
        let last = self.time.len() - 1;
        if next == 0 || next > last {
            return self.states[next.min(last)].clone();
        }
        let (from, to) = (self.time[next - 1], self.time[next]);
        let share = if to > from {
            (t - from) / (to - from)
        } else {
            1.0
        };
        let pair = self.states[next - 1].iter().zip(&self.states[next]);
        pair.map(|(a, b)| a + share * (b - a)).collect()
    }
}

/// What the model reads besides the state: the controls, and the time where it depends on that.
pub(super) fn drive(model: &dyn Model, controls: &[f64], time: f64) -> Vec<f64> {
    let explicit = model.declaration().explicit_time;
    let time = explicit.then_some(time);
    controls.iter().copied().chain(time).collect()
}

/// `(q, v)` with the normal accelerations that keep the contacts closed, as far as they push.
pub(super) fn with_forces(model: &dyn Model, state: Vec<f64>, drive: &[f64]) -> Vec<f64> {
    let mut x = state;
    let plain = x.len();
    x.extend(drive);
    let forces: Vec<f64> = (0..model.declaration().contacts.len())
        .map(|contact| (-free_normal_acceleration(model, contact, &x)).max(0.0))
        .collect();
    x.truncate(plain);
    x.extend(forces);
    x
}

/// Normal acceleration of a contact without its force, `n'a + curvature`, at an input vector.
pub(super) fn free_normal_acceleration(model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
    let n = model.declaration().coordinates.len();
    let mut point = vec![0.0; contact_point::length(n)];
    let mut acceleration = vec![0.0; n];
    model.contact(contact, x, &mut point);
    model.free_acceleration(x, &mut acceleration);
    let normal = &point[contact_point::NORMAL..][..n];
    let along: f64 = normal.iter().zip(&acceleration).map(|(n, a)| n * a).sum();
    along + point[contact_point::CURVATURE]
}
