//! Motions without derivatives, and requests without sense.

use hangtime::prelude::*;

use super::support::{assert_close, assert_exists, by_both, scene};
use super::texts::CEILING;

const LANDINGS: &str = "
    parameters { h1: m = 1, h2: m = 1, k: N/m = 20, c: N*s/m = 3, ground: m = 0 }
    coordinates { a: m, b: m }
    lagrangian 1[kg]*(dot(a)^2 + dot(b)^2)/2 - 9.81[N]*(a + b) - k/2*(a - b)^2
    forces { a: -c*(dot(a) - dot(b)), b: c*(dot(a) - dot(b)) }
    surface first: a - ground >= 0
    surface second: b - ground >= 0
    impact first: restitution 0.5
    impact second: restitution 0.5
    start { a: h1, b: h2 }
    horizon 0.6 [s]
";

#[test]
fn grazing_impact_has_no_derivative() {
    // Thrown at 4 m/s the ball has its apex at 1 m.
    for (_, gradient) in by_both(&scene(CEILING, &[]), &["v0"]) {
        let obstacle = gradient.obstacle.expect("a touch has no derivative");
        assert!(obstacle.contains("`ceiling` only grazes"), "{obstacle}");
        assert!(gradient.q[0][0].is_nan());
    }
    for top in [0.99, 1.01] {
        for (run, gradient) in by_both(&scene(CEILING, &[("top", top)]), &["v0"]) {
            assert_exists(&gradient);
            assert_eq!(run.events.len(), usize::from(top < 1.0));
        }
    }
}

#[test]
fn two_bodies_that_land_at_once_by_chance_have_none() {
    let scene = scene(LANDINGS, &[]);
    for (_, gradient) in by_both(&scene, &["h1"]) {
        let obstacle = gradient
            .obstacle
            .expect("another height makes one land first");
        assert!(obstacle.contains("at once"), "{obstacle}");
    }
    // The floor moves both landings alike, and what is lost by one quantity is not by another one.
    for (_, gradient) in by_both(&scene, &["h1", "ground"]) {
        assert!(gradient.obstacles[0].is_some() && gradient.obstacles[1].is_none());
        assert!(gradient.q[0][0].is_nan() && gradient.q[0][1].is_finite());
    }
    for (_, gradient) in by_both(&scene, &["ground"]) {
        assert_exists(&gradient);
    }
}

#[test]
fn landings_at_once_that_do_not_touch_each_other_have_a_derivative() {
    // Without a damper between them neither lands otherwise because the other one has: forces read places alone.
    let by = |gap: f64| {
        let scene = scene(LANDINGS, &[("c", 0.0), ("h1", 1.0 + gap)]);
        by_both(&scene, &["h1", "h2", "ground"])
    };
    let [beside, other] = [by(-1e-5), by(1e-5)];
    for (k, (_, gradient)) in by(0.0).iter().enumerate() {
        assert_exists(gradient);
        for row in 0..2 {
            for column in 0..3 {
                let sides = [&beside, &other].map(|beside| beside[k].1.q[row][column]);
                // Starts beside it differ by 1e-5 m, of which curvatures of order ten make 1e-4.
                assert_close(gradient.q[row][column], sides[0], 1e-3, "from below");
                assert_close(gradient.q[row][column], sides[1], 1e-3, "from above");
            }
        }
    }
}

#[test]
fn rest_on_the_verge_has_a_derivative_to_each_side() {
    // A block on a slope of 0.75 under as much friction: with more it stays, with less by h it slides by h g cos t^2/2.
    let text = "
        parameters { mu = 0.75, push: N = 0 }
        coordinates { s: m, h: m }
        lagrangian 1[kg]/2*(dot(s)^2 + dot(h)^2) - 10[N]*(0.8*h + 0.6*s)
        forces { s: push }
        surface slope: h >= 0
        impact slope: inelastic, friction mu, sliding dot(s)
        horizon 1 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["mu", "push"]) {
        assert!(
            gradient.obstacles.iter().all(Option::is_some),
            "{gradient:?}"
        );
        let sides = gradient.one_sided.expect("to both sides");
        assert_close(sides.above.q[0][0], 0.0, 1e-9, "s by more friction");
        assert_close(sides.below.q[0][0], 8.0 / 2.0, 1e-6, "s by less friction");
        assert_close(sides.above.q[0][1], 0.0, 1e-9, "s by a push upwards");
        assert_close(
            sides.below.q[0][1],
            1.0 / 2.0,
            1e-6,
            "s by a push downwards",
        );
    }
}

