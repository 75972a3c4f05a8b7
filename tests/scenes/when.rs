//! Conditions that set states and velocities: motions against closed forms by both methods that locate them.

use hangtime::baselines::{FixedStep, Smooth};
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

use super::both::{ends, motions, motions_under};

fn end(motion: &Simulation, name: &str) -> f64 {
    let time = *motion.trajectory.time.last().expect("a motion");
    motion.at(time).expect("its end")[name]
}

#[test]
fn escapement_gives_a_pendulum_its_speed_back() {
    // Each time it swings through upwards it gets the speed 1: between, a damped half period scales the amplitude.
    let text = "parameters { c: 1/s = 0.1 } coordinates { x: m } lagrangian (dot(x)^2/2 - x^2/2*1 [1/s^2])*1 [kg]
        forces { x: -c*dot(x)*1 [kg] } when x >= 0 [m] { dot(x) = 1 [m/s] } start { x: -0.5 } horizon 20 [s]";
    let c = 0.1_f64;
    let w = (1.0 - c * c / 4.0).sqrt();
    // From x = -1/2 at rest it is at 0 when tan(w t) = -2 w/c, in the second quadrant.
    let first = (std::f64::consts::PI - (2.0 * w / c).atan()) / w;
    let period = std::f64::consts::TAU / w;
    let count = ((20.0 - first) / period).floor();
    let t = 20.0 - first - count * period;
    let x = (-c * t / 2.0).exp() * (w * t).sin() / w;
    for motion in motions(text) {
        assert_eq!(motion.events.len() as f64, count + 1.0);
        assert!(motion.events.iter().all(|e| e.kind == EventKind::When));
        assert!(
            motion.residuals.primal < 1e-9,
            "{}",
            motion.residuals.primal
        );
        for (k, event) in motion.events.iter().enumerate() {
            let time = first + k as f64 * period;
            assert!((event.time - time).abs() < 1e-6, "{event} for {time}");
        }
        assert!((end(&motion, "x") - x).abs() < 1e-6);
    }
}

#[test]
fn condition_that_an_impact_makes_true_sets_as_well_and_counts() {
    // A ball with e = 1/2 from 1 m: its speed turns upwards at each impact, which is counted.
    let text = "parameters { g: m/s^2 = 2 } coordinates { z: m } states { count } lagrangian (dot(z)^2/2 - g*z)*1 [kg]
        surface floor: z >= 0 impact floor: restitution 0.5 when dot(z) >= 0 [m/s] { count = count + 1 }
        start { z: 1 } horizon 2.7 [s]";
    // Falls 1 s; flies 1 s, then 1/2 s, then 1/4 s.
    for motion in motions(text) {
        assert_eq!(end(&motion, "count"), 3.0);
        let counted = motion.events.iter().filter(|e| e.kind == EventKind::When);
        let times: Vec<f64> = counted.map(|event| event.time).collect();
        for (found, time) in times.iter().zip([1.0, 2.0, 2.5]) {
            assert!((found - time).abs() < 1e-7, "{times:?}");
        }
    }
}

#[test]
fn what_is_set_may_make_the_next_condition_true_at_once() {
    let text = "states { x, a, b } rates { x: 1 [1/s] } when x >= 1 { a = x + 1 } when a >= 1.5 { b = 2*a } start { b: 1 } horizon 3 [s]";
    for motion in motions(text) {
        assert!(
            motion.residuals.primal < 1e-12,
            "{}",
            motion.residuals.primal
        );
        assert!((end(&motion, "a") - 2.0).abs() < 1e-9 && (end(&motion, "b") - 4.0).abs() < 1e-9);
        assert_eq!(motion.events.len(), 2);
    }
}

#[test]
fn thrown_ball_strikes_what_it_is_thrown_at_at_once() {
    // At t = 1 a ball that lies on a floor gets the speed -3 of a hammer, and bounces with half of it.
    let text = "parameters { g: m/s^2 = 10 } coordinates { z: m } lagrangian (dot(z)^2/2 - g*z)*1 [kg] surface floor: z >= 0
        impact floor: restitution 0.5 when t >= 1 [s] { dot(z) = -3 [m/s] } horizon 1.2 [s]";
    for motion in motions(text) {
        let z = 1.5 * 0.2 - 5.0 * 0.04;
        assert!(
            (end(&motion, "z") - z).abs() < 1e-9,
            "{}",
            end(&motion, "z")
        );
    }
}

