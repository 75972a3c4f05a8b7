//! Derivatives of joints and closed loops against those of fewer coordinates, those at the instant of an impact, and requests without sense.

use hangtime::prelude::*;

use super::support::{assert_exists, assert_row, by_both, scene};
use super::texts::CEILING;
use crate::four_bar::{CRANK, RODS, SIZES};

/// Where the crank begins, how much it bounces off its stop, and the middle of the rocker.
const SEEN: &str = "
    parameters { t0: rad = 1.2, e = 0.5 }
    surface stop: t1 >= 0.2 [rad]
    impact stop: restitution e
    outputs { y3: m = c3.y, z3: m = c3.z }
    horizon 1.1 [s]
";

/// The start of the loop, where two circles meet.
const CLOSED: &str = "
    let e0 = (a*cos(t0) - d, a*sin(t0))
    let w0 = c^2 - |e0|^2 - b^2
    let s0 = sqrt(4*b^2*|e0|^2 - w0^2)
    let u0 = ((w0*e0.y + s0*e0.z)/(2*|e0|^2), (w0*e0.z - s0*e0.y)/(2*|e0|^2))
    start { t1: t0, t2: atan2(u0.z, u0.y), t3: atan2(e0.z + u0.z, e0.y + u0.y) }
";

#[test]
fn four_bar_has_the_derivatives_of_its_closed_form_also_where_its_crank_strikes_a_stop() {
    let names = ["m1", "m2", "m3", "a", "b", "c", "d", "g", "t0", "e"];
    let of = |links: &str, start: &str| {
        let text = format!("{SIZES}{links}{SEEN}{start}");
        by_both(&scene(&text, &[]), &names)
    };
    let (exact, looped) = (of(CRANK, "start { t1: t0 }"), of(RODS, CLOSED));
    for ((run, right), (other, found)) in exact.iter().zip(&looped) {
        assert_exists(right);
        assert_exists(found);
        assert!(!run.events.is_empty() && run.events.len() == other.events.len());
        assert_row(&found.q[0], &right.q[0], "angle of the crank");
        assert_row(&found.v[0], &right.v[0], "its velocity");
        for (found, right) in found.event_times.iter().zip(&right.event_times) {
            assert_row(found, right, "time of an impact");
        }
        let [last, end] = [run, other].map(|run| run.trajectory.time.len() - 1);
        for output in 0..2 {
            let (found, right) = (&found.outputs[output][end], &right.outputs[output][last]);
            assert_row(found, right, "place of the rocker");
        }
    }
}

#[test]
fn derivatives_at_the_instant_of_an_impact_are_those_of_both_sides() {
    let text = "
        parameters { g: m/s^2 = 9.5, e = 0.7, height: m = 1.3, v0: m/s = 0.4 }
        coordinates { z: m }
        lagrangian 1[kg]*(dot(z)^2/2 - g*z)
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height, dot(z): v0 }
        horizon 1 [s]
    ";
    let (g, e, height, v0) = (9.5_f64, 0.7, 1.3, 0.4);
    let speed = f64::sqrt(v0 * v0 + 2.0 * g * height);
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        let t = run.events[0].time;
        let first = run.trajectory.time.partition_point(|&other| other < t);
        assert_eq!(run.trajectory.time[first + 1], t);
        let [before, behind] = [first, first + 1].map(|side| &gradient.states[side]);
        assert_row(&before[0], &[-t * t / 2.0, 0.0, 1.0, t], "height before");
        assert_row(&before[1], &[-t, 0.0, 0.0, 1.0], "velocity before");
        // What makes the impact earlier makes it higher and slower at its old time, and what makes it faster throws it up faster.
        let faster = [height / speed, 0.0, g / speed, v0 / speed];
        let later = [
            (faster[0] - t) / g,
            0.0,
            faster[2] / g,
            (1.0 + faster[3]) / g,
        ];
        assert_row(
            &behind[0],
            &later.map(|by| -e * speed * by),
            "height behind",
        );
        let mut by: Vec<f64> = (0..4).map(|k| e * faster[k] + g * later[k]).collect();
        by[1] = speed;
        assert_row(&behind[1], &by, "velocity behind");
    }
}