#[test]
fn start_on_a_kink_has_a_derivative_to_each_side() {
    // A spring that only pulls back from x > 0: beyond 0 it oscillates with 2/s, before 0 nothing acts.
    let text = "
        parameters { k: N/m = 4, x0: m = 0, v0: m/s = 0 }
        coordinates { x: m }
        lagrangian 1[kg]/2*dot(x)^2
        forces { x: -k*max(0 [m], x) }
        start { x: x0, dot(x): v0 }
        horizon 0.6 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["x0", "k"]) {
        assert!(gradient.obstacles[0].is_some() && gradient.obstacles[1].is_none());
        let sides = gradient.one_sided.expect("to both sides");
        assert_close(sides.below.q[0][0], 1.0, 1e-7, "x from below");
        assert_close(sides.above.q[0][0], 1.2_f64.cos(), 1e-7, "x from above");
    }
    // With a velocity it only passes the kink, at which nothing jumps.
    for (_, gradient) in by_both(&scene(text, &[("v0", 1.0)]), &["x0", "v0"]) {
        assert_exists(&gradient);
        assert_close(gradient.q[0][0], 1.2_f64.cos(), 1e-9, "x by x0");
        assert_close(gradient.q[0][1], 1.2_f64.sin() / 2.0, 1e-9, "x by v0");
    }
}

#[test]
fn contact_without_a_force_has_a_derivative_to_each_side() {
    // The weight is carried by the thrust: less of it presses, more of it lifts.
    let text = "
        parameters { thrust: N = 20 }
        coordinates { z: m }
        lagrangian 2[kg]*(dot(z)^2/2 - 10[m/s^2]*z)
        forces { z: thrust }
        surface floor: z >= 0
        impact floor: inelastic
        horizon 1 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["thrust"]) {
        assert!(gradient.obstacle.is_some(), "{gradient:?}");
        let sides = gradient.one_sided.expect("to both sides");
        assert_close(sides.below.q[0][0], 0.0, 1e-9, "from below");
        assert_close(sides.above.q[0][0], 0.25, 1e-7, "from above");
    }
}

#[test]
fn start_on_a_surface_that_a_parameter_moves_away_has_none() {
    let text = "
        parameters { h: m = 0, g: m/s^2 = 9.81 }
        coordinates { z: m }
        lagrangian 1[kg]*(dot(z)^2/2 - g*z)
        surface floor: z >= 0
        impact floor: inelastic
        start { z: h }
        horizon 0.6 [s]
    ";
    let scene = scene(text, &[]);
    for (_, gradient) in by_both(&scene, &["h"]) {
        let obstacle = gradient
            .obstacle
            .expect("above the floor it falls, and below it cannot start");
        assert!(obstacle.contains("`floor` is closed"), "{obstacle}");
    }
    for (_, gradient) in by_both(&scene, &["g"]) {
        assert_exists(&gradient);
        assert_eq!(gradient.q[0], [0.0]);
    }
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
fn coefficients_at_their_limit_have_none() {
    let text = "
        parameters { e = 0, mu = 0, g: m/s^2 = 9.81, u0: m/s = 1 }
        coordinates { x: m, z: m }
        lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - g*z)
        surface floor: z >= 0
        impact floor: restitution e, friction mu, sliding dot(x)
        start { z: 1 [m], dot(x): u0 }
        horizon 0.6 [s]
    ";
    for (settings, by, word) in [
        (&[("mu", 0.1)][..], "e", "restitution of 0"),
        (&[("e", 0.5)], "mu", "friction of 0"),
    ] {
        let scene = scene(text, settings);
        for (_, gradient) in by_both(&scene, &[by]) {
            let obstacle = gradient.obstacle.expect("below 0 there is nothing");
            assert!(obstacle.contains(word), "{obstacle}");
        }
        for (_, gradient) in by_both(&scene, &["g", "u0"]) {
            assert_exists(&gradient);
        }
    }
}

#[test]
fn graze_has_a_derivative_to_the_side_that_does_not_touch_and_a_root_to_the_other() {
    // Thrown slower than 4 m/s the ball is at v0 T - g T^2/2 after T = 1 s, with the velocity v0 - g T; thrown faster by h it strikes
    // the ceiling at s = sqrt(8 h), after s/8 less than 1/2 s: then it is lower by (1 + e) s/2, and slower by (1 + e) s. A ceiling that
    // is lower by h is struck at s = 4 sqrt(h). What is left out of the root, h^2 of the largest distance, is below 1e-6.
    let root = |found: f64, right: f64, what: &str| assert_close(found, right, 1e-6, what);
    for (_, gradient) in by_both(&scene(CEILING, &[]), &["v0", "top"]) {
        let sides = gradient.one_sided.expect("to one side");
        assert_close(sides.below.q[0][0], 1.0, 1e-9, "z by v0 from below");
        assert_close(sides.below.v[0][0], 1.0, 1e-9, "dz/dt by v0 from below");
        assert_eq!(sides.above.q[0][0], f64::NEG_INFINITY);
        assert_eq!(sides.above.v[0][0], f64::NEG_INFINITY);
        root(sides.above.roots[0][0], -0.75 * 8.0_f64.sqrt(), "z by v0");
        root(
            sides.above.roots[1][0],
            -1.5 * 8.0_f64.sqrt(),
            "dz/dt by v0",
        );
        // A higher ceiling changes nothing, a lower one is struck.
        assert_close(sides.above.q[0][1], 0.0, 1e-12, "z by top from above");
        assert_eq!(sides.below.q[0][1], f64::INFINITY);
        root(sides.below.roots[0][1], -0.75 * 4.0, "z by top");
        assert!(sides.above.roots[0][1] == 0.0 && sides.below.roots[0][0] == 0.0);
    }
    let (_, gradient) = simulate(&scene(CEILING, &[("top", 2.0)]))
        .gradient(["v0"])
        .unwrap();
    assert!(gradient.one_sided.is_none());
}

