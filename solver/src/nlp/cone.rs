//! Multipliers that balance the gradient of the Lagrangian but belong to no row that holds the point.
//!
//! A row that has grown since the start has huge derivatives, for which a tiny multiplier makes up: one of the wrong sign, or of a row far
//! from its bounds. No absolute residual shows it. What does is the multiplier times the distance, in units of the objective; and where a
//! variable takes the place of the slack (`s` of `s = c(x)`), what the Lagrangian leaves of its derivative times its own size.

use crate::linalg::norms::norm_inf;

/// Product of a multiplier and its distance that belongs to no solution, in the scale of the program, and part of the gradient of the objective
/// (or of 1 where that is less) that such multipliers may account for: far above what the tolerance, 1e-8, leaves of rows whose
/// derivatives are 1e2 at the start, and far below what holds a point that is none.
pub(crate) const OFF_CONE: f64 = 1e-4;

/// Part of the multiplier's own term that the residual of a variable has to reach, for the multiplier to be nothing but this residual.
const NOISE: f64 = 0.5;
/// Part of the largest term of a row that makes a variable the one that measures it.
const MEASURES: f64 = 1e-3;

/// A point with its multipliers.
pub(crate) struct Cone<'a> {
    /// The variables.
    pub(crate) x: &'a [f64],
    /// The gradient of the Lagrangian.
    pub(crate) lagrangian: &'a [f64],
    /// The multipliers of the rows.
    pub(crate) y: &'a [f64],
    /// Distance of each row to the bound that a multiplier of its sign belongs to: 0 of an equation, infinite where there is none.
    pub(crate) distances: &'a [f64],
    /// Change of the objective that counts as none.
    pub(crate) none: f64,
}

/// What is wrong with some multipliers.
pub(crate) struct Astray {
    /// Rows whose multipliers say nothing.
    rows: Vec<bool>,
    /// Variables that measure such rows, in whose size these change.
    pub(crate) variables: Vec<usize>,
}

impl Cone<'_> {
    /// Rows whose multipliers have no business there; `None` where there are none.
    pub(crate) fn astray(
        &self,
        entries: impl Iterator<Item = ((usize, usize), f64)> + Clone,
    ) -> Option<Astray> {
        let pairs = self.y.iter().zip(self.distances);
        let mut rows: Vec<bool> = pairs
            .map(|(y, distance)| *y != 0.0 && y.abs() * distance > self.none)
            .collect();
        let left = |k: usize| self.lagrangian[k].abs();
        let is_left = |k: usize| left(k) * self.x[k].abs() > self.none;
        let mut variables = Vec::new();
        if (0..self.x.len()).any(is_left) {
            let mut largest = vec![0.0_f64; rows.len()];
            for ((row, k), a) in entries.clone() {
                largest[row] = largest[row].max((a * self.x[k]).abs());
            }
            for ((row, k), a) in entries {
                let measures = (a * self.x[k]).abs() >= MEASURES * largest[row];
                let term = (a * self.y[row]).abs();
                if is_left(k) && measures && term > 0.0 && left(k) >= NOISE * term {
                    rows[row] = true;
                    variables.push(k);
                }
            }
        }
        rows.contains(&true).then_some(Astray { rows, variables })
    }

    /// Largest entry of the gradient of the Lagrangian without these multipliers, apart from the variables that measure their rows.
    pub(crate) fn left_without(
        &self,
        astray: &Astray,
        entries: impl Iterator<Item = ((usize, usize), f64)>,
    ) -> f64 {
        let mut projected = self.lagrangian.to_vec();
        for ((row, column), a) in entries.filter(|((row, _), _)| astray.rows[*row]) {
            projected[column] -= a * self.y[row];
        }
        norm_inf(&projected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `min -x` where `c(x) = exp x >= 1` at `x = 30`, whose derivative is 1e13, with the multiplier that balances it.
    fn huge_row(distance: f64) -> f64 {
        let cone = Cone {
            x: &[30.0],
            lagrangian: &[0.0],
            y: &[-1e-13],
            distances: &[distance],
            none: 1e-4,
        };
        let entries = [((0, 0), 1e13)];
        cone.astray(entries.into_iter()).map_or(0.0, |astray| {
            cone.left_without(&astray, entries.into_iter())
        })
    }

    #[test]
    fn multiplier_of_a_distant_row_is_astray_and_that_of_a_near_one_is_not() {
        assert_eq!(huge_row(1e13), 1.0);
        assert_eq!(huge_row(f64::INFINITY), 1.0);
        assert_eq!(huge_row(1e7), 0.0);
        assert_eq!(huge_row(0.0), 0.0);
    }

    #[test]
    fn variable_that_measures_a_row_stands_for_its_slack() {
        // the same as the equation exp x - s = 0, of which the bound s >= 1 has no multiplier
        let of = |left: f64| {
            let cone = Cone {
                x: &[30.0, 1e13],
                lagrangian: &[0.0, left],
                y: &[1e-13],
                distances: &[0.0],
                none: 1e-4,
            };
            let entries = [((0, 0), 1e13), ((0, 1), -1.0)];
            cone.astray(entries.into_iter())
                .map(|astray| cone.left_without(&astray, entries.into_iter()))
        };
        assert!(of(-1e-13).is_some_and(|left| left >= 0.9));
        // a bound that holds s takes its share
        assert_eq!(of(1e-18), None);
    }
}
