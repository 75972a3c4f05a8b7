//! The soft restoration: Newton steps that lower the optimality error where the filter refuses them.
//!
//! The full Newton direction with one step length for primal and dual variables lowers the error of the barrier problem
//!
//! ```text
//!     E(mu) = |dual|_1/n + |primal|_1/m + |distance z - mu|_1/b
//! ```
//!
//! if it is short enough, whatever objective and violation do. Where the line search fails, the point enters the filter, and
//! such steps are taken instead of a search, each of which must reach 0.9999 of the error before it, until one of them
//! leads to a point that the filter accepts; only then, or when one fails, comes the restoration phase (Waechter and
//! Biegler, Mathematical Programming 106, 2006, section 3.3).

use super::filter::is_sufficient;
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
    /// `E(mu)` of the current point, whose Lagrangian is up to date; in free mode `mu = 0`.
    fn primal_dual_error(&self) -> f64 {
        let is_free = self.adaptive.as_ref().is_some_and(|a| a.is_free);
        let mu = if is_free { 0.0 } else { self.mu };
        mean(self.lagrangian.iter().copied())
            + mean(self.values.residual.iter().copied())
            + mean(products(&self.problem, &self.iterate).map(|product| product - mu))
    }

    /// Takes the Newton step if the filter accepts its end, which ends the soft restoration, or if it lowers the
    /// primal-dual error; `false` leaves the point as it was.
    pub(crate) fn soft_restoration_step(&mut self) -> bool {
        let is_main = !self.is_restoration && self.problem.products.is_empty();
        if !is_main || self.soft_steps >= self.core.settings.soft_restoration_steps {
            self.soft_steps = 0;
            return false;
        }
        let error = self.primal_dual_error();
        let (theta, phi) = (self.values.theta, self.barrier_function());
        if self.soft_steps == 0 {
            self.filter.add(theta, phi);
        }
        let alpha = self
            .longest_step(&self.direction)
            .min(self.longest_dual_step(&self.direction));
        if !self.take_trial(alpha, false) {
            self.soft_steps = 0;
            return false;
        }
        let (trial_theta, trial_phi) = (
            self.trial_values.theta,
            self.problem
                .barrier_function(&self.trial, &mut self.trial_values, self.mu),
        );
        let leaves = trial_phi.is_finite()
            && trial_theta <= self.filter.theta_max
            && is_sufficient(trial_theta, trial_phi, theta, phi)
            && self.filter.accepts(trial_theta, trial_phi);
        // the correction of the search that failed is not needed any more
        self.correction.copy_from(&self.iterate);
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
        if !leaves {
            self.evaluate_first_derivatives();
            self.update_lagrangian();
            let reached = self.primal_dual_error();
            if !(reached.is_finite() && reached <= REDUCTION * error) {
                self.iterate.copy_from(&self.correction);
                std::mem::swap(&mut self.values, &mut self.trial_values);
                self.evaluate_first_derivatives();
                self.update_lagrangian();
                self.soft_steps = 0;
                return false;
            }
        }
        self.safeguard();
        self.soft_steps = if leaves { 0 } else { self.soft_steps + 1 };
        self.info.acceptance = if leaves { 'S' } else { 's' };
        self.info.step_length_primal = alpha;
        self.info.step_length_dual = alpha;
        true
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
