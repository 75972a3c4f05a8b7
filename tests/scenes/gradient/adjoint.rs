//! Derivatives of values at the end, backwards along the motion, against closed forms, and what is said of them.

use hangtime::derivative::GradientMode;
use hangtime::prelude::*;

use super::support::{TOLERANCE, assert_close, scene};
use super::texts::{CEILING, HILLS};

#[test]
fn more_quantities_than_values_are_differentiated_backwards() {
    let scene = scene(HILLS, &[]);
    let of = |by: &[&str], of: &[&str]| {
        let run = simulate(&scene).gradient_of(of.iter().copied());
        run.gradient(by.iter().copied()).unwrap().1
    };
    assert_eq!(of(&["e", "g"], &["z"]).mode, GradientMode::Adjoint);
    assert_eq!(
        of(&["e", "g"], &["z", "rubbed"]).mode,
        GradientMode::Forward
    );
    assert_eq!(of(&["all"], &[]).mode, GradientMode::Forward);
    let forward = of(&["e"], &["z"]);
    assert_eq!(forward.values[0].1, forward.q[1]);
}

#[test]
fn motions_without_derivatives_say_so_backwards_too() {
    let scene = scene(CEILING, &[]);
    let run = simulate(&scene).tolerance(TOLERANCE).gradient_of(["z"]);
    let (_, gradient) = run.gradient(["v0", "top"]).unwrap();
    let obstacle = gradient.obstacle.expect("a touch has no derivative");
    assert!(obstacle.contains("`ceiling` only grazes"), "{obstacle}");
    assert!(gradient.values[0].1[0].is_nan());
    // Thrown slower the ball is at v0 T - g T^2/2; a higher ceiling changes nothing.
    let sides = gradient.one_sided.expect("to one side");
    assert_close(sides.below.values[0].1[0], 1.0, 1e-9, "z by v0 from below");
    // Thrown faster it strikes at s = sqrt(8 h), and is lower by (1 + e) s/2.
    assert_eq!(sides.above.values[0].1[0], f64::NEG_INFINITY);
    assert_close(
        sides.above.roots[2][0],
        -0.75 * 8.0_f64.sqrt(),
        1e-6,
        "z by the root of v0 from above",
    );
    assert_close(
        sides.above.values[0].1[1],
        0.0,
        1e-12,
        "z by top from above",
    );
}

#[test]
fn contact_that_one_of_many_parameters_opens_is_found_backwards() {
    let text = "
        parameters { h: m = 0, g: m/s^2 = 9.81, c: N = 1e6 }
        coordinates { x: m, z: m }
        lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - g*z)
        forces { x: c }
        surface floor: z >= 0
        impact floor: inelastic
        start { z: h }
        horizon 0.6 [s]
    ";
    let scene = scene(text, &[]);
    let run = simulate(&scene).gradient_of(["x"]);
    let (_, gradient) = run.gradient(["g", "h", "c"]).unwrap();
    let obstacle = gradient.obstacle.expect("another height opens it");
    assert!(obstacle.contains("another `h`"), "{obstacle}");
}

#[test]
fn values_that_nothing_has_are_refused() {
    let scene = scene(HILLS, &[]);
    for (of, words) in [
        ("y", "no gradient of `y` at the end"),
        ("objective", "`minimize` declares an objective"),
        ("g", "it has: x, dot(x), z, dot(z), rubbed"),
        (
            "event_times[9]",
            "the motion has 3 events, `event_times[0]` to `event_times[2]`",
        ),
        (
            "event_times[]",
            "`event_times[0]` is the time of the first event",
        ),
    ] {
        let run = simulate(&scene).gradient_of([of]);
        let refusal = run.gradient(["all"]).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}
