//! The motion of a re-simulation between its instants, which are the ends of its steps and more.
//!
//! Between two breaks, which are events and ends of control intervals, coordinates are the polynomials of degree five through `(q, v)` at
//! three neighbouring instants, and velocities their derivatives; only a piece with fewer than three instants has cubics.

use crate::model::held::complete_largest;
use crate::model::{Function, Model};
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::model_input::drive;
use crate::simulation::Simulation;
use crate::yardstick;

/// Share of a motion up to which a step is too short to be looked into: velocities are differences there. Follows: rounding over that share
/// is a millionth.
const SHORTEST: f64 = 1e-9;

/// Least ratio of two neighbouring steps that are interpolated together. Chosen: ten times less than steps of an integrator grow at once.
const APART: f64 = 0.01;

/// A re-simulation under the controls of a plan.
pub(super) struct Dense<'a> {
    model: &'a dyn Model,
    controls: &'a ControlGrid,
    replay: &'a Simulation,
    /// Length of the motion \[s\].
    pub(super) horizon: f64,
}

/// The motion between two instants.
pub(super) struct Step {
    /// When it begins and ends \[s\].
    pub(super) from: f64,
    pub(super) to: f64,
    /// The instants that it is interpolated by: its ends and, if there is one, the next to them.
    near: Vec<usize>,
}

impl<'a> Dense<'a> {
    pub(super) fn new(
        model: &'a dyn Model,
        controls: &'a ControlGrid,
        replay: &'a Simulation,
    ) -> Self {
        let horizon = replay.trajectory.time.last().copied().unwrap_or_default();
        Self {
            model,
            controls,
            replay,
            horizon,
        }
    }

    /// Its steps in the order of time, from one in so many of the instants between two breaks.
    pub(super) fn steps(&self, one_in: usize) -> Vec<Step> {
        let times = &self.replay.trajectory.time;
        let ends = self.controls.times(self.horizon);
        let same = |a: f64, b: f64| (a - b).abs() <= yardstick::ROUNDING * self.horizon;
        let is_break = |time: f64| {
            ends.iter().any(|&end| same(end, time)) || self.events().any(|event| same(event, time))
        };
        let (mut steps, mut first) = (Vec::new(), 0);
        for k in 1..times.len() {
            if k + 1 < times.len() && !is_break(times[k]) {
                continue;
            }
            let piece = self.apart((first..k).step_by(one_in).chain([k]).collect());
            for step in 0..piece.len() - 1 {
                let (from, to) = (times[piece[step]], times[piece[step + 1]]);
                if to - from > SHORTEST * self.horizon {
                    let first = step.saturating_sub(usize::from(step + 2 >= piece.len()));
                    let near = piece[first..(first + 3).min(piece.len())].to_vec();
                    steps.push(Step { from, to, near });
                }
            }
            first = k;
        }
        steps
    }

    /// The instants of a piece without those within it that are much nearer to the one before or behind than to the other: differences of
    /// these are rounding.
    fn apart(&self, piece: Vec<usize>) -> Vec<usize> {
        let times = &self.replay.trajectory.time;
        let mut kept: Vec<usize> = Vec::with_capacity(piece.len());
        for (place, &k) in piece.iter().enumerate() {
            let is_apart = match (kept.last(), piece.get(place + 1)) {
                (Some(&before), Some(&behind)) => {
                    let gaps = [times[k] - times[before], times[behind] - times[k]];
                    gaps[0] > APART * gaps[1] && gaps[1] > APART * gaps[0]
                }
                _ => true,
            };
            kept.extend(is_apart.then_some(k));
        }
        kept
    }

    /// When something happens \[s\].
    pub(super) fn events(&self) -> impl Iterator<Item = f64> {
        self.replay.events.iter().map(|event| event.time)
    }

    /// The control interval of a step.
    pub(super) fn interval(&self, step: &Step) -> usize {
        self.controls
            .interval_at(self.place(0.5 * (step.from + step.to)))
    }

    /// A time in units of intervals of equal length.
    fn place(&self, time: f64) -> f64 {
        time / self.horizon * self.controls.intervals() as f64
    }

    /// What path functions read at a time of a step, without forces.
    pub(super) fn input(&self, step: &Step, time: f64) -> Vec<f64> {
        let mut x = self.state(&step.near, time);
        let u = match self.controls.shape {
            ControlShape::Constant => self.controls.at(self.place(0.5 * (step.from + step.to))),
            ControlShape::Linear => self.controls.at(self.place(time)),
        };
        x.extend(drive(self.model, &u, time));
        x.resize(self.model.declaration().path_inputs(), 0.0);
        complete_largest(self.model, &mut x);
        x
    }

    /// The values of path functions there.
    pub(super) fn path_functions(&self, x: &[f64]) -> Vec<f64> {
        let declared = self.model.declaration().optimal_control;
        let mut values = vec![0.0; declared.map_or(0, |declared| declared.path_functions())];
        self.model.values(Function::Path, x, &mut values);
        values
    }

    /// `(q, v)` at a time by the polynomials through some instants, by divided differences over each of them taken twice.
    fn state(&self, instants: &[usize], time: f64) -> Vec<f64> {
        let motion = &self.replay.trajectory;
        let nodes: Vec<f64> = instants.iter().flat_map(|&k| [motion.time[k]; 2]).collect();
        let n = motion.q[instants[0]].len();
        let mut state = vec![0.0; 2 * n];
        for k in 0..n {
            let mut table: Vec<f64> = instants.iter().flat_map(|&i| [motion.q[i][k]; 2]).collect();
            for order in 1..nodes.len() {
                for i in (order..nodes.len()).rev() {
                    let width = nodes[i] - nodes[i - order];
                    table[i] = if order == 1 && i % 2 == 1 {
                        motion.v[instants[i / 2]][k]
                    } else if width > 0.0 {
                        (table[i] - table[i - 1]) / width
                    } else {
                        0.0
                    };
                }
            }
            let (mut value, mut slope) = (0.0, 0.0);
            for (node, difference) in nodes.iter().zip(&table).rev() {
                slope = slope * (time - node) + value;
                value = value * (time - node) + difference;
            }
            (state[k], state[n + k]) = (value, slope);
        }
        state
    }
}
