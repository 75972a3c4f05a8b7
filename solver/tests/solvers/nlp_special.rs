//! Infeasible, unbounded, degenerate and badly scaled programs; settings, warm starts, input faults.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::solver_support::{Asked, TextProblem, Watched, read_problems};
use hangtime_solver::nlp::{self, NlpProblem, Settings, Status, WarmStart};

fn problem(text: &str) -> TextProblem {
    read_problems(text).remove(0)
}

fn hock_schittkowski(name: &str) -> TextProblem {
    read_problems(include_str!("../data/hock_schittkowski.txt"))
        .into_iter()
        .find(|problem| problem.name == name)
        .unwrap()
}

#[test]
fn solve_infeasible_names_rows_within_100_iterations() {
    for mut problem in read_problems(include_str!("../data/nlp_infeasible.txt")) {
        let mut once = Settings::default();
        once.persistent = false;
        let first = nlp::solve(&mut problem, &once).unwrap();
        let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
        let name = &problem.name;
        assert_eq!(solution.status, Status::Infeasible, "{name}");
        assert!(first.counts.iterations <= 100, "{name}");
        // other starts find no better point
        assert_eq!(solution.x, first.x, "{name}");
        let gradient = solution.violation_stationarity.unwrap();
        // the tolerance of the phase, relative to its penalty, and its pull towards where it began
        assert!(gradient < 1e-6, "{name}: {gradient}");
        let worst = &solution.violations[0];
        assert!(worst.amount > 1e-3, "{name}: {worst:?}");
        assert!(worst.name.starts_with("c["), "{name}: {worst:?}");
    }
}

#[test]
fn solve_degenerate_reaches_the_solution() {
    for mut problem in read_problems(include_str!("../data/nlp_degenerate.txt")) {
        let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
        let name = &problem.name;
        assert_eq!(solution.status, Status::Solved, "{name}");
        let gap = problem
            .optimum
            .iter()
            .map(|optimum| (solution.objective - optimum).abs())
            .fold(f64::INFINITY, f64::min);
        // objectives are of size 1 to 10, so this is the tolerance times small multipliers
        assert!(gap < 1e-6, "{name}: {}", solution.objective);
    }
}

#[test]
fn solve_unbounded_diverges() {
    for text in [
        "problem line 1\nstart 1\nminimize -x1^3 + x1",
        "problem ray 2\nstart 1 1\nbounds 1 0 inf\nbounds 2 0 inf\nminimize x2 - x1\nrow -inf 1 x2 - x1",
    ] {
        let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::Diverging);
    }
}

#[test]
fn solve_domain_of_a_logarithm_is_respected() {
    // a full Newton step from 5 leaves the domain
    let mut problem =
        problem("problem logarithm 1\nstart 5\nminimize x1 - 2*log(x1 - 1)\noptimum 3");
    let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.x[0] - 3.0).abs() < 1e-6);
}

#[test]
fn solve_outside_the_domain_is_an_input_error() {
    let mut problem = problem("problem logarithm 1\nstart -5\nminimize x1\nrow 0 0 log(x1)");
    let error = nlp::solve(&mut problem, &Settings::default()).unwrap_err();
    insta::assert_snapshot!(error, @"c[0] is not finite at the starting point; start inside the domain of the functions");
}

#[test]
fn solve_crossed_bounds_are_an_input_error() {
    let mut problem = problem("problem crossed 1\nstart 0\nbounds 1 2 1\nminimize x1");
    let error = nlp::solve(&mut problem, &Settings::default()).unwrap_err();
    insta::assert_snapshot!(error, @"x[0]: lower bound 2, upper bound 1; give bounds with lower <= upper");
}

