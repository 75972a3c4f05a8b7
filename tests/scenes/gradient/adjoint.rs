//! Derivatives of values at the end, backwards along the motion, against those forwards and against closed forms.

use hangtime::derivative::{Gradient, GradientMode};
use hangtime::prelude::*;
use hangtime::simulation::Simulator;
use hangtime_scene_files::TextScene;

use super::support::{TOLERANCE, assert_close, assert_exists, scene};
use super::texts::{BELT, CEILING, HILLS, HUMP, LINKS};

/// Names, text, initial values, and values at the end.
struct Case {
    name: &'static str,
    text: &'static str,
    from: &'static [&'static str],
    of: &'static [&'static str],
}

const CASES: [Case; 7] = [
    Case {
        name: "a ball that bounces on a floor that moves, with an objective and a horizon that depend on parameters",
        text: "
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
        ",
        from: &["z", "dot(z)"],
        of: &["objective", "z", "dot(z)", "pushed", "energy", "event_times[0]", "event_times[1]"],
    },
    Case {
        name: "a ball that rubs on hills",
        text: HILLS,
        from: &["x", "dot(z)"],
        of: &["x", "rubbed", "event_times[1]"],
    },
    Case {
        name: "two links that strike a wall",
        text: LINKS,
        from: &["a", "dot(b)"],
        of: &["a", "dot(b)", "event_times[0]"],
    },
    Case {
        name: "a block on a belt that sticks and slips",
        text: BELT,
        from: &["x", "dot(x)"],
        of: &["dot(x)", "rubbing", "load", "event_times[0]", "event_times[1]"],
    },
    Case {
        name: "a body that slides over a hump, leaves it and lands",
        text: HUMP,
        from: &[],
        of: &["x", "event_times[0]", "event_times[1]"],
    },
    Case {
        name: "a motor with inductance that winds up a weight from the floor",
        text: "
            parameters { m: kg = 0.5, r: m = 0.1, k: N*m/A = 0.4, ell: H = 0.5, ohm: Ohm = 2, volt: V = 5, g: m/s^2 = 9.81 }
            coordinates { z: m }
            states { i: A }
            lagrangian m/2*dot(z)^2 - m*g*z
            forces { z: k/r*i }
            rates { i: (volt - ohm*i - k/r*dot(z))/ell }
            surface floor: z >= 0
            impact floor: inelastic
            start { z: 0 [m], i: 0 [A] }
            horizon 1.5 [s]
        ",
        from: &["i"],
        of: &["z", "i"],
    },
    Case {
        name: "a rod, as a joint, that strikes a wall and rubs on it",
        text: "
            parameters { m: kg = 1.2, g: m/s^2 = 9.7, l: m = 0.8, a0: rad = 1.1, w0: rad/s = 0.3, e = 0.6, mu = 0.1, wall: m = -0.2 }
            coordinates { x: m, z: m }
            lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
            joint rod: x^2 + z^2 == l^2
            surface stop: x - wall >= 0
            impact stop: restitution e, friction mu, sliding dot(z)
            start { x: l*sin(a0), z: -l*cos(a0), dot(x): l*cos(a0)*w0, dot(z): l*sin(a0)*w0 }
            horizon 1.4 [s]
        ",
        from: &["dot(x)"],
        of: &["x", "dot(z)", "event_times[0]"],
    },
];

fn differentiated(
    scene: &TextScene,
    method: impl Simulator,
    (by, of): (&[&str], &[&str]),
    mode: GradientMode,
) -> (Simulation, Gradient) {
    let run = simulate(scene).method(method).tolerance(TOLERANCE);
    let run = run.gradient_of(of.iter().copied()).gradient_mode(mode);
    let (run, gradient) = run.gradient(by.iter().copied()).unwrap();
    assert!(run.status.is_solved(), "{run}");
    (run, gradient)
}

/// Both have the same values: they are the same sums in another order, so that only rounding lies between them, which the
/// sensitivities of the motion amplify; the largest of a row is what each of its terms is compared with.
#[track_caller]
fn assert_same(name: &str, forward: &Gradient, backward: &Gradient) {
    assert_exists(forward);
    assert_exists(backward);
    assert_eq!(forward.mode, GradientMode::Forward, "{name}");
    assert_eq!(backward.mode, GradientMode::Adjoint, "{name}");
    assert_eq!(forward.with_respect_to, backward.with_respect_to);
    for ((of, forward), (_, backward)) in forward.values.iter().zip(&backward.values) {
        let largest = forward.iter().fold(0.0_f64, |most, by| most.max(by.abs()));
        assert!(largest > 0.0, "{name}: nothing to compare in {of}");
        for (k, (forward, backward)) in forward.iter().zip(backward).enumerate() {
            let off = (forward - backward).abs();
            assert!(
                off <= 1e-12 * largest,
                "{name}: {of} by {k}: forward {forward}, backward {backward}, off by {off:e}"
            );
        }
    }
    assert_eq!(forward.objective.is_some(), backward.objective.is_some());
}

fn compare(cases: &[Case]) {
    for case in cases {
        let scene = scene(case.text, &[]);
        let mut by = vec!["all"];
        by.extend(case.from);
        let both = |mode| {
            [
                differentiated(&scene, Fesd::default(), (&by, case.of), mode).1,
                differentiated(&scene, EventDriven::default(), (&by, case.of), mode).1,
            ]
        };
        let (forward, backward) = (both(GradientMode::Forward), both(GradientMode::Adjoint));
        for (forward, backward) in forward.iter().zip(&backward) {
            let objective = case.of.contains(&"objective");
            if objective {
                assert_eq!(forward.objective.as_ref(), Some(&forward.values[0].1));
            }
            let known = Gradient {
                objective: forward.objective.clone().filter(|_| objective),
                ..forward.clone()
            };
            assert_same(case.name, &known, backward);
            assert!(backward.q.is_empty() && backward.event_times.is_empty());
        }
    }
}

#[test]
fn backward_derivatives_through_impacts_and_friction_are_the_forward_ones() {
    compare(&CASES[..4]);
}

#[test]
fn backward_derivatives_of_arcs_in_contact_and_joints_are_the_forward_ones() {
    compare(&CASES[4..]);
}

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
    let scene = scene(CASES[0].text, &[]);
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
    let scene = scene(CASES[1].text, &[]);
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
