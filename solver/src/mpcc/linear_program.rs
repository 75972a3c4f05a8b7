//! Linear programs for the certificate, solved by the interior point method.

use super::watch::{Purpose, Watch};
use crate::nlp::{self, NlpProblem};

/// `min g'd` subject to `r_l <= J d <= r_u`, `d_l <= d <= d_u`; `d = 0` is feasible.
#[derive(Debug, Clone)]
pub(crate) struct LinearProgram {
    pub(crate) gradient: Vec<f64>,
    pub(crate) pattern: Vec<(usize, usize)>,
    pub(crate) values: Vec<f64>,
    pub(crate) row_lower: Vec<f64>,
    pub(crate) row_upper: Vec<f64>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
}

impl LinearProgram {
    /// Solution and value; `None` if the method fails, which a degenerate program may cause.
    pub(crate) fn solve(&mut self, watch: &mut Watch<'_>) -> Option<(Vec<f64>, f64)> {
        let settings = nlp::Settings {
            maximum_iterations: 100,
            permanent_dual_shift: 1e-8,
            tolerance: 1e-9,
            acceptable_tolerance: 1e-8,
            acceptable_iterations: 3,
            ..nlp::Settings::default()
        };
        let solution = watch
            .run(
                Purpose::Certificate,
                &settings,
                &mut |_| true,
                |settings, observer| nlp::solve_from(self, settings, None, Some(observer)),
            )
            .ok()?;
        let usable = matches!(
            solution.status,
            nlp::Status::Solved | nlp::Status::Acceptable
        );
        usable.then_some((solution.x, solution.objective))
    }
}

impl NlpProblem for LinearProgram {
    fn variables(&self) -> usize {
        self.gradient.len()
    }

    fn constraints(&self) -> usize {
        self.row_lower.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.copy_from_slice(&self.lower);
        upper.copy_from_slice(&self.upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.copy_from_slice(&self.row_lower);
        upper.copy_from_slice(&self.row_upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.fill(0.0);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.gradient.iter().zip(x).map(|(g, d)| g * d).sum()
    }

    fn gradient(&mut self, _: &[f64], gradient: &mut [f64]) {
        gradient.copy_from_slice(&self.gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        c.fill(0.0);
        for (&(row, column), value) in self.pattern.iter().zip(&self.values) {
            c[row] += value * x[column];
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.pattern.clone()
    }

    fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&self.values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }

    fn hessian_values(&mut self, _: &[f64], _: f64, _: &[f64], _: &mut [f64]) {}
}