#[test]
fn solve_warm_start_at_the_solution_needs_few_iterations() {
    let mut problem = hock_schittkowski("hs100");
    let cold = nlp::solve(&mut problem, &Settings::default()).unwrap();
    let mut settings = Settings::default();
    settings.bound_push = 1e-9;
    settings.bound_fraction = 1e-9;
    let start = WarmStart::from_solution(&cold);
    let warm = nlp::solve_from(&mut problem, &settings, Some(&start), None).unwrap();
    assert_eq!(warm.status, Status::Solved);
    assert!(
        warm.counts.iterations <= 3 && 3 * warm.counts.iterations < cold.counts.iterations,
        "{} after {}",
        warm.counts.iterations,
        cold.counts.iterations
    );
}

#[test]
fn solve_warm_start_of_wrong_length_is_an_input_error() {
    let mut other = hock_schittkowski("hs100");
    let start = WarmStart::from_solution(&nlp::solve(&mut other, &Settings::default()).unwrap());
    let mut problem = hock_schittkowski("hs71");
    let error =
        nlp::solve_from(&mut problem, &Settings::default(), Some(&start), None).unwrap_err();
    insta::assert_snapshot!(error, @"warm start: expected 2 entries of the constraint multipliers, got 4");
}

#[test]
fn solve_limits_end_the_run_with_their_status() {
    let mut problem = hock_schittkowski("hs100");
    let mut settings = Settings::default();
    settings.maximum_iterations = 3;
    let solution = nlp::solve(&mut problem, &settings).unwrap();
    assert_eq!(solution.status, Status::IterationLimit);
    assert_eq!(solution.counts.iterations, 3);
    assert_eq!(solution.history.len(), 4);
    let mut seen = 0;
    let mut observer = |_: &nlp::IterationInfo| {
        seen += 1;
        seen < 3
    };
    let solution = nlp::solve_from(
        &mut problem,
        &Settings::default(),
        None,
        Some(&mut observer),
    )
    .unwrap();
    assert_eq!(solution.status, Status::Interrupted);
}

#[test]
fn solve_multipliers_satisfy_the_optimality_conditions() {
    for name in ["hs71", "hs100", "hs113", "hs118", "hs44"] {
        let mut problem = hock_schittkowski(name);
        let solution = nlp::solve(&mut problem, &Settings::default()).unwrap();
        // grad f + J' y - z_l + z_u from the problem's own derivatives
        let (n, m) = (problem.variables(), problem.constraints());
        let mut residual = vec![0.0; n];
        problem.gradient(&solution.x, &mut residual);
        let pattern = problem.jacobian_pattern();
        let mut values = vec![0.0; pattern.len()];
        problem.jacobian_values(&solution.x, &mut values);
        for (&(i, j), a) in pattern.iter().zip(&values) {
            residual[j] += a * solution.multipliers[i];
        }
        let mut largest: f64 = 0.0;
        for (i, residual) in residual.iter().enumerate() {
            let (z_l, z_u) = (solution.multipliers_lower[i], solution.multipliers_upper[i]);
            largest = largest.max((residual + z_u - z_l).abs());
            assert!(z_l >= 0.0 && z_u >= 0.0);
        }
        assert!((largest - solution.residuals.dual).abs() < 1e-12, "{name}");
        // unscaled; objective scaling of these problems is at least 1e-2
        assert!(largest < 1e-6, "{name}: {largest:e}");
        // multipliers of inequalities have the sign of their active side
        let mut c = vec![0.0; m];
        problem.constraint_values(&solution.x, &mut c);
        for (row, (lower, upper)) in problem.rows.iter().enumerate() {
            let y = solution.multipliers[row];
            if y < -1e-6 {
                assert!((c[row] - lower).abs() < 1e-5, "{name} row {row}");
            }
            if y > 1e-6 {
                assert!((c[row] - upper).abs() < 1e-5, "{name} row {row}");
            }
        }
    }
}

