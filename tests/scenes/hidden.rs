//! What is over between the places that long steps look at, and what has no motion after it: narrow forces and bumps, conditions that come
//! true infinitely often.

use hangtime::prelude::*;

use super::both::{ends, motions, scene};

#[test]
fn magnet_that_is_passed_in_a_hundredth_of_the_motion_gives_its_energy() {
    // v^2 = v_0^2 + 2 F w sqrt(pi)/m.
    let (mass, speed, force) = (2.0_f64, 1.5_f64, 15.0_f64);
    for width in [0.08_f64, 0.3, 2.0] {
        let text = format!(
            "parameters {{ m: kg = {mass}, x0: m = 41.3, w: m = {width}, f: N = {force} }} coordinates {{ x: m }}
            lagrangian m/2*dot(x)^2 forces {{ x: f*exp(-((x - x0)/w)^2) }} start {{ dot(x): {speed} }} horizon 60 [s]"
        );
        let root_pi = std::f64::consts::PI.sqrt();
        let end = (speed.powi(2) + 2.0 * force * width * root_pi / mass).sqrt();
        for motion in motions(&text) {
            // The promise of a run: 1e-6 of the largest velocity.
            ends(&motion, &[("dot(x)", end)], 1e-6 * end);
        }
    }
}

#[test]
fn push_of_a_moment_is_not_stepped_over() {
    // An impulse of 1 N s at 21.7 s moves 1 kg from then on; the mean place of the push is its middle.
    let text = "parameters { m: kg = 1, t0: s = 21.7, w: s = 0.1 } coordinates { x: m } lagrangian m/2*dot(x)^2
        forces { x: 1[N s]/w*exp(-((t - t0)/w)^2)/sqrt(3.141592653589793) } horizon 80 [s]";
    for motion in motions(text) {
        ends(&motion, &[("x", 80.0 - 21.7), ("dot(x)", 1.0)], 6e-5);
    }
}

#[test]
fn bump_that_a_sliding_block_does_not_pass_turns_it_back() {
    // The bump is higher than v^2/(2 g): the block comes back with its speed.
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81, h: m = 0.09, w: m = 0.15, x0: m = 33.1, v: m/s = 1 }
        coordinates { x: m, z: m } lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface ground: z >= h*exp(-((x - x0)/w)^2) impact ground: inelastic start { dot(x): v } horizon 50 [s]";
    let motion = simulate(&scene(text)).run().unwrap();
    assert!(motion.status.is_solved(), "{}", motion.status);
    ends(&motion, &[("dot(x)", -1.0)], 1e-6);
    assert!(motion.events.is_empty(), "{:?}", motion.events);
}

#[test]
fn conditions_that_come_true_infinitely_often_end_in_a_status() {
    let ball = "parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.6 } coordinates { z: m } lagrangian m/2*dot(z)^2 - m*g*z
        when z <= 0 [m] { dot(z) = -e*dot(z) } start { z: 1 } horizon 6 [s]";
    let tanks = "parameters { v1: m/s = 0.5, v2: m/s = 0.4, w: m/s = 0.75, low: m = 0 } states { a: m, b: m, left }
        rates { a: w*left - v1, b: w*(1 - left) - v2 } when a <= low { left = 1 } when b <= low { left = 0 }
        start { a: 1, b: 1, left: 1 } horizon 20 [s]";
    let fall = (2.0_f64 / 9.81).sqrt();
    // The hose brings 0.15 m/s less than what leaves, of 2 m.
    for (text, end) in [(ball, fall * 1.6 / 0.4), (tanks, 2.0 / 0.15)] {
        let model = scene(text);
        for event_driven in [false, true] {
            let run = simulate(&model);
            let run = if event_driven {
                run.method(EventDriven::default())
            } else {
                run
            };
            let motion = run.run().unwrap();
            assert_eq!(motion.status.name(), "event_limit", "{}", motion.status);
            let diagnosis = motion.status.diagnosis().unwrap();
            assert!(
                (diagnosis.time - end).abs() < 1e-3,
                "{} {end}",
                diagnosis.time
            );
            assert!(
                diagnosis.message.contains("infinitely often"),
                "{}",
                diagnosis.message
            );
        }
    }
}

#[test]
fn root_that_leaves_its_domain_on_the_way_is_named() {
    let tank = "parameters { area: m^2 = 0.5, hole: m^2 = 0.01, g: m/s^2 = 9.81 } states { h: m }
        rates { h: -hole*sqrt(2*g*h)/area } start { h: 1 } horizon 60 [s]";
    let rope = "parameters { m: kg = 1, k: N = 1 } coordinates { y: m } lagrangian m/2*dot(y)^2
        forces { y: k*sqrt(1 - t/1[s]) } horizon 2 [s]";
    // h = (1 - t/T)^2 with T = area/hole sqrt(2/g).
    for (text, end) in [(tank, 50.0 * (2.0_f64 / 9.81).sqrt()), (rope, 1.0)] {
        let motion = simulate(&scene(text)).run().unwrap();
        assert_eq!(motion.status.name(), "not_finite", "{}", motion.status);
        let time = motion.status.diagnosis().unwrap().time;
        assert!((time - end).abs() < 1e-3, "{time} {end}");
    }
}
