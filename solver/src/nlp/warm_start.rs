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

    /// A point with multipliers of rows, and of lower and upper bounds.
    pub(crate) fn of_point(
        x: Vec<f64>,
        multipliers: Vec<f64>,
        (multipliers_lower, multipliers_upper): (Vec<f64>, Vec<f64>),
        barrier_parameter: f64,
    ) -> Self {
        Self {
            x,
            multipliers,
            multipliers_lower,
            multipliers_upper,
            barrier_parameter,
        }
    }

    /// From the solution of another problem: `variables[i]` is the variable there that the variable `i` here is, if there
    /// is one, and `rows` says the same of the constraints; `unit` is what the objective there is multiplied by to be the
    /// one here. `x` is the point of those that are new; the multipliers of these are 0.
    #[must_use]
    pub fn carried(
        solution: &Solution,
        unit: f64,
        mut x: Vec<f64>,
        (variables, rows): (&[Option<usize>], &[Option<usize>]),
        barrier_parameter: f64,
    ) -> Self {
        let known = |values: &[f64], known: Option<usize>| values.get(known?).copied();
        for (x, &variable) in x.iter_mut().zip(variables) {
            *x = known(&solution.x, variable).unwrap_or(*x);
        }
        let taken = |values: &[f64], from: &[Option<usize>]| -> Vec<f64> {
            let multipliers = from.iter().map(|&from| known(values, from));
            multipliers.map(|z| unit * z.unwrap_or(0.0)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nlp::{self, Settings};
    use crate::polynomials::Polynomials;

    /// `min weight x_0` subject to `x_0 + x_1 >= 1` and `x_1 <= 1/4`.
    fn least(weight: f64) -> Polynomials {
        Polynomials {
            bounds: vec![(0.0, f64::INFINITY), (0.0, 0.25)],
            start: vec![0.0; 2],
            objective: vec![(weight, &[0])],
            rows: vec![(1.0, f64::INFINITY, vec![(1.0, &[0]), (1.0, &[1])])],
            ..Polynomials::default()
        }
    }

    #[test]
    fn what_is_known_is_carried_in_the_unit_of_the_objective_here() {
        let settings = Settings::default();
        let there = nlp::solve(&mut least(1.0), &settings).unwrap();
        let maps = ([Some(1), None, Some(0), Some(7)], [None, Some(0)]);
        let carried = WarmStart::carried(&there, 5.0, vec![3.0; 4], (&maps.0, &maps.1), 1e-4);
        assert_eq!(carried.x, [there.x[1], 3.0, there.x[0], 3.0]);
        assert_eq!(carried.multipliers, [0.0, 5.0 * there.multipliers[0]]);
        let upper = &there.multipliers_upper;
        assert_eq!(
            carried.multipliers_upper,
            [5.0 * upper[1], 0.0, 5.0 * upper[0], 0.0]
        );
        // The solution of the other problem is that of this one.
        let same = [Some(0), Some(1)];
        let start = WarmStart::carried(&there, 5.0, vec![0.0; 2], (&same, &[Some(0)]), 1e-8);
        let settings = Settings {
            bound_push: 1e-8,
            bound_fraction: 1e-8,
            ..settings
        };
        let mut five = least(5.0);
        let warm = nlp::solve_from(&mut five, &settings, Some(&start), None).unwrap();
        let cold = nlp::solve(&mut five, &Settings::default()).unwrap();
        assert!((warm.objective - 3.75).abs() < 1e-7 && (cold.objective - 3.75).abs() < 1e-7);
        assert!(warm.counts.iterations < cold.counts.iterations);
    }
}
