//! The smooth program that remains when some variables are fixed at zero.

use super::Mpcc;
use crate::nlp::NlpProblem;

/// A complementarity problem without its pairs, with some variables fixed at zero.
pub(crate) struct Branch<'a> {
    pub(crate) problem: &'a mut dyn Mpcc,
    pub(crate) fixed: &'a [bool],
}

impl NlpProblem for Branch<'_> {
    fn variables(&self) -> usize {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.variable_bounds(lower, upper);
        for ((l, u), fixed) in lower.iter_mut().zip(upper).zip(self.fixed) {
            if *fixed {
                *l = 0.0;
                *u = 0.0;
            }
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.problem.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.problem.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.problem.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.problem.constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.problem.jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.problem.hessian_values(x, weight, multipliers, values);
    }

    fn variable_name(&self, index: usize) -> String {
        self.problem.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        self.problem.constraint_name(index)
    }
}
