//! The solver does not allocate in its iterations.

#![allow(clippy::unwrap_used, reason = "test code")]

mod solver_support;

use std::alloc::System;

use hangtime_solver::nlp::{self, Settings};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// One test, so that no other thread of this binary allocates meanwhile.
#[test]
fn iterations_after_the_first_do_not_allocate() {
    // what the observer sees between its second and its last call
    let text = include_str!("data/hock_schittkowski.txt");
    let mut problem = solver_support::read_problems(text)
        .into_iter()
        .find(|problem| problem.name == "hs100")
        .unwrap();
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
    let solution = nlp::solve_from(&mut problem, &settings, None, Some(&mut observer)).unwrap();
    assert!(solution.status.is_solved());
    assert!(calls > 5);
    assert_eq!(last, 0);
}
