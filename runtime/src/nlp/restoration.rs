//! The restoration phase: the least violation near the current point.
//!
//! ```text
//!     min  rho sum (n + p + t) + zeta/2 |D (x - x_ref)|^2
//!     s.t. c(x) + slacks + n - p = b,   x_i x_j + s - t = sigma,   n, p, t >= 0
//! ```
//!
//! with `rho = 1000`, `zeta = sqrt(mu)`, solved by the same loop on the same Newton pattern.

use super::barrier::Monotone;
use super::barrier_problem::Values;
use super::solver::{Loop, Outcome};
use super::{Settings, Status};

/// Penalty of the elastic slacks.
const PENALTY: f64 = 1000.0;

/// How the restoration phase ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Restored {
    /// The main loop goes on from the new point.
    Continue,
    /// The run ends.
    Ended(Status),
}

/// The pair of elastic slacks `(n, p)` that minimizes `rho (n + p) - mu (log n + log p)` for
/// `residual + n - p = 0` (Waechter and Biegler 2006, equations 32 and 33).
fn elastic_pair(residual: f64, mu: f64) -> (f64, f64) {
    let half = (mu - PENALTY * residual) / (2.0 * PENALTY);
    let n = half + (half * half + mu * residual / (2.0 * PENALTY)).sqrt();
    // for a large positive residual the sum above cancels
    let n = if half < 0.0 {
        let root = (half * half + mu * residual / (2.0 * PENALTY)).sqrt();
        (mu * residual / (2.0 * PENALTY)) / (root - half)
    } else {
        n
    };
    let n = n.max(f64::MIN_POSITIVE.sqrt());
    (n, residual + n)
}

impl Loop<'_, '_, '_, '_> {
    /// Minimizes the violation until it is below `factor` times its present value at a point that the
    /// filter accepts.
    pub(crate) fn restoration_phase(&mut self, factor: f64) -> Restored {
        let theta = self.values.theta;
        let phi = self.barrier_function();
        self.filter.add(theta, phi);
        // the loop may not go back to where the violation is far greater than here, or it would return
        // here again and again
        self.filter.theta_max = self.filter.theta_max.min(10.0 * theta.max(1.0));

        let problem = self.problem.restoration(&self.iterate.v, PENALTY);
        let mu = self.mu.max(self.values.infeasibility()).min(1e4);
        let mut path = Monotone {
            mu,
            sigma: self.sigma,
            tolerance: self.core.settings.tolerance,
        };
        let settings: Settings = self.core.settings.clone();
        // the test for leaving looks at the main problem
        let main = self.problem.clone();
        let filter = self.filter.clone();
        let (main_mu, sigma) = (self.mu, self.sigma);
        let main_variables = main.variables();
        let mut values = Values::zeros(main.rows());
        let mut point = vec![0.0; main_variables];
        let mut leave = |formulation: &mut super::formulation::Formulation<'_>,
                         _: &super::barrier_problem::BarrierProblem,
                         iterate: &super::iterate::Iterate| {
            point.copy_from_slice(&iterate.v[..main_variables]);
            raise_product_slacks(&main, sigma, &mut point);
            if !main.evaluate(formulation, &point, sigma, main_mu, &mut values) {
                return false;
            }
            let theta_new = values.theta;
            let phi = main.barrier_function(&point, &mut values, main_mu);
            theta_new <= factor * theta && phi.is_finite() && filter.accepts(theta_new, phi)
        };

        let (outcome, found) = {
            let mut inner = Loop::new(self.core, problem, &mut path, true);
            inner.iterate.v[..main_variables].copy_from_slice(&self.iterate.v);
            for i in 0..main_variables {
                inner.iterate.z_lower[i] = self.iterate.z_lower[i].min(PENALTY);
                inner.iterate.z_upper[i] = self.iterate.z_upper[i].min(PENALTY);
            }
            let first = inner.problem.n + (main_variables - self.problem.n);
            let mut k = first;
            for row in 0..self.problem.m {
                let (n, p) = elastic_pair(self.values.residual[row], mu);
                for value in [n, p] {
                    inner.iterate.v[k] = value;
                    inner.iterate.z_lower[k] = mu / value;
                    k += 1;
                }
            }
            for row in self.problem.m..self.problem.rows() {
                // residual = x_i x_j + s - sigma; t takes what is positive of it
                let t = self.values.residual[row].max(0.0) + mu / PENALTY;
                inner.iterate.v[k] = t;
                inner.iterate.z_lower[k] = mu / t;
                k += 1;
            }
            inner.evaluate_iterate();
            inner.start_filter();
            inner.evaluate_first_derivatives();
            inner.estimate_multipliers();
            inner.safeguard();
            let outcome = inner.run(Some(&mut leave));
            (outcome, inner.iterate.clone())
        };
        self.core.settings = settings;
        self.take_over(&outcome, found, theta)
    }

