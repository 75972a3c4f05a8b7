//! What barrier strategy, watchdog and soft restoration do.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::collections::BTreeMap;

use crate::solver_support::{TextProblem, read_problems};
use hangtime::nlp::{self, BarrierStrategy, Settings, Solution, Status, WarmStart};

fn problem(name: &str) -> TextProblem {
    read_problems(include_str!("../data/hock_schittkowski.txt"))
        .into_iter()
        .find(|problem| problem.name == name)
        .unwrap()
}

fn with(strategy: BarrierStrategy) -> Settings {
    let mut settings = Settings::default();
    settings.barrier_strategy = strategy;
    settings
}

/// How the steps of all Hock-Schittkowski problems were accepted.
fn letters(settings: &Settings) -> BTreeMap<char, usize> {
    let mut letters = BTreeMap::new();
    for mut problem in read_problems(include_str!("../data/hock_schittkowski.txt")) {
        let solution = nlp::solve(&mut problem, settings).unwrap();
        for info in &solution.history {
            *letters.entry(info.acceptance).or_default() += 1;
        }
    }
    letters
}

/// Whether each barrier parameter is the one before it or its successor under the monotone rule, which may skip levels.
fn follows_the_monotone_rule(solution: &Solution, tolerance: f64) -> bool {
    let next = |mu: f64| f64::max(tolerance / 11.0, f64::min(0.2 * mu, mu.powf(1.5)));
    solution.history.windows(2).all(|pair| {
        let (mut mu, target) = (pair[0].barrier_parameter, pair[1].barrier_parameter);
        while mu > target && next(mu) < mu {
            mu = next(mu);
        }
        mu == target
    })
}

#[test]
fn monotone_barrier_takes_its_levels_and_adaptive_chooses_others() {
    for name in ["hs71", "hs100", "hs113"] {
        let monotone = nlp::solve(&mut problem(name), &with(BarrierStrategy::Monotone)).unwrap();
        let adaptive = nlp::solve(&mut problem(name), &with(BarrierStrategy::Adaptive)).unwrap();
        assert_eq!(monotone.status, Status::Solved);
        assert_eq!(adaptive.status, Status::Solved);
        assert!(follows_the_monotone_rule(&monotone, 1e-8), "{name}");
        assert!(!follows_the_monotone_rule(&adaptive, 1e-8), "{name}");
        // both within 1e-8 of the optimum, relative to multipliers of size ten
        let size = monotone.objective.abs().max(1.0);
        assert!((monotone.objective - adaptive.objective).abs() < 1e-6 * size);
    }
}

#[test]
fn adaptive_warm_start_keeps_its_barrier_parameter_first() {
    let mut problem = problem("hs100");
    let cold = nlp::solve(&mut problem, &Settings::default()).unwrap();
    let start = WarmStart {
        barrier_parameter: 1e-5,
        ..WarmStart::from_solution(&cold)
    };
    let mut settings = with(BarrierStrategy::Adaptive);
    settings.bound_push = 1e-9;
    settings.bound_fraction = 1e-9;
    let warm = nlp::solve_from(&mut problem, &settings, Some(&start), None).unwrap();
    assert_eq!(warm.status, Status::Solved);
    assert_eq!(warm.history[0].barrier_parameter, 1e-5);
    assert!(warm.counts.iterations < cold.counts.iterations);
}

#[test]
fn watchdog_acts_where_it_is_allowed_only() {
    let mut settings = Settings::default();
    assert!(!letters(&settings).contains_key(&'w'));
    // after every shortened step, so that these small problems need it often
    settings.watchdog_steps = 1;
    let letters = letters(&settings);
    // deterministic: a change of these numbers is a change of the method
    insta::assert_snapshot!(format!("{letters:?}"), @"{' ': 161, 'F': 1, 'H': 16, 'R': 3, 'f': 1566, 'h': 714, 't': 6, 'w': 66}");
}

/// Monotone and adaptive barrier, with and without watchdog and soft restoration.
fn all_settings() -> Vec<Settings> {
    let mut all = Vec::new();
    for strategy in [BarrierStrategy::Monotone, BarrierStrategy::Adaptive] {
        for (watchdog, soft) in [(0, 0), (1, 0), (10, 0), (0, 10), (10, 10)] {
            let mut settings = with(strategy);
            settings.watchdog_steps = watchdog;
            settings.soft_restoration_steps = soft;
            all.push(settings);
        }
    }
    all
}