#[test]
fn check_derivatives_finds_a_wrong_entry_by_name() {
    let watch = |asked, _: &[f64], values: &mut [f64]| {
        if asked == Asked::Jacobian {
            values[1] += 0.25;
        }
    };
    let mut wrong = Watched::new(hock_schittkowski("hs71"), watch);
    let compared = nlp::check_derivatives(&mut wrong, None).unwrap();
    let worst = &compared[0];
    assert_eq!(worst.name, "d c[0] / d x[1]");
    assert!((worst.given - worst.difference - 0.25).abs() < 1e-6);
    assert!(compared[1].error < 1e-6);
}

#[test]
fn solve_without_free_variables_judges_the_point() {
    let fixed = "problem fixed 2\nstart 5 5\nbounds 1 1 1\nbounds 2 2 2\nminimize x1 + x2\n";
    let free = nlp::solve(&mut problem(fixed), &Settings::default()).unwrap();
    assert_eq!(free.status, Status::Solved);
    assert_eq!(free.x, [1.0, 2.0]);
    let kept = nlp::solve(
        &mut problem(&format!("{fixed}row 3 3 x1 + x2")),
        &Settings::default(),
    );
    assert_eq!(kept.unwrap().status, Status::Solved);
    let broken = nlp::solve(
        &mut problem(&format!("{fixed}row 4 4 x1 + x2")),
        &Settings::default(),
    );
    let broken = broken.unwrap();
    assert_eq!(broken.status, Status::Infeasible);
    assert_eq!(broken.violations[0].name, "c[0]");
}

#[test]
fn solve_row_of_fixed_variables_does_not_disturb_the_others() {
    let text = "problem row 2\nstart 5 5\nbounds 1 1 1\nminimize (x2 - 3)^2\nrow 2 2 2*x1\nrow 0 9 x2 + x1";
    let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.x[1] - 3.0).abs() < 1e-7);
}

#[test]
fn solve_not_a_number_in_a_derivative_ends_with_its_status() {
    // the value of x^1.5 is finite at 0, its second derivative is not
    let text = "problem corner 1\nstart 0\nminimize x1 + x1^1.5";
    let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::NotFinite);
}

#[test]
fn solve_tolerance_out_of_reach_is_acceptable_not_solved() {
    let mut settings = Settings::default();
    // far below the rounding errors of the gradients
    settings.tolerance = 1e-30;
    settings.acceptable_tolerance = 1e-7;
    settings.acceptable_iterations = 4;
    let solution = nlp::solve(&mut hock_schittkowski("hs71"), &settings).unwrap();
    assert_eq!(solution.status, Status::Acceptable);
    assert!(!solution.status.is_solved());
    assert!(solution.scaled_error <= 1e-7);
    // the acceptable iterations came last, one after the other
    let last = &solution.history[solution.history.len() - 4..];
    assert!(last.iter().all(|info| info.dual_infeasibility < 1e-5));
}

#[test]
fn solve_time_limit_ends_the_run_with_its_status() {
    let mut settings = Settings::default();
    settings.maximum_seconds = 1e-12;
    let solution = nlp::solve(&mut hock_schittkowski("hs100"), &settings).unwrap();
    assert_eq!(solution.status, Status::TimeLimit);
    assert_eq!(solution.counts.iterations, 0);
}

/// Solves a problem in text, and compares its objective with the closed form.
fn ends(text: &str, status: Status, optimum: f64) -> nlp::Solution {
    let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
    assert_eq!(solution.status, status, "{text}");
    let gap = (solution.objective - optimum).abs();
    assert!(gap < 1e-7, "{text}: {}", solution.objective);
    solution
}

