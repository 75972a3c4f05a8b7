//! What the caller keeps.

use super::{Certificate, RelaxationRule};
use crate::nlp::{self, Residuals, Violation};
use crate::seconds::Seconds;

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// Exact complementarity, optimality conditions within tolerance, certified S- or B-stationary.
    Solved,
    /// The relaxed problem is solved, but no crossover led to an exact point, or none was wanted:
    /// complementarity holds to the final relaxation.
    Relaxed,
    /// Exact complementarity and optimality within the chosen sides of the pairs, but B-stationarity could
    /// not be decided within the limit of linear programs.
    Uncertified,
    /// A feasible point with a known descent direction that the repairs could not follow.
    NotStationary,
    /// Every rule ended at a stationary point of the constraint violation.
    Infeasible,
    /// No rule reached a solution; the reason is that of the best run.
    Failed(nlp::Status),
}

impl Status {
    /// Whether the point is certified.
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Solved => f.write_str("solved and certified"),
            Self::Relaxed => f.write_str("solved in the relaxed sense only"),
            Self::Uncertified => f.write_str("solved, b-stationarity not decided"),
            Self::NotStationary => f.write_str("feasible, but a descent direction exists"),
            Self::Infeasible => f.write_str("converged to a point of local infeasibility"),
            Self::Failed(status) => write!(f, "failed: {status}"),
        }
    }
}

/// Result of a run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// Why the run ended.
    pub status: Status,
    /// The point, length `n`.
    pub x: Vec<f64>,
    /// Objective at the point.
    pub objective: f64,
    /// Multipliers of the constraints, length `m`.
    pub multipliers: Vec<f64>,
    /// Multipliers of the lower bounds, length `n`; for paired variables the multipliers `nu` of the
    /// complementarity problem, of either sign.
    pub multipliers_lower: Vec<f64>,
    /// Multipliers of the upper bounds, length `n`.
    pub multipliers_upper: Vec<f64>,
    /// Residuals of the original problem.
    pub residuals: Residuals,
    /// Of a point that is called infeasible: the largest entry of the gradient of the violation of rows and relaxed pairs, rows scaled,
    /// with the multipliers of bounds and of rows that hold; near zero the point is stationary for the violation.
    pub violation_stationarity: Option<f64>,
    /// Kind of the point; absent when there was no crossover.
    pub certificate: Option<Certificate>,
    /// The rule that led to the point.
    pub rule: RelaxationRule,
    /// `sigma` at the end of the relaxed run.
    pub relaxation_parameter: f64,
    /// Interior point iterations of all runs by all rules, crossovers included.
    pub iterations: usize,
    /// Iterations of the crossovers alone.
    pub crossover_iterations: usize,
    /// Iterations of the linear programs of certificates, which `iterations` does not hold.
    pub certificate_iterations: usize,
    /// Whether the run went on after a first crossover that failed or ended far off.
    pub(crate) resumed: bool,
    /// Factorizations of all runs, certificates included.
    pub factorizations: usize,
    /// CPU time of all runs by kind of work.
    pub cpu: Seconds,
    /// Log of the relaxed run that led to the point.
    pub history: Vec<nlp::IterationInfo>,
    /// Worst violated rows, bounds and pairs, at most ten; empty when all are within tolerance.
    pub violations: Vec<Violation>,
}

impl Solution {
    /// The solution of the same problem where one of the objective is `unit`.
    pub(super) fn times(mut self, unit: f64) -> Self {
        self.objective *= unit;
        self.residuals.dual *= unit;
        let multipliers = [
            &mut self.multipliers,
            &mut self.multipliers_lower,
            &mut self.multipliers_upper,
        ];
        multipliers.into_iter().flatten().for_each(|z| *z *= unit);
        self.history
            .iter_mut()
            .for_each(|info| *info = info.times(unit));
        self
    }

    /// The point with its multipliers, to start from with a barrier parameter.
    pub(crate) fn warm_start(&self, barrier_parameter: f64) -> nlp::WarmStart {
        nlp::WarmStart::of_point(
            self.x.clone(),
            self.multipliers.clone(),
            (
                self.multipliers_lower.clone(),
                self.multipliers_upper.clone(),
            ),
            barrier_parameter,
        )
    }
}
