//! Motions without derivatives, and requests without sense.

use hangtime::prelude::*;

use super::support::{assert_exists, by_both, scene};

const CEILING: &str = "
    parameters { g: m/s^2 = 8, v0: m/s = 4, top: m = 1 }
    coordinates { z: m }
    lagrangian 1[kg]*(dot(z)^2/2 - g*z)
    surface ceiling: top - z >= 0
    impact ceiling: restitution 0.5
    start { dot(z): v0 }
    horizon 1 [s]
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
    let text = "
        parameters { h1: m = 1, h2: m = 1, k: N/m = 20, ground: m = 0 }
        coordinates { a: m, b: m }
        lagrangian 1[kg]*(dot(a)^2 + dot(b)^2)/2 - 9.81[N]*(a + b) - k/2*(a - b)^2
        surface first: a - ground >= 0
        surface second: b - ground >= 0
        impact first: restitution 0.5
        impact second: restitution 0.5
        start { a: h1, b: h2 }
        horizon 0.6 [s]
    ";
    let scene = scene(text, &[]);
    for (_, gradient) in by_both(&scene, &["h1"]) {
        let obstacle = gradient
            .obstacle
            .expect("another height makes one land first");
        assert!(obstacle.contains("at once"), "{obstacle}");
    }
    // The floor moves both landings alike.
    for (_, gradient) in by_both(&scene, &["ground"]) {
        assert_exists(&gradient);
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
