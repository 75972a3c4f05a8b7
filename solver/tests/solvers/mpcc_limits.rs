//! Limits of a whole solve, and what its observer sees.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::mpcc_problems::hysteresis;
use crate::solver_support::{TextProblem, read_problems};
use hangtime_solver::mpcc::{self, Settings, Solution, Status};
use hangtime_solver::nlp::{self, IterationInfo};
use std::sync::LazyLock;

fn literature() -> Vec<TextProblem> {
    read_problems(include_str!("../data/mpcc_literature.txt"))
}

/// A problem whose solve needs relaxed runs, crossovers, and linear programs for its certificate.
static PROBLEM: LazyLock<TextProblem> = LazyLock::new(|| {
    let certified = |problem: &TextProblem| {
        let solution = mpcc::solve(&mut problem.clone(), &Settings::default()).unwrap();
        solution.crossover_iterations > 0 && solution.certificate_iterations > 0
    };
    literature().into_iter().find(certified).unwrap()
});

fn solve_within(settings: &Settings) -> Solution {
    mpcc::solve(&mut PROBLEM.clone(), settings).unwrap()
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
            mpcc::solve_observed(&mut PROBLEM.clone(), &Settings::default(), &mut observer)
                .unwrap();
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
fn second_opinion_cut_short_leaves_the_certified_point() {
    let spent = |solution: &Solution| solution.iterations + solution.certificate_iterations;
    let problem = hysteresis(20);
    let solve = |settings: &Settings| mpcc::solve(&mut problem.clone(), settings).unwrap();
    let mut first = Settings::default();
    first.second_opinion = false;
    let first = solve(&first);
    let total = spent(&solve(&Settings::default()));
    assert!(total > spent(&first));
    for limit in spent(&first)..=total {
        let mut settings = Settings::default();
        settings.maximum_iterations = limit;
        let solution = solve(&settings);
        assert!(spent(&solution) <= limit);
        assert_eq!(solution.status, Status::Solved, "{limit} of {total}");
        assert!(solution.objective <= first.objective);
    }
}

#[test]
fn infeasible_problem_cut_short_has_failed_and_is_not_called_infeasible() {
    let text = "problem infeasible 2\nstart 1 1\nbounds 1 0 inf\nbounds 2 0 inf\nminimize x1 + x2\n\
                row 1 inf x1\nrow 1 inf x2\npair 1 2";
    // where rows do not hold at the start, all rules are asked from another one first
    for text in [text, &text.replace("start 1 1", "start 3 0.5")] {
        let solve = |settings: &Settings| {
            mpcc::solve(&mut read_problems(text)[0], settings).expect("a valid program")
        };
        let whole = solve(&Settings::default());
        assert_eq!(whole.status, Status::Infeasible);
        assert!(whole.violations.iter().any(|v| v.name.contains("_|_")));
        for limit in 1..whole.iterations {
            let mut settings = Settings::default();
            settings.maximum_iterations = limit;
            let status = solve(&settings).status;
            let failed = status == Status::Failed(nlp::Status::IterationLimit);
            assert!(failed, "{limit} of {}: {status:?}", whole.iterations);
        }
    }
    let mut feasible = read_problems(&text.replace("row 1 inf x2", "row 0 inf x2")).remove(0);
    let solution = mpcc::solve(&mut feasible, &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Solved);
}

#[test]
fn time_limit_ends_the_solve_and_not_only_a_run() {
    let mut settings = Settings::default();
    settings.interior_point.maximum_seconds = 1e-9;
    let solution = solve_within(&settings);
    assert_eq!(solution.status, Status::Failed(nlp::Status::TimeLimit));
    // one run that stopped at its first look at the clock, none by the other rules
    assert!(solution.iterations <= 1, "{}", solution.iterations);
}

#[test]
fn rules_cut_short_leave_a_second_round_that_certifies() {
    // each rule is stopped after three iterations, far from its end; patient crossovers start from there
    let text = "problem projection 2\nstart 5 4\nbounds 1 0 inf\nbounds 2 0 inf\n\
                minimize (x1 + 1)^2 + (x2 - 1)^2\npair 1 2";
    let mut settings = Settings::default();
    settings.interior_point.maximum_iterations = 3;
    let solution = mpcc::solve(&mut read_problems(text)[0], &settings).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.x[0] == 0.0 && (solution.x[1] - 1.0).abs() < 1e-8);
}
