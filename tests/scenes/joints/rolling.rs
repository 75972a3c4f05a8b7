//! Equations between velocities: blades, wheels and discs; and quaternions.

use super::{assert_close, both, last, scene, solved, tight};
use hangtime::model::Model;
use hangtime::prelude::*;

/// Chaplygin's sleigh: with the velocity `v` of the blade and `k^2 = j/m + a^2`,
/// `v' = a w^2`, `w' = -a v w/k^2`, so that `v = c tanh(s)`, `w = c/k sech(s)`, `s = a c t/k^2 + s_0`.
#[test]
fn sleigh_moves_as_its_closed_form() {
    let sleigh = scene(
        "parameters { m: kg = 1, j: kg*m^2 = 0.5, a: m = 0.3 }
         coordinates { x: m, y: m, phi: rad }
         lagrangian m/2*((dot(x) - a*sin(phi)*dot(phi))^2 + (dot(y) + a*cos(phi)*dot(phi))^2) + j/2*dot(phi)^2
         joint blade: -sin(phi)*dot(x) + cos(phi)*dot(y) == 0
         outputs { v: m/s = cos(phi)*dot(x) + sin(phi)*dot(y) }
         start { dot(x): 1, dot(phi): 2 }
         horizon 5 [s]",
    );
    let (a, square) = (0.3, 0.5 + 0.09_f64);
    let k = square.sqrt();
    let c = (1.0 + square * 4.0).sqrt();
    let s = a * c * 5.0 / square + (1.0 / c).atanh();
    for run in both(&sleigh) {
        assert_close(
            last(&run, "v"),
            c * s.tanh(),
            1e-10,
            "velocity of the blade",
        );
        assert_close(last(&run, "dot(phi)"), c / k / s.cosh(), 1e-10, "turning");
        let (first, later) = (s.sinh().atan(), (s - a * c * 5.0 / square).sinh().atan());
        assert_close(last(&run, "phi"), k / a * (first - later), 1e-9, "angle");
    }
}

/// A knife edge on a slope, turning evenly (Neimark, Fufaev 1972): `x = b/2 sin(w t)^2`, `y = b/2 (w t - sin(2 w t)/2)` with
/// `b = g sin(s)/w^2` down and across the slope.
#[test]
fn knife_edge_on_a_slope_moves_across_it() {
    let edge = scene(
        "parameters { m: kg = 1, j: kg*m^2 = 0.1, g: m/s^2 = 9.81, s: rad = 0.2, w: 1/s = 2 }
         coordinates { x: m, y: m, phi: rad }
         lagrangian m/2*(dot(x)^2 + dot(y)^2) + j/2*dot(phi)^2 + m*g*sin(s)*x
         joint edge: sin(phi)*dot(x) - cos(phi)*dot(y) == 0
         start { dot(phi): w }
         horizon 4 [s]",
    );
    let (angle, b) = (8.0_f64, 9.81 * 0.2_f64.sin() / 4.0);
    for run in both(&edge) {
        assert_close(
            last(&run, "x"),
            b / 2.0 * angle.sin().powi(2),
            1e-10,
            "down the slope",
        );
        let across = b / 2.0 * (angle - (2.0 * angle).sin() / 2.0);
        assert_close(last(&run, "y"), across, 1e-10, "across");
    }
}

/// A disc that rolls in space: center, heading, lean and spin; `h` points ahead, `u` from the ground to the center.
const DISC: &str = "
    parameters { m: kg = 1, r: m = 0.5, g: m/s^2 = 9.81 }
    coordinates { x: m, y: m, z: m, heading: rad, lean: rad, spin: rad }
    let turns = dot(spin) + dot(heading)*sin(lean)
    let rest = dot(lean)^2 + (dot(heading)*cos(lean))^2
    lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) + m*r^2/8*rest + m*r^2/4*turns^2 - m*g*z
    joint roll: (dot(x), dot(y)) == (-r*turns*cos(heading) - r*dot(lean)*cos(lean)*sin(heading),
                                     -r*turns*sin(heading) + r*dot(lean)*cos(lean)*cos(heading))
    joint height: z == r*cos(lean)
    start { z: r, lean: 0.2, dot(spin): -8, dot(heading): 0.5 }
    horizon 100 [s]
";

