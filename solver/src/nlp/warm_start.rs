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

    /// From the solution of another problem: `variables[i]` is the variable there that the variable `i` here is, if there
    /// is one, and `rows` says the same of the constraints; `unit` is what the objective there is multiplied by. `x` is the point of those that are new; what is not known of
    /// them otherwise is 0.
    ///
    /// # Panics
    /// If an index is not one of the solution.
    #[must_use]
    pub fn carried(
        solution: &Solution,
        unit: f64,
        mut x: Vec<f64>,
        (variables, rows): (&[Option<usize>], &[Option<usize>]),
        barrier_parameter: f64,
    ) -> Self {
        for (x, known) in x.iter_mut().zip(variables) {
            if let Some(known) = known {
                *x = solution.x[*known];
            }
        }
        let taken = |values: &[f64], known: &[Option<usize>]| -> Vec<f64> {
            let known = known.iter();
            known
                .map(|known| known.map_or(0.0, |i| unit * values[i]))
                .collect()
        };
        Self {
            x,
            multipliers: taken(&solution.multipliers, rows),
            multipliers_lower: taken(&solution.multipliers_lower, variables),
            multipliers_upper: taken(&solution.multipliers_upper, variables),
            barrier_parameter,
        }
    }
}
