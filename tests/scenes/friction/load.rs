//! Dry friction whose bound follows a control, a velocity or the force of a surface.

use super::{ends, events, motions, motions_under, refusal};
use hangtime::baselines::Moreau;
use hangtime::prelude::*;

#[test]
fn clutch_engages_when_its_control_has_taken_the_difference_of_speeds() {
    let text = "parameters { j1: kg m^2 = 1, j2: kg m^2 = 2 } coordinates { a: rad, b: rad } controls { p: N m in 0..=10 }
        lagrangian j1/2*dot(a)^2 + j2/2*dot(b)^2
        dry friction clutch: bound p, sliding dot(a) - dot(b)
        start { dot(a): 100 [rad/s] } outputs { energy: J = j1/2*dot(a)^2 + j2/2*dot(b)^2 } horizon 15 [s]";
    // A torque that grows by c a second: (1/j1 + 1/j2) c t^2/2 = 100.
    let c = 1.2;
    let controls = ControlSignal::PiecewiseLinear {
        times: vec![0.0, 15.0],
        values: vec![vec![0.0], vec![15.0 * c]],
    };
    let time = (2.0 * 100.0 / (1.5 * c)).sqrt();
    for motion in motions_under(text, None, &controls) {
        events(&motion, &[(EventKind::Stick, time)], 1e-7);
        let heat = 5000.0 - motion.at(15.0).expect("the end")["energy"];
        // j1 j2/(j1 + j2)/2 100^2, of an energy of 5000 J.
        assert!((heat - 1e4 / 3.0).abs() < 1e-5, "{heat}");
        ends(
            &motion,
            &[("dot(a)", 100.0 / 3.0), ("dot(b)", 100.0 / 3.0)],
            1e-7,
        );
    }
}

#[test]
fn clutch_slips_again_where_its_control_falls() {
    // The torque of the engine wants (j2/(j1 + j2)) 3 N m through the clutch, which lets go below that.
    let text = "parameters { j1: kg m^2 = 1, j2: kg m^2 = 2 } coordinates { a: rad, b: rad } controls { p: N m in 0..=10 }
        lagrangian j1/2*dot(a)^2 + j2/2*dot(b)^2 forces { a: 3 [N m] }
        dry friction clutch: bound p, sliding dot(a) - dot(b) horizon 4 [s]";
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![2.5], vec![1.5]],
    };
    for motion in motions_under(text, None, &controls) {
        events(&motion, &[(EventKind::Slip, 1.0)], 1e-12);
        // Then a'' = 3 - 1.5 and b'' = 0.75.
        ends(
            &motion,
            &[("dot(a)", 1.0 + 4.5), ("dot(b)", 1.0 + 2.25)],
            1e-9,
        );
    }
}

/// A wheel between pads that are pressed by a force which changes with time.
const BRAKE: &str = "parameters { m: kg = 2, j: kg m^2 = 0.1, r: m = 0.2, mu = 0.4, f: N = 12, g: m/s^2 = 9.81 }
    coordinates { z: m, w: rad } lagrangian m/2*dot(z)^2 + j/2*dot(w)^2 - m*g*z
    forces { z: -f*(1 + sin(t/1 [s])/2) } surface pad: z >= 0 impact pad: inelastic
    dry friction brake: bound mu*r*force(pad), sliding dot(w) start { dot(w): 30 [rad/s] } horizon 3 [s]";

/// When the wheel has stopped: `0.8 ((m g + f) t + f (1 - cos t)/2) = 30`, by Newton's method.
fn stops() -> f64 {
    let mut time = 1.0_f64;
    for _ in 0..20 {
        let taken = 0.8 * (31.62 * time + 6.0 * (1.0 - time.cos()));
        time -= (taken - 30.0) / (0.8 * (31.62 + 6.0 * time.sin()));
    }
    time
}

#[test]
fn wheel_stops_when_pads_that_are_pressed_have_taken_its_momentum() {
    for motion in motions(BRAKE) {
        events(&motion, &[(EventKind::Stick, stops())], 1e-8);
        // The bound is recorded as its normal force.
        let bound = 0.08 * (31.62 + 6.0 * 3.0_f64.sin());
        ends(&motion, &[("dot(w)", 0.0), ("force(brake)", bound)], 1e-8);
    }
    let moreau = Moreau {
        steps: 3000,
        ..Moreau::default()
    };
    let motion = simulate(&super::scene(BRAKE))
        .method(moreau)
        .run()
        .expect("a scene");
    // First order: a step of 1 ms beside a second.
    let stopped = motion
        .trajectory
        .v
        .iter()
        .position(|v| v[1] == 0.0)
        .expect("it stops");
    assert!((motion.trajectory.time[stopped] - stops()).abs() < 3e-3);
}

#[test]
fn pads_that_lift_off_brake_no_longer() {
    // The pad is pulled away at t = 1 s; the torque until then is mu r m g.
    let text = "parameters { m: kg = 2, j: kg m^2 = 0.1, r: m = 0.2, mu = 0.4, g: m/s^2 = 9.81 } controls { u: N }
        coordinates { z: m, w: rad } lagrangian m/2*dot(z)^2 + j/2*dot(w)^2 - m*g*z forces { z: u }
        surface pad: z >= 0 impact pad: inelastic
        dry friction brake: bound mu*r*force(pad), sliding dot(w) start { dot(w): 30 [rad/s] } horizon 1.5 [s]";
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![0.0], vec![30.0]],
    };
    for motion in motions_under(text, None, &controls) {
        ends(
            &motion,
            &[
                ("dot(w)", 30.0 - 0.8 * 19.62),
                ("friction_force(brake)", 0.0),
            ],
            1e-9,
        );
    }
}

#[test]
fn bound_of_the_speed_is_the_friction_of_a_damper_that_also_holds() {
    // v' = -(1 + v): v = 2 exp(-t) - 1 from v = 1, at rest from t = ln 2 on.
    let text = "parameters { m: kg = 1, f: N = 1, c: N s/m = 1 } coordinates { x: m } lagrangian m/2*dot(x)^2
        dry friction rail: bound f + c*speed, sliding dot(x) start { dot(x): 1 } horizon 2 [s]";
    for motion in motions(text) {
        events(&motion, &[(EventKind::Stick, 2.0_f64.ln())], 1e-7);
        ends(&motion, &[("x", 1.0 - 2.0_f64.ln())], 1e-7);
    }
}

#[test]
fn bounds_that_make_no_sense_are_refused_with_what_to_write() {
    for (bound, words) in [
        ("mu*r*force(pad)^2/1 [N]", "no sum of forces of surfaces"),
        ("-mu*r*force(pad)", "change the sign"),
        ("mu*r*impulse(pad)/1 [s]", "normal forces of surfaces"),
        ("0.4*force(pad)", "bound of `brake`"),
    ] {
        let message = refusal(&BRAKE.replace("mu*r*force(pad)", bound));
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(message.contains(words), "{bound}: {message}");
    }
}
