//! Drag of the size of a velocity in the plane, at rest: motions, derivatives and optima against closed forms and against the line.

use hangtime::prelude::*;

use super::both::{ends, motions, scene};
use super::gradient::support::{assert_exists, by_both};

/// A body that is pushed from rest along (3, 4)/5 against its drag.
const PUSHED: &str = "parameters { m: kg = 2, f: N = 3, c: kg/m = 0.7 }
    coordinates { x: m, z: m }
    let v = dot((x, z))
    lagrangian m/2*|v|^2
    forces { x: 0.6*f - c*|v|*dot(x), z: 0.8*f - c*|v|*dot(z) }
    horizon 1.5 [s]";

#[test]
fn body_pushed_from_rest_moves_on_a_line_with_a_hyperbolic_tangent() {
    let (m, f, c, t) = (2.0_f64, 3.0_f64, 0.7_f64, 1.5_f64);
    let phase = t * (f * c).sqrt() / m;
    let (way, speed) = (m / c * phase.cosh().ln(), (f / c).sqrt() * phase.tanh());
    for motion in motions(PUSHED) {
        let end = [("x", 0.6 * way), ("z", 0.8 * way), ("dot(z)", 0.8 * speed)];
        ends(&motion, &end, 1e-7);
    }
    // d way/dc, with d phase/dc = phase/(2 c).
    let by_c = -way / c + m / c * phase.tanh() * phase / (2.0 * c);
    for (_, gradient) in by_both(&scene(PUSHED), &["c"]) {
        assert_exists(&gradient);
        let found = gradient.q[0][0];
        assert!((found - 0.6 * by_c).abs() < 1e-7, "{found} {by_c}");
    }
}

#[test]
fn optimum_from_rest_to_rest_in_the_plane_is_that_on_a_line() {
    let plane = "parameters { m: kg = 1, c: kg/m = 0.4 }
        coordinates { x: m, z: m } controls { a: N in -5..=5, b: N in -5..=5 }
        let v = dot((x, z))
        lagrangian m/2*|v|^2
        forces { x: a - c*|v|*dot(x), z: b - c*|v|*dot(z) }
        minimize integral(a^2 + b^2)
        finally { x == 0.6 [m], z == 0.8 [m], dot(x) == 0, dot(z) == 0 } horizon 2 [s]";
    let line = "parameters { m: kg = 1, c: kg/m = 0.4 }
        coordinates { x: m } controls { a: N in -5..=5 }
        lagrangian m/2*dot(x)^2
        forces { x: a - c*|dot(x)|*dot(x) }
        minimize integral(a^2)
        finally { x == 1 [m], dot(x) == 0 } horizon 2 [s]";
    let optimum = |text: &str| {
        let scene = scene(text);
        let solution = solve(&scene).intervals(8).run().expect("accepted");
        assert!(solution.status.is_solved(), "{solution}");
        solution.objective
    };
    let (plane, line) = (optimum(plane), optimum(line));
    assert!((plane - line).abs() < 1e-8, "{plane} {line}");
}
