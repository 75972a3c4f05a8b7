//! Derivatives through conditions that set states and velocities, against closed forms.

use std::f64::consts::{PI, TAU};

use hangtime::prelude::*;
use num_dual::{Dual64, DualNum};

use super::closed_forms::{CLOSE, assert_row, bounces, derivatives};
use super::support::{assert_close, assert_exists, by_both, scene};
use super::texts::{HAMMER, THERMOSTAT};

#[test]
fn thermostat_switches_by_its_thresholds() {
    let at = [1.3, 2.0, 1.9, 1.1, 0.2];
    // Heated x goes to h tau, cooled to 0.
    let heated = |p: &[Dual64], from: Dual64| {
        let most = p[0] * p[1];
        p[1] * ((most - from) / (most - p[2])).ln()
    };
    let cooled = |p: &[Dual64]| p[1] * (p[2] / p[3]).ln();
    let time = |p: &[Dual64], event: usize| {
        let mut time = heated(p, p[4]);
        for k in 1..=event {
            time += if k % 2 == 1 {
                cooled(p)
            } else {
                heated(p, p[3])
            };
        }
        time
    };
    for (run, gradient) in by_both(&scene(THERMOSTAT, &[]), &["h", "tau", "warm", "cold", "x0"]) {
        assert_exists(&gradient);
        let count = run.events.len();
        assert!(count == 5 && run.events.iter().all(|e| e.kind == EventKind::When));
        for (event, times) in gradient.event_times.iter().enumerate() {
            assert_row(times, &derivatives(|p| time(p, event), &at), "time");
        }
        // The last one ends the heating.
        let end = |p: &[Dual64]| p[2] * (-(-time(p, count - 1) + 8.0) / p[1]).exp();
        assert_row(&gradient.v[0], &derivatives(end, &at), "end");
        assert_row(&gradient.v[1], &[0.0; 5], "switch");
    }
}

#[test]
fn escapement_that_adds_to_the_speed_of_a_pendulum() {
    let text = "
        parameters { c: 1/s = 0.1, kick: m/s = 0.4, x0: m = -0.5 }
        coordinates { x: m }
        lagrangian (dot(x)^2/2 - x^2/2*1 [1/s^2])*1 [kg]
        forces { x: -c*dot(x)*1 [kg] }
        when x >= 0 [m] { dot(x) = dot(x) + kick }
        start { x: x0 }
        horizon 20 [s]
    ";
    let at = [0.1, 0.4, -0.5];
    let rate = |p: &[Dual64]| (-p[0] * p[0] / 4.0 + 1.0).sqrt();
    let time = |p: &[Dual64], event: usize| {
        let w = rate(p);
        (-(w * 2.0 / p[0]).atan() + PI) / w + Dual64::from(TAU) * event as f64 / w
    };
    // From rest at x0, and from 0 with a speed that a period damps.
    let speed = |p: &[Dual64], event: usize| {
        let w = rate(p);
        let (first, decay) = (time(p, 0), (-p[0] * PI / w).exp());
        let mut v = -p[2] * (-p[0] * first / 2.0).exp() * (w * first).sin() / w + p[1];
        for _ in 0..event {
            v = v * decay + p[1];
        }
        v
    };
    for (run, gradient) in by_both(&scene(text, &[]), &["c", "kick", "x0"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 3, "{run}");
        for (event, times) in gradient.event_times.iter().enumerate() {
            assert_row(times, &derivatives(|p| time(p, event), &at), "time");
        }
        let end = |p: &[Dual64]| {
            let (w, since) = (rate(p), -time(p, 2) + 20.0);
            speed(p, 2) * (-p[0] * since / 2.0).exp() * (w * since).sin() / w
        };
        assert_row(&gradient.q[0], &derivatives(end, &at), "end");
    }
}

#[test]
fn bounces_by_a_condition_are_those_of_a_surface() {
    let text = "
        parameters { m: kg = 2, g: m/s^2 = 9.5, e = 0.7, height: m = 1.3, v0: m/s = 0.4 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        when z <= 0 [m] { dot(z) = -e*dot(z) }
        start { z: height, dot(z): v0 }
        horizon 1.4 [s]
    ";
    let at = [9.5, 0.7, 1.3, 0.4];
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 2, "{run}");
        assert_row(
            &gradient.q[0],
            &derivatives(|p| bounces(p, 1.4, 2).1, &at),
            "height",
        );
        assert_row(
            &gradient.v[0],
            &derivatives(|p| bounces(p, 1.4, 2).2, &at),
            "velocity",
        );
        for (k, times) in gradient.event_times.iter().enumerate() {
            let right = derivatives(|p| bounces(p, 1.4, 2).0[k], &at);
            assert_row(times, &right, "time");
        }
    }
}

