//! The elastic form of a complementarity problem: one slack for all products.

use super::Mpcc;
use crate::nlp::{NlpProblem, Pattern};

/// The smooth program
///
/// ```text
///     min f(x) + t   s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u,  x_i x_j <= sigma t for all pairs,  t >= 0
/// ```
///
/// which is the l-infinity elastic mode `f + s / sigma`, `x_i x_j <= s`, with the slack `s = sigma t` in a unit
/// that keeps the gradient of the objective of order one (Anitescu, SIAM Journal on Optimization 15, 2005). It is
/// feasible wherever the other constraints are; `s` vanishes from some `sigma` on if the complementarity
/// problem has multipliers there.
pub(crate) struct Elastic<'a> {
    pub(crate) problem: &'a mut dyn Mpcc,
    pub(crate) sigma: f64,
    pairs: Vec<(usize, usize)>,
    /// Number of entries of the Jacobian of the problem itself.
    jacobian: usize,
    hessian: Pattern,
    /// Number of entries of the Hessian of the problem itself.
    own_hessian: usize,
}

impl<'a> Elastic<'a> {
    pub(crate) fn new(problem: &'a mut dyn Mpcc) -> Self {
        let pairs = problem.complementarities().to_vec();
        let mut hessian = problem.hessian_pattern();
        let own_hessian = hessian.len();
        hessian.extend(pairs.iter().map(|&(i, j)| (i.max(j), i.min(j))));
        Self {
            sigma: 1.0,
            jacobian: problem.jacobian_pattern().len(),
            hessian: Pattern::new(&hessian),
            own_hessian,
            pairs,
            problem,
        }
    }
}

impl NlpProblem for Elastic<'_> {
    fn variables(&self) -> usize {
        self.problem.variables() + 1
    }

    fn constraints(&self) -> usize {
        self.problem.constraints() + self.pairs.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let n = self.problem.variables();
        self.problem
            .variable_bounds(&mut lower[..n], &mut upper[..n]);
        (lower[n], upper[n]) = (0.0, f64::INFINITY);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let m = self.problem.constraints();
        self.problem
            .constraint_bounds(&mut lower[..m], &mut upper[..m]);
        lower[m..].fill(f64::NEG_INFINITY);
        upper[m..].fill(0.0);
    }

    fn initial_point(&self, x: &mut [f64]) {
        let n = self.problem.variables();
        self.problem.initial_point(&mut x[..n]);
        x[n] = 1.0;
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let n = self.problem.variables();
        self.problem.objective(&x[..n]) + x[n]
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let n = self.problem.variables();
        self.problem.gradient(&x[..n], &mut gradient[..n]);
        gradient[n] = 1.0;
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        self.problem.constraint_values(&x[..n], &mut c[..m]);
        for (c, &(i, j)) in c[m..].iter_mut().zip(&self.pairs) {
            *c = x[i] * x[j] - self.sigma * x[n];
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        let mut pattern = self.problem.jacobian_pattern();
        for (k, &(i, j)) in self.pairs.iter().enumerate() {
            pattern.extend([(m + k, i), (m + k, j), (m + k, n)]);
        }
        pattern
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let n = self.problem.variables();
        let (own, products) = values.split_at_mut(self.jacobian);
        self.problem.jacobian_values(&x[..n], own);
        for (values, &(i, j)) in products.chunks_exact_mut(3).zip(&self.pairs) {
            values.copy_from_slice(&[x[j], x[i], -self.sigma]);
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.entries.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let (n, m) = (self.problem.variables(), self.problem.constraints());
        // the problem's own entries come first, each position once
        let (own, added) = values.split_at_mut(self.own_hessian);
        self.problem
            .hessian_values(&x[..n], weight, &multipliers[..m], own);
        added.fill(0.0);
        let places = &self.hessian.places[self.own_hessian..];
        for (&place, multiplier) in places.iter().zip(&multipliers[m..]) {
            values[place] += multiplier;
        }
    }

    fn variable_name(&self, index: usize) -> String {
        if index == self.problem.variables() {
            return "elastic slack".into();
        }
        self.problem.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        match index.checked_sub(self.problem.constraints()) {
            Some(pair) => self.problem.complementarity_name(pair),
            None => self.problem.constraint_name(index),
        }
    }
}
