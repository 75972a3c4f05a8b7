//! The problem class: functions and derivatives on a fixed sparsity.

/// A sparse nonlinear program, `min f(x)` s.t. `c_l <= c(x) <= c_u`, `x_l <= x <= x_u`.
///
/// Equalities have `c_l = c_u`; absent bounds are infinite. Patterns are lists of (row, column), each
/// position once, fixed for the life of the problem; values come in the same order. Evaluation methods
/// take `&mut self` so that a problem may cache what it shares between them.
pub trait NlpProblem {
    /// Number of variables `n`.
    fn variables(&self) -> usize;

    /// Number of constraints `m`.
    fn constraints(&self) -> usize;

    /// Bounds of the variables, length `n`.
    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]);

    /// Bounds of the constraints, length `m`.
    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]);

    /// Where the solver starts, length `n`.
    fn initial_point(&self, x: &mut [f64]);

    /// Objective `f(x)`.
    fn objective(&mut self, x: &[f64]) -> f64;

    /// Gradient of the objective, dense, length `n`.
    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]);

    /// Constraint values `c(x)`, length `m`.
    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]);

    /// Pattern of the constraint Jacobian, (constraint, variable).
    fn jacobian_pattern(&self) -> Vec<(usize, usize)>;

    /// Values of the constraint Jacobian.
    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]);

    /// Pattern of the Hessian of the Lagrangian, lower triangle (row >= column).
    fn hessian_pattern(&self) -> Vec<(usize, usize)>;

    /// Values of the Hessian of `weight f(x) + multipliers' c(x)`.
    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]);

    /// Name of variable `index` in diagnoses.
    fn variable_name(&self, index: usize) -> String {
        format!("x[{index}]")
    }

    /// Name of constraint `index` in diagnoses.
    fn constraint_name(&self, index: usize) -> String {
        format!("c[{index}]")
    }
}
