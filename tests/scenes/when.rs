//! Conditions that set states and velocities: motions against closed forms by both methods that locate them.

use hangtime::prelude::*;
use hangtime::simulation::{FixedStep, Smooth};
use hangtime_scene_files::of_text;

use super::both::motions;

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
