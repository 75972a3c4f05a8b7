//! The quality function: which barrier parameter makes the next step best (Nocedal, Waechter and Waltz, SIAM Journal on
//! Optimization 19, 2009, section 4).
//!
//! The Newton matrix does not depend on the barrier parameter, so that the step for `mu = sigma m`, `m` the average
//! complementarity, is `d(sigma) = d_affine + sigma d_centring` from two solves with one factorization. With the longest
//! steps `alpha_p`, `alpha_d` that this direction allows,
//!
//! ```text
//!     q(sigma) = (1 - alpha_d)^2 |dual|^2/n + (1 - alpha_p)^2 |primal|^2/m + |complementarity after the step|^2/b
//! ```
//!
//! predicts the optimality error linearly; `b` counts the bounds. A golden section finds its least value over `sigma`.

use super::barrier_problem::BarrierProblem;
use super::iterate::Iterate;

/// Range of the centring parameter.
pub(crate) const CENTRING: (f64, f64) = (1e-6, 1e2);

/// Most sections of the search.
const SECTIONS: usize = 8;

/// Relative length at which the search ends.
const RESOLUTION: f64 = 1e-2;

/// Mean squares of the optimality conditions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct MeanSquares {
    pub(crate) dual: f64,
    pub(crate) primal: f64,
    pub(crate) complementarity: f64,
}

impl MeanSquares {
    /// Sum of the three.
    pub(crate) fn sum(&self) -> f64 {
        self.dual + self.primal + self.complementarity
    }
}

/// Mean square; 0 of nothing.
pub(crate) fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for value in values {
        sum += value * value;
        count += 1;
    }
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Products `distance z` of all bounds.
pub(crate) fn products<'i>(
    problem: &'i BarrierProblem,
    iterate: &'i Iterate,
) -> impl Iterator<Item = f64> + 'i {
    (0..iterate.v.len()).flat_map(move |i| {
        let lower = problem.lower[i];
        let upper = problem.upper[i];
        let below = (iterate.v[i] - lower) * iterate.z_lower[i];
        let above = (upper - iterate.v[i]) * iterate.z_upper[i];
        let below = lower.is_finite().then_some(below);
        let above = upper.is_finite().then_some(above);
        below.into_iter().chain(above)
    })
}

/// A bound with its multiplier, and how both change along the affine and the centring direction.
#[derive(Debug, Clone, Copy)]
struct Bound {
    distance: f64,
    z: f64,
    distance_steps: (f64, f64),
    z_steps: (f64, f64),
}

/// `q(sigma)` for the directions `affine + sigma centring`.
#[derive(Debug, Clone, Default)]
pub(crate) struct QualityFunction {
    bounds: Vec<Bound>,
    squares: MeanSquares,
}

impl QualityFunction {
    /// Takes the bounds of a point and its directions; keeps the memory of the last point.
    pub(crate) fn update(
        &mut self,
        problem: &BarrierProblem,
        iterate: &Iterate,
        (affine, centring): (&Iterate, &Iterate),
        squares: MeanSquares,
    ) {
        self.squares = squares;
        self.bounds.clear();
        for i in 0..iterate.v.len() {
            let (lower, upper) = (problem.lower[i], problem.upper[i]);
            if lower.is_finite() {
                self.bounds.push(Bound {
                    distance: iterate.v[i] - lower,
                    z: iterate.z_lower[i],
                    distance_steps: (affine.v[i], centring.v[i]),
                    z_steps: (affine.z_lower[i], centring.z_lower[i]),
                });
            }
            if upper.is_finite() {
                self.bounds.push(Bound {
                    distance: upper - iterate.v[i],
                    z: iterate.z_upper[i],
                    distance_steps: (-affine.v[i], -centring.v[i]),
                    z_steps: (affine.z_upper[i], centring.z_upper[i]),
                });
            }
        }
    }

