//! Nonlinear least squares within bounds: the method of Levenberg and Marquardt.
//!
//! With residuals `r` and their Jacobian `J`, each step is one of the damped linear problem, in which columns are measured by
//! their lengths (Marquardt 1963; Nielsen, *Damping parameter in Marquardt's method*, 1999, for how the damping changes):
//!
//! ```text
//! min |r + J d|^2 + lambda |S d|^2        S_j = |J_j|
//! ```
//!
//! Variables at a bound that the misfit presses against stay there for a step; others end at their bounds. Residuals that count
//! linearly beyond a bound `c` (Huber) enter with the weight `min(1, c/|r|)`, so that the gradient is that of the loss.

use super::svd::Svd;
use crate::linalg::products::dot;
use crate::yardstick;

/// Most steps from one start.
const MOST_STEPS: usize = 100;
/// Most dampings that are tried for a step.
const MOST_TRIALS: usize = 25;
/// First damping, with columns of length 1.
const DAMPING: f64 = 1e-3;
/// Distance from the optimum in standard deviations below which rounding decides, and the same with the residuals.
const FINE: f64 = 1e-9;
/// Largest distance from an optimum, in standard deviations of what is found, and in ranges.
const OPTIMAL: [f64; 2] = [1e-4, 1e-6];
/// Residuals and their derivatives.
#[derive(Debug, Clone)]
pub(super) struct Evaluation {
    /// In standard deviations of the measurements.
    pub(super) residuals: Vec<f64>,
    /// Derivatives by each variable.
    pub(super) columns: Vec<Vec<f64>>,
    /// Of each residual from where on it counts linearly; infinite for squares.
    pub(super) linear_from: Vec<f64>,
    /// Why there are derivatives of differences only, if so.
    pub(super) obstacle: Option<String>,
}

impl Evaluation {
    /// The misfit: squares, and beyond the bound `c` of a loss `2 c |r| - c^2`.
    pub(super) fn misfit(&self) -> f64 {
        let terms = self.residuals.iter().zip(&self.linear_from);
        terms
            .map(|(r, &c)| {
                if r.abs() <= c {
                    r * r
                } else {
                    c * (2.0 * r.abs() - c)
                }
            })
            .sum()
    }

    /// Residuals and derivatives with the weights that make their product the gradient of the loss.
    fn weighted(&self) -> (Vec<f64>, Vec<Vec<f64>>) {
        let weights = self.residuals.iter().zip(&self.linear_from);
        let weights: Vec<f64> = weights
            .map(|(r, &c)| {
                if r.abs() <= c {
                    1.0
                } else {
                    (c / r.abs()).sqrt()
                }
            })
            .collect();
        let times = |values: &[f64]| values.iter().zip(&weights).map(|(v, w)| v * w).collect();
        let columns = self.columns.iter().map(|column| times(column));
        (times(&self.residuals), columns.collect())
    }

    /// Derivatives of the misfit.
    pub(super) fn gradient(&self) -> Vec<f64> {
        let (residuals, columns) = self.weighted();
        let columns = columns.iter();
        columns
            .map(|column| 2.0 * dot(column, &residuals))
            .collect()
    }
}

/// What is minimized.
pub(super) trait Residuals {
    /// Residuals and derivatives at `x`; `None` where there are no residuals.
    fn evaluate(&mut self, x: &[f64]) -> Option<Evaluation>;

    /// Whether to end.
    fn is_stopped(&self) -> bool;
}

/// Where the search from one start ended.
#[derive(Debug, Clone)]
pub(super) struct Local {
    pub(super) x: Vec<f64>,
    pub(super) at: Evaluation,
    pub(super) steps: usize,
    /// Distance from the optimum of the linear problem, in standard deviations of what is found.
    pub(super) distance: f64,
    /// Whether the conditions of an optimum hold.
    pub(super) optimal: bool,
}

/// The linear problem at a point.
struct Linear {
    svd: Svd,
    /// The variables that move.
    moving: Vec<usize>,
    /// Lengths of the columns.
    lengths: Vec<f64>,
    /// Products of the left singular vectors with the residuals.
    along: Vec<f64>,
}

