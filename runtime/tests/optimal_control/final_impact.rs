//! Motions that end with an impact, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use std::cmp::Ordering;

use crate::root::root;
use crate::support::{one_start, solve as certified};
use hangtime::model::Model;
use hangtime::ocp::{self, ControlShape, Guess, Horizon, Problem, Settings, Solution, Status};
use hangtime::simulation::EventKind;

hangtime::model! {
    /// A mass that is to come to rest on the ground.
    Lander {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: inelastic
        minimize time
        finally { z == 0[m], dot(z) == 0[m/s] }
        start { z: 1 [m] }
    }
}

hangtime::model! {
    /// A ball that is to fly up at a given speed.
    Ball {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: restitution 0.5
        minimize time
        finally { z == 0[m], dot(z) == 2.2[m/s] }
        start { z: 1 [m] }
    }
}

fn solve(model: &dyn Model, settings: &Settings) -> Solution {
    let problem = Problem {
        // The ball is on its way down from its first bounce.
        horizon: Horizon::Free { guess: Some(0.5) },
        ..Problem::of(model, 4)
    };
    let solution = ocp::solve(model, &problem, settings, &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    solution
}

#[test]
fn impact_at_the_final_time_brings_the_motion_to_rest() {
    for controls in [ControlShape::Constant, ControlShape::Linear] {
        let mut settings = one_start();
        settings.controls = controls;
        let solution = solve(&Lander::default(), &settings);
        // It is pushed down all the way, and the ground stops it.
        let time = (2.0_f64 / (9.81 + 1.0)).sqrt();
        assert!(
            (solution.horizon - time).abs() < 1e-8,
            "{} against {time}",
            solution.horizon
        );
        assert_eq!(
            solution.planned_events,
            [(solution.horizon, EventKind::Impact, 0)]
        );
        // So does the motion under its controls, wherever rounding has put the end of that.
        let motion = solution.motion.as_ref().unwrap();
        assert_eq!(motion.trajectory.v.last().unwrap(), &[0.0]);
        let speed = ((9.81 + 1.0) * 2.0_f64).sqrt();
        assert_eq!(motion.events.len(), 1);
        assert!((motion.events[0].v_before[0] + speed).abs() < 1e-7);
        // The motion is a start for others, with the impact where it is.
        settings.guess = Guess::Previous(Box::new(solution.previous.unwrap()));
        let again = solve(&Lander::default(), &settings);
        assert_eq!(again.counts.global_iterations, 0);
        assert!((again.horizon - time).abs() < 1e-8);
    }
}

#[test]
fn bounce_at_the_final_time_gives_the_speed_after_it() {
    // The ground halves the speed, so it has to be met at 4.4 m/s: after a push down in the first two intervals, up in
    // the last, and u in between. With h = T / 4: h (4 g + 1 - u) = 4.4 and h^2 (8 g + 5.5 - 1.5 u) = 1.
    let solution = solve(&Ball::default(), &one_start());
    let g = 9.81;
    let length = |u: f64| 4.4 / (4.0 * g + 1.0 - u);
    let fall = |u: f64| length(u).powi(2) * (8.0 * g + 5.5 - 1.5 * u);
    assert!(fall(-1.0) < 1.0 && fall(1.0) > 1.0);
    let time = 4.0 * length(root(|u| 1.0 - fall(u), -1.0, 1.0));
    assert!(
        (solution.horizon - time).abs() < 1e-8,
        "{} against {time}",
        solution.horizon
    );
    assert_eq!(
        solution.planned_events,
        [(solution.horizon, EventKind::Impact, 0)]
    );
    let motion = solution.motion.unwrap();
    let speed = motion.trajectory.v.last().unwrap()[0];
    assert!((speed - 2.2).abs() < 1e-8, "{speed}");
    assert_eq!(motion.events.len(), 1);
}

hangtime::model! {
    /// A mass in a gust that is to end at rest at a wall; pushing costs more and more.
    Leaning {
        parameters { m: kg = 1, wall: m = 1, gust: N = 3, w: rad/s = 4 }
        coordinates { x: m }
        controls { u: N in -5..=5 }
        lagrangian m/2*dot(x)^2
        forces { x: u + gust*sin(w*t) }
        surface wall: x <= wall
        impact wall: inelastic
        minimize integral((1 + t/1[s])*u^2)
        finally { x == wall, dot(x) == 0 [m/s] }
        start { dot(x): -0.5 [m/s] }
        horizon 1.5 [s]
    }
}

#[test]
fn goal_at_a_surface_is_reached_with_an_impact_where_that_is_cheaper_than_to_brake() {
    for intervals in [8, 12] {
        let leaning = Leaning::default();
        let problem = Problem::of(&leaning, intervals);
        let solution = ocp::solve(&leaning, &problem, &Settings::default(), &mut |_| true).unwrap();
        // With a blow at the end one linear condition is left: x(T) = wall.
        let (end, w) = (1.5_f64, 4.0_f64);
        let alone = -0.5 * end + 3.0 * (end / w - (w * end).sin() / (w * w));
        let length = end / intervals as f64;
        let share = |k: usize| {
            let middle = (k as f64 + 0.5) * length;
            (length * (end - middle)).powi(2) / (length * (1.0 + middle))
        };
        let least = (1.0 - alone).powi(2) / (0..intervals).map(share).sum::<f64>();
        let apart = (solution.objective - least).abs();
        assert!(
            apart < 1e-8,
            "{intervals}: {} instead of {least}",
            solution.objective
        );
    }
}

hangtime::model! {
    /// A freighter that is to lie at a dock which bears no hard blow: it brakes until it gets there.
    Freighter {
        parameters { m: kg = 5000, way: m = 12 [km], bear: kN s = 50 }
        coordinates { y: m }
        controls { u: kN in -2..=2 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        surface dock: y <= way
        impact dock: inelastic
        minimize time
        constraint soft: impulse(dock) <= bear
        finally { y == way, dot(y) == 0 }
        horizon 300 [s]
    }
}

/// Least time of the freighter on `n` intervals: full force in the first `k`, `u` in the next one, and braking after it, with 10 m/s left
/// for the dock. With the step `h` and `a = 0.4 m/s^2` that is `a h (2 k + 1 - n + u) = 10`; distance in `h` has one root.
fn docking(n: usize, k: usize) -> f64 {
    let distance = |h: f64| {
        let mixed = 10.0 / (0.4 * h) + n as f64 - (2 * k + 1) as f64;
        let (mut y, mut v) = (0.0, 0.0);
        for interval in 0..n {
            let a = 0.4
                * match interval.cmp(&k) {
                    Ordering::Less => 1.0,
                    Ordering::Equal => mixed,
                    Ordering::Greater => -1.0,
                };
            y += h * (v + 0.5 * h * a);
            v += h * a;
        }
        y
    };
    let h = root(
        |h| 12_000.0 - distance(h),
        100.0 / n as f64,
        500.0 / n as f64,
    );
    h * n as f64
}

#[test]
fn nothing_lands_before_the_end_where_what_brakes_it_would_pull_it_off_again() {
    for (intervals, mixed) in [(8, 4), (10, 5), (12, 6)] {
        let solution = certified(&Freighter::default(), intervals, &one_start());
        let time = docking(intervals, mixed);
        assert!(
            (solution.horizon - time).abs() < 1e-8 * time,
            "{intervals}: {} instead of {time}",
            solution.horizon
        );
        assert_eq!(solution.planned_events.len(), 1);
    }
}

hangtime::model! {
    /// A door that is closed in a second, no faster than it may be in the end: the motion may end before it slams.
    Door {
        parameters { fastest = 10 }
        coordinates { phi }
        controls { u in -20..=20 }
        lagrangian dot(phi)^2/2
        forces { phi: u }
        surface frame: phi >= 0
        impact frame: inelastic
        minimize integral(u^2) + sum(2*impulse(frame)^2)
        finally { phi == 0, dot(phi) >= -fastest }
        start { phi: 1.5 }
        horizon 1
    }
}

#[test]
fn impact_right_after_the_end_is_said_to_be_no_part_of_the_motion() {
    let door = Door::default();
    let solution = certified(&door, 10, &Settings::default());
    // phi(1) - 1.5 = sum of w_k u_k: the least effort is along w
    let step = 0.1;
    let weights: Vec<f64> = (0..10)
        .map(|k| step * (1.0 - step * (f64::from(k) + 0.5)))
        .collect();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let effort = step * 1.5 * 1.5 / squares;
    assert!((solution.objective - effort).abs() < 1e-8 * effort);
    let velocity = -1.5 * step * weights.iter().sum::<f64>() / squares;
    let struck = solution.struck_after_the_end(&door);
    assert!(
        matches!(struck[..], [(0, found)] if (found - velocity).abs() < 1e-7),
        "{struck:?} instead of {velocity}"
    );

    // to rest
    let closed = Door { fastest: 0.0 };
    let solution = certified(&closed, 10, &Settings::default());
    assert_eq!(solution.struck_after_the_end(&closed), []);
}
