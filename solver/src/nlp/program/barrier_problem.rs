//! The barrier problem that the main loop and the restoration phase both solve.
//!
//! ```text
//!     min  F(x) + cost' s - mu sum log(distances to bounds)
//!     s.t. c_i(x) + sum_k sign_k s_k = b_i                  rows 0..m
//!          x_a x_b + sum_k sign_k s_k = sigma               product rows m..m+p
//!          l <= (x, s) <= u
//! ```
//!
//! Each `s_k` appears in exactly one row. In the main problem ranges have one slack (sign -1) and
//! products one (sign +1, `s >= 0`), and `F = f`. The restoration phase adds the elastic slacks
//! (`+n`, `-p`, both `>= 0`, cost rho) to every row and takes `F = zeta/2 |D (x - x_ref)|^2`
//! (Waechter and Biegler 2006, section 3.3). Both have the same sparsity after the slacks are
//! eliminated from the Newton system, so both use one symbolic factorization.

use super::formulation::{Formulation, RowKind};
use crate::linalg::norms::{norm_inf, norm_one};

/// Weight of the damping that keeps one-sided bounded variables from growing, kappa_d.
const DAMPING: f64 = 1e-5;

/// A variable that appears in one row only, with coefficient `sign`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slack {
    pub(crate) row: usize,
    pub(crate) sign: f64,
    pub(crate) cost: f64,
}

/// The smooth part of the objective.
#[derive(Debug, Clone)]
pub(crate) enum Objective {
    /// The user's objective.
    Original,
    /// `sqrt(mu)/2 sum (weight_i (x_i - reference_i))^2`.
    Proximity {
        reference: Vec<f64>,
        weight: Vec<f64>,
    },
}

/// Shape of a barrier problem.
#[derive(Debug, Clone)]
pub(crate) struct BarrierProblem {
    /// Structural variables.
    pub(crate) n: usize,
    /// Explicit rows.
    pub(crate) m: usize,
    pub(crate) products: Vec<(usize, usize)>,
    pub(crate) slacks: Vec<Slack>,
    /// Bounds of (x, s).
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    /// Right-hand sides of the explicit rows.
    pub(crate) b: Vec<f64>,
    pub(crate) objective: Objective,
}

/// Value of a barrier problem at a point, without its barrier terms.
#[derive(Debug, Clone, Default)]
pub(crate) struct Values {
    pub(crate) objective: f64,
    /// Row residuals, explicit rows first.
    pub(crate) residual: Vec<f64>,
    /// `|residual|_1`, the measure theta of the filter.
    pub(crate) theta: f64,
    /// The barrier terms at the point, once they were asked for.
    pub(crate) barrier: Option<f64>,
}

impl Values {
    pub(crate) fn zeros(rows: usize) -> Self {
        Self {
            residual: vec![0.0; rows],
            ..Self::default()
        }
    }

    /// `|residual|_inf`.
    pub(crate) fn infeasibility(&self) -> f64 {
        norm_inf(&self.residual)
    }
}

impl BarrierProblem {
    /// The main problem.
    pub(crate) fn main(formulation: &Formulation<'_>) -> Self {
        let n = formulation.variables.len();
        let m = formulation.rows.len();
        let mut lower = formulation.lower.clone();
        let mut upper = formulation.upper.clone();
        let mut slacks = Vec::new();
        let mut b = vec![0.0; m];
        for (row, kind) in formulation.kinds.iter().enumerate() {
            match *kind {
                RowKind::Equality(value) => b[row] = value,
                RowKind::Range(l, u) => {
                    slacks.push(Slack {
                        row,
                        sign: -1.0,
                        cost: 0.0,
                    });
                    lower.push(l);
                    upper.push(u);
                }
            }
        }
        for pair in 0..formulation.products.len() {
            slacks.push(Slack {
                row: m + pair,
                sign: 1.0,
                cost: 0.0,
            });
            lower.push(0.0);
            upper.push(f64::INFINITY);
        }
        Self {
            n,
            m,
            products: formulation.products.clone(),
            slacks,
            lower,
            upper,
            b,
            objective: Objective::Original,
        }
    }

    /// The restoration problem around the point `reference` of this one: all variables of this
    /// problem, then `n_i` (sign +1) and `p_i` (sign -1) of each explicit row, then `t` (sign -1) of
    /// each product row.
    pub(crate) fn restoration(&self, reference: &[f64], penalty: f64) -> Self {
        let mut problem = self.clone();
        let mut add = |row, sign| {
            problem.slacks.push(Slack {
                row,
                sign,
                cost: penalty,
            });
            problem.lower.push(0.0);
            problem.upper.push(f64::INFINITY);
        };
        for row in 0..self.m {
            add(row, 1.0);
            add(row, -1.0);
        }
        for pair in 0..self.products.len() {
            add(self.m + pair, -1.0);
        }
        problem.objective = Objective::Proximity {
            reference: reference[..self.n].to_vec(),
            weight: reference[..self.n]
                .iter()
                .map(|x| 1.0 / x.abs().max(1.0))
                .collect(),
        };
        problem
    }

    /// Number of variables, slacks included.
    pub(crate) fn variables(&self) -> usize {
        self.n + self.slacks.len()
    }

    /// Number of rows, product rows included.
    pub(crate) fn rows(&self) -> usize {
        self.m + self.products.len()
    }

    /// Whether slack `k` belongs to a product row.
    pub(crate) fn is_product_slack(&self, k: usize) -> bool {
        self.slacks[k].row >= self.m
    }

