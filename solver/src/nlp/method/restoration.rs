//! The restoration phase: the least violation near the current point.
//!
//! ```text
//!     min  rho sum (n + p + t) + zeta/2 |D (x - x_ref)|^2
//!     s.t. c(x) + slacks + n - p = b,   x_i x_j + s - t = sigma,   n, p, t >= 0
//! ```
//!
//! with `rho = 1000`, `zeta = sqrt(mu)`, solved by the same loop on the same Newton pattern.

use super::barrier::Monotone;
use super::filter::Filter;
use super::safeguard::safeguard;
use super::state::{Outcome, Point, State};
use super::trial::raise_product_slacks;
use crate::nlp::Status;
use crate::nlp::program::barrier_problem::{BarrierProblem, Values};
use crate::nlp::program::formulation::Formulation;
use crate::nlp::program::iterate::Iterate;

/// Penalty of the elastic slacks.
pub(super) const PENALTY: f64 = 1000.0;

/// How the restoration phase ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Restored {
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

/// Test for leaving the restoration phase: is a point good enough for the main problem to go on with?
pub(super) struct Leave {
    main: BarrierProblem,
    filter: Filter,
    mu: f64,
    sigma: f64,
    /// Violation below which the main loop goes on.
    theta: f64,
    point: Vec<f64>,
    values: Values,
}

impl Leave {
    /// Whether the part of `iterate` that belongs to the main problem has a small enough violation and is acceptable to its
    /// filter.
    pub(super) fn accepts(&mut self, formulation: &mut Formulation<'_>, iterate: &Iterate) -> bool {
        let Self {
            main,
            point,
            values,
            ..
        } = self;
        let n = point.len();
        point.copy_from_slice(&iterate.v[..n]);
        raise_product_slacks(main, self.sigma, point);
        if !main.evaluate(formulation, point, self.sigma, self.mu, values) {
            return false;
        }
        let theta = values.theta;
        let phi = main.barrier_function(point, values, self.mu);
        theta <= self.theta && phi.is_finite() && self.filter.accepts(theta, phi)
    }
}

/// The problem, path and end of a phase that minimizes the violation until it is below `factor` times its present value at
/// a point that the filter accepts.
pub(super) fn begin(
    state: &mut State<'_, '_, '_, '_>,
    factor: f64,
) -> (BarrierProblem, Monotone, Leave) {
    let theta = state.point.values.theta;
    let phi = state.barrier_function();
    let filter = &mut state.globalization.filter;
    filter.add(theta, phi);
    // the loop may not go back to where the violation is far greater than here, or it would return
    // here again and again
    filter.theta_max = filter.theta_max.min(10.0 * theta.max(1.0));
    let path = Monotone {
        mu: state.mu.max(state.point.values.infeasibility()).min(1e4),
        sigma: state.sigma,
        tolerance: state.core.settings.tolerance,
    };
    let leave = Leave {
        main: state.problem.clone(),
        filter: filter.clone(),
        mu: state.mu,
        sigma: state.sigma,
        theta: factor * theta,
        point: vec![0.0; state.problem.variables()],
        values: Values::zeros(state.problem.rows()),
    };
    let problem = state.problem.restoration(&state.point.iterate.v, PENALTY);
    (problem, path, leave)
}

/// Takes the point of the main loop into the restoration phase, with the elastic slacks that suit it best.
pub(super) fn enter(inner: &mut State<'_, '_, '_, '_>, main: &BarrierProblem, from: &Point) {
    let mu = inner.mu;
    let main_variables = main.variables();
    let iterate = &mut inner.point.iterate;
    iterate.v[..main_variables].copy_from_slice(&from.iterate.v);
    for i in 0..main_variables {
        iterate.z_lower[i] = from.iterate.z_lower[i].min(PENALTY);
        iterate.z_upper[i] = from.iterate.z_upper[i].min(PENALTY);
    }
    let mut k = main_variables;
    for row in 0..main.m {
        let (n, p) = elastic_pair(from.values.residual[row], mu);
        for value in [n, p] {
            iterate.v[k] = value;
            iterate.z_lower[k] = mu / value;
            k += 1;
        }
    }
    for row in main.m..main.rows() {
        // residual = x_i x_j + s - sigma; t takes what is positive of it
        let t = from.values.residual[row].max(0.0) + mu / PENALTY;
        iterate.v[k] = t;
        iterate.z_lower[k] = mu / t;
        k += 1;
    }
    inner.evaluate_iterate();
    inner.start_filter();
    inner.evaluate_first_derivatives();
    inner.estimate_multipliers();
    safeguard(inner);
}

/// Takes the point of the restoration phase into the main loop.
pub(super) fn take_over(
    state: &mut State<'_, '_, '_, '_>,
    outcome: &Outcome,
    found: &Iterate,
    theta: f64,
) -> Restored {
    let n = state.point.iterate.v.len();
    state.point.iterate.v.copy_from_slice(&found.v[..n]);
    raise_product_slacks(&state.problem, state.sigma, &mut state.point.iterate.v);
    if !state.evaluate_iterate() {
        return Restored::Ended(Status::NotFinite);
    }
    if !outcome.left {
        return match outcome.status {
            Status::Solved | Status::Acceptable if is_violated(state) => {
                Restored::Ended(Status::Infeasible)
            }
            // feasible, though not acceptable to the filter: go on without it
            Status::Solved | Status::Acceptable if state.point.values.theta <= 0.9 * theta => {
                state.globalization.filter.clear();
                reset_multipliers(state, found);
                Restored::Continue
            }
            Status::Solved | Status::Acceptable => Restored::Ended(Status::RestorationFailed),
            status => Restored::Ended(status),
        };
    }
    reset_multipliers(state, found);
    Restored::Continue
}

/// Whether the point violates rows by more than what a solution may.
fn is_violated(state: &State<'_, '_, '_, '_>) -> bool {
    let settings = &state.core.settings;
    let infeasibility = state.point.values.infeasibility();
    if !state.problem.products.is_empty() {
        return infeasibility > settings.tolerance;
    }
    infeasibility > settings.acceptable_tolerance
        || state.unscaled_infeasibility() > settings.constraint_tolerance
}

/// Bound multipliers from the restoration phase, at most 1000; row multipliers by least squares.
fn reset_multipliers(state: &mut State<'_, '_, '_, '_>, found: &Iterate) {
    let n = state.point.iterate.v.len();
    for i in 0..n {
        state.point.iterate.z_lower[i] = found.z_lower[i].min(1e3);
        state.point.iterate.z_upper[i] = found.z_upper[i].min(1e3);
    }
    for (k, slack) in state.problem.slacks.iter().enumerate() {
        if slack.row >= state.problem.m {
            let i = state.problem.n + k;
            state.point.iterate.z_lower[i] = state.mu / state.point.iterate.v[i];
        }
    }
    safeguard(state);
    state.evaluate_first_derivatives();
    state.estimate_multipliers();
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
