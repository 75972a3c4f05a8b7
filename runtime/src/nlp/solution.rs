//! What the caller keeps.

use super::{IterationInfo, NlpProblem, Status};

/// Residuals of the optimality conditions of the *original*, unscaled problem.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Residuals {
    /// Largest violation of a constraint or bound.
    pub primal: f64,
    /// Largest entry of `grad f + J' y - z_l + z_u`.
    pub dual: f64,
    /// Largest `(x - l) z_l`, `(u - x) z_u` of variables and of constraint slacks.
    pub complementarity: f64,
    /// The scaled error that the stopping test uses.
    pub scaled_error: f64,
}

/// Counts of the work done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counts {
    /// Iterations, those of the restoration phase included.
    pub iterations: usize,
    /// Iterations of the restoration phase.
    pub restoration_iterations: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// Objective evaluations.
    pub objectives: usize,
    /// Constraint evaluations.
    pub constraints: usize,
    /// Gradient and Jacobian evaluations.
    pub jacobians: usize,
    /// Hessian evaluations.
    pub hessians: usize,
}

/// A row or bound that a point violates.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// Name of the constraint, variable or pair, from the problem.
    pub name: String,
    /// By how much, in the unit of the row.
    pub amount: f64,
}

/// Result of a run: the last, or best, point and everything needed to judge it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// Why the run ended.
    pub status: Status,
    /// The point, length `n`.
    pub x: Vec<f64>,
    /// Objective at the point.
    pub objective: f64,
    /// Multipliers `y` of the constraints, of the Lagrangian `f + y' c`, length `m`.
    pub multipliers: Vec<f64>,
    /// Multipliers `z_l >= 0` of the lower bounds of the variables, length `n`.
    pub multipliers_lower: Vec<f64>,
    /// Multipliers `z_u >= 0` of the upper bounds of the variables, length `n`.
    pub multipliers_upper: Vec<f64>,
    /// Barrier parameter of the last iteration, for a warm start.
    pub barrier_parameter: f64,
    /// Residuals of the original problem.
    pub residuals: Residuals,
    /// Work done.
    pub counts: Counts,
    /// CPU seconds of assembling, factorizing and solving the Newton systems.
    pub linear_seconds: f64,
    /// Wall-clock seconds of the run.
    pub seconds: f64,
    /// One entry for each iteration.
    pub history: Vec<IterationInfo>,
    /// The worst violated rows, largest first, at most ten; empty when all are within tolerance.
    pub violations: Vec<Violation>,
}

/// Violation, complementarity and the worst rows of a point, in the user's units.
pub(crate) fn diagnose(
    problem: &dyn NlpProblem,
    x: &[f64],
    c: &[f64],
    (y, z_lower, z_upper): (&[f64], &[f64], &[f64]),
    tolerance: f64,
) -> (f64, f64, Vec<Violation>) {
    let (n, m) = (x.len(), c.len());
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let mut complementarity: f64 = 0.0;
    let mut violated = Vec::new();
    let mut primal: f64 = 0.0;
    let mut visit = |value: f64, lower: f64, upper: f64, z_l: f64, z_u: f64, index: usize, row| {
        let violation = (lower - value).max(value - upper).max(0.0);
        primal = primal.max(violation);
        if violation > tolerance || !violation.is_finite() {
            violated.push((violation, index, row));
        }
        if lower < upper {
            for (distance, z) in [(value - lower, z_l), (upper - value, z_u)] {
                if distance.is_finite() {
                    complementarity = complementarity.max((distance * z).abs());
                }
            }
        }
    };
    for i in 0..n {
        visit(x[i], lower[i], upper[i], z_lower[i], z_upper[i], i, false);
    }
    lower.resize(m, 0.0);
    upper.resize(m, 0.0);
    problem.constraint_bounds(&mut lower[..m], &mut upper[..m]);
    for i in 0..m {
        let (z_l, z_u) = ((-y[i]).max(0.0), y[i].max(0.0));
        visit(c[i], lower[i], upper[i], z_l, z_u, i, true);
    }
    violated.sort_by(|a, b| b.0.total_cmp(&a.0));
    violated.truncate(10);
    let violations = violated
        .into_iter()
        .map(|(amount, index, row)| Violation {
            name: if row {
                problem.constraint_name(index)
            } else {
                problem.variable_name(index)
            },
            amount,
        })
        .collect();
    (primal, complementarity, violations)
}