    /// Objective and residuals at `v`; `false` if one of them is not finite.
    pub(crate) fn evaluate(
        &self,
        formulation: &mut Formulation<'_>,
        v: &[f64],
        sigma: f64,
        mu: f64,
        out: &mut Values,
    ) -> bool {
        let x = &v[..self.n];
        let smooth = match &self.objective {
            Objective::Original => formulation.objective(x),
            Objective::Proximity { reference, weight } => {
                0.5 * mu.sqrt()
                    * x.iter()
                        .zip(reference)
                        .zip(weight)
                        .map(|((x, r), w)| (w * (x - r)).powi(2))
                        .sum::<f64>()
            }
        };
        formulation.constraint_values(x, &mut out.residual[..self.m]);
        for (r, b) in out.residual.iter_mut().zip(&self.b) {
            *r -= b;
        }
        for (r, &(i, j)) in out.residual[self.m..].iter_mut().zip(&self.products) {
            *r = x[i] * x[j] - sigma;
        }
        let mut linear = 0.0;
        for (slack, s) in self.slacks.iter().zip(&v[self.n..]) {
            out.residual[slack.row] += slack.sign * s;
            linear += slack.cost * s;
        }
        out.objective = smooth + linear;
        out.theta = norm_one(&out.residual);
        out.barrier = None;
        out.objective.is_finite() && out.theta.is_finite()
    }

    /// Gradient of the objective without barrier terms.
    pub(crate) fn gradient(
        &self,
        formulation: &mut Formulation<'_>,
        v: &[f64],
        mu: f64,
        gradient: &mut [f64],
    ) {
        let x = &v[..self.n];
        match &self.objective {
            Objective::Original => formulation.gradient(x, &mut gradient[..self.n]),
            Objective::Proximity { reference, weight } => {
                for (((g, x), r), w) in gradient.iter_mut().zip(x).zip(reference).zip(weight) {
                    *g = mu.sqrt() * w * w * (x - r);
                }
            }
        }
        for (g, slack) in gradient[self.n..].iter_mut().zip(&self.slacks) {
            *g = slack.cost;
        }
    }

    /// Weight of the user's objective in the Hessian.
    pub(crate) fn objective_weight(&self) -> f64 {
        match self.objective {
            Objective::Original => 1.0,
            Objective::Proximity { .. } => 0.0,
        }
    }

    /// Coefficient of the damping term of variable `i`, its sign included.
    pub(crate) fn damping(&self, i: usize) -> f64 {
        if i >= self.n && self.is_product_slack(i - self.n) {
            return 0.0;
        }
        match (self.lower[i].is_finite(), self.upper[i].is_finite()) {
            (true, false) => DAMPING,
            (false, true) => -DAMPING,
            _ => 0.0,
        }
    }

    /// Barrier function `objective - mu sum log(distances)` with damping; infinite outside the bounds.
    pub(crate) fn barrier_function(&self, v: &[f64], values: &mut Values, mu: f64) -> f64 {
        let terms = *values.barrier.get_or_insert_with(|| self.barrier_terms(v));
        let value = values.objective - mu * terms;
        if value.is_nan() { f64::INFINITY } else { value }
    }

    /// `sum log(distances)` less the damping terms; not a number outside the bounds.
    fn barrier_terms(&self, v: &[f64]) -> f64 {
        let mut logarithms = SumOfLogarithms::default();
        let mut damping = 0.0;
        for (i, &v) in v.iter().enumerate() {
            let (l, u) = (self.lower[i], self.upper[i]);
            let coefficient = self.damping(i);
            if l.is_finite() {
                logarithms.add(v - l);
                if coefficient > 0.0 {
                    damping += coefficient * (v - l);
                }
            }
            if u.is_finite() {
                logarithms.add(u - v);
                if coefficient < 0.0 {
                    damping -= coefficient * (u - v);
                }
            }
        }
        logarithms.value() - damping
    }
}

/// A sum of logarithms as the logarithm of a product, which costs far less; it is taken before the product leaves the range
/// of numbers. A factor adds one rounding to the product, as a logarithm does to the sum.
#[derive(Debug, Clone, Copy)]
struct SumOfLogarithms {
    sum: f64,
    product: f64,
}

impl Default for SumOfLogarithms {
    fn default() -> Self {
        Self {
            sum: 0.0,
            product: 1.0,
        }
    }
}

impl SumOfLogarithms {
    /// Factors and products in this range have a product within the range of numbers.
    const RANGE: std::ops::RangeInclusive<f64> = 1e-150..=1e150;

    #[inline(always)]
    fn add(&mut self, factor: f64) {
        let product = self.product * factor;
        if Self::RANGE.contains(&factor) && Self::RANGE.contains(&product) {
            self.product = product;
        } else {
            // not a number for factors below zero
            self.sum += self.product.ln() + factor.ln();
            self.product = 1.0;
        }
    }

    fn value(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sum_of_logarithms_agrees_with_single_ones_over_all_sizes() {
        let factors = (0..2000).map(|k| 10.0_f64.powf(300.0 * (k as f64).sin()) * 1.1);
        let mut sum = SumOfLogarithms::default();
        let mut exact = 0.0;
        let mut size = 0.0;
        for factor in factors {
            sum.add(factor);
            exact += factor.ln();
            size += factor.ln().abs();
        }
        // one rounding for each of 2000 terms
        assert!((sum.value() - exact).abs() <= 2000.0 * f64::EPSILON * size);
        sum.add(-1.0);
        assert!(sum.value().is_nan());
        let mut two = SumOfLogarithms::default();
        two.add(-2.0);
        two.add(-2.0);
        assert!(two.value().is_nan());
        let mut boundary = SumOfLogarithms::default();
        boundary.add(0.0);
        assert_eq!(boundary.value(), f64::NEG_INFINITY);
    }
}