#[test]
fn solve_from_a_steep_start_ends_at_the_solution() {
    // 4 (x - 1)^3 = -1
    let quartic = 0.25_f64.powf(4.0 / 3.0) + 1.0 - 0.25_f64.cbrt();
    for (text, optimum) in [
        ("problem exp 1\nstart 30\nminimize exp(x1) - x1", 1.0),
        ("problem exp 1\nstart 100\nminimize exp(x1) - x1", 1.0),
        (
            "problem quartic 1\nstart 10000\nminimize (x1 - 1)^4 + x1",
            quartic,
        ),
        (
            "problem quartic 1\nstart 1e8\nminimize (x1 - 1)^4 + x1",
            quartic,
        ),
        (
            "problem inverse 1\nstart 1e-5\nbounds 1 0 inf\nminimize x1 + 1/x1",
            2.0,
        ),
        (
            "problem log 1\nstart 1e-12\nbounds 1 0 inf\nminimize x1 - log(x1)",
            1.0,
        ),
        (
            "problem row 2\nstart 1e4 1e4\nminimize x1 + (x2 - 1)^4\nrow 0 inf x1 - (x2 - 3)^4",
            2.0,
        ),
    ] {
        let solution = ends(text, Status::Solved, optimum);
        assert!(
            solution.residuals.dual < 1e-7,
            "{text}: {:?}",
            solution.residuals
        );
        assert!(solution.residuals.complementarity < 1e-7, "{text}");
        let last = solution.history.last().unwrap();
        assert_eq!(last.iteration, solution.counts.iterations, "{text}");
    }
}

#[test]
fn solve_from_a_steep_start_counts_all_its_runs_towards_the_limits() {
    let mut exponential = problem("problem exp 1\nstart 30\nminimize exp(x1) - x1");
    let all = nlp::solve(&mut exponential, &Settings::default()).unwrap();
    let mut settings = Settings::default();
    settings.maximum_iterations = all.counts.iterations - 1;
    let solution = nlp::solve(&mut exponential, &settings).unwrap();
    assert_eq!(solution.status, Status::IterationLimit);
    assert_eq!(solution.counts.iterations, all.counts.iterations - 1);
    let mut seen = Vec::new();
    let mut observer = |info: &nlp::IterationInfo| {
        seen.push(info.iteration);
        info.iteration + 2 < all.counts.iterations
    };
    let settings = Settings::default();
    let solution = nlp::solve_from(&mut exponential, &settings, None, Some(&mut observer)).unwrap();
    assert_eq!(solution.status, Status::Interrupted);
    assert!(seen.is_sorted() && seen.len() == solution.history.len());
}

#[test]
fn solve_finds_out_three_times_that_rows_are_dependent() {
    let text = "problem valley 3\nstart -1.2 1 2\nminimize 100*(x2 - x1^2)^2 + (1 - x1)^2 + (x3 - x1)^2\n\
                row 3 3 x1 + x2 + x3\nrow 6 6 2*x1 + 2*x2 + 2*x3";
    let solution = nlp::solve(&mut read_problems(text)[0], &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.x.iter().all(|x| (x - 1.0).abs() < 1e-6));
    let counts = solution.counts;
    // one an iteration, those that show it, and those of multipliers and curvature
    insta::assert_snapshot!(
        format!("{} factorizations in {} iterations", counts.factorizations, counts.iterations),
        @"30 factorizations in 17 iterations"
    );
}

#[test]
fn solve_with_dependent_or_tiny_rows_is_solved() {
    for (text, optimum) in [
        (
            "problem dependent 3\nstart 1 2 3\nminimize x1^2 + x2^2 + x3^2\nrow 3 3 x1 + x2 + x3\nrow 3 3 x1 + x2 + x3\n\
             row 9 9 (x1 + x2 + x3)^2",
            3.0,
        ),
        (
            "problem thrice 2\nstart 1 2\nminimize x1 + x2\nrow 2 2 x1^2 + x2^2\nrow 4 4 2*x1^2 + 2*x2^2\n\
             row 0 0 (x1^2 + x2^2 - 2)^3",
            -2.0,
        ),
        (
            "problem tiny 2\nstart 1 1\nminimize x1^2 + x2^2\nrow 1e8 1e8 1e8*x1 + 1e-8*x2\nrow 1e-8 1e-8 1e-8*x2",
            2.0,
        ),
        (
            "problem tiny 1\nstart 0\nminimize x1\nrow 1e-9 inf 1e-9*x1",
            1.0,
        ),
        (
            "problem steep 2\nstart 1e-6 1e-6\nbounds 1 0 inf\nbounds 2 0 inf\nminimize x1 + x2\nrow -inf 1 1/x1 + 1/x2",
            4.0,
        ),
    ] {
        ends(text, Status::Solved, optimum);
    }
}

