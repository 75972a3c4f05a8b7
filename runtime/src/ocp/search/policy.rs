//! Motions under controls by feedback: what feeds power into a motion, or leans against it, leads to swings and run-ups that random controls
//! do not come to.
//!
//! On each interval every control is at a bound: with the sign of the power that it feeds into the motion, with that of the velocity of a
//! coordinate, or at random; from some time on the other way round. Where a coordinate could not stop any more before one of its bounds,
//! controls turn it back.

use super::throw::Throw;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::{natural_size, uniform};
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Horizon;
use crate::ocp::tuning::sampled::{LATEST_TURN, NARROWED, OF_SIZES, TOLERANCE};
use crate::simulation::{EventDriven, SimulationStatus, simulate_once};

/// What a policy follows.
#[derive(Clone, Copy)]
enum Follows {
    Power,
    Velocity,
    Chance,
}

/// A policy: what it follows, between which values each control is, and when it turns round.
struct Policy {
    follows: Follows,
    /// Lower and upper value of each control.
    limits: Vec<(f64, f64)>,
    /// The coordinate whose velocity each control follows, and with which sign.
    followed: Vec<(usize, f64)>,
    /// Share of the motion from which on it is the other way round.
    turn: f64,
    /// Parts of the motion with the same values by chance.
    parts: usize,
}

/// What controls do at a state: the acceleration without them, and the difference that each of them makes from its lower to its upper value.
struct Effects {
    alone: Vec<f64>,
    of: Vec<Vec<f64>>,
}

impl Policy {
    fn drawn(
        setting: Setting,
        straight: &Trajectory,
        seed: u64,
        random: &mut impl FnMut() -> f64,
    ) -> Self {
        let Setting {
            model,
            problem,
            bounds: (lower, upper),
            ..
        } = setting;
        let n = problem.q.len();
        let controls = lower.len() - n;
        let mut share = || 0.5 * (random() + 1.0);
        let used = NARROWED.powf(2.0 * share().powi(2));
        let limits = (n..lower.len()).map(|k| {
            let nearest = 0.0_f64.clamp(lower[k], upper[k]);
            let most = OF_SIZES * natural_size(model, straight, k);
            let low = if lower[k].is_finite() {
                lower[k]
            } else {
                nearest - most
            };
            let high = if upper[k].is_finite() {
                upper[k]
            } else {
                nearest + most
            };
            (
                nearest + used * (low - nearest),
                nearest + used * (high - nearest),
            )
        });
        let limits = limits.collect();
        let followed = (0..controls).map(|_| {
            let coordinate = ((share() * n as f64) as usize).min(n - 1);
            (coordinate, if share() > 0.5 { 1.0 } else { -1.0 })
        });
        Self {
            followed: followed.collect(),
            limits,
            follows: match seed % 3 {
                0 => Follows::Power,
                1 => Follows::Velocity,
                _ => Follows::Chance,
            },
            turn: LATEST_TURN * share(),
            parts: 1 + (share() * problem.intervals as f64).round() as usize,
        }
    }

    /// What it sets at a state, at a share of the motion.
    fn controls(
        &self,
        setting: Setting,
        (state, time, share): (&[f64], f64, f64),
        chance: &[bool],
        step: f64,
    ) -> Vec<f64> {
        let n = setting.problem.q.len();
        let effects = self.effects(setting, state, time);
        let mass = match self.follows {
            Follows::Power => mass(setting, state, time),
            Follows::Velocity | Follows::Chance => Vec::new(),
        };
        let way = if share < self.turn { 1.0 } else { -1.0 };
        let controls = self.limits.iter().enumerate().map(|(k, &(low, high))| {
            let followed = match self.follows {
                Follows::Power => power(&mass, &state[n..2 * n], &effects.of[k]),
                Follows::Velocity => {
                    let (coordinate, sign) = self.followed[k];
                    sign * state[n + coordinate]
                }
                Follows::Chance => 0.0,
            };
            let up = match way * followed {
                value if value > 0.0 => true,
                value if value < 0.0 => false,
                _ => chance[k],
            };
            if up { high } else { low }
        });
        let mut controls: Vec<f64> = controls.collect();
        self.turn_back(setting, (state, step), &effects, &mut controls);
        controls
    }

