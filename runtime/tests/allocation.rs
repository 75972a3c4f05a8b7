//! The solver does not allocate in its iterations.

#![allow(clippy::unwrap_used, reason = "test code")]

mod solver_support;

use std::alloc::System;

use hangtime::linalg::{
    KktFactorization, MultifrontalLdl, RefinedSolver, SimplicialLdl, SymmetricPattern,
};
use hangtime::nlp::{self, LinearSolver, Settings};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// One test, so that no other thread of this binary allocates meanwhile.
#[test]
fn iterations_after_the_first_do_not_allocate() {
    // a chain of saddle point blocks: the fronts and the pivots do not change with the values
    let n = 200;
    let mut entries = Vec::new();
    for i in 0..n {
        entries.push((i, i));
        if i > 0 {
            entries.push((i, i - 1));
        }
    }
    for row in 0..n / 2 {
        entries.push((n + row, 2 * row));
        entries.push((n + row, 2 * row + 1));
    }
    let dimension = n + n / 2;
    let (pattern, map) = SymmetricPattern::new(dimension, &entries).unwrap();
    let mut values = vec![0.0; pattern.stored()];
    for (&k, &(i, j)) in map.iter().zip(&entries) {
        values[k] = if i == j { 4.0 } else { 1.0 };
    }
    let back_ends: [Box<dyn KktFactorization + Send>; 2] = [
        Box::new(SimplicialLdl::new(&pattern, n).unwrap()),
        Box::new(MultifrontalLdl::new(&pattern, n).unwrap()),
    ];
    for back_end in back_ends {
        let mut solver = RefinedSolver::new(pattern.clone(), n, back_end);
        let b = vec![1.0; dimension];
        let mut x = vec![0.0; dimension];
        solver.factor(&values, 0.0, 0.0).unwrap();
        solver.solve(&b, &mut x);
        let region = Region::new(GLOBAL);
        for k in 0..5 {
            solver.factor(&values, f64::from(k), 0.0).unwrap();
            solver.solve(&b, &mut x);
        }
        assert_eq!(region.change().allocations, 0);
    }

    // the whole method: what the observer sees between its second and its last call
    for linear_solver in [LinearSolver::Pivoting, LinearSolver::Static] {
        let text = include_str!("data/hock_schittkowski.txt");
        let mut problem = solver_support::read_problems(text)
            .into_iter()
            .find(|problem| problem.name == "hs100")
            .unwrap();
        let mut settings = Settings::default();
        settings.linear_solver = linear_solver;
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
        let solution = nlp::solve_from(&mut problem, &settings, None, Some(&mut observer)).unwrap();
        assert!(solution.status.is_solved());
        assert!(calls > 5);
        assert_eq!(last, 0, "{linear_solver:?}");
    }
}