#[test]
fn hammer_that_drives_a_ball_onto_the_floor_it_lies_on() {
    let at = [9.6, 0.5, 3.0, 0.9];
    let end = |p: &[Dual64]| {
        let since = -p[3] + 1.1;
        p[1] * p[2] * since - p[0] * since * since / 2.0
    };
    for (_, gradient) in by_both(&scene(HAMMER, &[]), &["g", "e", "v1", "t1"]) {
        assert_exists(&gradient);
        assert_row(&gradient.event_times[0], &[0.0, 0.0, 0.0, 1.0], "time");
        assert_row(&gradient.q[0], &derivatives(end, &at), "end");
    }
}

#[test]
fn what_an_impact_makes_true_sets_what_is_so_behind_it() {
    // The speed behind each impact and its time, of a ball whose speed turns upwards there.
    let text = "
        parameters { m: kg = 2, g: m/s^2 = 9.5, e = 0.7, height: m = 1.3, v0: m/s = 0.4, share = 1.5 }
        coordinates { z: m }
        states { fast: m/s, last: s }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        when dot(z) >= 0 [m/s] { fast = share*dot(z), last = t }
        start { z: height, dot(z): v0 }
        horizon 1.4 [s]
    ";
    let at = [9.5, 0.7, 1.3, 0.4, 1.5];
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "e", "height", "v0", "share"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 4, "{run}");
        let time = |p: &[Dual64]| bounces(p, 1.4, 2).0[1];
        let fast = |p: &[Dual64]| {
            let speed = (p[3] * p[3] + p[0] * p[2] * 2.0).sqrt();
            p[4] * p[1] * p[1] * speed
        };
        assert_row(&gradient.v[1], &derivatives(fast, &at), "speed");
        assert_row(&gradient.v[2], &derivatives(time, &at), "time");
        let right = derivatives(|p| bounces(p, 1.4, 2).1, &at);
        assert_row(&gradient.q[0], &right, "height");
    }
}

#[test]
fn what_is_set_may_make_another_condition_true() {
    let text = "
        parameters { p = 0.8, rate: 1/s = 0.7 }
        states { x, a, b }
        rates { x: rate, b: a*1[1/s] }
        when x >= 1 { a = x + p }
        when a >= 1.5 { b = 2*a }
        start { b: 1 }
        horizon 3 [s]
    ";
    // b = 2 (1 + p) + (1 + p) (3 - 1/rate)
    let end = |p: &[Dual64]| (p[0] + 1.0) * (-p[1].recip() + 5.0);
    for (run, gradient) in by_both(&scene(text, &[]), &["p", "rate"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 2, "{run}");
        assert_row(&gradient.v[2], &derivatives(end, &[0.8, 0.7]), "end");
    }
}

#[test]
fn conditions_that_other_parameters_take_apart_have_no_derivative() {
    let text = "
        parameters { a: 1/s = 0.5, b: 1/s = 0.5 }
        states { x, y, first }
        rates { x: a, y: b }
        when x >= 1 { first = y }
        when y >= 1 { first = 2*x }
        horizon 3 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["a"]) {
        let obstacle = gradient.obstacle.expect("one comes first then");
        assert!(obstacle.contains("change at once"), "{obstacle}");
    }
}

#[test]
fn condition_that_nearly_comes_true_ends_the_range() {
    // The apex is at 1 m after 0.5 s, and rises by 0.5 s times the velocity.
    let text = "
        parameters { g: m/s^2 = 8, v0: m/s = 4, top: m = 1.1 }
        coordinates { z: m }
        states { seen }
        lagrangian 1[kg]*(dot(z)^2/2 - g*z)
        when z >= top { seen = 1 }
        start { dot(z): v0 }
        horizon 1 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["v0", "top"]) {
        assert_exists(&gradient);
        let above = gradient.ranges[0].above.as_ref().expect("it is seen then");
        assert!(above.because.contains("z >= top"), "{above:?}");
        assert_close(above.change, 0.2, CLOSE, "by v0");
        let below = gradient.ranges[1].below.as_ref().expect("it is seen then");
        assert_close(below.change, -0.1, CLOSE, "by top");
    }
}