impl Linear {
    fn at(x: &[f64], at: &Evaluation, bounds: &[(f64, f64)]) -> Self {
        let (residuals, columns) = at.weighted();
        let presses = |j: usize| {
            let slope = dot(&columns[j], &residuals);
            let (lower, upper) = bounds[j];
            let near = yardstick::ROUNDING * (upper - lower);
            (x[j] <= lower + near && slope > 0.0) || (x[j] >= upper - near && slope < 0.0)
        };
        let moving: Vec<usize> = (0..x.len()).filter(|&j| !presses(j)).collect();
        let length = |j: &usize| dot(&columns[*j], &columns[*j]).sqrt();
        let lengths: Vec<f64> = moving.iter().map(length).collect();
        let scaled = moving.iter().zip(&lengths).map(|(&j, length)| {
            let factor = if *length > 0.0 { 1.0 / length } else { 0.0 };
            columns[j].iter().map(|value| value * factor).collect()
        });
        let svd = Svd::of(scaled.collect());
        let along = svd.u.iter().map(|u| dot(u, &residuals)).collect();
        Self {
            svd,
            moving,
            lengths,
            along,
        }
    }

    fn is_something(&self, k: usize) -> bool {
        self.svd.sigma[k] > yardstick::NOTHING * self.svd.largest()
    }

    /// Distance from the optimum, in standard deviations of what is found.
    fn distance(&self) -> f64 {
        let known = (0..self.along.len()).filter(|&k| self.is_something(k));
        known
            .map(|k| self.along[k] * self.along[k])
            .sum::<f64>()
            .sqrt()
    }

    /// The step with that damping.
    fn step(&self, damping: f64, variables: usize) -> Vec<f64> {
        let mut step = vec![0.0; variables];
        for k in (0..self.along.len()).filter(|&k| self.is_something(k)) {
            let sigma = self.svd.sigma[k];
            let factor = -self.along[k] * sigma / (sigma * sigma + damping);
            for ((&j, length), v) in self.moving.iter().zip(&self.lengths).zip(&self.svd.v[k]) {
                if *length > 0.0 {
                    step[j] += factor * v / length;
                }
            }
        }
        step
    }
}