    /// The value, with steps to the fraction `tau` of the way to the boundary.
    pub(crate) fn value(&self, sigma: f64, tau: f64) -> f64 {
        let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
        let shorten = |alpha: &mut f64, value: f64, change: f64| {
            // most steps end before they need a division
            if tau * value < *alpha * -change {
                *alpha = -tau * value / change;
            }
        };
        for bound in &self.bounds {
            let (affine, centring) = bound.distance_steps;
            shorten(&mut primal, bound.distance, affine + sigma * centring);
            let (affine, centring) = bound.z_steps;
            shorten(&mut dual, bound.z, affine + sigma * centring);
        }
        let mut sum = 0.0;
        for bound in &self.bounds {
            let (affine, centring) = bound.distance_steps;
            let distance = bound.distance + primal * (affine + sigma * centring);
            let (affine, centring) = bound.z_steps;
            let z = bound.z + dual * (affine + sigma * centring);
            sum += (distance * z).powi(2);
        }
        (1.0 - dual).powi(2) * self.squares.dual
            + (1.0 - primal).powi(2) * self.squares.primal
            + sum / self.bounds.len().max(1) as f64
    }
}

/// Centring parameter of least quality function. Whether more or less centring than 1 pays decides which side of 1 is
/// searched, in logarithms.
pub(crate) fn best_centring(q: impl Fn(f64) -> f64) -> f64 {
    let (lower, upper) = CENTRING;
    let near = 1.0 - 1e-4;
    let (lower, upper) = if q(near) > q(1.0) {
        (1.0, upper)
    } else {
        (lower, near)
    };
    golden_section(|s| q(s.exp()), lower.ln(), upper.ln()).exp()
}

/// Point of least value of a function that falls and then rises, among those that a golden section visits.
fn golden_section(f: impl Fn(f64) -> f64, lower: f64, upper: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (lower, upper);
    let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut f_c, mut f_d) = (f(c), f(d));
    let ends = [(f(a), a), (f(b), b)];
    for _ in 0..SECTIONS {
        if b - a <= RESOLUTION * (upper - lower) {
            break;
        }
        if f_c <= f_d {
            b = d;
            (d, f_d) = (c, f_c);
            c = b - ratio * (b - a);
            f_c = f(c);
        } else {
            a = c;
            (c, f_c) = (d, f_d);
            d = a + ratio * (b - a);
            f_d = f(d);
        }
    }
    let mut best = if f_c <= f_d { (f_c, c) } else { (f_d, d) };
    for end in ends {
        if end.0 < best.0 {
            best = end;
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_of_one_bound_by_hand() {
        // distance 2 falls by 4 (1 - sigma), z = 3 grows by sigma
        let quality = QualityFunction {
            bounds: vec![Bound {
                distance: 2.0,
                z: 3.0,
                distance_steps: (-4.0, 4.0),
                z_steps: (0.0, 1.0),
            }],
            squares: MeanSquares {
                dual: 10.0,
                primal: 100.0,
                complementarity: 0.0,
            },
        };
        // half the step reaches the bound, so tau = 0.5 allows a quarter: (3/4)^2 of the primal error, (2 - 1) 3 remains
        assert!((quality.value(0.0, 0.5) - (100.0 * 0.75_f64.powi(2) + 9.0)).abs() < 1e-13);
        // no step towards the bound: both steps are full
        assert!((quality.value(1.0, 0.5) - (2.0 * 4.0_f64).powi(2)).abs() < 1e-13);
    }

    #[test]
    fn golden_section_parabola_finds_its_minimum_to_the_last_interval() {
        // eight sections shorten [0, 10] to 10 * 0.618^8 = 0.21
        let x = golden_section(|x| (x - 3.7).powi(2), 0.0, 10.0);
        assert!((x - 3.7).abs() < 0.22, "{x}");
    }

    #[test]
    fn golden_section_monotone_function_ends_at_the_lower_end() {
        assert_eq!(golden_section(|x| x, 2.0, 5.0), 2.0);
        assert_eq!(golden_section(|x| -x, 2.0, 5.0), 5.0);
    }

    #[test]
    fn best_centring_searches_the_side_that_falls() {
        let near = |target: f64| best_centring(|s| (s.ln() - target.ln()).powi(2));
        // the search ends on 0.618^8 = 2 % of the logarithmic interval: ln(1e6) * 0.0213 = 0.29 below, 0.1 above 1
        assert!((near(1e-3).ln() - 1e-3_f64.ln()).abs() < 0.3);
        assert!((near(10.0).ln() - 10.0_f64.ln()).abs() < 0.1);
    }

    #[test]
    fn mean_square_of_two_numbers_is_half_their_sum_of_squares() {
        assert_eq!(mean_square([3.0, 4.0].into_iter()), 12.5);
        assert_eq!(mean_square(std::iter::empty()), 0.0);
    }
}
