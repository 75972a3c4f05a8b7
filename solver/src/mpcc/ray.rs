//! Programs without bound: a ray of feasible points along which the objective falls.
//!
//! A run on such a program need not diverge: where a row or the objective outgrows all digits, it stops anywhere. From there directions are
//! tried that could lead on for ever: the way that the run has come, steepest descent, and the solution of
//!
//! ```text
//!     min grad f'd  s.t.  J d >= 0 where rows have no upper bound, <= 0 without a lower, = 0 with both,  d likewise,  |d|_inf <= 1.
//! ```
//!
//! They are followed, by functions and not by derivatives, over thirty orders of magnitude. Variables that only measure a row (`s` of
//! `s = c(x)`) take what the row says, so that the ray need not be one in them.

use super::linear_program::LinearProgram;
use super::watch::Watch;
use super::{Mpcc, Settings};
use crate::linalg::norms::norm_inf;

/// Doublings of the step that a ray is followed for: 1e30, beyond any bound that is meant as one.
const DOUBLINGS: i32 = 100;
/// Fall of the objective, relative to its size at the first point (that of its slopes where that is less), that has no bound.
const UNBOUNDED: f64 = 1e12;
/// Part of the longest entry of a direction that is none: what converges while the others diverge.
const NONE: f64 = 1e-3;
/// Distance from 0 and 1 at which an entry of a solution of the linear program is meant as that.
const ROUNDED: f64 = 1e-6;
/// Violation of a row relative to the terms it is the sum of, a hundred roundings, and least violation that counts.
const ROUNDING: f64 = 1e-14;
const VIOLATION: f64 = 1e-9;
/// A side of a pair up to this size vanishes.
const ZERO: f64 = 1e-6;

/// Whether the objective falls without bound along a ray of feasible points from near `x`, where a run from `start` has ended; in at most
/// so many seconds for the linear program.
pub(crate) fn falls_along_a_ray(
    problem: &mut dyn Mpcc,
    (x, start): (&[f64], &[f64]),
    seconds: f64,
) -> bool {
    let mut program = Rays::new(problem, x);
    let way = x.iter().zip(start).map(|(x, start)| x - start).collect();
    let descent = program.gradient.iter().map(|g| -g).collect();
    let steps = [way, descent].map(|d: Vec<f64>| program.possible(&d));
    steps.iter().any(|d| program.falls(d))
        || program
            .recession(seconds)
            .is_some_and(|d| program.falls(&program.possible(&d)) || program.falls(&d))
}

/// A problem and the point that rays begin at.
struct Rays<'a> {
    problem: &'a mut dyn Mpcc,
    from: Vec<f64>,
    gradient: Vec<f64>,
    pattern: Vec<(usize, usize)>,
    bounds: (Vec<f64>, Vec<f64>),
    rows: (Vec<f64>, Vec<f64>),
    /// Sides of pairs that stay zero.
    vanishes: Vec<bool>,
    /// Row and coefficient of variables that only measure a row.
    measures: Vec<Option<(usize, f64)>>,
}

impl<'a> Rays<'a> {
    fn new(problem: &'a mut dyn Mpcc, x: &[f64]) -> Self {
        let (n, m) = (problem.variables(), problem.constraints());
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        let mut rows = (vec![0.0; m], vec![0.0; m]);
        problem.constraint_bounds(&mut rows.0, &mut rows.1);
        let mut from = x.to_vec();
        let mut vanishes = vec![false; n];
        for &(i, j) in problem.complementarities() {
            let side = if from[i] <= from[j] { i } else { j };
            if from[side] <= ZERO {
                from[side] = 0.0;
                vanishes[side] = true;
            }
        }
        for (x, (lower, upper)) in from.iter_mut().zip(lower.iter().zip(&upper)) {
            *x = x.max(*lower).min(*upper);
        }
        let mut gradient = vec![0.0; n];
        problem.gradient(&from, &mut gradient);
        let pattern = problem.jacobian_pattern();
        let measures = measures(problem, &from, &gradient, &rows);
        Self {
            bounds: (lower, upper),
            problem,
            from,
            gradient,
            pattern,
            rows,
            vanishes,
            measures,
        }
    }

    /// What of a direction leads nowhere near a bound, nor off a side that vanishes.
    fn possible(&self, d: &[f64]) -> Vec<f64> {
        let largest = norm_inf(d);
        let mut d = d.to_vec();
        for (i, d) in d.iter_mut().enumerate() {
            let bound = if *d < 0.0 {
                self.bounds.0[i]
            } else {
                self.bounds.1[i]
            };
            if bound.is_finite() || self.vanishes[i] || d.abs() <= NONE * largest {
                *d = 0.0;
            }
        }
        d
    }

