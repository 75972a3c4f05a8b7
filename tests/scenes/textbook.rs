//! Systems of textbooks and benchmarks, written as their authors would: against closed forms, against scipy, and against the digits of the
//! literature.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

use super::both::{ends, motions};

fn optimum(text: &str, intervals: usize, controls: ControlShape) -> Solution {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let solve = solve(&scene).intervals(intervals).controls(controls);
    let solution = solve.run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

#[test]
fn slide_of_least_time_is_a_cycloid() {
    // To a line at a distance d it takes sqrt(pi d/g) (Bernoulli 1696), to a point the cycloid through it; the direction turns evenly along
    // either, so that controls that are linear on intervals are exact.
    let text = |goal: &str| {
        format!(
            "parameters {{ g: m/s^2 = 9.81 }} states {{ x: m, y: m, v: m/s }} controls {{ angle: rad in -0.2..=3.2 }}
            rates {{ x: v*sin(angle), y: v*cos(angle), v: g*cos(angle) }}
            minimize time finally {{ {goal} }} horizon 1 [s]"
        )
    };
    let line = optimum(&text("x == 1.3 [m]"), 4, ControlShape::Linear);
    let least = (std::f64::consts::PI * 1.3 / 9.81).sqrt();
    assert!((line.objective - least).abs() < 1e-7, "{line} {least}");
    // (s - sin s)/(1 - cos s) = x/y.
    let (x, y) = (1.0_f64, 0.8);
    let (mut low, mut high) = (1e-3, std::f64::consts::TAU - 1e-3);
    for _ in 0..100 {
        let s: f64 = 0.5 * (low + high);
        if (s - s.sin()) / (1.0 - s.cos()) < x / y {
            low = s;
        } else {
            high = s;
        }
    }
    let least = low * (y / (1.0 - low.cos()) / 9.81).sqrt();
    let point = optimum(&text("x == 1 [m], y == 0.8 [m]"), 4, ControlShape::Linear);
    assert!((point.objective - least).abs() < 1e-7, "{point} {least}");
}

#[test]
fn rocket_of_goddard_climbs_as_high_as_published() {
    // In units of its own (COPS 3.0, Dolan, More, Munson 2004): 1.01283.
    let text = "parameters { drag = 310, scale = 500, jet = 0.5, empty = 0.6, most = 3.5 }
        states { h, v, m } controls { thrust in 0..=most }
        rates { h: v, v: (thrust - drag*v^2*exp(-scale*(h - 1)))/m - 1/h^2, m: -thrust/jet }
        start { h: 1, m: 1 }
        minimize -h
        finally { m == empty, time <= 1 }
        horizon 0.2";
    let solution = optimum(text, 20, ControlShape::Constant);
    assert!((-solution.objective - 1.01283).abs() < 1e-5, "{solution}");
}

#[test]
fn hang_glider_comes_as_far_as_published_up_to_its_grid() {
    // 1248.03 m with hundreds of intervals (COPS 3.0); with twenty no more than that.
    let text = "parameters { m: kg = 100, g: m/s^2 = 9.80665, s: m^2 = 14, rho: kg/m^3 = 1.13, c0 = 0.034, k = 0.069662, up: m/s = 2.5, r: m = 100 }
        states { x: m, y: m, vx: m/s, vy: m/s } controls { cl in 0..=1.4 }
        let far = (x/r - 2.5)^2
        let w = vy - up*(1 - far)*exp(-far)
        let flow = rho*s/2*sqrt(vx^2 + w^2)
        let drag = (c0 + k*cl^2)*flow
        rates { x: vx, y: vy, vx: (-cl*flow*w - drag*vx)/m, vy: (cl*flow*vx - drag*w)/m - g }
        start { y: 1000 [m], vx: 13.227567500, vy: -1.2875005200 }
        minimize -x
        finally { y == 900 [m], vx == 13.227567500 [m/s], vy == -1.2875005200 [m/s], time <= 150 [s] }
        horizon 100 [s]";
    let solution = optimum(text, 20, ControlShape::Linear);
    let far = -solution.objective;
    assert!((1246.0..1248.04).contains(&far), "{solution}");
}

#[test]
fn hysteresis_of_bouc_and_wen_agrees_with_another_integrator() {
    let text = "coordinates { x } states { z } lagrangian dot(x)^2/2 - x^2/8
        forces { x: 1.3*cos(0.9*t) - 0.1*dot(x) - 0.75*z }
        rates { z: dot(x) - 0.6*|dot(x)|*z - 0.4*dot(x)*|z| } start { dot(x): 0.3, z: 0.1 } horizon 20";
    for motion in motions(text) {
        // tools/peers/textbook.py. A default run promises 1e-6 of the largest values, about 3.
        let wanted = [
            ("x", -2.856_447_017_5),
            ("dot(x)", -0.402_992_250_7),
            ("z", -0.991_275_415_7),
        ];
        ends(&motion, &wanted, 3e-6);
    }
}

#[test]
fn voice_coil_that_rubs_agrees_with_another_integrator() {
    // Kirches 2006: two masses on a spring, the first of which rubs and is driven by a coil with an inductance.
    let text = "parameters { m1: kg = 1.03, m2: kg = 0.56, k: N/m = 2400, kf: N/A = 12, rub: N = 2.1, r: Ohm = 2, ell: H = 0.002 }
        coordinates { x1: m, x2: m } states { i: A }
        lagrangian m1/2*dot(x1)^2 + m2/2*dot(x2)^2 - k/2*(x1 - x2)^2
        dry friction rail: bound rub, sliding dot(x1)
        forces { x1: kf*i }
        rates { i: (5 [V]*cos(400 [rad/s]*t) - r*i - kf*dot(x1))/ell }
        horizon 0.04 [s]";
    for motion in motions(text) {
        // tools/peers/textbook.py; currents of some amperes, 1e-6 of which are promised.
        let wanted = [
            ("x1", 1.271_545_712_3e-4, 1e-9),
            ("x2", -6.574_823_582e-6, 1e-9),
            ("dot(x1)", -1.117_918_107_4e-2, 1e-7),
            ("dot(x2)", -5.969_999_879_7e-3, 1e-7),
            ("i", -2.399_534_262_8, 3e-6),
        ];
        for (name, value, promise) in wanted {
            ends(&motion, &[(name, value)], promise);
        }
    }
}

#[test]
fn race_car_on_grass_agrees_with_another_integrator() {
    // Beside a track of half width 1 grass brakes three times as much (as for the car that Schumacher drives in nosnoc's examples).
    let text = "parameters { half: m = 1 } states { x: m, y: m, angle: rad, v: m/s }
        let brake = if y^2 >= half^2 { 0.3 [1/m] } else { 0.1 [1/m] }
        rates { x: v*cos(angle), y: v*sin(angle), angle: 0.5 [rad/m]*cos(t*1 [rad/s])*v/3, v: 2 [m/s^2] - brake*v^2/2 }
        start { v: 2 } horizon 8 [s]";
    for motion in motions(text) {
        // tools/peers/textbook.py.
        let times: Vec<f64> = motion.events.iter().map(|event| event.time).collect();
        let wanted = [
            1.262_364_070_9,
            4.395_848_030_8,
            5.127_091_855_3,
            7.837_713_856_8,
        ];
        let near = |(found, wanted): (&f64, &f64)| (found - wanted).abs() < 1e-5;
        assert!(
            times.len() == 4 && times.iter().zip(&wanted).all(near),
            "{times:?}"
        );
        let wanted = [
            ("x", 26.781_517_606_7),
            ("y", -0.670_318_058_7),
            ("v", 3.898_548_595_3),
        ];
        ends(&motion, &wanted, 3e-5);
    }
}

#[test]
fn vessel_that_drifts_onto_an_island_follows_its_shore() {
    // A projected system: the current carries it until it lies on the shore, which takes what leads inland; a push that is strong enough does the
    // same by Filippov's rule. Along the shore tan(s/2) grows as exp(-U t/r), and at s = pi/2 the current leads away.
    let (speed, radius, x, y) = (0.7_f64, 1.5_f64, -4.0_f64, 0.2_f64);
    let text = format!(
        "parameters {{ speed: m/s = {speed}, radius: m = {radius} }} states {{ x: m, y: m }}
        let r = sqrt(x^2 + y^2)
        let push = if r >= radius {{ 0 [m/s] }} else {{ 2*speed }}
        rates {{ x: speed + push*x/r, y: push*y/r }} start {{ x: {x}, y: {y} }} horizon 12 [s]"
    );
    let lands = (-(radius * radius - y * y).sqrt() - x) / speed;
    let angle = y.atan2(-(radius * radius - y * y).sqrt());
    let along = radius / speed * (angle / 2.0).tan().ln();
    for motion in motions(&text) {
        let events: Vec<(EventKind, f64)> =
            motion.events.iter().map(|e| (e.kind, e.time)).collect();
        let wanted = [
            (EventKind::Slide, lands),
            (EventKind::Switch, lands + along),
        ];
        assert_eq!(events.len(), 2, "{motion}");
        for ((kind, time), (wanted, when)) in events.iter().zip(wanted) {
            assert!(
                *kind == wanted && (time - when).abs() < 2e-5,
                "{motion} {when}"
            );
        }
        ends(
            &motion,
            &[("x", speed * (12.0 - lands - along)), ("y", radius)],
            2e-5,
        );
    }
}
