//! What a changed problem has in common with the problem that it holds.

/// Methods of [`NlpProblem`](crate::nlp::NlpProblem) and [`Mpcc`](super::Mpcc) that are those of the field `problem`, by their names.
macro_rules! forward {
    ($($method:ident),+ $(,)?) => { $(forward!(@$method);)+ };
    (@variables) => {
        fn variables(&self) -> usize {
            self.problem.variables()
        }
    };
    (@constraints) => {
        fn constraints(&self) -> usize {
            self.problem.constraints()
        }
    };
    (@variable_bounds) => {
        fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            self.problem.variable_bounds(lower, upper);
        }
    };
    (@constraint_bounds) => {
        fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
            self.problem.constraint_bounds(lower, upper);
        }
    };
    (@initial_point) => {
        fn initial_point(&self, x: &mut [f64]) {
            self.problem.initial_point(x);
        }
    };
    (@objective) => {
        fn objective(&mut self, x: &[f64]) -> f64 {
            self.problem.objective(x)
        }
    };
    (@gradient) => {
        fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
            self.problem.gradient(x, gradient);
        }
    };
    (@constraint_values) => {
        fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
            self.problem.constraint_values(x, c);
        }
    };
    (@jacobian_pattern) => {
        fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
            self.problem.jacobian_pattern()
        }
    };
    (@jacobian_values) => {
        fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
            self.problem.jacobian_values(x, values);
        }
    };
    (@hessian_pattern) => {
        fn hessian_pattern(&self) -> Vec<(usize, usize)> {
            self.problem.hessian_pattern()
        }
    };
    (@hessian_values) => {
        fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
            self.problem.hessian_values(x, weight, multipliers, values);
        }
    };
    (@variable_name) => {
        fn variable_name(&self, index: usize) -> String {
            self.problem.variable_name(index)
        }
    };
    (@constraint_name) => {
        fn constraint_name(&self, index: usize) -> String {
            self.problem.constraint_name(index)
        }
    };
    (@complementarities) => {
        fn complementarities(&self) -> &[(usize, usize)] {
            self.problem.complementarities()
        }
    };
    (@complementarity_name) => {
        fn complementarity_name(&self, index: usize) -> String {
            self.problem.complementarity_name(index)
        }
    };
    (@vanishing_sides) => {
        fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
            self.problem.vanishing_sides(x, vanishes)
        }
    };
    (@neighbour) => {
        fn neighbour(&self, index: usize, x: &mut [f64], vanishes: &mut [bool]) -> bool {
            self.problem.neighbour(index, x, vanishes)
        }
    };
}

pub(super) use forward;
