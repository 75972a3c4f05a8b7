//! How far parameters may go until the events are others, to first order, against closed forms.

use hangtime::derivative::{Gradient, SequenceLimit};
use hangtime::prelude::*;

use super::support::{assert_close, assert_exists, by_both, scene};
use super::texts::CEILING;

/// Ranges of motions that tolerances of 1e-12 leave.
const CLOSE: f64 = 1e-9;

#[track_caller]
fn assert_limit(limit: Option<&SequenceLimit>, change: f64, words: &str) {
    let limit = limit.unwrap_or_else(|| panic!("nothing ends it, and not: {words}"));
    assert!(limit.because.contains(words), "{limit:?}");
    assert_close(limit.change, change, CLOSE, words);
}

#[track_caller]
fn sides(gradient: &Gradient, k: usize) -> [Option<&SequenceLimit>; 2] {
    assert_exists(gradient);
    let range = &gradient.ranges[k];
    [range.below.as_ref(), range.above.as_ref()]
}

#[test]
fn end_before_the_next_bounce() {
    let text = "
        parameters { e = 0.5, g: m/s^2 = 9.81, h: m = 1 }
        coordinates { z: m }
        lagrangian 1[kg]*(dot(z)^2/2 - g*z)
        surface floor: z >= 0
        impact floor: restitution e
        start { z: h }
        horizon 0.8 [s]
    ";
    let (e, g, h, end) = (0.5_f64, 9.81_f64, 1.0_f64, 0.8_f64);
    let (fall, speed) = ((2.0 * h / g).sqrt(), (2.0 * g * h).sqrt());
    let since = end - fall;
    for (run, gradient) in by_both(&scene(text, &[]), &["e", "h"]) {
        assert_eq!(run.events.len(), 1);
        // The height at the end is linear in e.
        let [below, above] = sides(&gradient, 0);
        assert_limit(
            below,
            g * since / (2.0 * speed) - e,
            "`floor` is touched at t = 0.8 s",
        );
        assert!(above.is_none(), "{above:?}");
        let [below, above] = sides(&gradient, 1);
        let height = e * speed * since - g * since * since / 2.0;
        let later = fall / (2.0 * h);
        let by_h = e * g / speed * since - (e * speed - g * since) * later;
        assert_limit(below, -height / by_h, "`floor` is touched at t = 0.8 s");
        assert_limit(above, since / later, "happens behind the end");
    }
}

#[test]
fn ceiling_that_is_nearly_reached() {
    // The apex is at 1 m after 0.5 s, and rises by 0.5 s times the velocity.
    for (_, gradient) in by_both(&scene(CEILING, &[("top", 1.1)]), &["v0", "top"]) {
        let [below, above] = sides(&gradient, 0);
        assert!(below.is_none(), "{below:?}");
        assert_limit(above, 0.2, "`ceiling` is touched at t = 0.5 s");
        let [below, above] = sides(&gradient, 1);
        assert_limit(below, -0.1, "`ceiling` is touched");
        assert!(above.is_none(), "{above:?}");
    }
}

#[test]
fn ceiling_that_is_just_struck() {
    // With the speed s, s^2 = v0^2 - 2 g top.
    let speed = 1.6_f64.sqrt();
    for (_, gradient) in by_both(&scene(CEILING, &[("top", 0.9)]), &["v0", "top"]) {
        let [below, above] = sides(&gradient, 0);
        assert_limit(below, -1.6 / (2.0 * 4.0), "`ceiling` is not struck");
        // The impact is earlier by t1/s.
        assert_limit(above, speed, "the start and the impact at `ceiling`");
        let [_, above] = sides(&gradient, 1);
        assert_limit(above, 1.6 / (2.0 * 8.0), "`ceiling` is not struck");
    }
}

