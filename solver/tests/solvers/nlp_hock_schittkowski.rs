//! The Hock-Schittkowski problems from their standard starting points.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::solver_support::{TextProblem, read_problems};
use hangtime_solver::nlp::{self, Settings, Status};

fn problems() -> Vec<TextProblem> {
    read_problems(include_str!("../data/hock_schittkowski.txt"))
}

/// Problems whose solution satisfies no constraint qualification: no multipliers exist there.
const WITHOUT_MULTIPLIERS: [&str; 3] = ["hs13", "hs220", "hs221"];

/// Relative distance of the objective from the reference. The references have 12 digits; a scaled
/// optimality error of 1e-8 leaves an error of the objective of 1e-8 times the multipliers, and those of
/// this set reach 1e2.
const OBJECTIVE: f64 = 1e-6;

/// Least relative distance to one of the optima.
fn distance(problem: &TextProblem, objective: f64) -> f64 {
    problem
        .optimum
        .iter()
        .map(|optimum| (objective - optimum).abs() / optimum.abs().max(1.0))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn solve_standard_start_reaches_an_optimum() {
    let mut iterations = 0;
    let mut failures = Vec::new();
    let mut solved = 0;
    for mut problem in problems() {
        if WITHOUT_MULTIPLIERS.contains(&problem.name.as_str()) {
            continue;
        }
        let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
        iterations += solution.counts.iterations;
        let gap = distance(&problem, solution.objective);
        if solution.status == Status::Solved
            && gap <= OBJECTIVE
            && solution.residuals.primal <= 1e-6
        {
            solved += 1;
        } else {
            failures.push(format!(
                "{}: {}, gap {gap:.1e}",
                problem.name, solution.status
            ));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    // deterministic: a change of these numbers is a change of the method
    insta::assert_snapshot!(format!("{solved} solved, {iterations} iterations"), @"155 solved, 2001 iterations");
}

#[test]
fn solve_without_constraint_qualification_is_not_solved_at_a_wrong_point() {
    for mut problem in problems() {
        if !WITHOUT_MULTIPLIERS.contains(&problem.name.as_str()) {
            continue;
        }
        let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
        let gap = distance(&problem, solution.objective);
        assert!(
            !solution.status.is_solved() || gap <= OBJECTIVE,
            "{}: {} with gap {gap:.1e}",
            problem.name,
            solution.status
        );
        // and whatever the status, the point is near: the constraints are cubic in the distance d from the
        // solution, so a residual of the tolerance 1e-8 allows d = cbrt(1e-8)
        assert!(gap < 1e-8_f64.cbrt(), "{}: gap {gap:.1e}", problem.name);
    }
}

#[test]
fn hessian_of_the_reader_matches_differences_of_its_gradient() {
    // the derivatives that all comparisons rest on, checked for a spread of problems
    for mut problem in problems().into_iter().step_by(7) {
        let compared = nlp::check_derivatives(&mut problem, None).unwrap();
        assert!(
            compared[0].error < 1e-5,
            "{}: {:?}",
            problem.name,
            compared[0]
        );
    }
}