#[test]
fn landings_at_once_have_a_derivative_to_each_side() {
    let of = |h1: f64| {
        let scene = scene(LANDINGS, &[("h1", h1)]);
        let run = simulate(&scene).method(EventDriven::default());
        let run = run.tolerance(1e-13).run().unwrap();
        [0, 1].map(|k| run.trajectory.q.last().unwrap()[k])
    };
    for (_, gradient) in by_both(&scene(LANDINGS, &[]), &["h1"]) {
        let sides = gradient.one_sided.expect("to both sides");
        // Quotients of an independent method, whose limits are taken from two distances: their error is that of the motion over
        // the distance, about 1e-8, and the square of the distance.
        for (side, sense) in [(&sides.below, -1.0), (&sides.above, 1.0)] {
            for k in 0..2 {
                let quotient = |way: f64| (of(1.0 + sense * way)[k] - of(1.0)[k]) / (sense * way);
                let limit = 2.0 * quotient(1e-5) - quotient(2e-5);
                assert_close(side.q[k][0], limit, 1e-6, "by h1");
            }
        }
    }
}

#[test]
fn end_that_jumps_has_no_derivative_to_either_side() {
    // Two bodies that share an inertia, so that landing at once is another impact than landing one after the other.
    let text = LANDINGS.replace("dot(b)^2)/2", "dot(b)^2 + dot(a)*dot(b))/2");
    for (_, gradient) in by_both(&scene(&text, &[]), &["h1"]) {
        assert!(
            gradient.obstacle.is_some() && gradient.one_sided.is_none(),
            "{gradient:?}"
        );
    }
}

#[test]
fn slide_from_rest_has_no_derivative_by_its_first_velocity() {
    // Turned back first, the brake would act the other way until the wheel stands.
    let text = "
        parameters { j: kg*m^2 = 2, torque: N*m = 0.9, push: N*m = 2.1, w0: rad/s = 0 }
        coordinates { phi: rad }
        lagrangian j/2*dot(phi)^2
        forces { phi: push }
        dry friction brake: bound torque, sliding dot(phi)
        start { dot(phi): w0 }
        horizon 2 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["w0"]) {
        let obstacle = gradient.obstacle.expect("to one side only");
        assert!(obstacle.contains("`brake` is at its edge"), "{obstacle}");
        // Forwards it has 2 s more of that, backwards it is braked by 1.5 rad/s^2 at first and then driven by 0.6 rad/s^2.
        let sides = gradient.one_sided.expect("to both sides");
        assert_close(sides.above.q[0][0], 2.0, 1e-7, "from above");
        assert_close(sides.below.q[0][0], 2.0 * 0.6 / 1.5, 1e-7, "from below");
    }
    for (_, gradient) in by_both(&scene(text, &[]), &["push", "torque"]) {
        assert_exists(&gradient);
        // phi = (push - torque)/j t^2/2
        assert_close(gradient.q[0][0], 1.0, 1e-9, "by push");
        assert_close(gradient.q[0][1], -1.0, 1e-9, "by torque");
    }
}

/// Two masses of which one grazes a wall and is held to the other by a spring, so that all rows move with the root.
#[test]
fn graze_that_is_struck_moves_everything_behind_it_by_the_root() {
    let text = "
        parameters { v0: m/s = 4, k: N/m = 9 }
        coordinates { z: m, y: m }
        lagrangian 1[kg]*(dot(z)^2 + dot(y)^2)/2 - 8[N]*(z + y) - k/2*(z - y)^2
        surface ceiling: 1[m] - z >= 0
        impact ceiling: restitution 0.5
        start { dot(z): v0, dot(y): v0 }
        horizon 1 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["v0"]) {
        let sides = gradient.one_sided.expect("to both sides");
        // z loses 1.5 s = 1.5 sqrt(8 h) at t = 1/2 s, half of it with the mean, half with the difference of both, which turns at w.
        let (w, lost) = (18.0_f64.sqrt(), -1.5 * 8.0_f64.sqrt());
        let (mean, turned) = (lost / 4.0, lost / 2.0 * (w / 2.0).sin() / w);
        assert_close(sides.above.roots[0][0], mean + turned, 1e-6, "z");
        assert_close(sides.above.roots[1][0], mean - turned, 1e-6, "y");
        assert_close(sides.below.q[0][0], 1.0, 1e-9, "z from below");
        assert_close(sides.below.q[1][0], 1.0, 1e-9, "y from below");
    }
}

