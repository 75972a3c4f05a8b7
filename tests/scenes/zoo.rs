//! What the search is meant to keep on any scene, tried on some of the zoo that are quick to solve.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::ocp::{self, Problem, Settings, Solution};
use hangtime_zoo::exhibits;

/// Relative increase of the objective that tolerances explain.
const NOT_WORSE: f64 = 1e-6;

fn solve(name: &str, intervals: usize, settings: &Settings) -> Solution {
    let exhibit = exhibits().iter().find(|exhibit| exhibit.name == name);
    let model = (exhibit.unwrap().model)();
    let problem = Problem::of(&*model, intervals);
    ocp::solve(&*model, &problem, settings, &mut |_| true).unwrap()
}

#[test]
fn twice_the_intervals_never_end_at_a_worse_motion() {
    for name in ["weak-pendulum", "catch-ball", "soft-landing"] {
        let coarse = solve(name, 8, &Settings::default()).objective;
        let fine = solve(name, 16, &Settings::default()).objective;
        assert!(
            fine <= coarse + NOT_WORSE * coarse.abs(),
            "{name}: {coarse} {fine}"
        );
    }
}

#[test]
#[ignore = "long"]
fn ten_twenty_and_forty_intervals_never_end_at_a_worse_motion() {
    let quick = [
        "three-carts",
        "fast-cart",
        "soft-landing",
        "weak-throw",
        "throw-from-plate",
        "juggler",
        "wall-ball",
        "weak-pendulum",
        "hop",
        "push-off",
    ];
    for name in quick {
        let objective = |intervals| solve(name, intervals, &Settings::default()).objective;
        let all = [10, 20, 40].map(objective);
        for (coarse, fine) in [(all[0], all[1]), (all[1], all[2])] {
            assert!(fine <= coarse + NOT_WORSE * coarse.abs(), "{name}: {all:?}");
        }
    }
}

#[test]
fn more_starts_never_end_at_a_worse_motion() {
    let with = |starts: usize| {
        let mut settings = Settings::default();
        settings.starts = Some(starts);
        solve("throw-from-plate", 8, &settings).objective
    };
    let (few, many) = (with(2), with(6));
    assert!(many <= few + NOT_WORSE * few.abs(), "{few} {many}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut seen: Vec<(u64, Vec<u64>)> = Vec::new();
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let solution = pool
            .unwrap()
            .install(|| solve("catch-ball", 8, &Settings::default()));
        let controls = solution.controls.iter().flatten();
        seen.push((
            solution.objective.to_bits(),
            controls.map(|u| u.to_bits()).collect(),
        ));
    }
    assert!(seen.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn contact_that_begins_at_the_end_of_the_motion_is_found() {
    // Only with it may the body touch down early and stand on its spring; without it the objective was 2.31 and more.
    let solution = solve("lander", 20, &Settings::default());
    assert!(solution.status.is_solved());
    assert!(solution.objective < 0.937, "{}", solution.objective);
}

#[test]
fn ball_is_struck_as_often_as_it_pays() {
    // Simulations under guessed controls strike it four times, and all starts agreed on 170; two impacts need 39.
    for intervals in [10, 20] {
        let solution = solve("juggler", intervals, &Settings::default());
        assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
        let best = hangtime_zoo::best("juggler", intervals).unwrap();
        assert!((solution.objective / best - 1.0).abs() < 1e-6);
    }
}

#[test]
fn forces_far_from_zero_leave_no_neighbour_undecided() {
    // Multipliers of 4e-11 at forces of 0.4 m/s^2 asked for neighbours that allow no motion nearby.
    let solution = solve("crane-between-walls", 10, &Settings::default());
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    let best = hangtime_zoo::best("crane-between-walls", 10).unwrap();
    assert!((solution.objective / best - 1.0).abs() < 1e-6);
}

#[test]
#[ignore = "long"]
fn neighbours_that_start_from_the_plan_are_decided() {
    let solution = solve("cart-pole-walls", 10, &Settings::default());
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    let best = hangtime_zoo::best("cart-pole-walls", 10).unwrap();
    assert!((solution.objective / best - 1.0).abs() < 1e-6);
}

#[test]
#[ignore = "long"]
fn neighbours_that_gain_nothing_by_the_first_derivative_are_decided() {
    // Each of them was as good as the plan to nine digits, and its program ended at the limit of iterations.
    for (name, intervals) in [("plate-and-box", 10), ("spinning-wheel", 20)] {
        let solution = solve(name, intervals, &Settings::default());
        assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
        let best = hangtime_zoo::best(name, intervals).unwrap();
        assert!((solution.objective / best - 1.0).abs() < 1e-6, "{name}");
    }
}
