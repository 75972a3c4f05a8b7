//! Drag of the size of a velocity in the plane, at rest: motions, derivatives and optima against closed forms and against the line.

use hangtime::prelude::*;

use super::both::{ends, motions, scene};
use super::gradient::support::{assert_exists, by_both};

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