/// Minimizes from `start` within `bounds`; `None` where there are no residuals at the start.
pub(super) fn minimize(
    problem: &mut dyn Residuals,
    start: &[f64],
    bounds: &[(f64, f64)],
) -> Option<Local> {
    let mut x = start.to_vec();
    let mut at = problem.evaluate(&x)?;
    let mut damping = DAMPING;
    let mut steps = 0;
    let mut linear = Linear::at(&x, &at, bounds);
    while steps < MOST_STEPS && !problem.is_stopped() {
        let size = dot(&at.residuals, &at.residuals).sqrt();
        if linear.distance() <= FINE * (1.0 + size) {
            break;
        }
        let Some((next, evaluation)) = better(problem, (&x, &at), &linear, (bounds, &mut damping))
        else {
            break;
        };
        (x, at) = (next, evaluation);
        linear = Linear::at(&x, &at, bounds);
        steps += 1;
    }
    // Where steps are as small as that, one without damping squares their error.
    let last = within(&x, &linear.step(0.0, x.len()), bounds);
    if linear.distance() <= FINE * (1.0 + dot(&at.residuals, &at.residuals).sqrt())
        && !problem.is_stopped()
        && let Some(evaluation) = problem.evaluate(&last)
        && evaluation.misfit() <= at.misfit()
    {
        (x, at) = (last, evaluation);
        linear = Linear::at(&x, &at, bounds);
    }
    let step = linear.step(0.0, x.len());
    let ranges = step.iter().zip(bounds);
    let farthest = ranges
        .map(|(step, (lower, upper))| step.abs() / (upper - lower).max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    let distance = linear.distance();
    Some(Local {
        optimal: distance <= OPTIMAL[0] && farthest <= OPTIMAL[1],
        x,
        at,
        steps,
        distance,
    })
}

/// A point after a step, as far as bounds let it.
fn within(x: &[f64], step: &[f64], bounds: &[(f64, f64)]) -> Vec<f64> {
    let moved = x.iter().zip(step).zip(bounds);
    moved
        .map(|((x, step), (lower, upper))| (x + step).clamp(*lower, *upper))
        .collect()
}

/// The next point that is better, with less and less of a step.
fn better(
    problem: &mut dyn Residuals,
    (x, at): (&[f64], &Evaluation),
    linear: &Linear,
    (bounds, damping): (&[(f64, f64)], &mut f64),
) -> Option<(Vec<f64>, Evaluation)> {
    let misfit = at.misfit();
    let (residuals, columns) = at.weighted();
    let mut growth = 2.0;
    for _ in 0..MOST_TRIALS {
        if problem.is_stopped() {
            return None;
        }
        let step = linear.step(*damping, x.len());
        let next = within(x, &step, bounds);
        if next == x {
            return None;
        }
        let mut predicted = residuals.clone();
        for (j, column) in columns.iter().enumerate() {
            let by = next[j] - x[j];
            for (value, slope) in predicted.iter_mut().zip(column) {
                *value += by * slope;
            }
        }
        let gain = dot(&residuals, &residuals) - dot(&predicted, &predicted);
        if gain > 0.0
            && let Some(evaluation) = problem.evaluate(&next)
        {
            let ratio = (misfit - evaluation.misfit()) / gain;
            if ratio > 0.0 {
                *damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
                return Some((next, evaluation));
            }
        }
        *damping *= growth;
        growth *= 2.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{Evaluation, Residuals, minimize};

    /// A program of residuals with hand-written derivatives.
    struct Written<F>(F, f64);

    impl<F: Fn(&[f64]) -> (Vec<f64>, Vec<Vec<f64>>)> Residuals for Written<F> {
        fn evaluate(&mut self, x: &[f64]) -> Option<Evaluation> {
            let (residuals, columns) = (self.0)(x);
            Some(Evaluation {
                linear_from: vec![self.1; residuals.len()],
                residuals,
                columns,
                obstacle: None,
            })
        }

        fn is_stopped(&self) -> bool {
            false
        }
    }

    fn rosenbrock(x: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        (
            vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
            vec![vec![-20.0 * x[0], -1.0], vec![10.0, 0.0]],
        )
    }

    #[test]
    fn curved_valley_is_followed_to_its_end_and_to_a_bound_before_it() {
        let mut problem = Written(rosenbrock, f64::INFINITY);
        let found = minimize(&mut problem, &[-1.2, 1.0], &[(-5.0, 5.0), (-5.0, 5.0)]).unwrap();
        assert!(found.optimal);
        // The optimum has no residual, so that steps converge to rounding.
        assert!((found.x[0] - 1.0).abs() < 1e-12 && (found.x[1] - 1.0).abs() < 1e-12);
        // With y <= 1/4 the best x solves 400 x^3 - 98 x - 2 = 0 near 1/2: the condition of the remaining variable.
        let found = minimize(&mut problem, &[-1.2, -1.0], &[(0.0, 5.0), (-5.0, 0.25)]).unwrap();
        let slope = 400.0 * found.x[0].powi(3) - 98.0 * found.x[0] - 2.0;
        assert!(
            found.optimal && found.x[1] == 0.25 && slope.abs() < 1e-6,
            "{found:?}"
        );
    }

    #[test]
    fn loss_of_huber_finds_the_median_of_values_far_apart() {
        let values = [0.0, 1.0, 50.0];
        let line = |x: &[f64]| {
            let residuals = values.iter().map(|value| x[0] - value).collect();
            (residuals, vec![vec![1.0; 3]])
        };
        // With the bound 1/4 the middle value counts by its square, the others by their signs, which cancel.
        let found = minimize(&mut Written(line, 0.25), &[30.0], &[(-100.0, 100.0)]).unwrap();
        // Weights change from step to step, so that steps shrink by a factor only: they end within 1e-9 of the residuals.
        assert!(
            found.optimal && (found.x[0] - 1.0).abs() < 1e-9 * 50.0,
            "{found:?}"
        );
        let found = minimize(
            &mut Written(line, f64::INFINITY),
            &[30.0],
            &[(-100.0, 100.0)],
        );
        assert!((found.unwrap().x[0] - 17.0).abs() < 1e-12);
    }
}
