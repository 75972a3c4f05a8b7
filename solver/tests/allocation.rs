//! The solver does not allocate in its iterations.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::alloc::System;

use hangtime_solver::nlp::{self, NlpProblem, Settings};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const VARIABLES: usize = 8;

/// The chained function of Rosenbrock, `sum 100 (a^2 - b)^2 + (a - 1)^2` over neighbours `a`, `b`, with a bound on the sum of all `a`.
struct Valleys;

impl NlpProblem for Valleys {
    fn variables(&self) -> usize {
        VARIABLES
    }

    fn constraints(&self) -> usize {
        1
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(-2.0);
        upper.fill(2.0);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(0.0);
        upper.fill(3.0);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.fill(-1.2);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let terms = x.windows(2);
        let terms = terms.map(|p| 100.0 * (p[0] * p[0] - p[1]).powi(2) + (p[0] - 1.0).powi(2));
        terms.sum()
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (i, p) in x.windows(2).enumerate() {
            let valley = p[0] * p[0] - p[1];
            gradient[i] += 400.0 * p[0] * valley + 2.0 * (p[0] - 1.0);
            gradient[i + 1] -= 200.0 * valley;
        }
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        c[0] = x[..VARIABLES - 1].iter().sum();
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        (0..VARIABLES - 1).map(|i| (0, i)).collect()
    }

    fn jacobian_values(&mut self, _: &[f64], values: &mut [f64]) {
        values.fill(1.0);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        let diagonal = (0..VARIABLES).map(|i| (i, i));
        diagonal.chain((1..VARIABLES).map(|i| (i, i - 1))).collect()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        for (i, p) in x.windows(2).enumerate() {
            values[i] += weight * (1200.0 * p[0] * p[0] - 400.0 * p[1] + 2.0);
            values[i + 1] += weight * 200.0;
            values[VARIABLES + i] -= weight * 400.0 * p[0];
        }
    }
}

/// One test, so that no other thread of this binary allocates meanwhile.
#[test]
fn iterations_after_the_first_do_not_allocate() {
    // what the observer sees between its second and its last call
    let mut calls = 0;
    let mut last = 0;
    let mut region = Region::new(GLOBAL);
    let mut observer = |_: &nlp::IterationInfo| {
        calls += 1;
        if calls == 2 {
            region.reset();
        }
        last = region.change().allocations;
        true
    };
    let settings = Settings::default();
    let solution = nlp::solve_from(&mut Valleys, &settings, None, Some(&mut observer)).unwrap();
    assert!(solution.status.is_solved());
    assert!(calls > 5);
    assert_eq!(last, 0);
}
