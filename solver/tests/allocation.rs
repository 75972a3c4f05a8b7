//! The solver does not allocate in its iterations.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::alloc::System;

use hangtime_solver::nlp::{self, DualNum, Element, ElementProblemBuilder, Settings, Target};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A term of the chained function of Rosenbrock.
struct Valley;

impl Element<2, 1> for Valley {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b]: &[D; 2]) -> [D; 1] {
        [(*a * *a - *b).powi(2) * 100.0 + (*a - 1.0).powi(2)]
    }
}

/// One test, so that no other thread of this binary allocates meanwhile.
#[test]
fn iterations_after_the_first_do_not_allocate() {
    // what the observer sees between its second and its last call
    let mut builder = ElementProblemBuilder::new();
    let x: Vec<usize> = (0..8).map(|_| builder.variable(-2.0, 2.0, -1.2)).collect();
    let row = builder.row(0.0, 3.0);
    for pair in x.windows(2) {
        builder.element(Valley, [pair[0], pair[1]], [&[(Target::Objective, 1.0)]]);
        builder.linear(Target::Row(row), 1.0, pair[0]);
    }
    let mut problem = builder.build().unwrap();
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
