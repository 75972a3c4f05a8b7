//! A problem that measures the time of its evaluations.

use cpu_time::ThreadTime;
use hangtime_solver::nlp::NlpProblem;

/// Wraps a problem; `seconds` adds up the CPU time of its evaluations.
pub(crate) struct Timed<P> {
    problem: P,
    pub(crate) seconds: f64,
}

impl<P> Timed<P> {
    pub(crate) fn new(problem: P) -> Self {
        Self {
            problem,
            seconds: 0.0,
        }
    }

    fn measure<R>(&mut self, evaluate: impl FnOnce(&mut P) -> R) -> R {
        let start = ThreadTime::now();
        let result = evaluate(&mut self.problem);
        self.seconds += start.elapsed().as_secs_f64();
        result
    }
}

impl<P: NlpProblem> NlpProblem for Timed<P> {
    fn variables(&self) -> usize {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.problem.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.measure(|p| p.objective(x))
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.measure(|p| p.gradient(x, gradient));
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.measure(|p| p.constraint_values(x, c));
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.measure(|p| p.jacobian_values(x, values));
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.measure(|p| p.hessian_values(x, weight, multipliers, values));
    }
}
