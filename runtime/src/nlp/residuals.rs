//! Residuals of the optimality conditions and the error of the stopping test.

use super::barrier_problem::BarrierProblem;
use super::iterate::Iterate;

/// Multipliers up to this average are not scaled out of the error, s_max.
const SCALE_MAX: f64 = 100.0;

/// Infinity norms of the optimality conditions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct OptimalityError {
    pub(crate) primal: f64,
    pub(crate) dual: f64,
    /// Largest `|distance z - mu|`.
    pub(crate) complementarity: f64,
    /// Scales s_d and s_c.
    pub(crate) dual_scale: f64,
    pub(crate) complementarity_scale: f64,
}

impl OptimalityError {
    /// `max(primal, dual / s_d, complementarity / s_c)` (Waechter and Biegler 2006, equation 5).
    pub(crate) fn scaled(&self) -> f64 {
        self.primal
            .max(self.dual / self.dual_scale)
            .max(self.complementarity / self.complementarity_scale)
    }
}

/// Gradient of the Lagrangian `grad F + J' y - z_l + z_u` into `out`, given `J` by entries of the
/// explicit rows.
pub(crate) fn lagrangian_gradient(
    problem: &BarrierProblem,
    iterate: &Iterate,
    gradient: &[f64],
    jacobian: impl Iterator<Item = ((usize, usize), f64)>,
    out: &mut [f64],
) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = gradient[i] - iterate.z_lower[i] + iterate.z_upper[i];
    }
    for ((row, column), value) in jacobian {
        out[column] += value * iterate.y[row];
    }
    for (pair, &(i, j)) in problem.products.iter().enumerate() {
        let y = iterate.y[problem.m + pair];
        out[i] += y * iterate.v[j];
        out[j] += y * iterate.v[i];
    }
    for (slack, out) in problem.slacks.iter().zip(&mut out[problem.n..]) {
        *out += slack.sign * iterate.y[slack.row];
    }
}

/// Largest `|distance z - mu|` over all bounds.
pub(crate) fn complementarity(problem: &BarrierProblem, iterate: &Iterate, mu: f64) -> f64 {
    let mut largest: f64 = 0.0;
    for i in 0..iterate.v.len() {
        if problem.lower[i].is_finite() {
            let product = (iterate.v[i] - problem.lower[i]) * iterate.z_lower[i];
            largest = largest.max((product - mu).abs());
        }
        if problem.upper[i].is_finite() {
            let product = (problem.upper[i] - iterate.v[i]) * iterate.z_upper[i];
            largest = largest.max((product - mu).abs());
        }
    }
    largest
}

/// Scales (s_d, s_c): `max(100, average multiplier) / 100`.
pub(crate) fn error_scales(problem: &BarrierProblem, iterate: &Iterate) -> (f64, f64) {
    let mut bounds = 0;
    let mut sum_z = 0.0;
    for i in 0..iterate.v.len() {
        if problem.lower[i].is_finite() {
            bounds += 1;
            sum_z += iterate.z_lower[i].abs();
        }
        if problem.upper[i].is_finite() {
            bounds += 1;
            sum_z += iterate.z_upper[i].abs();
        }
    }
    let sum_y: f64 = iterate.y.iter().map(|y| y.abs()).sum();
    let average = |sum: f64, count: usize| {
        if count == 0 {
            1.0
        } else {
            (sum / count as f64).max(SCALE_MAX) / SCALE_MAX
        }
    };
    (
        average(sum_y + sum_z, iterate.y.len() + bounds),
        average(sum_z, bounds),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_takes_the_largest_of_the_three_scaled_norms() {
        let error = OptimalityError {
            primal: 1e-3,
            dual: 1.0,
            complementarity: 4e-2,
            dual_scale: 100.0,
            complementarity_scale: 2.0,
        };
        assert_eq!(error.scaled(), 2e-2);
    }
}
