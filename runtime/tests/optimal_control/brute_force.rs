//! Optimal control of scenes that the solver was not made for, compared with brute force.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{assert_program, one_start};
use hangtime::model::Model;
use hangtime::ocp::{self, Formulation, Guess, Problem, Solution, Status, TimeFreezingSettings};

hangtime::model! {
    /// A mass with an engine, above the ground.
    pub Hopper {
        parameters {
            /// Mass.
            m: kg = 1,
            /// Gravitational acceleration.
            g: m/s^2 = 9.81,
            /// Height that is to be reached.
            goal: m = 0.3,
        }
        coordinates {
            /// Height.
            z: m,
        }
        controls {
            /// Thrust.
            u: N in 0..=40,
        }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2)
        finally { z == goal }
        start { z: 0.2 [m] }
        horizon 1 [s]
    }
}

const GRAVITY: f64 = 9.81;
const START: f64 = 0.2;
const INTERVAL: f64 = 0.5;

/// Efforts that reach 0.3 m by a thrust after a rest on the ground, and without landing, where `3 u_1 + u_2 = 8 (0.1 + g/2)`.
fn optima() -> [f64; 2] {
    let thrust = GRAVITY + 2.4;
    let flight = 0.8 + 4.0 * GRAVITY;
    [
        INTERVAL * thrust * thrust,
        INTERVAL * flight * flight / 10.0,
    ]
}

fn hop(goal: f64) -> Solution {
    let hopper = Hopper {
        goal,
        ..Hopper::default()
    };
    let problem = Problem::of(&hopper, 2);
    ocp::solve(&hopper, &problem, &one_start(), &mut |_| true).unwrap()
}

#[test]
fn goal_beyond_the_thrust_is_not_found() {
    let solution = hop(100.0);
    assert_eq!(solution.status, Status::NotFound);
    assert!(solution.motion.is_none());
    let diagnosis = solution.diagnosis().unwrap();
    let nearest = solution.nearest.as_ref().unwrap();
    let [miss] = &nearest.misses[..] else {
        panic!("{nearest:?}");
    };
    assert_eq!((&miss.name[..], &miss.unit[..]), ("z == goal", "m"));
    // Full thrust all the time ends at the greatest height; motions drawn at random come near to that, and not beyond what simulations
    // with a tolerance of 1e-6 make of it.
    let highest = START + 0.5 * (40.0 - GRAVITY);
    let left = miss.amount - (100.0 - highest);
    assert!((-1e-6..0.5).contains(&left), "{left}");
    assert!(diagnosis.contains("misses `z == goal` by"), "{diagnosis}");
}

hangtime::model! {
    /// A cart on a spring between two stops: nothing about it is a parabola.
    pub Spring {
        parameters {
            /// Mass.
            m: kg = 1,
            /// Stiffness.
            c: N/m = 4,
        }
        coordinates {
            /// Position.
            y: m in -0.3..=0.3,
        }
        controls {
            /// Force.
            u: N in -3..=3,
        }
        lagrangian m/2*dot(y)^2 - c/2*y^2
        forces { y: u }
        minimize -dot(y)
        finally { y == 0[m] }
        horizon 2 [s]
    }
}