#[test]
fn infeasible_problems_are_called_so_within_100_iterations_under_every_setting() {
    for settings in all_settings() {
        for problem in &mut read_problems(include_str!("../data/nlp_infeasible.txt")) {
            let solution = nlp::solve(problem, &settings).unwrap();
            let case = format!("{} {settings:?}", problem.name);
            assert_eq!(solution.status, Status::Infeasible, "{case}");
            assert!(solution.counts.iterations <= 100, "{case}");
            assert!(!solution.violations.is_empty(), "{case}");
        }
    }
}

/// The letters of the log outside restoration phases.
fn steps(solution: &Solution) -> String {
    solution
        .history
        .iter()
        .filter(|info| !info.restoration)
        .map(|info| info.acceptance)
        .collect()
}

#[test]
fn soft_restoration_steps_replace_the_restoration_phase_under_both_strategies() {
    // from here the line search fails, but the Newton step lowers the optimality error
    let mut problem = problem("hs219");
    problem.start = vec![16.0, 13.0, 5.0, 14.0];
    for strategy in [BarrierStrategy::Monotone, BarrierStrategy::Adaptive] {
        let [without, soft] = [0, 10].map(|most| {
            let mut settings = with(strategy);
            settings.soft_restoration_steps = most;
            nlp::solve(&mut problem, &settings).unwrap()
        });
        assert!(steps(&without).contains('R') && !steps(&without).contains('s'));
        // an accepted step, then one whose end the filter accepts, and no restoration phase
        assert!(steps(&soft).contains("sS"), "{}", steps(&soft));
        assert!(!steps(&soft).contains('R'), "{}", steps(&soft));
        assert_eq!(soft.counts.restoration_iterations, 0);
        assert!(soft.counts.iterations < without.counts.iterations);
        for solution in [&without, &soft] {
            assert_eq!(solution.status, Status::Solved);
            // the minimum is -1; 1e-8 of it and of the tolerance
            assert!((solution.objective + 1.0).abs() < 1e-7);
        }
        // both step lengths of such a step are one
        for info in soft.history.iter().filter(|info| info.acceptance == 's') {
            assert_eq!(info.step_length_primal, info.step_length_dual);
        }
    }
}

#[test]
fn soft_restoration_gives_up_after_its_most_steps() {
    let mut problem = problem("hs219");
    problem.start = vec![16.0, 13.0, 5.0, 14.0];
    let mut settings = Settings::default();
    settings.soft_restoration_steps = 1;
    let solution = nlp::solve(&mut problem, &settings).unwrap();
    assert_eq!(solution.status, Status::Solved);
    // the first step reaches no point that the filter accepts, and there is no second one
    assert!(steps(&solution).contains("sR"), "{}", steps(&solution));
}

/// Problems whose line search fails: degenerate ones, and the one whose linearised constraints no step inside the bounds
/// can satisfy (Waechter and Biegler, Mathematical Programming 88, 2000).
#[test]
fn soft_restoration_leaves_the_end_of_hard_problems_as_it_is() {
    let mut problems = read_problems(include_str!("../data/nlp_degenerate.txt"));
    problems.extend(read_problems(
        "problem waechter_biegler 3\nstart -2 1 1\nbounds 2 0 inf\nbounds 3 0 inf\nminimize x1\n\
         row 0 0 x1^2 - x2 - 1\nrow 0 0 x1 - x3 - 0.5\n",
    ));
    for problem in &mut problems {
        let [without, with] = [0, 10].map(|most| {
            let mut settings = Settings::default();
            settings.soft_restoration_steps = most;
            nlp::solve(problem, &settings).unwrap()
        });
        assert_eq!(without.status, with.status, "{}", problem.name);
    }
}

#[test]
fn solve_tolerance_out_of_reach_is_acceptable_not_solved() {
    let mut settings = Settings::default();
    // far below the rounding errors of the gradients
    settings.tolerance = 1e-30;
    settings.acceptable_tolerance = 1e-7;
    settings.acceptable_iterations = 4;
    let solution = nlp::solve(&mut problem("hs71"), &settings).unwrap();
    assert_eq!(solution.status, Status::Acceptable);
    assert!(!solution.status.is_solved());
    assert!(solution.residuals.scaled_error <= 1e-7);
    // the acceptable iterations came last, one after the other
    let last = &solution.history[solution.history.len() - 4..];
    assert!(last.iter().all(|info| info.dual_infeasibility < 1e-5));
}

#[test]
fn solve_time_limit_ends_the_run_with_its_status() {
    let mut settings = Settings::default();
    settings.maximum_seconds = 1e-12;
    let solution = nlp::solve(&mut problem("hs100"), &settings).unwrap();
    assert_eq!(solution.status, Status::TimeLimit);
    assert_eq!(solution.counts.iterations, 0);
}
