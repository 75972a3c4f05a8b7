//! What a solved element tells: its error estimate and the state inside it.

use super::FiniteElement;
use crate::rk::ButcherTableau;

impl FiniteElement<'_> {
    /// Embedded error estimate of order `s`: the defect of the collocation polynomials at the start of the
    /// element, `h (k_0 - p(0)) / s^2`, relative to `tolerance` times one plus the size of the component.
    /// `acceleration` is the true acceleration at the start. Source: Hairer, Wanner, Solving ODEs II,
    /// section IV.8, for any number of stages.
    pub(crate) fn error_ratio(&self, acceleration: &[f64], tolerance: f64) -> f64 {
        let (n, stages, block) = (self.n, self.tableau.stages(), self.block());
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        self.tableau.lagrange_values(0.0, &mut values[..stages]);
        let weight = self.length / (stages * stages) as f64;
        let mut ratio = 0.0_f64;
        for (k, &start) in acceleration.iter().enumerate() {
            let (mut by_velocity, mut by_position) = (-start, -self.start.v[k]);
            for (j, value) in values[..stages].iter().enumerate() {
                by_velocity += value * self.unknowns[j * block + k];
                by_position += value * self.inputs_of_stages[j * self.inputs + n + k];
            }
            ratio = ratio
                .max(weight * by_velocity.abs() / (1.0 + self.start.v[k].abs()))
                .max(weight * by_position.abs() / (1.0 + self.start.q[k].abs()));
        }
        ratio / tolerance
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
