//! How long steps may be: the first one, those that tell what depends on time, and what rounding leaves of their errors.

use super::{GLANCE, Integration};
use crate::simulation::event::dop853::System;

/// Power of the length of a step with which errors of steps fall much faster.
const SLOWLY: i32 = 3;

impl Integration<'_> {
    /// Expects a first step by the free accelerations, to which those of the first contact mode are compared: beside what
    /// would give the velocities in a glance, any of them would be small.
    pub(super) fn expect_step(&mut self, longest: f64) {
        let n = self.dynamics.n;
        self.dynamics.observe(self.t, &self.y, self.h);
        let a = self.dynamics.free_acceleration().to_vec();
        let mass = self.dynamics.mass(self.t, &self.y);
        let scale = &self.step.error_scale;
        let time = scale.time_at_start(mass, &self.y[n..2 * n], &a);
        self.dynamics.expect_moment(time.min(longest));
    }

    /// A first step size: a share of the shortest time in which velocities or accelerations change.
    pub(super) fn first_step(&mut self, longest: f64) -> f64 {
        let n = self.dynamics.n;
        let moment = GLANCE * longest;
        let slope = self.method.slope();
        for ((later, y), slope) in self.dense.state.iter_mut().zip(&self.y).zip(slope) {
            *later = y + moment * slope;
        }
        self.dynamics
            .derivative(self.t + moment, &self.dense.state, &mut self.dense.slope);
        let change: Vec<f64> = self.dense.slope[n..2 * n]
            .iter()
            .zip(&slope[n..2 * n])
            .map(|(later, now)| later - now)
            .collect();
        let mass = self.dynamics.mass(self.t, &self.y);
        let time = self.step.error_scale.shortest_time(mass, &change, moment);
        let h = (self.settings.tolerance.powf(1.0 / 8.0) * time).min(longest);
        self.dynamics.expect_moment(h);
        h
    }

    /// Looks at what rounding makes of accelerations where a step of length `h` is rejected for an `error` that hardly falls with the length,
    /// as those of a method of order 8 do.
    pub(super) fn look_at_rounding(&mut self, h: f64, error: f64) {
        let last = self.step.rejected.replace((self.t, h, error));
        let hardly_falls = last.is_some_and(|(time, length, before)| {
            time == self.t && h < length && error > before * (h / length).powi(SLOWLY)
        });
        if hardly_falls {
            self.observe_rounding();
        }
    }

    /// Tells the measure of errors what the last digits of the present state make of its derivative, which is known.
    fn observe_rounding(&mut self) {
        let n = self.dynamics.n;
        let mut change = vec![0.0_f64; n];
        // All digits one way, and neighbours against each other: what one choice hides in a difference shows in the other.
        for other in [1.0, -1.0] {
            let places = self.dense.state.iter_mut().zip(&self.y).enumerate();
            for (k, (moved, y)) in places {
                let sense = if k % 2 == 0 { 1.0 } else { other };
                *moved = y * (1.0 + sense * f64::EPSILON);
            }
            self.dynamics
                .derivative(self.t, &self.dense.state, &mut self.dense.slope);
            let slopes = self.dense.slope[n..].iter().zip(&self.method.slope()[n..]);
            for (change, (moved, slope)) in change.iter_mut().zip(slopes) {
                *change = change.max((moved - slope).abs());
            }
        }
        if change.iter().all(|change| change.is_finite()) {
            let mass = self.dynamics.mass(self.t, &self.y);
            self.step.error_scale.observe_rounding(mass, &change);
        }
    }

    /// Length of a step of at most `wanted` that tells what depends on time.
    pub(super) fn foreseen(&mut self, wanted: f64) -> f64 {
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
}