#[test]
fn block_on_a_slope_that_holds_it() {
    let text = "
        parameters { mu = 0.5, angle: rad = 0.3, g: m/s^2 = 9.81 }
        coordinates { x: m, z: m }
        lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - g*(z*cos(angle) + x*sin(angle)))
        surface slope: z >= 0
        impact slope: inelastic, friction mu, sliding dot(x)
        start { x: 0 [m], z: 0 [m] }
        horizon 1 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["mu", "angle"]) {
        let [below, _] = sides(&gradient, 0);
        assert_limit(below, 0.3_f64.tan() - 0.5, "`slope` begins to slide");
        let [_, above] = sides(&gradient, 1);
        let (sin, cos) = 0.3_f64.sin_cos();
        let change = (0.5 * cos - sin) / (0.5 * sin + cos);
        assert_limit(above, change, "`slope` begins to slide");
    }
}

#[test]
fn block_that_stops_before_the_end() {
    let text = "
        parameters { g: m/s^2 = 9.7, mu = 0.35, v0: m/s = 2.1 }
        coordinates { x: m, z: m }
        lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - g*z)
        surface floor: z >= 0
        impact floor: inelastic, friction mu, sliding dot(x)
        start { x: 0 [m], z: 0 [m], dot(x): v0 }
        horizon 1.5 [s]
    ";
    for (_, gradient) in by_both(&scene(text, &[]), &["v0"]) {
        let [below, above] = sides(&gradient, 0);
        assert_limit(below, -2.1, "happen at once");
        assert_limit(above, 1.5 * 0.35 * 9.7 - 2.1, "the stick at `floor`");
    }
}

#[test]
fn bodies_that_land_one_after_the_other() {
    let text = "
        parameters { h1: m = 1, h2: m = 1.1 }
        coordinates { a: m, b: m }
        lagrangian 1[kg]*(dot(a)^2 + dot(b)^2)/2 - 9.81[N]*(a + b)
        surface first: a >= 0
        surface second: b >= 0
        impact first: restitution 0.5
        impact second: restitution 0.5
        start { a: h1, b: h2 }
        horizon 0.6 [s]
    ";
    let fall = |h: f64| (2.0 * h / 9.81).sqrt();
    for (run, gradient) in by_both(&scene(text, &[]), &["h1"]) {
        assert_eq!(run.events.len(), 2);
        let [_, above] = sides(&gradient, 0);
        let apart = fall(1.1) - fall(1.0);
        let words = "the impact at `first` and the impact at `second`";
        assert_limit(above, apart / (fall(1.0) / 2.0), words);
    }
}

#[test]
fn impact_that_decides_between_sliding_and_rest() {
    // The impulse that would stop it is the velocity u0; friction gives mu (1 + e) times the closing speed at most.
    let text = "
        parameters { e = 0.4, mu = 0.2, u0: m/s = 1 }
        coordinates { x: m, z: m }
        lagrangian 1[kg]*((dot(x)^2 + dot(z)^2)/2 - 9.81[m/s^2]*z)
        surface floor: z >= 0
        impact floor: restitution e, friction mu, sliding dot(x)
        start { x: 0 [m], z: 1 [m], dot(x): u0 }
        horizon 0.7 [s]
    ";
    let most = |mu: f64| mu * 1.4 * (2.0 * 9.81_f64).sqrt();
    for (_, gradient) in by_both(&scene(text, &[]), &["u0"]) {
        let [_, above] = sides(&gradient, 0);
        assert_limit(above, most(0.2) - 1.0, "`floor` slides behind the impact");
    }
    for (_, gradient) in by_both(&scene(text, &[("mu", 0.1)]), &["u0", "mu"]) {
        let [below, _] = sides(&gradient, 0);
        assert_limit(
            below,
            most(0.1) - 1.0,
            "`floor` does not slide behind the impact",
        );
        let [_, above] = sides(&gradient, 1);
        let change = (1.0 - most(0.1)) / most(1.0);
        assert_limit(above, change, "`floor` does not slide behind the impact");
    }
}

#[test]
fn backwards_there_are_no_ranges() {
    let run = simulate(&scene(CEILING, &[("top", 1.1)]))
        .gradient_of(["z"])
        .gradient(["all"])
        .map(|(_, gradient)| gradient);
    assert!(run.unwrap().ranges.is_empty());
}
