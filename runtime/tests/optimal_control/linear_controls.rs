//! Optimal control with controls that are linear between nodes, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{assert_program, linear, most_exceeded, one_start};
use hangtime::model::Model;
use hangtime::ocp::{
    self, ControlShape, Formulation, Guess, Problem, Settings, Solution, Status,
    TimeFreezingSettings,
};
use hangtime::simulation::EventKind;

/// Linear controls by time-freezing.
fn frozen() -> Settings {
    let mut settings = linear();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    settings
}

/// The solver's tolerance is 1e-9, that of the re-simulation 1e-12.
const DIGITS: f64 = 1e-8;

fn solve(model: &dyn Model, problem: &Problem, settings: &Settings) -> Solution {
    let solution = ocp::solve(model, problem, settings, &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    solution
}

hangtime::model! {
    /// A cart that is pushed.
    Cart {
        parameters { m: kg = 1 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize integral(u^2)
        finally { y == 1[m], dot(y) == 0 }
        horizon 1 [s]
    }
}

#[test]
fn least_effort_of_a_cart_is_linear_in_time_on_every_grid() {
    let cart = Cart::default();
    for intervals in [1, 2, 5] {
        let problem = Problem::of(&cart, intervals);
        let solution = solve(&cart, &problem, &linear());
        // u = 6 (1 - 2 t), and the integral of its square is 12.
        assert!(
            (solution.objective - 12.0).abs() < DIGITS,
            "{}",
            solution.objective
        );
        assert_eq!(solution.controls.len(), intervals + 1);
        let frozen = solve(&cart, &problem, &frozen());
        assert!(
            (frozen.objective - 12.0).abs() < DIGITS,
            "{}",
            frozen.objective
        );
        assert_program(&frozen, DIGITS);
        for (node, u) in solution.controls.iter().enumerate() {
            let expected = 6.0 - 12.0 * node as f64 / intervals as f64;
            assert!((u[0] - expected).abs() < DIGITS, "{u:?} against {expected}");
        }
        let trajectory = &solution.motion.as_ref().unwrap().trajectory;
        for (&t, q) in trajectory.time.iter().zip(&trajectory.q) {
            assert!(
                (q[0] - t * t * (3.0 - 2.0 * t)).abs() < DIGITS,
                "{q:?} at {t}"
            );
        }
        if intervals > 1 {
            // Constant controls lose the share 1 / N^2 of their effort.
            let constant = solve(&cart, &problem, &one_start());
            let expected = 12.0 / (1.0 - 1.0 / (intervals * intervals) as f64);
            assert!((constant.objective - expected).abs() < DIGITS * expected);
        }
    }
}

hangtime::model! {
    /// A cart that is pushed, by one who is in a hurry.
    Hurried {
        parameters { m: kg = 1, w: 1/N^2 = 0.4444444444444444 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time + w*integral(u^2)
        finally { y == 1[m], dot(y) == 0[m/s] }
    }
}

#[test]
fn effort_with_a_price_on_time_has_the_free_final_time_of_the_closed_form() {
    // T + w 12 / T^3 is least for T^4 = 36 w.
    let cart = Hurried::default();
    let solution = solve(&cart, &Problem::of(&cart, 3), &linear());
    // Second-order conditions make the time as accurate as the square root of the objective is.
    assert!(
        (solution.horizon - 2.0).abs() < 1e-6,
        "{}",
        solution.horizon
    );
    assert!(
        (solution.objective - 8.0 / 3.0).abs() < DIGITS,
        "{}",
        solution.objective
    );
}

hangtime::model! {
    /// A cart that must not go further than a ninth of a metre (Bryson, Denham, Dreyfus 1963).
    Confined {
        parameters { m: kg = 1 }
        coordinates { y: m in -1..=1/9 }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize integral(u^2)
        finally { y == 0[m], dot(y) == -1[m/s] }
        start { dot(y): 1 [m/s] }
        horizon 1 [s]
    }
}

#[test]
fn coordinate_that_rests_on_its_bound_follows_the_closed_form() {
    let cart = Confined::default();
    let solution = solve(&cart, &Problem::of(&cart, 3), &linear());
    // For a bound l <= 1/6 the control is -2/(3 l) (1 - t/(3 l)) up to 3 l, then 0, then mirrored: with l = 1/9
    // linear on three intervals, and the integral of its square is 8/(9 l).
    assert!(
        (solution.objective - 8.0).abs() < 1e-6,
        "{}",
        solution.objective
    );
    for (u, expected) in solution.controls.iter().zip([-6.0, 0.0, 0.0, -6.0]) {
        // The objective is flat to second order.
        assert!((u[0] - expected).abs() < 1e-3, "{u:?} against {expected}");
    }
    let excess = most_exceeded(&solution);
    assert!(excess < DIGITS, "{excess}");
}

hangtime::model! {
    /// A cart whose push is limited by a path constraint.
    Limited {
        parameters { m: kg = 1 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        constraint push: 5[N] - u >= 0
        constraint pull: 5[N] + u >= 0
        minimize integral(u^2)
        finally { y == 1[m], dot(y) == 0 }
        horizon 1 [s]
    }
}

#[test]
fn path_constraint_on_linear_controls_holds_from_the_start_on() {
    let cart = Limited::default();
    let solution = solve(&cart, &Problem::of(&cart, 4), &linear());
    // By symmetry u = (a, b, 0, -b, -a), with distance (a + 6 b) / 48 * 2 ... = 1 and the least effort at a = 5.
    assert!(
        (solution.controls[0][0] - 5.0).abs() < DIGITS,
        "{:?}",
        solution.controls
    );
    assert!(
        (solution.controls[4][0] + 5.0).abs() < DIGITS,
        "{:?}",
        solution.controls
    );
    let excess = most_exceeded(&solution);
    assert!(excess < DIGITS, "{excess}");
}

hangtime::model! {
    /// A mass with an engine, on the ground.
    Hopper {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        controls { u: N in 0..=40 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2)
        finally { z == 0.5[m], dot(z) == 0[m/s] }
        horizon 1.2 [s]
    }
}

/// The least effort of the hopper with four intervals and no thrust in the first, by golden section over the thrust at the
/// middle: the ones after it follow from the goals.
fn least_effort_by_search() -> f64 {
    let h: f64 = 0.3;
    let effort = |u2: f64| {
        let slope = u2 / h;
        // From the lift-off to the middle, then two intervals whose ends are affine in (u3, u4).
        let t = h - 9.81 / slope;
        let after = |(z, v): (f64, f64), (a, b): (f64, f64)| {
            let (a, b) = (a - 9.81, b - 9.81);
            (
                z + v * h + h * h * (2.0 * a + b) / 6.0,
                v + h * (a + b) / 2.0,
            )
        };
        let end = |u3: f64, u4: f64| {
            let middle = (slope * t * t * t / 6.0, slope * t * t / 2.0);
            let (z, v) = after(after(middle, (u2, u3)), (u3, u4));
            [z - 0.5, v]
        };
        let (zero, by3, by4) = (end(0.0, 0.0), end(1.0, 0.0), end(0.0, 1.0));
        let [a, b] = [by3[0] - zero[0], by4[0] - zero[0]];
        let [c, d] = [by3[1] - zero[1], by4[1] - zero[1]];
        let determinant = a * d - b * c;
        let u3 = (-zero[0] * d + b * zero[1]) / determinant;
        let u4 = (-a * zero[1] + c * zero[0]) / determinant;
        let square = |a: f64, b: f64| h / 3.0 * (a * a + a * b + b * b);
        square(0.0, u2) + square(u2, u3) + square(u3, u4)
    };
    let (mut from, mut to) = (10.0, 40.0);
    for _ in 0..100 {
        let (a, b) = (from + 0.382 * (to - from), to - 0.382 * (to - from));
        if effort(a) < effort(b) {
            to = b;
        } else {
            from = a;
        }
    }
    effort(from)
}

#[test]
fn hopper_leaves_the_ground_where_the_thrust_carries_it() {
    let hopper = Hopper::default();
    let solution = solve(&hopper, &Problem::of(&hopper, 4), &linear());
    let kinds: Vec<EventKind> = solution
        .planned_events
        .iter()
        .map(|event| event.1)
        .collect();
    assert_eq!(kinds, [EventKind::LiftOff]);
    let mut u = [0.0];
    solution
        .signal()
        .write(solution.planned_events[0].0, &mut u)
        .unwrap();
    assert!((u[0] - 9.81).abs() < 1e-6, "{u:?}");
    assert!(
        solution.resimulation_error < 1e-9,
        "{:e}",
        solution.resimulation_error
    );
    let least = least_effort_by_search();
    assert!(
        (solution.objective - least).abs() < DIGITS * least,
        "{} {least}",
        solution.objective
    );
    // So does the complementarity problem of the time-freezing system, whose clock runs the slower the more the ground carries: the
    // error of its schemes of order 3, 5, 7 is that of a clock which changes its speed during the first interval.
    for (stages, near) in [(2, 1e-3), (3, 1e-5), (4, 1e-7)] {
        let mut settings = frozen();
        let mut formulation = TimeFreezingSettings::default();
        formulation.stages = stages;
        settings.formulation = Formulation::TimeFreezing(formulation);
        let other = solve(&hopper, &Problem::of(&hopper, 4), &settings);
        assert!(
            (other.objective - least).abs() < DIGITS * least,
            "{} {least}",
            other.objective
        );
        assert_program(&other, near);
    }
}

hangtime::model! {
    /// A cart that is pushed away from a wall, back to it and away again, as the wall throws it back.
    Returned {
        parameters { m: kg = 1 }
        coordinates { y: m }
        controls { u: N in -20..=20 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        surface wall: y >= 0
        impact wall: restitution 0.5
        minimize integral(u^2)
        start { y: 1 [m], dot(y): -2 [m/s] }
        finally { y == 1[m], dot(y) == 0 [m/s] }
        horizon 2 [s]
    }
}

#[test]
fn program_of_a_motion_with_an_impact_has_linear_controls_on_both_sides() {
    let cart = Returned::default();
    let solution = solve(&cart, &Problem::of(&cart, 6), &frozen());
    assert!(
        solution
            .planned_events
            .iter()
            .any(|e| e.1 == EventKind::Impact)
    );
    assert_eq!(solution.controls.len(), 7);
    assert_program(&solution, DIGITS);
}

#[test]
fn previous_motion_starts_other_grids_and_shapes() {
    let hopper = Hopper::default();
    let coarse = solve(&hopper, &Problem::of(&hopper, 4), &linear());
    let mut objectives = vec![coarse.objective];
    let mut previous = coarse.previous.unwrap();
    for (intervals, controls) in [
        (8, ControlShape::Linear),
        (8, ControlShape::Constant),
        (16, ControlShape::Linear),
    ] {
        let mut settings = linear();
        settings.controls = controls;
        settings.guess = Guess::Previous(Box::new(previous));
        let solution = solve(&hopper, &Problem::of(&hopper, intervals), &settings);
        // No search: the contact sequence of the motion before is enough.
        assert_eq!(solution.counts.global_iterations, 0);
        assert_eq!(solution.shape, controls);
        objectives.push(solution.objective);
        previous = solution.previous.unwrap();
    }
    // What four linear pieces can do, eight and sixteen can do better.
    assert!(
        objectives[1] < objectives[0] && objectives[3] < objectives[1],
        "{objectives:?}"
    );
}
