//! Residuals of the optimality conditions and the error of the stopping test.

use super::barrier_problem::BarrierProblem;
use super::iterate::Iterate;
use crate::linalg::norms::{norm_inf, norm_one};

/// Multipliers up to this average are not scaled out of the error, s_max.
pub(crate) const SCALE_MAX: f64 = 100.0;

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
        let dual = self.dual / self.dual_scale;
        let complementarity = self.complementarity / self.complementarity_scale;
        if (self.primal + dual + complementarity).is_nan() {
            return f64::NAN;
        }
        self.primal.max(dual).max(complementarity)
    }
}

/// What the optimality errors of all barrier parameters follow from, at one point.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Optimality {
    primal: f64,
    dual: f64,
    /// Least and greatest `distance z`, if there is a bound.
    products: Option<(f64, f64)>,
    /// Scales (s_d, s_c): `max(100, average multiplier) / 100`.
    dual_scale: f64,
    complementarity_scale: f64,
}

impl Optimality {
    /// Measures the point with the given residuals and gradient of the Lagrangian.
    pub(crate) fn new(
        problem: &BarrierProblem,
        iterate: &Iterate,
        residual: &[f64],
        lagrangian: &[f64],
    ) -> Self {
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut bounds, mut sum_z) = (0, 0.0);
        let mut see = |distance: f64, z: f64| {
            let product = distance * z;
            if product < least {
                least = product;
            }
            if product > greatest {
                greatest = product;
            }
            bounds += 1;
            sum_z += z.abs();
        };
        let multipliers = iterate.z_lower.iter().zip(&iterate.z_upper);
        let bounded = problem.lower.iter().zip(&problem.upper);
        for ((v, (z_lower, z_upper)), (lower, upper)) in
            iterate.v.iter().zip(multipliers).zip(bounded)
        {
            if lower.is_finite() {
                see(v - lower, *z_lower);
            }
            if upper.is_finite() {
                see(upper - v, *z_upper);
            }
        }
        let average = |sum: f64, count: usize| {
            if count == 0 {
                1.0
            } else {
                (sum / count as f64).max(SCALE_MAX) / SCALE_MAX
            }
        };
        Self {
            primal: norm_inf(residual),
            dual: norm_inf(lagrangian),
            products: (bounds > 0).then_some((least, greatest)),
            dual_scale: average(norm_one(&iterate.y) + sum_z, iterate.y.len() + bounds),
            complementarity_scale: average(sum_z, bounds),
        }
    }

    /// Error of the barrier problem with parameter `mu`.
    pub(crate) fn error(&self, mu: f64) -> OptimalityError {
        let complementarity = self.products.map_or(0.0, |(least, greatest)| {
            (least - mu).abs().max((greatest - mu).abs())
        });
        OptimalityError {
            primal: self.primal,
            dual: self.dual,
            complementarity,
            dual_scale: self.dual_scale,
            complementarity_scale: self.complementarity_scale,
        }
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
    let multipliers = iterate.z_lower.iter().zip(&iterate.z_upper);
    for ((out, gradient), (z_lower, z_upper)) in out.iter_mut().zip(gradient).zip(multipliers) {
        *out = gradient - z_lower + z_upper;
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

#[cfg(test)]
mod tests {
    use super::super::barrier_problem::Objective;
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

    #[test]
    fn scaled_error_that_is_not_a_number_is_not_hidden_by_the_others() {
        let error = OptimalityError {
            dual: f64::NAN,
            dual_scale: 1.0,
            complementarity_scale: 1.0,
            ..OptimalityError::default()
        };
        assert!(error.scaled().is_nan());
    }

    #[test]
    fn optimality_gives_the_error_of_every_barrier_parameter() {
        let infinite = f64::INFINITY;
        let problem = BarrierProblem {
            n: 2,
            m: 1,
            products: Vec::new(),
            slacks: Vec::new(),
            lower: vec![0.0, -infinite],
            upper: vec![infinite, 3.0],
            b: vec![0.0],
            objective: Objective::Original,
        };
        // distances times multipliers are 1 and 8
        let iterate = Iterate {
            v: vec![2.0, 1.0],
            y: vec![-895.5],
            z_lower: vec![0.5, 0.0],
            z_upper: vec![0.0, 4.0],
        };
        let optimality = Optimality::new(&problem, &iterate, &[0.25], &[-0.5, 0.125]);
        let error = optimality.error(0.0);
        assert_eq!((error.primal, error.dual), (0.25, 0.5));
        assert_eq!(error.complementarity, 8.0);
        assert_eq!(optimality.error(10.0).complementarity, 9.0);
        assert_eq!(optimality.error(2.0).complementarity, 6.0);
        // (895.5 + 4.5) / 3 = 300, and 4.5 / 2 is below 100
        assert_eq!((error.dual_scale, error.complementarity_scale), (3.0, 1.0));
    }
}
