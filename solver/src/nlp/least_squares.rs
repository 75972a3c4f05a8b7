//! The program of the least squares of a violation, `min sum r_i^2 / 2` s.t. `c_l <= c(x) + r / w <= c_u`, `x_l <= x <= x_u`, with
//! the factors `w` that bring the gradients of the rows at the start to a size of at most 100.

use super::NlpProblem;
use super::program::scaling::row_scaling;

/// A problem whose rows may be violated.
pub(super) struct LeastSquares<'a> {
    problem: &'a mut dyn NlpProblem,
    start: Vec<f64>,
    weights: Vec<f64>,
    jacobian_entries: usize,
    hessian_entries: usize,
}

impl<'a> LeastSquares<'a> {
    /// The least squares of the violation of `problem`, from the point `x`.
    pub(super) fn new(problem: &'a mut dyn NlpProblem, x: &[f64]) -> Self {
        let m = problem.constraints();
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.jacobian_values(x, &mut values);
        let mut largest = vec![0.0_f64; m];
        for (&(row, _), a) in pattern.iter().zip(&values) {
            largest[row] = largest[row].max(a.abs());
        }
        let weights: Vec<f64> = largest.into_iter().map(row_scaling).collect();
        let start = [x, &violation(problem, x, &weights)].concat();
        Self {
            weights,
            start,
            jacobian_entries: pattern.len(),
            hessian_entries: problem.hessian_pattern().len(),
            problem,
        }
    }

    fn n(&self) -> usize {
        self.start.len() - self.weights.len()
    }
}

/// What each row needs to hold, times its weight.
pub(crate) fn violation(problem: &mut dyn NlpProblem, x: &[f64], weights: &[f64]) -> Vec<f64> {
    let m = weights.len();
    let (mut c, mut lower, mut upper) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
    problem.constraint_values(x, &mut c);
    problem.constraint_bounds(&mut lower, &mut upper);
    let rows = c.iter().zip(lower.iter().zip(&upper)).zip(weights);
    rows.map(|((c, (lower, upper)), w)| w * (c.max(*lower).min(*upper) - c))
        .collect()
}

impl NlpProblem for LeastSquares<'_> {
    fn variables(&self) -> usize {
        self.start.len()
    }

    fn constraints(&self) -> usize {
        self.weights.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let n = self.n();
        self.problem
            .variable_bounds(&mut lower[..n], &mut upper[..n]);
        lower[n..].fill(f64::NEG_INFINITY);
        upper[n..].fill(f64::INFINITY);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        0.5 * x[self.n()..].iter().map(|r| r * r).sum::<f64>()
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let n = self.n();
        gradient[..n].fill(0.0);
        gradient[n..].copy_from_slice(&x[n..]);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let n = self.n();
        self.problem.constraint_values(&x[..n], c);
        for (c, (r, w)) in c.iter_mut().zip(x[n..].iter().zip(&self.weights)) {
            *c += r / w;
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        let n = self.n();
        let mut pattern = self.problem.jacobian_pattern();
        pattern.extend((0..self.weights.len()).map(|row| (row, n + row)));
        pattern
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let (own, slacks) = values.split_at_mut(self.jacobian_entries);
        self.problem.jacobian_values(&x[..self.n()], own);
        for (value, w) in slacks.iter_mut().zip(&self.weights) {
            *value = 1.0 / w;
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        let mut pattern = self.problem.hessian_pattern();
        pattern.extend((self.n()..self.start.len()).map(|i| (i, i)));
        pattern
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let (own, squares) = values.split_at_mut(self.hessian_entries);
        self.problem
            .hessian_values(&x[..self.n()], 0.0, multipliers, own);
        squares.fill(weight);
    }

    fn variable_name(&self, index: usize) -> String {
        match index.checked_sub(self.n()) {
            None => self.problem.variable_name(index),
            Some(row) => format!("violation of {}", self.problem.constraint_name(row)),
        }
    }

    fn constraint_name(&self, index: usize) -> String {
        self.problem.constraint_name(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nlp::{self, Settings, Status};
    use crate::polynomials::Polynomials;

    /// `x = 1`, `x = 3`, `x^2 <= 16`, from 5.
    fn rows() -> Polynomials {
        Polynomials {
            bounds: vec![(-9.0, 9.0)],
            start: vec![5.0],
            objective: vec![(1.0, &[0])],
            rows: vec![
                (1.0, 1.0, vec![(1.0, &[0])]),
                (3.0, 3.0, vec![(1.0, &[0])]),
                (f64::NEG_INFINITY, 16.0, vec![(1.0, &[0, 0])]),
            ],
            ..Polynomials::default()
        }
    }

    #[test]
    fn least_squares_of_two_values_are_at_their_mean() {
        let mut rows = rows();
        let mut squares = LeastSquares::new(&mut rows, &[5.0]);
        let solution = nlp::solve(&mut squares, &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::Solved);
        // r = (-1, 1, 0) at x = 2, where the inequality holds
        for (value, exact) in solution.x.iter().zip([2.0, -1.0, 1.0, 0.0]) {
            assert!((value - exact).abs() < 1e-6, "{:?}", solution.x);
        }
        assert!((solution.objective - 1.0).abs() < 1e-6);
    }

    #[test]
    fn derivatives_are_those_of_the_functions() {
        let mut rows = rows();
        let mut squares = LeastSquares::new(&mut rows, &[5.0]);
        let entries = nlp::check_derivatives(&mut squares, Some(&[1.5, 0.5, -0.25, 2.0])).unwrap();
        // differences are right to the root of the rounding unit
        assert!(
            entries.iter().all(|entry| entry.error < 1e-5),
            "{entries:?}"
        );
    }
}
