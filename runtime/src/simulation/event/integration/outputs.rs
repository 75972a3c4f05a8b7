//! The points of a trajectory at times that were asked for.

use crate::simulation::Trajectory;
use crate::simulation::event::dop853::{Dop853, System};
use crate::simulation::event::dynamics::{Dynamics, motion};

/// Times at which the motion is to be known, `horizon / count` apart, and a state inside a step.
pub(super) struct Outputs {
    pub(super) state: Vec<f64>,
    pub(super) slope: Vec<f64>,
    /// Length of the motion \[s\].
    horizon: f64,
    /// Number of output times.
    count: usize,
    /// Index of the next one.
    next: usize,
}

impl Outputs {
    /// Those of a motion whose states have that many components.
    pub(super) fn new(length: usize, horizon: f64, count: usize) -> Self {
        Self {
            state: vec![0.0; length],
            slope: vec![0.0; length],
            horizon,
            count,
            next: 1,
        }
    }

    fn time(&self, index: usize) -> f64 {
        self.horizon * index as f64 / self.count as f64
    }

    /// Whether an output time lies inside the next `h` from the time `t` on.
    pub(super) fn are_due(&self, t: f64, h: f64) -> bool {
        self.next < self.count && self.time(self.next) < t + h
    }

    /// Writes the output times inside the first `until` of the step of length `h` just made from the time `t` on.
    pub(super) fn write(
        &mut self,
        (dynamics, method): (&mut Dynamics, &Dop853),
        trajectory: &mut Trajectory,
        (t, h, until): (f64, f64, f64),
    ) {
        while self.are_due(t, until) {
            let time = self.time(self.next);
            self.next += 1;
            if time <= t {
                continue;
            }
            method.interpolate((time - t) / h, &mut self.state);
            if !motion::project(dynamics, time, &mut self.state) {
                continue;
            }
            dynamics.derivative(time, &self.state, &mut self.slope);
            let (mut normal, mut tangential) = (vec![0.0; dynamics.contacts], Vec::new());
            dynamics.forces(&mut normal);
            if dynamics.laws.declares_friction {
                tangential.clone_from(&normal);
                dynamics.friction_forces(&mut tangential);
            }
            let now = (time, &self.state[..]);
            record(trajectory, dynamics, now, (&normal, &tangential));
        }
    }
}

/// Adds the state `y` at `t`, with the normal forces of the contacts and, where the scene declares friction, the tangential ones.
pub(super) fn record(
    trajectory: &mut Trajectory,
    dynamics: &Dynamics<'_>,
    (t, y): (f64, &[f64]),
    (normal, tangential): (&[f64], &[f64]),
) {
    let n = dynamics.n;
    let (q, v) = (&y[..n], &y[n..2 * n]);
    trajectory.push(t, y[2 * n], q, v, &dynamics.u, normal);
    if dynamics.laws.declares_friction {
        trajectory.friction_force.push(tangential.to_vec());
    }
}