/// The motion by finite elements on grids whose ends, of elements or of steps, are at 1, and by the methods that choose their steps.
fn on_every_grid(text: &str, controls: &ControlSignal) -> Vec<Simulation> {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut runs = motions_under(text, None, controls).to_vec();
    for (steps, elements) in [(2, 1), (1, 2), (4, 3)] {
        let method = Fesd {
            steps: Some(steps),
            elements,
            ..Fesd::default()
        };
        let run = simulate(&scene).controls(controls.clone()).method(method);
        let run = run.run().expect("accepted");
        assert!(run.status.is_solved(), "{}", run.status);
        runs.push(run);
    }
    runs
}

#[test]
fn condition_that_comes_true_together_with_a_switch_sets_once() {
    // The function of the condition vanishes where another switch, or a jump of the controls, is at the same time.
    let constant = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![1.0], vec![3.0]],
    };
    let none = &ControlSignal::Zero;
    let cases = [
        (
            "states { x, seen } rates { x: if t >= 1 [s] { 3 [1/s] } else { 1 [1/s] } }",
            none,
        ),
        (
            "states { x, seen } controls { u } rates { x: u*1 [1/s] }",
            &constant,
        ),
        (
            "states { x, seen } rates { x: 1 [1/s] + 2 [1/s^2]*max(0 [s], t - 1 [s]) }",
            none,
        ),
    ];
    for (scene, controls) in cases {
        let text = format!("{scene} when x >= 1 {{ seen = seen + x }} horizon 2 [s]");
        for motion in on_every_grid(&text, controls) {
            ends(&motion, &[("seen", 1.0)], 1e-9);
            let sets = |event: &&Event| event.kind == EventKind::When;
            assert_eq!(motion.events.iter().filter(sets).count(), 1, "{motion}");
        }
    }
}

#[test]
fn condition_on_a_time_where_controls_jump_sets_what_is_seen_then() {
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![0.25], vec![0.75]],
    };
    let text = "states { x, seen } controls { u } rates { x: u*1 [1/s] } when t >= 1 [s] { seen = x } horizon 2 [s]";
    for motion in on_every_grid(text, &controls) {
        ends(&motion, &[("seen", 0.25), ("x", 1.0)], 1e-9);
    }
}

#[test]
fn blow_at_a_jump_of_the_controls_strikes_the_floor_at_once() {
    // The ball lies on the floor until the controls jump, where it gets the speed -3 and bounces with half of it.
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![0.0], vec![4.0]],
    };
    let text = "parameters { g: m/s^2 = 10 } states { x } coordinates { z: m } controls { u } rates { x: 1 [1/s] }
        lagrangian (dot(z)^2/2 - g*z)*1 [kg] forces { z: u*1 [N] } surface floor: z >= 0
        impact floor: restitution 0.5 when x >= 1 { dot(z) = -3 [m/s] } horizon 1.2 [s]";
    for motion in on_every_grid(text, &controls) {
        ends(&motion, &[("z", 1.5 * 0.2 - 3.0 * 0.04)], 1e-9);
    }
}

#[test]
fn condition_sets_once_where_it_comes_true_again_at_zero() {
    // From 0 down to -1 and back to 0, which rounding misses by less than any size of the state: it sets there, at 2, and not at the start.
    let text = "states { x, seen } rates { x: if t >= 1 [s] { 1 [1/s] } else { -1 [1/s] } } when x >= 0 { seen = seen + 5 } horizon 3 [s]";
    for motion in on_every_grid(text, &ControlSignal::Zero) {
        ends(&motion, &[("seen", 5.0), ("x", 1.0)], 1e-9);
        let mut sets = motion.events.iter().filter(|e| e.kind == EventKind::When);
        assert!(sets.all(|event| (event.time - 2.0).abs() < 1e-9));
    }
}

#[test]
fn condition_that_holds_at_the_start_or_comes_true_at_the_end_sets_nothing() {
    for condition in ["x >= 0", "x >= -1", "t >= 0 [s]", "x >= 2", "t >= 2 [s]"] {
        let text = format!(
            "states {{ x, seen }} rates {{ x: 1 [1/s] }} when {condition} {{ seen = 5 }} horizon 2 [s]"
        );
        for motion in on_every_grid(&text, &ControlSignal::Zero) {
            ends(&motion, &[("seen", 0.0)], 1e-12);
            assert!(motion.events.is_empty(), "{motion}");
        }
    }
}