    /// The direction of steepest descent that linear rows and bounds do not end.
    fn recession(&mut self, seconds: f64) -> Option<Vec<f64>> {
        let n = self.from.len();
        let mut values = vec![0.0; self.pattern.len()];
        self.problem.jacobian_values(&self.from, &mut values);
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        if !finite(&values) || !finite(&self.gradient) {
            return None;
        }
        let end = |bound: f64, free: f64| if bound.is_finite() { 0.0 } else { free };
        let ends = |bounds: &[f64], free: f64| -> Vec<f64> {
            bounds.iter().map(|bound| end(*bound, free)).collect()
        };
        let (mut lower, mut upper) = (ends(&self.bounds.0, -1.0), ends(&self.bounds.1, 1.0));
        let mut row_lower = ends(&self.rows.0, f64::NEG_INFINITY);
        let mut row_upper = ends(&self.rows.1, f64::INFINITY);
        for i in 0..n {
            if self.vanishes[i] {
                (lower[i], upper[i]) = (0.0, 0.0);
            }
            if let Some((row, _)) = self.measures[i] {
                // the row says what becomes of it
                (row_lower[row], row_upper[row]) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
        let program = LinearProgram {
            gradient: self.gradient.clone(),
            pattern: self.pattern.clone(),
            values,
            row_lower,
            row_upper,
            lower,
            upper,
        };
        let mut settings = Settings::default();
        settings.interior_point.maximum_seconds = seconds;
        let mut observer = |_: &crate::nlp::IterationInfo| true;
        let (mut d, value) = program.solve(&mut Watch::new(&settings, &mut observer))?;
        for d in &mut d {
            let near = d.round();
            if (*d - near).abs() <= ROUNDED {
                *d = near;
            }
        }
        (value < 0.0).then_some(d)
    }

    /// Whether the objective falls without bound along `from + t d`, at feasible points only.
    fn falls(&mut self, d: &[f64]) -> bool {
        let largest = norm_inf(d);
        if !(largest > 0.0 && largest.is_finite()) {
            return false;
        }
        let (mut first, mut last) = (f64::NAN, f64::INFINITY);
        for doubling in 0..=DOUBLINGS {
            let t = if doubling == 0 {
                0.0
            } else {
                2.0_f64.powi(doubling - 1) / largest
            };
            let mut x: Vec<f64> = self.from.iter().zip(d).map(|(x, d)| x + t * d).collect();
            let is_feasible = self.follow(&mut x);
            let objective = self.problem.objective(&x);
            // not a number does not fall
            let falls = objective < last;
            if !is_feasible || !falls {
                return false;
            }
            if doubling == 0 {
                first = objective;
            }
            if objective == f64::NEG_INFINITY {
                break;
            }
            last = objective;
        }
        first - last > UNBOUNDED * first.abs().max(norm_inf(&self.gradient))
    }

    /// Gives variables that measure rows their values; whether rows, bounds and pairs hold then. What is infinite is beyond any bound but
    /// an absent one.
    fn follow(&mut self, x: &mut [f64]) -> bool {
        let mut c = vec![0.0; self.rows.0.len()];
        for (x, measure) in x.iter_mut().zip(&self.measures) {
            if measure.is_some() {
                *x = 0.0;
            }
        }
        self.problem.constraint_values(x, &mut c);
        for (x, measure) in x.iter_mut().zip(&self.measures) {
            if let Some((row, coefficient)) = measure {
                *x = (self.rows.0[*row] - c[*row]) / coefficient;
            }
        }
        let measured: Vec<bool> = self.measured_rows(c.len());
        let mut values = vec![0.0; self.pattern.len()];
        self.problem.jacobian_values(x, &mut values);
        let mut terms = vec![0.0_f64; c.len()];
        for (&(row, column), a) in self.pattern.iter().zip(&values) {
            let term = (a * x[column]).abs();
            // without a value, or beyond all, it says nothing of rounding
            terms[row] += if term.is_finite() { term } else { 0.0 };
        }
        let within = |value: f64, lower: f64, upper: f64, none: f64| {
            value >= lower - none && value <= upper + none
        };
        let mut rows = c.iter().zip(&terms).enumerate();
        let hold = rows.all(|(row, (&c, terms))| {
            let (lower, upper) = (self.rows.0[row], self.rows.1[row]);
            measured[row] || within(c, lower, upper, VIOLATION + ROUNDING * terms)
        });
        let mut variables = x.iter().zip(self.bounds.0.iter().zip(&self.bounds.1));
        let pairs = self.problem.complementarities();
        hold && variables.all(|(&x, (&lower, &upper))| within(x, lower, upper, VIOLATION))
            && pairs.iter().all(|&(i, j)| x[i].min(x[j]) <= VIOLATION)
    }

    fn measured_rows(&self, rows: usize) -> Vec<bool> {
        let mut measured = vec![false; rows];
        for (row, _) in self.measures.iter().flatten() {
            measured[*row] = true;
        }
        measured
    }
}

/// Row and coefficient of variables that are linear in one equation and stand nowhere else, one for each equation.
fn measures(
    problem: &mut dyn Mpcc,
    x: &[f64],
    gradient: &[f64],
    (lower, upper): &(Vec<f64>, Vec<f64>),
) -> Vec<Option<(usize, f64)>> {
    let pattern = problem.jacobian_pattern();
    let mut values = vec![0.0; pattern.len()];
    problem.jacobian_values(x, &mut values);
    let mut curved = vec![false; x.len()];
    for (i, j) in problem.hessian_pattern() {
        (curved[i], curved[j]) = (true, true);
    }
    let mut entries = vec![(0, 0, 0.0); x.len()];
    for (&(row, column), value) in pattern.iter().zip(&values) {
        let (count, _, _) = entries[column];
        entries[column] = (count + 1, row, *value);
    }
    let mut taken = vec![false; lower.len()];
    let words = entries.into_iter().enumerate();
    words
        .map(|(i, (count, row, coefficient))| {
            let alone = count == 1 && !curved[i] && gradient[i] == 0.0 && coefficient != 0.0;
            let measures = alone && lower[row] == upper[row] && !taken[row];
            measures.then(|| {
                taken[row] = true;
                (row, coefficient)
            })
        })
        .collect()
}