    fn effects(&self, setting: Setting, state: &[f64], time: f64) -> Effects {
        let model = setting.model;
        let n = setting.problem.q.len();
        let idle: Vec<f64> = self
            .limits
            .iter()
            .map(|&(low, high)| 0.0_f64.clamp(low.min(high), high.max(low)))
            .collect();
        let acceleration = |controls: &[f64]| {
            let mut input = state[..2 * n].to_vec();
            input.extend(drive(model, controls, time));
            let mut acceleration = vec![0.0; n];
            model.free_acceleration(&input, &mut acceleration);
            acceleration
        };
        let of = self.limits.iter().enumerate().map(|(k, &(low, high))| {
            let with = |value: f64| {
                let mut controls = idle.clone();
                controls[k] = value;
                acceleration(&controls)
            };
            let pairs = with(high).into_iter().zip(with(low));
            pairs.map(|(high, low)| high - low).collect()
        });
        Effects {
            of: of.collect(),
            alone: acceleration(&idle),
        }
    }

    /// Turns coordinates back that could not stop any more before one of their bounds.
    fn turn_back(
        &self,
        setting: Setting,
        (state, step): (&[f64], f64),
        effects: &Effects,
        controls: &mut [f64],
    ) {
        let (lower, upper) = setting.bounds;
        let n = setting.problem.q.len();
        for i in (0..n).filter(|&i| lower[i].is_finite() || upper[i].is_finite()) {
            let (q, v) = (state[i], state[n + i]);
            let all: f64 = effects.of.iter().map(|effect| effect[i].abs()).sum();
            let most = 0.5 * all;
            if most <= TOLERANCE * (1.0 + effects.alone[i].abs()) {
                continue;
            }
            let way = v * v / (2.0 * most) + v.abs() * step;
            let over = v > 0.0 && q + way > upper[i];
            let under = v < 0.0 && q - way < lower[i];
            if !(over || under) {
                continue;
            }
            for (k, control) in controls.iter_mut().enumerate() {
                let effect = effects.of[k][i];
                let (low, high) = self.limits[k];
                if effect != 0.0 {
                    *control = if (effect > 0.0) == under { high } else { low };
                }
            }
        }
    }
}

/// The mass matrix at a state, row by row.
fn mass(setting: Setting, state: &[f64], time: f64) -> Vec<f64> {
    let n = setting.problem.q.len();
    let controls = vec![0.0; setting.bounds.0.len() - n];
    let mut input = state[..2 * n].to_vec();
    input.extend(drive(setting.model, &controls, time));
    let mut mass = vec![0.0; n * n];
    setting.model.mass_matrix(&input, &mut mass);
    mass
}

/// The power `v' M a` of an acceleration.
fn power(mass: &[f64], v: &[f64], acceleration: &[f64]) -> f64 {
    let rows = mass.chunks(v.len()).zip(v);
    let terms = rows.map(|(row, v)| {
        let force: f64 = row.iter().zip(acceleration).map(|(m, a)| m * a).sum();
        v * force
    });
    terms.sum()
}

/// The motion under a policy.
pub(super) fn policy(setting: Setting, straight: &Trajectory, seed: u64) -> Throw {
    let Setting { model, problem, .. } = setting;
    let n = problem.q.len();
    // Other numbers than those of random controls.
    let mut random = uniform(!(seed << 20));
    let policy = Policy::drawn(setting, straight, seed, &mut random);
    let intervals = problem.intervals;
    let horizon = match problem.horizon {
        Horizon::Fixed(horizon) => horizon,
        Horizon::Free { .. } => straight.horizon * 2.0_f64.powf(1.0 + random()),
    };
    let step = horizon / intervals as f64;
    let simulator = EventDriven {
        tolerance: TOLERANCE,
        output_times: 1,
        ..EventDriven::default()
    };
    let mut state = problem.start();
    let mut values: Vec<Vec<f64>> = Vec::new();
    let (mut part, mut chance) = (usize::MAX, vec![true; policy.limits.len()]);
    for k in 0..intervals {
        let share = k as f64 / intervals as f64;
        let now = k * policy.parts / intervals;
        if now != part {
            part = now;
            chance.iter_mut().for_each(|up| *up = random() > 0.0);
        }
        let at = (&state[..], share * horizon, share);
        let controls = policy.controls(setting, at, &chance, step);
        let signal = ControlGrid::constant(vec![controls.clone()]).signal(step);
        values.push(controls);
        let motion = problem.initial_value_problem(&state, step, signal);
        let Ok(mut run) = simulate_once(&simulator, model, &motion) else {
            break;
        };
        let end = run.trajectory.q.pop().zip(run.trajectory.v.pop());
        let Some((q, v)) = end.filter(|_| run.status == SimulationStatus::Solved) else {
            break;
        };
        state = [q, v].concat();
        state.truncate(2 * n);
    }
    let last = values.last().cloned().unwrap_or_default();
    values.resize(intervals, last);
    Throw {
        start: problem.start(),
        controls: ControlGrid::constant(values),
        horizon,
    }
}
