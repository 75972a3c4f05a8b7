//! Variables that a linear row forces to zero.

use super::Mpcc;

/// Size up to which the room that a row leaves its terms counts as none: sums of numbers of order one.
const NO_ROOM: f64 = 1e-12;

/// The linear rows of a problem: `least <= constant + sum_k a_k x_k <= most`. A row counts as linear if its derivatives at two points
/// are the same.
pub(crate) struct LinearRows {
    /// Bounds of the variables.
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) rows: Vec<LinearRow>,
}

/// One of them.
pub(crate) struct LinearRow {
    pub(crate) constant: f64,
    pub(crate) least: f64,
    pub(crate) most: f64,
    /// Variables and their factors.
    pub(crate) terms: Vec<(usize, f64)>,
}

impl LinearRows {
    /// Reads the rows off derivatives near `x`.
    pub(crate) fn new(problem: &mut dyn Mpcc, x: &[f64]) -> Self {
        let (n, m) = (problem.variables(), problem.constraints());
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        // two points inside the bounds that differ in every variable that can move
        let inside: Vec<f64> = (0..n).map(|i| x[i].clamp(lower[i], upper[i])).collect();
        let moved: Vec<f64> = (0..n)
            .map(|i| {
                let (down, up) = (inside[i] - lower[i], upper[i] - inside[i]);
                let step = 0.1 + 0.8 / (2.0 + i as f64).sqrt();
                inside[i]
                    + if up >= down {
                        step * up.min(1.0)
                    } else {
                        -step * down.min(1.0)
                    }
            })
            .collect();
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        let mut others = vec![0.0; pattern.len()];
        problem.jacobian_values(&inside, &mut values);
        problem.jacobian_values(&moved, &mut others);
        let mut constant = vec![0.0; m];
        problem.constraint_values(&inside, &mut constant);
        let mut rows = vec![Some(Vec::new()); m];
        for ((&(row, column), &value), &other) in pattern.iter().zip(&values).zip(&others) {
            constant[row] -= value * inside[column];
            if value != other {
                rows[row] = None;
            } else if value != 0.0
                && let Some(terms) = &mut rows[row]
            {
                terms.push((column, value));
            }
        }
        let (mut least, mut most) = (vec![0.0; m], vec![0.0; m]);
        problem.constraint_bounds(&mut least, &mut most);
        let rows = rows.into_iter().enumerate();
        let rows = rows.filter_map(|(row, terms)| {
            terms.map(|terms| LinearRow {
                constant: constant[row],
                least: least[row],
                most: most[row],
                terms,
            })
        });
        Self {
            rows: rows.collect(),
            lower,
            upper,
        }
    }
}

/// Marks, besides the variables that vanish already, those that a linear row then leaves no other value than
/// zero, until there are no more: `sum_k a_k x_k <= b` with `a_k > 0`, `x_k >= 0` and `b = 0`.
///
/// With all terms of a fixed sum at zero the program would have no interior, and an interior point method no
/// multipliers to converge to. Presolvers of linear programs call such rows forcing (Andersen and Andersen,
/// Mathematical Programming 71, 1995).
pub(crate) fn mark_forced(problem: &mut dyn Mpcc, x: &[f64], vanishes: &mut [bool]) {
    let LinearRows { lower, upper, rows } = LinearRows::new(problem, x);
    loop {
        let mut changed = false;
        for row in &rows {
            let mut rest = row.constant;
            let mut scale = rest.abs();
            let (mut positive, mut negative, mut zero_below) = (false, false, true);
            for &(k, a) in &row.terms {
                if vanishes[k] {
                    continue;
                }
                if lower[k] == upper[k] {
                    rest += a * lower[k];
                    scale += (a * lower[k]).abs();
                    continue;
                }
                positive |= a > 0.0;
                negative |= a < 0.0;
                zero_below &= lower[k] == 0.0;
            }
            let room = NO_ROOM * (1.0 + scale);
            let forcing = zero_below
                && (positive && !negative && row.most - rest <= room
                    || negative && !positive && row.least - rest >= -room);
            if forcing {
                for &(k, _) in &row.terms {
                    changed |= !vanishes[k] && lower[k] < upper[k];
                    vanishes[k] |= lower[k] < upper[k];
                }
            }
        }
        if !changed {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomials::Polynomials;

    /// `x_0 = x_1 + x_2`, `x_2 + x_3 <= 0`, `x_4 x_0 = 0` with all variables nonnegative.
    fn sums() -> Polynomials {
        let below = f64::NEG_INFINITY;
        Polynomials {
            bounds: vec![(0.0, f64::INFINITY); 5],
            start: vec![1.0; 5],
            rows: vec![
                (
                    0.5,
                    0.5,
                    vec![(0.5, &[]), (1.0, &[0]), (-1.0, &[1]), (-1.0, &[2])],
                ),
                (below, 3.0, vec![(3.0, &[]), (1.0, &[2]), (1.0, &[3])]),
                (0.0, 0.0, vec![(1.0, &[4, 0])]),
            ],
            ..Polynomials::default()
        }
    }

    fn forced(vanishing: &[usize]) -> Vec<bool> {
        let mut vanishes = vec![false; 5];
        for &i in vanishing {
            vanishes[i] = true;
        }
        mark_forced(&mut sums(), &[0.3, 0.2, 0.1, 0.0, 0.7], &mut vanishes);
        vanishes
    }

    #[test]
    fn mark_forced_empty_sum_takes_its_terms_with_it() {
        // without x_0 the first row is a sum of two signs: only the second one forces
        assert_eq!(forced(&[]), [false, false, true, true, false]);
        assert_eq!(forced(&[0]), [true, true, true, true, false]);
        // x_1 and x_2 force x_0; the third row is not linear
        assert_eq!(forced(&[1]), [true, true, true, true, false]);
    }
}
