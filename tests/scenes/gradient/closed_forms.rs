//! Derivatives of motions that formulas give.

use hangtime::prelude::*;
use num_dual::{Dual64, DualNum, first_derivative};

use super::support::{assert_close, assert_exists, by_both, scene};
use super::texts::{EDGE, STOP};

/// Derivatives are as good as the motion: tolerances of 1e-12 leave this.
pub(super) const CLOSE: f64 = 1e-9;

/// Derivatives of a function of several numbers by each of them.
pub(super) fn derivatives(f: impl Fn(&[Dual64]) -> Dual64, at: &[f64]) -> Vec<f64> {
    let by = |k: usize| {
        let along = |x: Dual64| {
            let mut values: Vec<Dual64> = at.iter().map(|&value| Dual64::from(value)).collect();
            values[k] = x;
            f(&values)
        };
        first_derivative(along, at[k]).1
    };
    (0..at.len()).map(by).collect()
}

#[track_caller]
pub(super) fn assert_row(found: &[f64], right: &[f64], what: &str) {
    assert_eq!(found.len(), right.len());
    for (k, (found, right)) in found.iter().zip(right).enumerate() {
        assert_close(*found, *right, CLOSE, &format!("{what}, quantity {k}"));
    }
}

const BALL: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.5, e = 0.7, height: m = 1.3, v0: m/s = 0.4 }
    coordinates { z: m }
    lagrangian m/2*dot(z)^2 - m*g*z
    surface floor: z >= 0
    impact floor: restitution e
    start { z: height, dot(z): v0 }
    outputs { energy: J = m/2*dot(z)^2 + m*g*z, height_of_fall = z/height, blows: N*s = impulse(floor) }
    horizon 1 [s]
";

/// Times of the first impacts, and height and velocity at `t` behind them, for `(g, e, height, v0)`.
pub(super) fn bounces(p: &[Dual64], t: f64, impacts: usize) -> (Vec<Dual64>, Dual64, Dual64) {
    let (g, e, height, v0) = (p[0], p[1], p[2], p[3]);
    let speed = (v0 * v0 + g * height * 2.0).sqrt();
    let mut time = (v0 + speed) / g;
    let mut up = speed * e;
    let mut times = Vec::new();
    if impacts == 0 {
        let t = Dual64::from(t);
        return (times, height + v0 * t - g * t * t / 2.0, v0 - g * t);
    }
    for k in 0..impacts {
        times.push(time);
        if k + 1 < impacts {
            time += up * 2.0 / g;
            up *= e;
        }
    }
    let since = Dual64::from(t) - time;
    (times, up * since - g * since * since / 2.0, up - g * since)
}

#[test]
fn bouncing_ball_before_and_after_impacts() {
    let at = [9.5, 0.7, 1.3, 0.4];
    for (horizon, impacts) in [(0.3, 0), (0.9, 1), (1.4, 2), (2.2, 4)] {
        let text = BALL.replace("horizon 1", &format!("horizon {horizon}"));
        for (run, gradient) in by_both(&scene(&text, &[]), &["g", "e", "height", "v0", "m"]) {
            assert_exists(&gradient);
            assert_eq!(run.events.len(), impacts);
            let mut right = derivatives(|p| bounces(p, horizon, impacts).1, &at);
            right.push(0.0);
            assert_row(&gradient.q[0], &right, "height");
            let mut right = derivatives(|p| bounces(p, horizon, impacts).2, &at);
            right.push(0.0);
            assert_row(&gradient.v[0], &right, "velocity");
            for (k, times) in gradient.event_times.iter().enumerate() {
                let mut right = derivatives(|p| bounces(p, horizon, impacts).0[k], &at);
                right.push(0.0);
                assert_row(times, &right, "time of an impact");
            }
            // The energy at the end is that at the start times e^2 an impact, and a jump of `m (1 + e)` times the speed is
            // the impulse.
            let last = run.trajectory.time.len() - 1;
            let energy = |p: &[Dual64]| {
                let start = p[4] * (p[3] * p[3] / 2.0 + p[0] * p[2]);
                start * p[1].powi(2 * impacts as i32)
            };
            let all = [9.5, 0.7, 1.3, 0.4, 2.0];
            assert_row(
                &gradient.outputs[0][last],
                &derivatives(energy, &all),
                "energy",
            );
            let share = |p: &[Dual64]| bounces(p, horizon, impacts).1 / p[2];
            assert_row(
                &gradient.outputs[1][last],
                &derivatives(share, &all),
                "share",
            );
            let blows = |p: &[Dual64]| {
                let speed = (p[3] * p[3] + p[0] * p[2] * 2.0).sqrt();
                let factors = (0..impacts as i32).map(|k| p[1].powi(k));
                let sum = factors.fold(Dual64::from(0.0), |sum, factor| sum + factor);
                sum * (p[1] + 1.0) * speed * p[4]
            };
            assert_row(
                &gradient.outputs[2][last],
                &derivatives(blows, &all),
                "impulses",
            );
        }
    }
}