/// A pendulum that strikes a wall, with the angle or with a rod as a joint.
const PENDULUMS: [&str; 2] = [
    "coordinates { a: rad }
     lagrangian m/2*l^2*dot(a)^2 + m*g*l*cos(a)
     surface stop: l*sin(a) - wall >= 0
     start { a: a0, dot(a): w0 }
     outputs { x: m = l*sin(a), z: m = -l*cos(a) }",
    "coordinates { x: m, z: m }
     lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
     joint rod: x^2 + z^2 == l^2
     surface stop: x - wall >= 0
     start { x: l*sin(a0), z: -l*cos(a0), dot(x): l*cos(a0)*w0, dot(z): l*sin(a0)*w0 }
     outputs { pull: N/m = force(rod) }",
];

#[test]
fn joint_has_the_derivatives_of_fewer_coordinates() {
    let head = "parameters { m: kg = 1.2, g: m/s^2 = 9.7, l: m = 0.8, a0: rad = 1.1, w0: rad/s = 0.3, e = 0.6, wall: m = -0.2 }
        impact stop: restitution e horizon 1.4 [s] ";
    let redundant = PENDULUMS[1].replace("surface", "joint again: 2*x^2 + 2*z^2 == 2*l^2 surface");
    let names = ["m", "g", "l", "a0", "w0", "e", "wall"];
    let of = |rod: &str| by_both(&scene(&format!("{head}{rod}"), &[]), &names);
    let few = of(PENDULUMS[0]);
    for more in [of(PENDULUMS[1]), of(&redundant)] {
        for ((run, few), (other, more)) in few.iter().zip(&more) {
            assert_exists(few);
            assert_exists(more);
            assert!(run.events.len() == 1 && other.events.len() == 1, "{other}");
            let last = run.trajectory.time.len() - 1;
            for (i, what) in ["x", "z"].iter().enumerate() {
                assert_row(&more.q[i], &few.outputs[i][last], what);
            }
            assert_row(&more.event_times[0], &few.event_times[0], "time");
        }
    }
    let rod = scene(&format!("{head}{}", PENDULUMS[1]), &[]);
    let refused = simulate(&rod).gradient_of(["pull"]).gradient(names);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("reads forces of joints"), "{refused}");
}

#[test]
fn names_that_nothing_has_are_refused() {
    let scene = scene(CEILING, &[]);
    for (names, words) in [
        (&["w0"][..], "no gradient of `Scene` by `w0`"),
        (&["v0", "v0"], "asked for twice"),
        (&["all", "g"], "asked for twice"),
        (&[], "a gradient by nothing"),
    ] {
        let refusal = simulate(&scene)
            .gradient(names.iter().copied())
            .unwrap_err();
        assert!(refusal.to_string().contains(words), "{refusal}");
    }
    let all = simulate(&scene).gradient(["all", "z"]).unwrap().1;
    assert_eq!(all.with_respect_to, ["g", "v0", "top", "z"]);
}

#[test]
fn end_that_jumps_has_no_derivative_to_either_side() {
    // Two bodies that share an inertia, so that landing at once is another impact than landing one after the other.
    let text = "
        parameters { h1: m = 1 }
        coordinates { a: m, b: m }
        lagrangian 1[kg]*(dot(a)^2 + dot(b)^2 + dot(a)*dot(b))/2 - 9.81[N]*(a + b) - 10[N/m]*(a - b)^2
        forces { a: -3[N*s/m]*(dot(a) - dot(b)), b: 3[N*s/m]*(dot(a) - dot(b)) }
        surface first: a >= 0
        surface second: b >= 0
        impact first: restitution 0.5
        impact second: restitution 0.5
        start { a: h1, b: 1 [m] }
        horizon 0.6 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["h1"]) {
        assert!(
            gradient.obstacle.is_some() && gradient.one_sided.is_none(),
            "{gradient:?}"
        );
    }
}