#[test]
fn disc_rolls_for_a_hundred_seconds_with_its_energy() {
    let disc = scene(DISC);
    let run = tight(&disc);
    let energy = |k: usize| {
        let x = [&run.trajectory.q[k][..], &run.trajectory.v[k]].concat();
        let mut parts = [0.0; 2];
        disc.energy(&x, &mut parts);
        parts[0] + parts[1]
    };
    let (first, count) = (energy(0), run.trajectory.time.len());
    let worst = (0..count).fold(0.0_f64, |worst, k| worst.max((energy(k) - first).abs()));
    assert_close(worst / first, 0.0, 1e-10, "energy over 100 s");
    println!(
        "residual {:e}, {} steps",
        run.residuals.primal, run.counts.elements
    );
    let default = solved(simulate(&disc).horizon(5.0).run());
    let tight = solved(
        simulate(&disc)
            .horizon(5.0)
            .method(EventDriven::default())
            .tolerance(1e-13)
            .run(),
    );
    for name in ["x", "y", "lean", "heading"] {
        assert_close(last(&default, name), last(&tight, name), 1e-5, name);
    }
}

#[test]
fn wheel_that_rolls_by_a_joint_is_one_that_sticks_by_friction() {
    let common = "parameters { m: kg = 1, r: m = 0.3, g: m/s^2 = 9.81, s: rad = 0.3 }
         coordinates { x: m, z: m, phi: rad }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) + m*r^2/4*dot(phi)^2 + m*g*(x*sin(s) - z*cos(s))
         start { z: r }
         horizon 2 [s]";
    let joint = scene(&format!(
        "{common} joint roll: dot(x) == r*dot(phi)  joint height: z == r
         outputs {{ load: N = force(height), grip: N = force(roll) }}"
    ));
    let friction = scene(&format!(
        "{common} surface slope: z >= r
         impact slope: inelastic, friction 0.8, sliding dot(x) - r*dot(phi)
         outputs {{ load: N = force(slope), grip: N = friction_force(slope) }}"
    ));
    let rubbed = tight(&friction);
    for run in both(&joint) {
        // A third of the pull of gravity turns it.
        assert_close(
            last(&run, "x"),
            2.0 / 3.0 * 9.81 * 0.3_f64.sin() / 2.0 * 4.0,
            1e-11,
            "x",
        );
        for name in ["x", "phi", "load", "grip"] {
            assert_close(last(&run, name), last(&rubbed, name), 1e-11, name);
        }
    }
}

/// A heavy top: a quaternion of length 1 against Euler's angles.
#[test]
fn top_by_a_quaternion_is_that_by_angles() {
    // The rotation turns the body's third axis to (2(q1 q3 + q0 q2), ., q0^2 - q1^2 - q2^2 + q3^2). Along the quaternion
    // itself anything is an inertia that has nothing to do.
    let quaternion = scene(
        "parameters { j: kg*m^2 = 0.4, i: kg*m^2 = 0.7, p: J = 3, one: kg*m^2 = 1 }
         coordinates { q0, q1, q2, q3 }
         let w1 = 2*(q0*dot(q1) - q1*dot(q0) + q3*dot(q2) - q2*dot(q3))
         let w2 = 2*(q0*dot(q2) - q2*dot(q0) + q1*dot(q3) - q3*dot(q1))
         let w3 = 2*(q0*dot(q3) - q3*dot(q0) + q2*dot(q1) - q1*dot(q2))
         let own = q0*dot(q0) + q1*dot(q1) + q2*dot(q2) + q3*dot(q3)
         let height = q0^2 - q1^2 - q2^2 + q3^2
         lagrangian j/2*(w1^2 + w2^2) + i/2*w3^2 + one/2*own^2 - p*height
         joint unit: q0^2 + q1^2 + q2^2 + q3^2 == 1
         outputs { up = height, spin: 1/s = w3 }
         start { q0: cos(0.2), q1: sin(0.2), dot(q3): 2.5 [1/s]*cos(0.2), dot(q2): -2.5 [1/s]*sin(0.2) }
         horizon 3 [s]",
    );
    let begin = solved(simulate(&quaternion).run());
    let spin = begin["spin"][0];
    // Nutation of a symmetric top: with the conserved momenta, theta alone.
    let angles = scene(
        "parameters { j: kg*m^2 = 0.4, i: kg*m^2 = 0.7, p: J = 3 }
         coordinates { theta: rad, phi: rad, psi: rad }
         lagrangian j/2*(dot(theta)^2 + sin(theta)^2*dot(phi)^2) + i/2*(dot(psi) + cos(theta)*dot(phi))^2 - p*cos(theta)
         outputs { up = cos(theta) }
         start { theta: 0.4 }
         horizon 3 [s]",
    );
    // The start turns around the third axis of the body alone.
    let exact = simulate(&angles)
        .start("dot(psi)", spin)
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    let exact = solved(exact);
    for run in both(&quaternion) {
        assert_close(last(&run, "up"), last(&exact, "up"), 1e-9, "height");
        assert_close(last(&run, "spin"), spin, 1e-9, "spin");
    }
}
