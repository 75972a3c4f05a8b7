//! What a solved element tells: its error estimate and the state inside it.

use super::FiniteElement;
use super::motion_size::MotionSize;
use crate::rk::ButcherTableau;

impl FiniteElement<'_> {
    /// Embedded error estimate of order `s`: the defect of the collocation polynomials at the start of the
    /// element, `h (k_0 - p(0)) / s^2`, relative to the `motion` with the element.
    /// `acceleration` is the true acceleration at the start. Source: Hairer, Wanner, Solving ODEs II,
    /// section IV.8, for any number of stages.
    pub(crate) fn relative_error(&self, acceleration: &[f64], motion: &MotionSize) -> f64 {
        let (n, stages, block, h) = (self.n, self.tableau.stages(), self.block(), self.length);
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        self.tableau.lagrange_values(0.0, &mut values[..stages]);
        let weight = h / (stages * stages) as f64;
        let (mut velocity, mut position) = (0.0_f64, 0.0_f64);
        for (k, &start) in acceleration.iter().enumerate() {
            let (mut by_velocity, mut by_position) = (-start, -self.start.v[k]);
            for (j, value) in values[..stages].iter().enumerate() {
                by_velocity += value * self.unknowns[j * block + k];
                by_position += value * self.inputs_of_stages[j * self.inputs + n + k];
            }
            velocity = velocity.max(weight * by_velocity.abs());
            position = position.max(weight * by_position.abs());
        }
        // A start from rest is measured by what the element itself makes of it.
        let speed = motion.speed.max(self.speed());
        let distance = motion.distance.max(h * speed);
        let rounding = motion.rounding;
        let beyond = |error: f64, rounding: f64, size: f64| (error - rounding).max(0.0) / size;
        beyond(velocity, rounding / h, speed).max(beyond(position, rounding, distance))
    }

    /// State inside the solved element by its collocation polynomials; `weights` are the dense output
    /// weights at that place.
    pub(crate) fn interpolate(&self, theta: f64, weights: &[f64], x: &mut [f64]) {
        let (n, h, block) = (self.n, self.length, self.block());
        let multipliers = n + self.constraints.count();
        x.copy_from_slice(self.stage_input(0));
        for k in 0..n {
            let (mut velocity, mut position) = (0.0, 0.0);
            for (j, weight) in weights.iter().enumerate() {
                let unknown = &self.unknowns[j * block..(j + 1) * block];
                velocity += weight * unknown[k];
                position += weight * self.inputs_of_stages[j * self.inputs + n + k];
                for (i, eta) in unknown[multipliers..].iter().enumerate() {
                    position += weight * h * eta * self.corrections[i * n + k];
                }
            }
            x[k] = self.start.q[k] + h * position;
            x[n + k] = self.start.v[k] + h * velocity;
        }
        self.write_time(self.start.time + theta * h, x);
    }
}
