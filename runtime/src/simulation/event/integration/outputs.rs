//! The points of a trajectory at times that were asked for.

use super::Integration;
use crate::simulation::event::dop853::System;
use crate::simulation::event::dynamics::motion;

impl Integration<'_> {
    fn output_time(&self, index: usize) -> f64 {
        self.problem.horizon * index as f64 / self.settings.output_times as f64
    }

    /// Whether an output time lies inside the next `h`.
    pub(super) fn output_due(&self, h: f64) -> bool {
        self.dense.next < self.settings.output_times
            && self.output_time(self.dense.next) < self.t + h
    }

    /// Writes the output times inside the first `until` of the step of length `h` just made.
    pub(super) fn write_outputs(&mut self, h: f64, until: f64) {
        let n = self.dynamics.n;
        while self.output_due(until) {
            let time = self.output_time(self.dense.next);
            self.dense.next += 1;
            if time <= self.t {
                continue;
            }
            self.method
                .interpolate((time - self.t) / h, &mut self.dense.state);
            if !motion::project(&mut self.dynamics, time, &mut self.dense.state) {
                continue;
            }
            self.dynamics
                .derivative(time, &self.dense.state, &mut self.dense.slope);
            let mut forces = vec![0.0; self.forces.normal.len()];
            self.dynamics.forces(&mut forces);
            let trajectory = &mut self.result.trajectory;
            trajectory.push(
                time,
                self.dense.state[2 * n],
                &self.dense.state[..n],
                &self.dense.state[n..2 * n],
                &self.dynamics.u,
                &forces,
            );
            if self.dynamics.laws.declares_friction {
                self.dynamics.friction_forces(&mut forces);
                trajectory.friction_force.push(forces);
            }
        }
    }
}
