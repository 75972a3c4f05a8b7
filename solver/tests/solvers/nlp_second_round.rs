//! What is tried where a run would end without a solution.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::solver_support::read_problems;
use hangtime_solver::nlp::{self, Settings, Status};

fn solve(text: &str) -> nlp::Solution {
    nlp::solve(&mut read_problems(text)[0], &Settings::default()).unwrap()
}

/// The same without further attempts.
fn solve_once(text: &str) -> nlp::Solution {
    let mut settings = Settings::default();
    settings.persistent = false;
    nlp::solve(&mut read_problems(text)[0], &settings).unwrap()
}

#[test]
fn solve_least_squares_to_the_rounding_of_their_differences() {
    // Misra1c of NIST, y = b1 (1 - 1 / sqrt(1 + 2 b2 x)) from its first start
    let data = [
        (77.6, 10.07),
        (114.9, 14.73),
        (141.1, 17.94),
        (190.8, 23.93),
        (239.9, 29.61),
        (289.0, 35.18),
        (332.8, 40.02),
        (378.4, 44.82),
        (434.8, 50.76),
        (477.3, 55.05),
        (536.8, 61.01),
        (593.1, 66.40),
        (689.1, 75.47),
        (760.0, 81.78),
    ];
    let squares = data.map(|(x, y)| format!("({y} - x1*(1 - 1/sqrt(1 + {}*x2)))^2", 2.0 * x));
    let text = format!(
        "problem misra1c 2\nstart 500 0.0001\nminimize {}",
        squares.join(" + ")
    );
    let solution = solve(&text);
    assert_eq!(solution.status, Status::Solved);
    // the certified values have eleven digits
    for (value, certified) in [
        (solution.x[0], 6.3642725809e2),
        (solution.x[1], 2.0813627256e-4),
        (solution.objective, 4.0966836971e-2),
    ] {
        assert!((value / certified - 1.0).abs() < 1e-10, "{value}");
    }
}

#[test]
fn solve_eigenvalue_equations_has_multipliers_that_vanish() {
    // Q' D Q = diag(1, 2), Q' Q = I with d >= 0: x = (d1, d2, q11, q12, q21, q22); nothing is minimized
    let text = "problem eigenvalues 6\nstart 1 1 1 0 0 1\nbounds 1 0 inf\nbounds 2 0 inf\nbounds 3 0 inf\nbounds 4 0 inf\nbounds 5 0 inf\nbounds 6 0 inf\n\
                minimize 0*x1\nrow 1 1 x3^2*x1 + x5^2*x2\nrow 0 0 x3*x4*x1 + x5*x6*x2\nrow 2 2 x4^2*x1 + x6^2*x2\n\
                row 1 1 x3^2 + x5^2\nrow 0 0 x3*x4 + x5*x6\nrow 1 1 x4^2 + x6^2";
    let solution = solve(text);
    assert_eq!(solution.status, Status::Solved);
    let mut values = solution.x[..2].to_vec();
    values.sort_by(f64::total_cmp);
    assert!((values[0] - 1.0).abs() < 1e-7 && (values[1] - 2.0).abs() < 1e-7);
}

#[test]
fn solve_at_far_bounds_with_steep_objectives_ends_on_them() {
    // from 1, towards both ends: the distance that complementarity allows is below the spacing of the numbers
    let text = "problem far 4\nstart 1 1 1 1\nbounds 1 -1e5 1e6\nbounds 2 -1e5 1e6\nbounds 3 -1e5 1e6\nbounds 4 -1e5 1e6\n\
                minimize x1 + x2 + x3 + x4 - 2*x1^2 - 1.5*x2^2 - x3^2 + x4^2";
    let solution = solve(text);
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.residuals.primal < 1e-9, "{:?}", solution.residuals);
    let ends = [1e6, -1e5];
    assert!(solution.x[..3].iter().all(|x| ends.contains(x)));
    assert!((solution.x[3] + 0.5).abs() < 1e-7);
}

#[test]
fn solve_gradients_that_grow_call_for_large_multipliers() {
    // the gradient is 0 at the start and 4e9 at the only point there is
    let solution = solve("problem quartic 1\nstart 0\nminimize x1^4\nrow 1000 1000 x1");
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.objective / 1e12 - 1.0).abs() < 1e-7);
    assert!((solution.multipliers[0] / -4e9 - 1.0).abs() < 1e-7);
}

#[test]
fn solve_narrow_strip_along_a_wave_reaches_its_end() {
    // sin(x1) <= x2 <= sin(x1) + 3 x1/10^4 leaves x1 >= 0
    let text = "problem strip 2\nstart 5 9\nminimize x1\nrow 0 inf x2 - sin(x1)\nrow 0 inf 0.0003*x1 - x2 + sin(x1)";
    assert!(!solve_once(text).status.is_solved());
    let solution = solve(text);
    assert_eq!(solution.status, Status::Solved);
    // the tolerance of the rows is that of 3 x1/10^4
    assert!(solution.objective.abs() < 2e-4, "{}", solution.objective);
}

#[test]
fn solve_equations_with_a_stationary_violation_beside_their_solution() {
    // x1 + x2 x3^k = c_k: x3 = (c_3 - c_2) / (c_2 - c_1)
    let text = "problem powers 3\nstart 1.2 -1.2 0.98\nminimize 0*x1\nrow 0.032 0.032 x1 + x2*x3\nrow 0.056 0.056 x1 + x2*x3^2\n\
                row 0.099 0.099 x1 + x2*x3^3";
    let once = solve_once(text);
    assert_eq!(once.status, Status::Infeasible);
    assert!(once.violation_stationarity.unwrap() < 1e-6);
    let solution = solve(text);
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.violation_stationarity.is_none());
    let ratio = 0.043 / 0.024;
    assert!((solution.x[2] - ratio).abs() < 1e-5, "{:?}", solution.x);
}

#[test]
fn solve_violation_of_linear_rows_is_looked_at_once() {
    let text = "problem parallel_lines 2\nstart 0 0\nminimize x1^2 + x2^2\nrow 1 1 x1 + x2\nrow 3 3 x1 + x2";
    let solution = solve(text);
    assert_eq!(solution.status, Status::Infeasible);
    assert_eq!(
        solution.counts.iterations,
        solve_once(text).counts.iterations
    );
}

#[test]
fn solve_violation_within_the_constraint_tolerance_is_not_called_infeasible() {
    // the least violation is 2e-7
    let text = "problem near 1\nstart 0\nminimize 0*x1\nrow 0 0 x1\nrow 4e-7 4e-7 x1";
    let solution = solve(text);
    assert_ne!(solution.status, Status::Infeasible);
    assert!(solution.residuals.primal < 1e-6);
}
