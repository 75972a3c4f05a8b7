//! What the caller keeps.

use serde::Serialize;

use super::{IterationInfo, NlpProblem, Status};
use crate::seconds::Seconds;

/// What a result leaves unsatisfied, each the largest of its kind, in the units of the *original*, unscaled problem.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Residuals {
    /// Violation of a constraint or bound.
    pub primal: f64,
    /// Entry of the gradient of the Lagrangian, `grad f + J' y - z_l + z_u`.
    pub dual: f64,
    /// Product `(x - l) z_l`, `(u - x) z_u` of a variable or a constraint slack; of a complementarity problem:
    /// `min(x_i, x_j)` of a pair.
    pub complementarity: f64,
}

/// Counts of the work done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counts {
    /// Iterations, those of the restoration phase included.
    pub iterations: usize,
    /// Iterations of the restoration phase.
    pub(crate) restoration_iterations: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
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
    /// The scaled optimality error, which [`Settings::tolerance`](super::Settings::tolerance) bounds.
    pub scaled_error: f64,
    /// Of a point that is called infeasible: the largest entry of the gradient of the violation of rows, rows scaled,
    /// with the multipliers of bounds and of rows that hold; near zero the point is stationary for the violation.
    pub violation_stationarity: Option<f64>,
    /// Work done.
    pub counts: Counts,
    /// CPU time by kind of work.
    pub cpu: Seconds,
    /// Wall-clock seconds of the run.
    pub seconds: f64,
    /// One entry for each iteration.
    pub history: Vec<IterationInfo>,
    /// The worst violated rows, largest first, at most ten; empty when all are within tolerance.
    pub violations: Vec<Violation>,
}

/// Multipliers in the user's units.
pub(super) struct Multipliers {
    pub(super) rows: Vec<f64>,
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
}

/// What is wrong with a point, in the user's units.
#[derive(Default)]
pub(super) struct Diagnosis {
    /// Largest violation.
    pub(super) primal: f64,
    /// Largest product of a distance and its multiplier.
    pub(super) complementarity: f64,
    /// The worst rows and variables.
    pub(super) violations: Vec<Violation>,
}

/// A value between its bounds, with their multipliers.
struct Bounded {
    value: f64,
    lower: f64,
    upper: f64,
    z_lower: f64,
    z_upper: f64,
}

impl Diagnosis {
    /// Takes in a value; returns its violation.
    fn see(&mut self, of: &Bounded) -> f64 {
        let violation = (of.lower - of.value).max(of.value - of.upper).max(0.0);
        self.primal = self.primal.max(violation);
        if of.lower < of.upper {
            for (distance, z) in [
                (of.value - of.lower, of.z_lower),
                (of.upper - of.value, of.z_upper),
            ] {
                if distance.is_finite() {
                    self.complementarity = self.complementarity.max((distance * z).abs());
                }
            }
        }
        violation
    }
}

/// Violation, complementarity and the worst rows of a point with constraint values `c`.
pub(super) fn diagnose(
    problem: &dyn NlpProblem,
    x: &[f64],
    c: &[f64],
    multipliers: &Multipliers,
    tolerance: f64,
) -> Diagnosis {
    let (n, m) = (x.len(), c.len());
    let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
    problem.variable_bounds(&mut lower, &mut upper);
    let mut diagnosis = Diagnosis::default();
    // variables, then rows
    let mut violations = Vec::with_capacity(n + m);
    for i in 0..n {
        violations.push(diagnosis.see(&Bounded {
            value: x[i],
            lower: lower[i],
            upper: upper[i],
            z_lower: multipliers.lower[i],
            z_upper: multipliers.upper[i],
        }));
    }
    lower.resize(m, 0.0);
    upper.resize(m, 0.0);
    problem.constraint_bounds(&mut lower[..m], &mut upper[..m]);
    for i in 0..m {
        let y = multipliers.rows[i];
        violations.push(diagnosis.see(&Bounded {
            value: c[i],
            lower: lower[i],
            upper: upper[i],
            z_lower: (-y).max(0.0),
            z_upper: y.max(0.0),
        }));
    }
    let mut violated: Vec<(f64, usize)> = violations.into_iter().zip(0..).collect();
    violated.retain(|(violation, _)| *violation > tolerance || !violation.is_finite());
    violated.sort_by(|a, b| b.0.total_cmp(&a.0));
    violated.truncate(10);
    let named = |(amount, index): (f64, usize)| Violation {
        name: match index.checked_sub(n) {
            Some(row) => problem.constraint_name(row),
            None => problem.variable_name(index),
        },
        amount,
    };
    diagnosis.violations = violated.into_iter().map(named).collect();
    diagnosis
}
