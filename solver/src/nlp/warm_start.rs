//! What a run may start from.

use super::Solution;

/// A point with multipliers to start from, for instance those of an earlier [`Solution`].
#[derive(Debug, Clone, PartialEq)]
pub struct WarmStart {
    /// The point, length `n`.
    pub(crate) x: Vec<f64>,
    /// Multipliers of the constraints, length `m`.
    pub(crate) multipliers: Vec<f64>,
    /// Multipliers of the lower bounds, length `n`.
    pub(crate) multipliers_lower: Vec<f64>,
    /// Multipliers of the upper bounds, length `n`.
    pub(crate) multipliers_upper: Vec<f64>,
    /// First barrier parameter; the nearer the point, the smaller.
    pub(crate) barrier_parameter: f64,
}

impl WarmStart {
    /// Everything from a solution, with its barrier parameter.
    pub fn from_solution(solution: &Solution) -> Self {
        Self {
            x: solution.x.clone(),
            multipliers: solution.multipliers.clone(),
            multipliers_lower: solution.multipliers_lower.clone(),
            multipliers_upper: solution.multipliers_upper.clone(),
            barrier_parameter: solution.barrier_parameter,
        }
    }
}