#[test]
fn derivatives_at_the_instant_of_an_impact_are_those_of_both_sides() {
    let at = [9.5, 0.7, 1.3, 0.4];
    for (run, gradient) in by_both(&scene(BALL, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        let time = run.events[0].time;
        let first = run.trajectory.time.partition_point(|&t| t < time);
        assert_eq!(run.trajectory.time[first + 1], time);
        for (side, impacts) in [(first, 0), (first + 1, 1)] {
            let states = &gradient.states[side];
            let right = derivatives(|p| bounces(p, time, impacts).1, &at);
            assert_row(&states[0], &right, "height");
            let right = derivatives(|p| bounces(p, time, impacts).2, &at);
            assert_row(&states[1], &right, "velocity");
        }
    }
}

#[test]
fn initial_values_are_parameters_of_a_motion() {
    let scene = scene(BALL, &[]);
    for (_, gradient) in by_both(&scene, &["height", "z", "dot(z)", "v0"]) {
        assert_exists(&gradient);
        assert_close(
            gradient.q[0][1],
            gradient.q[0][0],
            CLOSE,
            "start by its parameter",
        );
        assert_close(
            gradient.v[0][2],
            gradient.v[0][3],
            CLOSE,
            "velocity by its parameter",
        );
    }
    // A start that is given replaces the one that depends on parameters.
    let given = simulate(&scene)
        .start("z", 1.1)
        .gradient(["height", "z"])
        .unwrap()
        .1;
    assert_eq!(given.q[0][0], 0.0);
    assert!(given.q[0][1].abs() > 0.1);
}

#[test]
fn horizon_that_depends_on_parameters_moves_the_end() {
    let text = BALL.replace("horizon 1 [s]", "horizon 3*v0/g + 0.2 [s]");
    let at = [9.5, 0.7, 1.3, 0.4];
    for (_, gradient) in by_both(&scene(&text, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        let height = |p: &[Dual64]| {
            let t = p[3] * 3.0 / p[0] + 0.2;
            p[2] + p[3] * t - p[0] * t * t / 2.0
        };
        assert_row(&gradient.q[0], &derivatives(height, &at), "height");
    }
}

#[test]
fn surfaces_and_laws_read_parameters() {
    // A floor at height `b` that rises at the rate `w`, and a restitution `k^2`.
    let text = "
        parameters { g: m/s^2 = 9, b: m = 0.2, w: m/s = 0.3, k = 0.8 }
        coordinates { z: m }
        lagrangian dot(z)^2/2 - g*z
        surface floor: z - b - w*t >= 0
        impact floor: restitution k^2
        start { z: 1 [m] }
        horizon 0.6 [s]
    ";
    let text = text.replace("dot(z)^2/2 - g*z", "1[kg]*(dot(z)^2/2 - g*z)");
    let at = [9.0, 0.2, 0.3, 0.8];
    let time = |p: &[Dual64]| {
        let (g, b, w) = (p[0], p[1], p[2]);
        ((w * w + g * (-b + 1.0) * 2.0).sqrt() - w) / g
    };
    let height = |p: &[Dual64]| {
        let t = time(p);
        let (g, w, e) = (p[0], p[2], p[3] * p[3]);
        // Newton's law for the velocity relative to the floor.
        let up = w - e * (-g * t - w);
        let since = -t + 0.6;
        p[1] + w * t + up * since - g * since * since / 2.0
    };
    for (_, gradient) in by_both(&scene(&text, &[]), &["g", "b", "w", "k"]) {
        assert_exists(&gradient);
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        assert_row(&gradient.q[0], &derivatives(height, &at), "height");
    }
}

#[test]
fn block_with_friction_that_stops() {
    let text = "
        parameters { m: kg = 3, g: m/s^2 = 9.7, mu = 0.35, v0: m/s = 2.1 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        impact floor: inelastic, friction mu, sliding dot(x)
        start { x: 0 [m], z: 0 [m], dot(x): v0 }
        outputs { rubbing: N = friction_force(floor), load: N = force(floor) }
        horizon 1.5 [s]
    ";
    let at = [9.7, 0.35, 2.1, 3.0];
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "mu", "v0", "m"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 1);
        let time = |p: &[Dual64]| p[2] / (p[1] * p[0]);
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        let way = |p: &[Dual64]| p[2] * p[2] / (p[1] * p[0] * 2.0);
        assert_row(&gradient.q[0], &derivatives(way, &at), "way");
        assert_row(&gradient.v[0], &[0.0; 4], "rest");
        // While it slides, and when it stands.
        let slides = derivatives(|p| -p[3] * p[1] * p[0], &at);
        assert_row(&gradient.outputs[0][0], &slides, "friction");
        let last = run.trajectory.time.len() - 1;
        assert_row(&gradient.outputs[0][last], &[0.0; 4], "friction at rest");
        let load = derivatives(|p| p[3] * p[0], &at);
        assert_row(&gradient.outputs[1][last], &load, "load");
    }
}

#[test]
fn dry_friction_that_brings_a_wheel_to_rest() {
    let text = "
        parameters { j: kg*m^2 = 2, torque: N*m = 0.9, w0: rad/s = 3 }
        coordinates { phi: rad }
        lagrangian j/2*dot(phi)^2
        dry friction brake: bound torque, sliding dot(phi)
        start { dot(phi): w0 }
        horizon 8 [s]
    ";
    let at = [2.0, 0.9, 3.0];
    for (_, gradient) in by_both(&scene(text, &[]), &["j", "torque", "w0"]) {
        assert_exists(&gradient);
        let time = |p: &[Dual64]| p[2] * p[0] / p[1];
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        let turn = |p: &[Dual64]| p[2] * p[2] * p[0] / (p[1] * 2.0);
        assert_row(&gradient.q[0], &derivatives(turn, &at), "angle");
    }
}

#[test]
fn body_that_leaves_a_dome() {
    let text = "
        parameters { m: kg = 1, g: m/s^2 = 9.81, r: m = 2, v0: m/s = 1 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface dome: sqrt(x^2 + z^2) - r >= 0
        impact dome: inelastic
        start { x: 0 [m], z: r, dot(x): v0 }
        horizon 1.2 [s]
    ";
    let at = [9.81, 2.0, 1.0];
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "r", "v0"]) {
        assert_exists(&gradient);
        let event = run
            .events
            .iter()
            .position(|event| event.kind == EventKind::LiftOff)
            .unwrap();
        let k = run
            .trajectory
            .time
            .partition_point(|&t| t < run.events[event].time);
        // Where it leaves, by the balance of energy: the place moves by its derivative at a fixed time and with that time.
        let height = |p: &[Dual64]| p[1] * (p[2] * p[2] / (p[0] * p[1] * 3.0) + 2.0 / 3.0);
        let speed = |p: &[Dual64]| (p[0] * height(p)).sqrt();
        let moved = |component: usize, rate: f64| -> Vec<f64> {
            let states = gradient.states[k][component].iter();
            states
                .zip(&gradient.event_times[event])
                .map(|(s, t)| s + rate * t)
                .collect()
        };
        let v = &run.trajectory.v[k];
        let acceleration = |component: usize| if component == 3 { -9.81 } else { 0.0 };
        assert_row(&moved(1, v[1]), &derivatives(height, &at), "height");
        let right = derivatives(|p| speed(p) * height(p) / p[1], &at);
        assert_row(&moved(2, acceleration(2)), &right, "velocity");
        // From there it flies.
        let flight = run.trajectory.time.last().unwrap() - run.events[event].time;
        for by in 0..3 {
            let (x, u, t) = (
                moved(0, v[0])[by],
                moved(2, 0.0)[by],
                gradient.event_times[event][by],
            );
            assert_close(gradient.q[0][by], x + u * flight - v[0] * t, CLOSE, "end");
        }
    }
}