#[test]
fn end_with_an_impact_has_a_derivative_to_each_side() {
    // The ball falls 1 m in 1/2 s, to 4 m/s; from higher by h it arrives h/4 s/m later.
    let text = "
        parameters { g: m/s^2 = 8, e = 0.5, height: m = 1 }
        coordinates { z: m }
        lagrangian 1[kg]*(dot(z)^2/2 - g*z)
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height }
        horizon 0.5 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["height", "e"]) {
        let obstacle = gradient.obstacle.expect("another height does not strike");
        assert!(obstacle.contains("event at `floor`"), "{obstacle}");
        let sides = gradient.one_sided.expect("to both sides");
        assert_close(sides.above.q[0][0], 1.0, 1e-9, "z from above");
        // z = e s (T - t) with t' = 1/4 s/m and s = 4 m/s.
        assert_close(sides.below.q[0][0], -0.5, 1e-9, "z from below");
        assert_close(sides.above.v[0][0], 0.0, 1e-9, "dz/dt from above");
        // Another restitution leaves the impact where it is: nothing has come of it yet.
        assert_eq!(gradient.q[0][1], 0.0);
    }
    for (_, gradient) in by_both(&scene(text, &[]), &["e"]) {
        assert_exists(&gradient);
        assert_eq!(gradient.q, [[0.0]]);
    }
    // An end that moves with the impact has the derivatives of a motion without it.
    let text = text.replace("horizon 0.5 [s]", "horizon sqrt(2*height/g)");
    for (_, gradient) in by_both(&scene(&text, &[]), &["height", "g", "e"]) {
        assert_exists(&gradient);
        assert!(
            gradient.q[0].iter().all(|by| by.abs() < 1e-9),
            "{gradient:?}"
        );
    }
}

#[test]
fn end_at_which_a_condition_comes_true_has_a_derivative_to_each_side() {
    let text = "
        parameters { rate: 1/s = 0.5, back = 0.25 }
        states { x }
        rates { x: rate }
        when x >= 1 { x = back }
        horizon 2 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["rate"]) {
        let obstacle = gradient
            .obstacle
            .expect("at another rate it comes true later");
        assert!(obstacle.contains("event at `x >= 1`"), "{obstacle}");
        // Slower it has gone on to rate times 2 s.
        let sides = gradient.one_sided.expect("to one side");
        assert_close(sides.below.v[0][0], 2.0, 1e-9, "x from below");
    }
}

#[test]
fn starts_that_joints_complete_move_with_what_moves_the_joints() {
    // Moved along the rod, the start is at the direction of the guess and the distance l; without weight it turns by v/l.
    let text = "parameters { l: m = 1.5, v: m/s = 0.6 } coordinates { x: m, z: m } lagrangian 1[kg]/2*(dot(x)^2 + dot(z)^2)
        joint rod: x^2 + z^2 == l^2 start { x: 0.8, z: -0.6, dot(x): 0.6*v, dot(z): 0.8*v } horizon 1 [s]";
    for (run, gradient) in by_both(&scene(text, &[]), &["l", "v", "x"]) {
        assert_exists(&gradient);
        let turned = (-0.6_f64).atan2(0.8) + 0.6 / 1.5;
        let end = [1.5 * turned.cos(), 1.5 * turned.sin()];
        let last = run.trajectory.q.last().unwrap();
        assert_close(last[0], end[0], 1e-9, "x");
        // By l: cos, and -v/l^2 turns; by v: 1/l turns; the guess by x turns by -z/(x^2 + z^2).
        let by_angle = [-end[1], end[0]];
        let turns = [-0.6 / 2.25, 1.0 / 1.5, 0.6];
        for (k, unit) in [turned.cos(), turned.sin()].into_iter().enumerate() {
            for (column, turns) in turns.into_iter().enumerate() {
                let along = if column == 0 { unit } else { 0.0 };
                // The guess turns its velocity as well, which loses what is along the rod: by its square.
                let right = along + turns * by_angle[k];
                assert_close(gradient.q[k][column], right, 1e-8, "end");
            }
        }
    }
}
