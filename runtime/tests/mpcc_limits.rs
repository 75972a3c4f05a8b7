//! Limits of a whole solve, and what its observer sees.

#![allow(clippy::unwrap_used, reason = "test code")]

#[allow(dead_code, reason = "shared with other test programs")]
mod solver_support;

use hangtime::mpcc::{self, Settings, Solution, Status};
use hangtime::nlp::{self, IterationInfo};
use solver_support::{TextProblem, read_problems};

fn literature() -> Vec<TextProblem> {
    read_problems(include_str!("data/mpcc_literature.txt"))
}

/// A problem whose solve needs relaxed runs, crossovers, and linear programs for its certificate.
fn problem() -> TextProblem {
    let certified = |problem: &TextProblem| {
        let solution = mpcc::solve(&mut problem.clone(), &Settings::default()).unwrap();
        solution.crossover_iterations > 0 && solution.certificate_iterations > 0
    };
    literature().into_iter().find(certified).unwrap()
}

fn solve_within(settings: &Settings) -> Solution {
    mpcc::solve(&mut problem(), settings).unwrap()
}

#[test]
fn observer_sees_the_iterations_of_all_runs() {
    let (mut crossovers, mut certificates) = (0, 0);
    for mut problem in literature() {
        let mut lines = 0;
        let mut observer = |info: &IterationInfo| {
            lines += usize::from(info.iteration > 0);
            true
        };
        let solution =
            mpcc::solve_observed(&mut problem, &Settings::default(), &mut observer).unwrap();
        let seen = solution.iterations + solution.certificate_iterations;
        assert_eq!(lines, seen, "{}", problem.name);
        crossovers += solution.crossover_iterations;
        certificates += solution.certificate_iterations;
    }
    assert!(crossovers > 0 && certificates > 0);
}

#[test]
fn observer_interrupts_wherever_the_solve_is() {
    let free = solve_within(&Settings::default());
    let total = free.iterations + free.certificate_iterations;
    for allowed in 0..total {
        let mut lines = 0;
        let mut observer = |info: &IterationInfo| {
            lines += usize::from(info.iteration > 0);
            lines <= allowed
        };
        let solution =
            mpcc::solve_observed(&mut problem(), &Settings::default(), &mut observer).unwrap();
        assert_eq!(
            solution.status,
            Status::Failed(nlp::Status::Interrupted),
            "after {allowed} iterations"
        );
        // the line that said stop is the last one
        assert_eq!(lines, allowed + 1);
    }
}

#[test]
fn iteration_limit_bounds_the_whole_solve() {
    let free = solve_within(&Settings::default());
    let total = free.iterations + free.certificate_iterations;
    for limit in 1..=total {
        let mut settings = Settings::default();
        settings.maximum_iterations = limit;
        let solution = solve_within(&settings);
        let spent = solution.iterations + solution.certificate_iterations;
        assert!(spent <= limit, "{spent} of {limit}");
        // cut short before the certificate is complete, the point is exact, but not certified
        let expected = match solution.status {
            Status::Solved => limit == total,
            Status::Uncertified => solution.crossover_iterations > 0,
            status => status == Status::Failed(nlp::Status::IterationLimit),
        };
        assert!(expected, "{limit} of {total}: {}", solution.status);
    }
}

#[test]
fn time_limit_ends_the_solve_and_not_only_a_run() {
    let mut settings = Settings::default();
    settings.interior_point.maximum_seconds = 1e-9;
    let solution = solve_within(&settings);
    assert_eq!(solution.status, Status::Failed(nlp::Status::TimeLimit));
    // one run that stopped at its first look at the clock, none by the other rules
    assert!(solution.iterations <= 1, "{}", solution.iterations);
    let parallel = mpcc::solve_parallel(&problem(), &settings).unwrap();
    assert_eq!(parallel.status, Status::Failed(nlp::Status::TimeLimit));
}