/// The optimum of a scene.
fn optimum(text: &str, intervals: usize) -> hangtime::ocp::Solution {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let solution = solve(&scene).intervals(intervals).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

#[test]
fn car_with_hysteresis_comes_to_its_goal_in_the_time_of_its_closed_form() {
    // Up to 12 with 4, to 16 with 8; down to 8 with 8, to 0 with 4: 3 + 1/2 s and 1 + 2 s; 1 s at 16 between, on nodes of half a second.
    let way = 18.0 + 7.0 + 16.0 + 12.0 + 8.0;
    let text = format!(
        "parameters {{ way: m = {way} }} states {{ q: m, v: m/s in 0..=16, turbo }} controls {{ u: m/s^2 in -4..=4 }}
        rates {{ q: v, v: u*(1 + turbo) }} when v >= 12 [m/s] {{ turbo = 1 }} when v <= 8 [m/s] {{ turbo = 0 }}
        minimize time finally {{ q == way, v == 0 [m/s] }} horizon 8 [s]"
    );
    let solution = optimum(&text, 15);
    // Phases keep a distance of some billionths from nodes.
    assert!((solution.objective - 7.5).abs() < 1e-7, "{solution}");
    let events = &solution.motion.as_ref().expect("a motion").events;
    assert!(events.iter().all(|event| event.kind == EventKind::When));
    assert_eq!(events.len(), 2);
}

#[test]
fn thermostat_that_has_to_switch_off_heats_with_the_least_energy() {
    // It cools from 21 to 20 for 10 ln(21/20) s; before, the heater brings x from 15 to 21, constant over each of four seconds, of which the last
    // one counts as a whole: (integral of w u)^2 over the sum of the squares of the integrals of w.
    let text = "parameters { loss = 0.1 } states { x, on } controls { power in 0..=9 } rates { x: power*on - loss*x }
        when x >= 21 { on = 0 } when x <= 14 { on = 1 } start { x: 15, on: 1 } minimize integral(power^2)
        finally { x == 20, on == 0 } horizon 4 [s]";
    let off = 4.0 - 10.0 * 1.05_f64.ln();
    let weight =
        |from: f64, to: f64| ((-0.1 * (off - to)).exp() - (-0.1 * (off - from)).exp()) / 0.1;
    let weights = [0.0, 1.0, 2.0, 3.0].map(|from| weight(from, off.min(from + 1.0)));
    let heat = 21.0 - 15.0 * (-0.1 * off).exp();
    let least = heat * heat / weights.iter().map(|w| w * w).sum::<f64>();
    let solution = optimum(text, 4);
    assert!(
        (solution.objective - least).abs() < 1e-7 * least,
        "{} for {least}",
        solution.objective
    );
}

#[test]
fn bounce_that_a_condition_sets_is_that_of_a_wall() {
    let wall = |law: &str| {
        format!(
            "coordinates {{ x: m }} controls {{ u: N in -3..=3 }} lagrangian dot(x)^2*1 [kg] forces {{ x: u }} {law}
            minimize integral(u^2) finally {{ x == 0.2 [m], dot(x) <= -1.1 [m/s] }} horizon 2 [s]"
        )
    };
    let set = optimum(&wall("when x >= 1 [m] { dot(x) = -dot(x)/2 }"), 4);
    let struck = optimum(
        &wall("surface wall: x <= 1 [m] impact wall: restitution 0.5"),
        4,
    );
    let apart = (set.objective - struck.objective).abs();
    assert!(apart < 1e-8 * struck.objective, "{set} {struck}");
}

#[test]
fn condition_that_comes_true_at_a_jump_of_the_controls_sets_in_the_replay_as_well() {
    // A push of 1 until a time that is a node, and a state that is set there: what is seen then.
    let text = "states { x, seen } controls { u in 0..=1 } rates { x: u*1 [1/s] } when t >= 1 [s] { seen = x } minimize integral(u^2)
        finally { x == 1, seen == 0.25 } horizon 2 [s]";
    let solution = optimum(text, 2);
    assert!(
        (solution.objective - (0.0625 + 0.5625)).abs() < 1e-9,
        "{solution}"
    );
}

#[test]
fn methods_that_locate_nothing_refuse_conditions_by_name() {
    let text = "states { x, on } rates { x: 1 [1/s] } when x >= 1 { on = 1 } horizon 2 [s]";
    let scene = of_text("scene.hang", text).expect("a scene");
    for refused in [
        simulate(&scene).method(FixedStep::default()).run(),
        simulate(&scene).method(Smooth::default()).run(),
    ] {
        let why = refused.expect_err("refused").to_string();
        assert!(why.contains("`when x >= 1`"), "{why}");
    }
}
