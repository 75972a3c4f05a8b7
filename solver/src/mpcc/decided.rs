//! Sides that linear rows decide before anything is solved.
//!
//! Where a linear row and the bounds keep one side of a pair above zero, the other one vanishes at every exact point. A relaxed program
//! knows that only as far as its products do: a side of 5e-9 times another of one is well below the last relaxation, so that a run may end
//! far from every exact point. First elements of a motion have such pairs, as their initial gaps are given.

use super::Mpcc;
use super::forced::{LinearRow, LinearRows, mark_forced};

/// Size from which on a side is positive at every point that counts as exact.
const POSITIVE: f64 = 2e-9;
/// How far a bound has to move to count.
const MOVED: f64 = 1e-9;
/// Rounding errors of a bound, relative to the terms of its row.
const ROUNDING: f64 = 1e-13;
/// Most passes over all rows; bounds that creep towards a limit need not get there.
const MOST_PASSES: usize = 20;

/// The variables that vanish at every exact point: partners of sides that linear rows keep above zero, and what these rows force to
/// zero with them. `None` if there are none.
pub(crate) fn decided_sides(problem: &mut dyn Mpcc) -> Option<Vec<bool>> {
    let pairs = problem.complementarities().to_vec();
    let mut x = vec![0.0; problem.variables()];
    problem.initial_point(&mut x);
    let mut known = LinearRows::new(problem, &x);
    let mut vanishes = vec![false; x.len()];
    for _ in 0..MOST_PASSES {
        let LinearRows { lower, upper, rows } = &mut known;
        let mut changed = false;
        for row in rows.iter() {
            changed |= tighten(row, lower, upper);
        }
        for &(i, j) in &pairs {
            for (side, other) in [(i, j), (j, i)] {
                if lower[side] > POSITIVE && upper[other] > 0.0 && lower[other] == 0.0 {
                    (upper[other], vanishes[other], changed) = (0.0, true, true);
                }
            }
        }
        if !changed {
            break;
        }
    }
    if !vanishes.contains(&true) {
        return None;
    }
    mark_forced(problem, &x, &mut vanishes);
    Some(vanishes)
}

/// A sum of bounds, some of which may be infinite.
#[derive(Clone, Copy, Default)]
struct Sum {
    finite: f64,
    infinite: usize,
}

impl Sum {
    fn add(&mut self, term: f64) {
        if term.is_finite() {
            self.finite += term;
        } else {
            self.infinite += 1;
        }
    }

    /// The sum without one of its terms; `None` if it is infinite.
    fn without(self, term: f64) -> Option<f64> {
        match (self.infinite, term.is_finite()) {
            (0, _) => Some(self.finite - term),
            (1, false) => Some(self.finite),
            _ => None,
        }
    }
}

/// Bounds of the variables of a row as the bounds of the others leave them; whether one of them moved by more than rounding.
fn tighten(row: &LinearRow, lower: &mut [f64], upper: &mut [f64]) -> bool {
    let (mut least, mut most) = (Sum::default(), Sum::default());
    let mut scale = row.constant.abs();
    for &(k, a) in &row.terms {
        let (one, two) = ends(a, (lower[k], upper[k]));
        least.add(one);
        most.add(two);
        scale += [one, two]
            .iter()
            .filter(|end| end.is_finite())
            .map(|end| end.abs())
            .sum::<f64>();
    }
    let room = ROUNDING * scale;
    let mut changed = false;
    for &(k, a) in &row.terms {
        let (one, two) = ends(a, (lower[k], upper[k]));
        // row.least <= constant + rest + a x <= row.most
        let below = most
            .without(two)
            .map(|rest| row.least - row.constant - rest - room);
        let above = least
            .without(one)
            .map(|rest| row.most - row.constant - rest + room);
        let (below, above) = (
            below.unwrap_or(f64::NEG_INFINITY),
            above.unwrap_or(f64::INFINITY),
        );
        let (low, high) = ends(1.0 / a, (below, above));
        // an empty interval belongs to an infeasible problem, which the runs will name
        if low > lower[k] + MOVED && low <= upper[k] {
            (lower[k], changed) = (low, true);
        }
        if high < upper[k] - MOVED && high >= lower[k] {
            (upper[k], changed) = (high, true);
        }
    }
    changed
}

/// The ends of an interval times a factor.
fn ends(factor: f64, (lower, upper): (f64, f64)) -> (f64, f64) {
    let (one, two) = (factor * lower, factor * upper);
    (one.min(two), one.max(two))
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, Status, solve};
    use super::*;
    use crate::polynomials::Polynomials;

    /// A given gap, as at the start of a motion:
    ///
    /// ```text
    ///     min (x_1 - 1)^2 + (x_4 - 1)^2   s.t.  x_2 - x_0 = gap,  x_1 + x_3 = 1,  x_5 + x_3 x_4 = 0.5
    /// ```
    ///
    /// with the pairs `(2, 1)` and `(3, 5)`.
    fn start(gap: f64) -> Polynomials {
        let mut bounds = vec![(0.0, f64::INFINITY); 6];
        bounds[4].1 = 2.0;
        Polynomials {
            bounds,
            start: vec![0.5; 6],
            objective: vec![
                (1.0, &[1, 1]),
                (-2.0, &[1]),
                (1.0, &[4, 4]),
                (-2.0, &[4]),
                (2.0, &[]),
            ],
            rows: vec![
                (gap, gap, vec![(1.0, &[2]), (-1.0, &[0])]),
                (1.0, 1.0, vec![(1.0, &[1]), (1.0, &[3])]),
                (0.5, 0.5, vec![(1.0, &[5]), (1.0, &[3, 4])]),
            ],
            pairs: vec![(2, 1), (3, 5)],
        }
    }

    #[test]
    fn decided_sides_follow_from_row_to_row() {
        // x_2 >= gap takes x_1, the second row then gives x_3 = 1, and that takes x_5; the third row is not linear
        let vanishes = decided_sides(&mut start(5e-9));
        assert_eq!(vanishes, Some(vec![false, true, false, false, false, true]));
        // a gap that an exact point may leave open decides nothing
        assert_eq!(decided_sides(&mut start(5e-10)), None);
    }

    #[test]
    fn a_gap_below_the_last_relaxation_is_not_closed() {
        // the relaxed program puts x_1 = 1 with a product of 5e-9; at an exact point x_1 = 0, x_3 = 1, x_4 = 0.5
        let solution = solve(&mut start(5e-9), &Settings::default()).expect("a valid program");
        assert_eq!(solution.status, Status::Solved);
        assert_eq!(solution.x[1], 0.0);
        assert!((solution.x[4] - 0.5).abs() < 1e-8, "{:?}", solution.x);
    }
}