#[test]
fn bounds_of_a_coordinate_that_is_no_parabola_hold_at_all_times() {
    let spring = Spring::default();
    let problem = Problem::of(&spring, 8);
    let solution = ocp::solve(&spring, &problem, &one_start(), &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    // From rest at the stop, 3 N over 0.3 m and the energy of the spring there: v^2 / 2 = 0.9 + 0.18 at most; the
    // intervals cost a few per cent of it.
    let limit = (2.0_f64 * 1.08).sqrt();
    let speed = -solution.objective;
    assert!(speed <= limit + 1e-6 && speed > 0.9 * limit, "{speed}");
    let motion = solution.motion.unwrap();
    let lowest = motion.trajectory.q.iter().map(|q| q[0]);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    // The run-up uses the whole way to the stop, and between the stages it may miss by the tolerance and by the
    // error of the plan.
    assert!((-0.3 - 1e-7..-0.299).contains(&lowest), "{lowest}");
    assert!(solution.resimulation_error < 1e-6);
}

#[test]
fn problem_with_wrong_input_is_refused_in_one_line() {
    let hopper = Hopper::default();
    let problem = Problem::of(&hopper, 3);
    let refuse = |problem: &Problem| {
        let error = ocp::solve(&hopper, problem, &one_start(), &mut |_| true);
        error.unwrap_err().to_string()
    };
    let no_intervals = Problem {
        intervals: 0,
        ..problem.clone()
    };
    insta::assert_snapshot!(refuse(&no_intervals), @"number of control intervals = 0: must be in 1..=10000");
    let mut settings = one_start();
    settings.stages = 1;
    let error = ocp::solve(&hopper, &problem, &settings, &mut |_| true).unwrap_err();
    insta::assert_snapshot!(error, @"Runge-Kutta stages = 1: must be in 2..=9");
    let mut settings = one_start();
    let cart = Spring::default();
    let problem = Problem::of(&cart, 2);
    let motion = hop(0.3).previous.unwrap();
    settings.guess = Guess::Previous(Box::new(motion));
    let error = ocp::solve(&cart, &problem, &settings, &mut |_| true).unwrap_err();
    insta::assert_snapshot!(error, @"the states of the previous motion, which is of another scene, has 3 components, expected 2");
}

#[test]
fn every_guess_of_the_hopping_mass_ends_at_the_same_optimum() {
    let hopper = Hopper::default();
    let problem = Problem::of(&hopper, 2);
    let [best, _] = optima();
    for guess in [
        Guess::Rest,
        Guess::Straight,
        Guess::Ride,
        Guess::Perturbed(1),
        Guess::Perturbed(2),
    ] {
        let mut settings = one_start();
        settings.guess = guess;
        let solution = ocp::solve(&hopper, &problem, &settings, &mut |_| true).unwrap();
        let guess = &settings.guess;
        assert_eq!(
            solution.status,
            Status::Solved,
            "{guess:?}: {:?}",
            solution.diagnosis()
        );
        assert!((solution.objective - best).abs() < 1e-6, "{guess:?}");
    }
    assert_eq!(hopper.declaration().name, "Hopper");
}

#[test]
fn observer_that_stops_early_gets_no_motion_and_late_the_best_so_far() {
    let hopper = Hopper::default();
    let problem = Problem::of(&hopper, 2);
    let run = |calls: usize| {
        let mut seen = Vec::new();
        let solution = ocp::solve(&hopper, &problem, &one_start(), &mut |progress| {
            seen.push((progress.iterations, progress.best));
            seen.len() < calls
        });
        (solution.unwrap(), seen)
    };
    let (solved, all) = run(usize::MAX);
    assert!(solved.status.is_solved());
    assert!(all.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    let (early, seen) = run(3);
    assert_eq!((early.status, seen.len()), (Status::Interrupted, 3));
    assert!(early.motion.is_none() && early.diagnosis().unwrap().contains("stopped"));
    // As soon as there is a best motion, it is what an interrupted run returns.
    let first = all.iter().position(|(_, best)| best.is_some()).unwrap();
    let (late, seen) = run(first + 1);
    assert_eq!(late.status, Status::Interrupted);
    assert_eq!(Some(late.objective), seen.last().unwrap().1);
    assert!(late.motion.is_some() && late.resimulation_error < 1e-6);
}

#[test]
fn time_freezing_formulation_polished_finds_both_local_optima_of_the_hopping_mass() {
    let hopper = Hopper::default();
    let mut settings = one_start();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    settings.starts = Some(4);
    let problem = Problem::of(&hopper, 2);
    let solution = ocp::solve(&hopper, &problem, &settings, &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    let both = optima();
    assert!(
        (solution.objective - both[0]).abs() < 1e-6,
        "{:?}",
        solution.optima
    );
    for optimum in &solution.optima {
        let known = both
            .iter()
            .any(|best| (optimum.objective - best).abs() < 1e-6);
        assert!(known, "{optimum:?} is none of {both:?}");
    }
    assert_program(&solution, 1e-7);
    let report = solution.time_freezing.unwrap();
    assert!(report.relaxed.complementarity > 0.0, "{report:?}");
    assert!(report.size.complementarities > 0 && report.iterations > 0);
    settings.starts = Some(1);
    settings.guess = Guess::Rest;
    let rested = ocp::solve(&hopper, &problem, &settings, &mut |_| true).unwrap();
    let nearest = both.map(|best| (rested.objective - best).abs());
    assert!(
        nearest.iter().any(|gap| *gap < 1e-6),
        "{}",
        rested.objective
    );
}

#[test]
fn several_starts_of_a_word_come_to_the_same_each_time_and_are_stopped_at_once() {
    let hopper = Hopper::default();
    let mut settings = one_start();
    settings.starts = Some(4);
    let problem = Problem::of(&hopper, 2);
    let solve = || ocp::solve(&hopper, &problem, &settings, &mut |_| true).unwrap();
    let solution = solve();
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.objective - optima()[0]).abs() < 1e-6);
    assert!(solution.starts >= 4, "{}", solution.starts);
    assert_eq!(solution.optima[0].objective, solution.objective);
    let again = solve();
    assert_eq!(again.objective, solution.objective);
    assert_eq!(again.optima, solution.optima);
    // A stop reaches all of it.
    let mut calls = 0;
    let stopped = ocp::solve(&hopper, &problem, &settings, &mut |_| {
        calls += 1;
        false
    });
    assert_eq!(stopped.unwrap().status, Status::Interrupted);
    assert_eq!(calls, 1);
}
