//! Contacts whose bodies dry friction holds as well: they are left without a force, and the motion goes on when friction gives way.

use super::super::both::ends;
use super::{events, motions};
use hangtime::prelude::*;

#[test]
fn block_that_friction_holds_leaves_the_wall_when_it_is_pulled_harder() {
    // Of 2 kg, pushed to the wall with 4 N - 2 N/s t: friction carries its 0.6 N of it down to 0.6 N, alone from there on, and slips at -0.6 N.
    let text = "coordinates { x: m } lagrangian 2 [kg]*dot(x)^2/2 forces { x: 4 [N] - 2 [N/s]*t }
        surface wall: 0 [m] - x >= 0 [m] impact wall: inelastic dry friction f: bound 0.6 [N], sliding dot(x)
        start { x: 0 } horizon 4 [s]";
    let wanted = [(EventKind::LiftOff, 1.7), (EventKind::Slip, 2.3)];
    for motion in motions(text) {
        events(&motion, &wanted, 1e-9);
        let values = [
            ("x", -1.7_f64.powi(3) / 6.0),
            ("dot(x)", -1.7_f64.powi(2) / 2.0),
        ];
        ends(&motion, &values, 1e-10);
    }
}

#[test]
fn block_that_friction_holds_is_pulled_from_the_wall_by_a_spring() {
    // The other end swings through as cos(w t)/2 - 3/w sin(w t), faster than a step: the spring pulls with -0.25 N when friction gives way.
    let text = "coordinates { a: m, b: m } lagrangian 1 [kg]*(dot(a)^2 + dot(b)^2)/2 - 36 [N/m]*(b - a - 1 [m])^2
        surface right: 2 [m] - b >= 0 [m] impact right: inelastic dry friction f: bound 0.25 [N], sliding dot(b)
        start { a: 1.5, dot(a): -3, b: 2 } horizon 0.2 [s]";
    let w = 72_f64.sqrt();
    // R cos(w t + p) with R cos p = 1/2 and R sin p = 3/w.
    let (size, phase) = (0.5_f64.hypot(3.0 / w), (6.0 / w).atan());
    let time = |pull: f64| ((-pull / 72.0 / size).acos() - phase) / w;
    let wanted = [
        (EventKind::LiftOff, time(-0.25)),
        (EventKind::Slip, time(0.25)),
    ];
    let [one, other] = motions(text);
    events(&one, &wanted, 1e-9);
    events(&other, &wanted, 1e-9);
    let last = other.trajectory.q.last().expect("a motion");
    ends(&one, &[("a", last[0]), ("b", last[1])], 1e-7);
}

#[test]
fn one_of_two_blocks_that_friction_holds_goes_back() {
    // Pushed to the other one with 1.5 N - 2 N/s t; each is held by 1 N.
    let text = "coordinates { a: m, b: m } lagrangian 1 [kg]*(dot(a)^2 + dot(b)^2)/2 forces { a: 1.5 [N] - 2 [N/s]*t }
        surface c: b - a - 1 [m] >= 0 [m] impact c: inelastic
        dry friction f: bound 1 [N], sliding dot(a) dry friction g: bound 1 [N], sliding dot(b)
        start { a: 0, b: 1 } horizon 2 [s]";
    for motion in motions(text) {
        let slip = motion.events.last().expect("an event");
        assert!(slip.kind == EventKind::Slip && (slip.time - 1.25).abs() < 1e-9);
        ends(
            &motion,
            &[("a", -0.75_f64.powi(3) / 3.0), ("b", 1.0)],
            1e-10,
        );
    }
}
