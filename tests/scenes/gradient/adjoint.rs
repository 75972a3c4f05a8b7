//! Derivatives of values at the end, backwards along the motion, against closed forms, and what is said of them.

use hangtime::derivative::GradientMode;
use hangtime::prelude::*;

use super::support::{TOLERANCE, assert_close, assert_exists, scene};
use super::texts::{CEILING, HILLS};

/// A ball that bounces on a floor that moves, with an objective and a horizon that depend on parameters.
const BALL: &str = "
    parameters { m: kg = 1.3, g: m/s^2 = 9.7, e = 0.7, height: m = 1.1, v0: m/s = 0.4, a: m = 0.05, w: rad/s = 7, c: N*s/m = 0.3 }
    coordinates { z: m }
    lagrangian m/2*dot(z)^2 - m*g*z
    forces { z: -c*dot(z) }
    surface floor: z - a*sin(w*t) >= 0
    impact floor: restitution e
    start { z: height, dot(z): v0 }
    horizon 0.9 [s] + height/4[m/s]
    minimize integral(g*z^2/1[m^3/s]) + height/1[m]*(dot(z)/1[m/s])^2 + m*z/1[kg*m]
    outputs { pushed: N*s = impulse(floor), energy: J = m/2*dot(z)^2 + m*g*z }
";

/// A ball under a force with this many harmonics.
fn harmonics(count: usize) -> String {
    let amplitudes: Vec<String> = (1..=count)
        .map(|k| format!("a{k}: N = {}", 0.5 / (k * k) as f64))
        .collect();
    let terms: Vec<String> = (1..=count).map(|k| format!("a{k}*cos({k}*w*t)")).collect();
    format!(
        "parameters {{ e = 0.6, w: rad/s = 1.5, {} }}
         coordinates {{ z: m }}
         lagrangian 1[kg]*(dot(z)^2/2 - 9.81[m/s^2]*z)
         forces {{ z: {} }}
         surface floor: z >= 0
         impact floor: restitution e
         start {{ z: 1 [m] }}
         horizon 0.8 [s]",
        amplitudes.join(", "),
        terms.join(" + ")
    )
}

#[test]
fn hundred_parameters_of_a_force_have_their_closed_form() {
    const COUNT: usize = 100;
    let text = harmonics(COUNT);
    let scene = scene(&text, &[]);
    let names: Vec<String> = (1..=COUNT).map(|k| format!("a{k}")).collect();
    let run = simulate(&scene).tolerance(TOLERANCE);
    let run = run.gradient_of(["z", "event_times[0]"]);
    let (run, gradient) = run.gradient(names.iter().map(String::as_str)).unwrap();
    assert_exists(&gradient);
    assert_eq!(gradient.mode, GradientMode::Adjoint);
    assert_eq!(run.events.len(), 1, "{run}");
    let (w, e, end) = (1.5, 0.6, 0.8);
    let impact = run.events[0].time;
    // What a harmonic adds to velocity and height without the floor.
    let speed = |k: f64, t: f64| (k * w * t).sin() / (k * w);
    let height = |k: f64, t: f64| (1.0 - (k * w * t).cos()) / (k * w).powi(2);
    let harmonics = || (1..=COUNT).map(|k| (k as f64, 0.5 / (k * k) as f64));
    let force = |t: f64| -> f64 { harmonics().map(|(k, a)| a * (k * w * t).cos()).sum() };
    let fall: f64 = harmonics().map(|(k, a)| a * speed(k, impact)).sum();
    let before = fall - 9.81 * impact;
    let rate = force(impact) - 9.81;
    let times = &gradient.values[1].1;
    for (k, (found, time)) in (1..=COUNT).zip(gradient.values[0].1.iter().zip(times)) {
        let k = k as f64;
        let moves = -height(k, impact) / before;
        assert_close(*time, moves, 1e-10, "time of the impact by a harmonic");
        let after = -e * (speed(k, impact) + rate * moves) - rate * moves;
        let since = end - impact;
        let later = height(k, end) - height(k, impact) - speed(k, impact) * since;
        let right = e * before * moves + after * since + later;
        // The largest are about 0.5, and a motion is known to about 1e-12.
        assert_close(*found, right, 1e-10, "height by a harmonic");
    }
}

#[test]
fn more_quantities_than_values_are_differentiated_backwards() {
    let scene = scene(BALL, &[]);
    let of = |by: &[&str], of: &[&str]| {
        let run = simulate(&scene).gradient_of(of.iter().copied());
        run.gradient(by.iter().copied()).unwrap().1
    };
    assert_eq!(of(&["e", "g"], &["z"]).mode, GradientMode::Adjoint);
    assert_eq!(
        of(&["e", "g"], &["z", "energy"]).mode,
        GradientMode::Forward
    );
    assert_eq!(of(&["all"], &[]).mode, GradientMode::Forward);
    let forward = of(&["e"], &["z"]);
    assert_eq!(forward.values[0].1, forward.q[0]);
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