#[test]
fn oblique_throw_with_friction_that_slides_and_that_stops() {
    let text = "
        parameters { m: kg = 1, g: m/s^2 = 9.81, mu = 0.2, e = 0.6, u0: m/s = 3, height: m = 1 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        impact floor: restitution e, friction mu, sliding dot(x)
        start { x: 0 [m], z: height, dot(x): u0 }
        horizon 0.9 [s]
    ";
    for (mu, sticks) in [(0.2, false), (0.9, true)] {
        let at = [9.81, mu, 0.6, 3.0, 1.0];
        let x = |p: &[Dual64]| {
            let time = (p[4] * 2.0 / p[0]).sqrt();
            let speed = (p[4] * p[0] * 2.0).sqrt();
            let after = if sticks {
                p[3] * 0.0
            } else {
                p[3] - p[1] * (p[2] + 1.0) * speed
            };
            p[3] * time + after * (-time + 0.9)
        };
        let scene = scene(text, &[("mu", mu)]);
        for (_, gradient) in by_both(&scene, &["g", "mu", "e", "u0", "height"]) {
            assert_exists(&gradient);
            assert_row(&gradient.q[0], &derivatives(x, &at), "way");
        }
    }
}

/// Complete elliptic integral of the first kind by the arithmetic-geometric mean.
fn quarter(k: Dual64) -> Dual64 {
    let (mut a, mut b) = (Dual64::from(1.0), (-k * k + 1.0).sqrt());
    for _ in 0..8 {
        (a, b) = ((a + b) / 2.0, (a * b).sqrt());
    }
    Dual64::from(std::f64::consts::FRAC_PI_2) / a
}

#[test]
fn pendulum_that_strikes_a_wall() {
    let text = "
        parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1.2, e = 0.7, theta0: rad = 1.1 }
        coordinates { theta: rad }
        lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos(theta)
        surface wall: l*sin(theta) >= 0
        impact wall: restitution e
        start { theta: theta0 }
        horizon 2.5 [s]
    ";
    let at = [9.81, 1.2, 0.7, 1.1];
    // A quarter of a swing, and then two of each that follows, whose amplitude has its sine of the half lessened by `e`.
    let time = |p: &[Dual64], impact: usize| {
        let slowness = (p[1] / p[0]).sqrt();
        let mut k = (p[3] / 2.0).sin();
        let mut time = quarter(k) * slowness;
        for _ in 0..impact {
            k *= p[2];
            time += quarter(k) * slowness * 2.0;
        }
        time
    };
    for (run, gradient) in by_both(&scene(text, &[]), &["g", "l", "e", "theta0"]) {
        assert_exists(&gradient);
        assert!(run.events.len() >= 2);
        for impact in 0..run.events.len() {
            let right = derivatives(|p| time(p, impact), &at);
            assert_row(&gradient.event_times[impact], &right, "time");
        }
    }
}

