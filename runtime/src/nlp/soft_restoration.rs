//! The soft restoration: Newton steps that lower the optimality error where the filter refuses them.
//!
//! The full Newton direction with one step length for primal and dual variables lowers the error of the barrier problem
//!
//! ```text
//!     E(mu) = |dual|_1/n + |primal|_1/m + |distance z - mu|_1/b
//! ```
//!
//! if it is short enough, whatever objective and violation do. Such steps, each of which must reach 0.9999 of the error
//! before it, often bring the iterates to a point that the filter accepts, without the restoration phase.

use super::quality_function::products;
use super::solver::Loop;

/// Factor by which a step has to lower the error.
const REDUCTION: f64 = 0.9999;

/// Mean absolute value; 0 of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for value in values {
        sum += value.abs();
        count += 1;
    }
    if count == 0 { 0.0 } else { sum / count as f64 }
}

impl Loop<'_, '_, '_, '_> {
    /// `E(mu)` of the current point, whose Lagrangian is up to date.
    fn primal_dual_error(&self) -> f64 {
        mean(self.lagrangian.iter().copied())
            + mean(self.values.residual.iter().copied())
            + mean(products(&self.problem, &self.iterate).map(|product| product - self.mu))
    }

    /// Takes the Newton step if it lowers the primal-dual error; `false` leaves the point as it was.
    pub(crate) fn soft_restoration_step(&mut self) -> bool {
        let is_main = !self.is_restoration && self.problem.products.is_empty();
        if !is_main || self.soft_steps >= self.core.settings.soft_restoration_steps {
            return false;
        }
        let error = self.primal_dual_error();
        let theta = self.values.theta;
        let phi = self.barrier_function();
        let alpha = self
            .longest_step(&self.direction)
            .min(self.longest_dual_step(&self.direction));
        if !self.take_trial(alpha, false) {
            return false;
        }
        let before = self.iterate.clone();
        std::mem::swap(&mut self.iterate.v, &mut self.trial);
        std::mem::swap(&mut self.values, &mut self.trial_values);
        for (value, step) in [
            (&mut self.iterate.y, &self.direction.y),
            (&mut self.iterate.z_lower, &self.direction.z_lower),
            (&mut self.iterate.z_upper, &self.direction.z_upper),
        ] {
            for (value, step) in value.iter_mut().zip(step) {
                *value += alpha * step;
            }
        }
        self.safeguard();
        self.evaluate_first_derivatives();
        self.update_lagrangian();
        let reached = self.primal_dual_error();
        if reached.is_finite() && reached <= REDUCTION * error {
            if self.soft_steps == 0 {
                self.filter.add(theta, phi);
            }
            self.soft_steps += 1;
            self.info.acceptance = 's';
            self.info.step_length_primal = alpha;
            self.info.step_length_dual = alpha;
            return true;
        }
        self.iterate.copy_from(&before);
        std::mem::swap(&mut self.values, &mut self.trial_values);
        self.evaluate_first_derivatives();
        self.update_lagrangian();
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_is_of_absolute_values() {
        assert_eq!(mean([3.0, -5.0].into_iter()), 4.0);
        assert_eq!(mean(std::iter::empty()), 0.0);
    }
}