#[test]
fn solve_without_multipliers_is_degenerate_at_the_solution() {
    for (text, optimum) in [
        ("problem square 1\nstart 5\nminimize x1\nrow 0 0 x1^2", 0.0),
        (
            "problem circle 2\nstart 5 7\nminimize x1\nrow 0 0 (x1 - 1)^2 + (x2 - 2)^2",
            1.0,
        ),
        (
            "problem sine 1\nstart 0\nminimize x1\nrow 1 1 sin(x1)",
            std::f64::consts::FRAC_PI_2,
        ),
    ] {
        ends(text, Status::Degenerate, optimum);
    }
    // without an interior, but with multipliers
    ends(
        "problem point 2\nstart 0 0\nbounds 1 0 inf\nbounds 2 0 inf\nminimize x1 + x2\nrow 0 0 x1 + x2\nrow 0 0 x1 - x2",
        Status::Solved,
        0.0,
    );
    // flat enough to be feasible far from the solution
    let flat = "problem flat 1\nstart 5\nminimize x1\nrow 0 0 (x1 - 1)^3";
    let solution = nlp::solve(&mut problem(flat), &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Degenerate);
}

#[test]
fn solve_unbounded_linear_programs_diverge_soon() {
    for text in [
        "problem line 2\nstart 1 2\nminimize x1 + x2\nrow 1 1 x1 - x2",
        "problem line 2\nstart 0 0\nminimize 0.5*x1\nrow 1 1 x1 - 3*x2",
        "problem cone 2\nstart 0 0\nbounds 1 0 inf\nbounds 2 0 inf\nminimize -x1\nrow -inf 1 x1 - 3*x2",
    ] {
        let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::Diverging, "{text}");
        assert!(solution.counts.iterations < 60, "{text}");
    }
}

#[test]
fn solve_far_points_that_violate_rows_do_not_diverge() {
    let text = "problem both 2\nstart 0 0\nbounds 1 0 inf\nbounds 2 0 inf\nminimize -x1\nrow 1 1 x2\nrow 0 0 x2";
    let solution = nlp::solve(&mut problem(text), &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Infeasible);
    for start in ["1e6", "1e8"] {
        let text = format!(
            "problem row 2\nstart {start} {start}\nminimize x1 + (x2 - 1)^4\nrow 0 inf x1 - (x2 - 3)^4"
        );
        let solution = nlp::solve(&mut problem(&text), &Settings::default()).unwrap();
        assert_ne!(solution.status, Status::Diverging, "{start}");
    }
}

#[test]
fn solve_from_a_maximum_or_saddle_point_leaves_it() {
    for (text, optimum) in [
        (
            "problem square 2\nstart 0.5 0.5\nbounds 1 0 1\nbounds 2 0 1\nminimize -(x1 - 0.5)^2 - (x2 - 0.5)^2",
            -0.5,
        ),
        (
            "problem ball 2\nstart 0 0\nminimize x2^2 - x1^2\nrow -inf 1 x1^2 + x2^2",
            -1.0,
        ),
        (
            "problem line 2\nstart 0 0\nminimize -x1^2 - x2^2\nrow 0 0 x1 + x2\nrow -inf 4 x1^2",
            -8.0,
        ),
    ] {
        ends(text, Status::Solved, optimum);
    }
    let hill = "problem hill 1\nstart 0\nminimize -x1^2";
    let solution = nlp::solve(&mut problem(hill), &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Diverging);
    let valley = "problem valley 1\nstart 0\nminimize x1^2";
    let solution = ends(valley, Status::Solved, 0.0);
    assert_eq!(solution.counts.iterations, 0);
}