#[test]
fn objective_along_a_motion() {
    // The integral of the height, and the square of the last velocity with a weight, of a ball that bounces once.
    let text = BALL.replace(
        "horizon 1 [s]",
        "minimize integral(z/1[m*s]) + height/1[m]*(dot(z)/1[m/s])^2 horizon 0.7 + height/2[m/s] [s]",
    );
    let text = text.replace("0.7 + height/2[m/s] [s]", "0.3[s] + height/2[m/s]");
    let at = [9.5, 0.7, 1.3, 0.4];
    let objective = |p: &[Dual64]| {
        let (g, e, height, v0) = (p[0], p[1], p[2], p[3]);
        let end = height / 2.0 + 0.3;
        let speed = (v0 * v0 + g * height * 2.0).sqrt();
        let impact = (v0 + speed) / g;
        let area =
            |from: Dual64, up: Dual64, t: Dual64| from * t + up * t * t / 2.0 - g * t * t * t / 6.0;
        let since = end - impact;
        let last = e * speed - g * since;
        area(height, v0, impact) + area(height * 0.0, e * speed, since) + height * last * last
    };
    for (run, gradient) in by_both(&scene(&text, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        assert_eq!(run.events.len(), 1);
        assert_row(
            &gradient.objective.unwrap(),
            &derivatives(objective, &at),
            "objective",
        );
    }
}

#[test]
fn body_that_passes_an_edge() {
    let at = [9.6, 0.3, 0.1, 3.0];
    // Down one slope for 1 m, and up the other with what the second takes of the velocity.
    let time = |p: &[Dual64]| {
        let rate = p[0] * p[1] / (p[1] * p[1] + 1.0);
        ((p[3] * p[3] + rate * 2.0).sqrt() - p[3]) / rate
    };
    let way = |p: &[Dual64]| {
        let (a, b) = (p[1], p[2]);
        let speed = p[3] + p[0] * a / (a * a + 1.0) * time(p);
        let after = speed * (-a * b + 1.0) / (b * b + 1.0);
        let since = -time(p) + 0.6;
        after * since - p[0] * b / (b * b + 1.0) * since * since / 2.0
    };
    for (_, gradient) in by_both(&scene(EDGE, &[]), &["g", "a", "b", "v0"]) {
        assert_exists(&gradient);
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        assert_row(&gradient.q[0], &derivatives(way, &at), "way");
    }
}

#[test]
fn end_of_infinitely_many_bounces() {
    let text = BALL.replace("horizon 1 [s]", "horizon 4 [s]");
    let rest = |p: &[Dual64]| {
        let (g, e, height, v0) = (p[0], p[1], p[2], p[3]);
        let speed = (v0 * v0 + g * height * 2.0).sqrt();
        (v0 + speed) / g + speed * 2.0 * e / (g * (-e + 1.0))
    };
    let right = derivatives(rest, &[9.5, 0.7, 1.3, 0.4]);
    for (_, gradient) in by_both(&scene(&text, &[]), &["g", "e", "height", "v0"]) {
        assert_exists(&gradient);
        assert_row(&gradient.q[0], &[0.0; 4], "rest");
        // Bounces that are left out, slower than a millionth of the first, would take that share of the time.
        for (found, right) in gradient.event_times.last().unwrap().iter().zip(&right) {
            assert_close(*found, *right, 1e-4, "time of rest");
        }
    }
}

#[test]
fn rate_that_jumps_is_crossed() {
    let text = "
        parameters { a: 1/s = 3, b: 1/s = 1.2, c = 0.1, x0 = -0.9 }
        states { x }
        rates { x: if x >= c { a } else { b } }
        start { x: x0 }
        horizon 2 [s]
    ";
    let at = [3.0, 1.2, 0.1, -0.9];
    let time = |p: &[Dual64]| (p[2] - p[3]) / p[1];
    let end = |p: &[Dual64]| p[2] + p[0] * (-time(p) + 2.0);
    for (_, gradient) in by_both(&scene(text, &[]), &["a", "b", "c", "x0"]) {
        assert_exists(&gradient);
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        assert_row(&gradient.v[0], &derivatives(end, &at), "end");
    }
}

#[test]
fn relay_slides_and_is_left() {
    // It arrives where x0 + a t^2/2 = r t, slides with the sign a t/r, and leaves where that is 1.
    let text = "
        parameters { a: 1/s^2 = 0.9, r: 1/s = 1.1, x0 = 0.3, w: 1/s = 0.7 }
        states { x, y }
        rates { x: a*t - sign(x)*r, y: sign(x)*w }
        start { x: x0 }
        horizon 2 [s]
    ";
    let at = [0.9, 1.1, 0.3, 0.7];
    let arrives = |p: &[Dual64]| (p[1] - (p[1] * p[1] - p[0] * p[2] * 2.0).sqrt()) / p[0];
    let leaves = |p: &[Dual64]| p[1] / p[0];
    let x = |p: &[Dual64]| p[0] * (-leaves(p) + 2.0).powi(2) / 2.0;
    let y = |p: &[Dual64]| {
        let (first, last) = (arrives(p), leaves(p));
        let sliding = p[0] / p[1] * (last * last - first * first) / 2.0;
        p[3] * (first + sliding - last + 2.0)
    };
    for (_, gradient) in by_both(&scene(text, &[]), &["a", "r", "x0", "w"]) {
        assert_exists(&gradient);
        assert_row(
            &gradient.event_times[0],
            &derivatives(arrives, &at),
            "arrival",
        );
        assert_row(
            &gradient.event_times[1],
            &derivatives(leaves, &at),
            "leaving",
        );
        assert_row(&gradient.v[0], &derivatives(x, &at), "x");
        assert_row(&gradient.v[1], &derivatives(y, &at), "y");
    }
}

#[test]
fn stop_of_rubber_and_step_of_the_time() {
    let at = [0.7, 40.0, 1.3, -0.5, 0.4, 0.9];
    // It is thrown back after half a period, and pushed on from `t1` on.
    let end = |p: &[Dual64]| {
        let leaves = -p[3] / p[2] + (p[0] / p[1]).sqrt() * std::f64::consts::PI;
        let since = -p[5] + 1.6;
        -p[2] * (-leaves + 1.6) - p[4] / p[0] * since * since / 2.0
    };
    for (_, gradient) in by_both(&scene(STOP, &[]), &["m", "k", "v0", "x0", "push", "t1"]) {
        assert_exists(&gradient);
        assert_row(&gradient.q[0], &derivatives(end, &at), "end");
    }
}

/// A pendulum that strikes a wall, with the angle or with a rod as a joint.
const RODS: [&str; 2] = [
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
    let redundant = RODS[1].replace("surface", "joint again: 2*x^2 + 2*z^2 == 2*l^2 surface");
    let names = ["m", "g", "l", "a0", "w0", "e", "wall"];
    let of = |rod: &str| by_both(&scene(&format!("{head}{rod}"), &[]), &names);
    let few = of(RODS[0]);
    for more in [of(RODS[1]), of(&redundant)] {
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
    let rod = scene(&format!("{head}{}", RODS[1]), &[]);
    let refused = simulate(&rod).gradient_of(["pull"]).gradient(names);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("reads forces of joints"), "{refused}");
}

#[test]
fn disc_that_rolls_by_a_joint_of_velocities() {
    let text = "
        parameters { m: kg = 2, r: m = 0.3, g: m/s^2 = 9.6, angle: rad = 0.2, v0: m/s = 0.4 }
        coordinates { x: m, phi: rad }
        lagrangian m/2*dot(x)^2 + m*r^2/4*dot(phi)^2 + m*g*x*sin(angle)
        joint roll: dot(x) == r*dot(phi)
        start { x: 0 [m], dot(x): v0, dot(phi): v0/r*1[rad] }
        horizon 1.5 [s]
    ";
    let at = [2.0, 0.3, 9.6, 0.2, 0.4];
    let way = |p: &[Dual64]| p[4] * 1.5 + p[2] * p[3].sin() * (1.5 * 1.5 / 3.0);
    let turn = |p: &[Dual64]| way(p) / p[1];
    for (_, gradient) in by_both(&scene(text, &[]), &["m", "r", "g", "angle", "v0"]) {
        assert_exists(&gradient);
        assert_row(&gradient.q[0], &derivatives(way, &at), "way");
        assert_row(&gradient.q[1], &derivatives(turn, &at), "turn");
    }
}

#[test]
fn weight_that_a_growing_force_lifts() {
    let text = "
        parameters { m: kg = 1.5, g: m/s^2 = 9.7, c: N/s = 20 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: c*t }
        surface floor: z >= 0
        impact floor: inelastic
        start { z: 0 [m] }
        horizon 1.2 [s]
    ";
    let at = [1.5, 9.7, 20.0];
    let time = |p: &[Dual64]| p[0] * p[1] / p[2];
    let height = |p: &[Dual64]| p[2] / p[0] * (-time(p) + 1.2).powi(3) / 6.0;
    for (_, gradient) in by_both(&scene(text, &[]), &["m", "g", "c"]) {
        assert_exists(&gradient);
        assert_row(&gradient.event_times[0], &derivatives(time, &at), "time");
        assert_row(&gradient.q[0], &derivatives(height, &at), "height");
        // It lifts off at the end only if the force is as much smaller.
        let below = gradient.ranges[2].below.as_ref().unwrap();
        let by_c = -1.5 * 9.7 / 20.0 / 20.0;
        assert_close(
            below.change,
            (1.2 - 1.5 * 9.7 / 20.0) / by_c,
            CLOSE,
            "range by c",
        );
    }
}