    /// Takes the point of the restoration phase into the main loop.
    fn take_over(
        &mut self,
        outcome: &Outcome,
        found: super::iterate::Iterate,
        theta: f64,
    ) -> Restored {
        let n = self.iterate.v.len();
        self.iterate.v.copy_from_slice(&found.v[..n]);
        raise_product_slacks(&self.problem, self.sigma, &mut self.iterate.v);
        if !self.evaluate_iterate() {
            return Restored::Ended(Status::NotFinite);
        }
        let tolerance = self.core.settings.tolerance;
        if !outcome.left {
            let infeasibility = self.values.infeasibility();
            return match outcome.status {
                Status::Solved | Status::Acceptable if infeasibility > tolerance => {
                    Restored::Ended(Status::Infeasible)
                }
                // feasible, though not acceptable to the filter: go on without it
                Status::Solved | Status::Acceptable if self.values.theta <= 0.9 * theta => {
                    self.filter.clear();
                    self.reset_multipliers(&found);
                    Restored::Continue
                }
                Status::Solved | Status::Acceptable => Restored::Ended(Status::RestorationFailed),
                status => Restored::Ended(status),
            };
        }
        self.reset_multipliers(&found);
        Restored::Continue
    }

    /// Bound multipliers from the restoration phase, at most 1000; row multipliers by least squares.
    fn reset_multipliers(&mut self, found: &super::iterate::Iterate) {
        let n = self.iterate.v.len();
        for i in 0..n {
            self.iterate.z_lower[i] = found.z_lower[i].min(1e3);
            self.iterate.z_upper[i] = found.z_upper[i].min(1e3);
        }
        for (k, slack) in self.problem.slacks.iter().enumerate() {
            if slack.row >= self.problem.m {
                let i = self.problem.n + k;
                self.iterate.z_lower[i] = self.mu / self.iterate.v[i];
            }
        }
        self.safeguard();
        self.evaluate_first_derivatives();
        self.estimate_multipliers();
    }
}

/// Lifts slacks of products to `sigma - x_i x_j`.
pub(crate) fn raise_product_slacks(
    problem: &super::barrier_problem::BarrierProblem,
    sigma: f64,
    v: &mut [f64],
) {
    for (k, slack) in problem.slacks.iter().enumerate() {
        if slack.row >= problem.m && slack.sign > 0.0 {
            let (i, j) = problem.products[slack.row - problem.m];
            let room = sigma - v[i] * v[j];
            let s = &mut v[problem.n + k];
            *s = s.max(room);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elastic_pair_satisfies_row_and_optimality() {
        // n solves mu/n + mu/p = 2 rho with p = c + n
        for residual in [-3.0, -1e-3, 0.0, 1e-3, 2.0, 1e4] {
            let mu = 0.1;
            let (n, p) = elastic_pair(residual, mu);
            assert!(n > 0.0 && p > 0.0);
            assert!((residual + n - p).abs() <= 1e-12 * (1.0 + residual.abs()));
            let balance = mu / n + mu / p;
            // the sum is exact up to the cancellation in p = c + n
            assert!(
                (balance - 2.0 * PENALTY).abs() < 1e-6 * 2.0 * PENALTY,
                "{residual}"
            );
        }
    }
}
