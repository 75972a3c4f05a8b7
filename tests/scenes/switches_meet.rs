//! Switches whose functions vanish together, or with their rates: rest, what leaves it, and what is not unique; motions against closed forms and
//! against scipy, by both methods that locate switches.

use hangtime::prelude::*;

use super::both::{ends, motions, scene};

/// What both methods say where there is no single motion.
fn refusals(text: &str) -> [String; 2] {
    let scene = scene(text);
    [
        simulate(&scene).run().expect("accepted"),
        simulate(&scene)
            .method(EventDriven::default())
            .run()
            .expect("accepted"),
    ]
    .map(|motion| {
        assert!(!motion.status.is_solved(), "{text}: {motion}");
        motion.status.to_string()
    })
}

/// Two relays, of a position and of its velocity, that pull with `a` and `b`.
fn relays(a: f64, b: f64, more: &str) -> String {
    format!(
        "states {{ x: m, v: m/s }} rates {{ x: v, v: (-{a}*sign(x) - {b}*sign(v))*1 [m/s^2] }} {more}"
    )
}

#[test]
fn load_that_relays_hold_rests_at_their_zero() {
    for (a, b) in [(1.0, 0.0), (0.7, 0.4), (2.5, 2.4), (1.3, 1.3)] {
        for motion in motions(&relays(a, b, "horizon 3 [s]")) {
            ends(&motion, &[("x", 0.0), ("v", 0.0)], 1e-300);
            assert!(motion.events.is_empty(), "{motion}");
        }
    }
}

#[test]
fn two_relays_bring_a_load_to_rest_by_infinitely_many_switches() {
    let (a, b, start) = (3.0_f64, 1.2_f64, 0.6_f64);
    let more = format!("start {{ x: {start} }} horizon 15 [s]");
    // Each half turn takes the share sqrt((a - b)/(a + b)) of the time of the one before.
    let half = (2.0 * start / (a - b)).sqrt() + (2.0 * start * (a - b)).sqrt() / (a + b);
    let rest = half / (1.0 - ((a - b) / (a + b)).sqrt());
    for motion in motions(&relays(a, b, &more)) {
        ends(&motion, &[("x", 0.0), ("v", 0.0)], 1e-9);
        let last = motion.events.last().expect("switches");
        // Switches of the last 1e-6 of the horizon are one.
        assert!(
            last.kind == EventKind::Slide && (last.time - rest).abs() < 1.5e-5,
            "{last} {rest}"
        );
    }
}

#[test]
fn rest_ends_where_a_growing_pull_is_as_strong_as_the_relay() {
    // From t = 2.5/0.4 on x'' = 0.4 (t - 6.25).
    let text = "coordinates { x: m } lagrangian dot(x)^2/2*1 [kg]
        forces { x: 2.5 [N]*sign(-x) + t*0.4 [N/s] } outputs { share = sign(x) } horizon 9 [s]";
    let beyond = 9.0_f64 - 6.25;
    for motion in motions(text) {
        let wanted = [
            ("x", 0.4 * beyond.powi(3) / 6.0),
            ("dot(x)", 0.2 * beyond * beyond),
        ];
        ends(&motion, &wanted, 1e-8);
        assert_eq!(motion.events.len(), 1);
        assert!((motion.events[0].time - 6.25).abs() < 1e-9, "{motion}");
    }
}

#[test]
fn rest_that_twisting_has_led_to_ends_where_a_ramp_is_stronger() {
    // The ramp begins within the rest, and is as strong as both relays 2.6/0.5 s later.
    let ramp = "states { x: m, v: m/s } rates { x: v, v: (-2*sign(x) - 0.6*sign(v))*1 [m/s^2] + 0.5 [m/s^3]*max(0 [s], t - 6 [s]) }";
    for (horizon, gone) in [(8.0, 0.0), (13.0, 13.0_f64 - 6.0 - 5.2)] {
        let text = format!("{ramp} start {{ x: 0.5 }} horizon {horizon} [s]");
        for motion in motions(&text) {
            let wanted = [("x", 0.5 * gone.powi(3) / 6.0), ("v", 0.25 * gone * gone)];
            ends(&motion, &wanted, 1e-7);
        }
    }
}

#[test]
fn load_that_may_stay_or_leave_is_said_to_do_either() {
    let pushed = |how: &str| format!("states {{ x, v }} rates {{ x: v, v: {how} }} horizon 2 [s]");
    let cases = [
        // To both sides, to one side, and turning round it ever further.
        pushed("1.5*sign(x)"),
        pushed("0.3*step(x)"),
        pushed("-2*sign(x) + 0.5*sign(v)"),
        // By the sign of what stays zero.
        "states { x, on } rates { x: 3*sign(on), on: 0 } horizon 2 [s]".to_owned(),
    ];
    for text in cases {
        for why in refusals(&text) {
            assert!(why.contains("not unique"), "{text}: {why}");
        }
    }
}

#[test]
fn relay_that_is_held_beside_a_motion_is_named() {
    let text = "states { x, v, y } rates { x: v, v: -sign(x), y: sign(x) + cos(t*1 [rad/s]) } horizon 2 [s]";
    for why in refusals(text) {
        assert!(why.contains("sliding of second order"), "{why}");
    }
}

#[test]
fn motion_that_begins_on_a_switch_without_speed_takes_the_side_that_follows() {
    // x = t^2 on a kink, x = -t^3 on a jump and a kink: integrals of |x|, and of it and the sign.
    let square = "states { x, y, v } rates { x: v, v: 2, y: |x| } horizon 1.5 [s]";
    let cube = "states { x, y } rates { x: -3*t^2*1 [1/s^2], y: |x| + 2*sign(x) } horizon 1.5 [s]";
    for motion in motions(square) {
        ends(&motion, &[("x", 2.25), ("y", 1.5_f64.powi(3) / 3.0)], 1e-8);
    }
    for motion in motions(cube) {
        let y = 1.5_f64.powi(4) / 4.0 - 3.0;
        ends(&motion, &[("x", -(1.5_f64.powi(3))), ("y", y)], 1e-8);
    }
}

#[test]
fn kink_in_its_own_rate_is_passed() {
    // x' = a - b|x| from -1: an exponential up to 0, and another one from there.
    let (a, b) = (0.8_f64, 0.3_f64);
    let text =
        format!("states {{ x }} rates {{ x: {a} - {b}*|x| }} start {{ x: -1 }} horizon 4 [s]");
    // Before, x + a/b grows by exp(b t).
    let passes = ((a / b) / (a / b - 1.0)).ln() / b;
    let end = a / b * (1.0 - (-b * (4.0 - passes)).exp());
    for motion in motions(&text) {
        ends(&motion, &[("x", end)], 1e-7);
        assert!(motion.events.len() == 1 && motion.events[0].kind == EventKind::Switch);
        assert!((motion.events[0].time - passes).abs() < 1e-7, "{motion}");
    }
}

#[test]
fn hysteresis_of_bouc_and_wen_begins_at_rest() {
    // Two kinks, of the velocity and of the hysteresis itself, meet at the start.
    let text = |push: &str| {
        format!(
            "coordinates {{ x: m }} states {{ z: m }} lagrangian (dot(x)^2/2 - x^2/2*1 [1/s^2])*1 [kg]
            forces {{ x: -0.1 [kg/s]*dot(x) - 2 [N/m]*z + 1 [N]*{push} }}
            rates {{ z: dot(x) - 0.5 [1/m]*|dot(x)|*z - 0.3 [1/m]*dot(x)*|z| }} horizon 10 [s]"
        )
    };
    // tools/peers/textbook.py.
    let cases = [
        (
            "sin(2 [rad/s]*t)",
            [-0.797_894_706, -0.207_285_100, -0.685_089_110],
        ),
        (
            "cos(2 [rad/s]*t)",
            [-0.104_134_865, 1.586_614_006, 0.068_763_393],
        ),
        (
            "step(t - 1 [s])",
            [0.698_568_280, 0.188_754_444, 0.330_419_093],
        ),
    ];
    for (push, [x, v, z]) in cases {
        for motion in motions(&text(push)) {
            ends(&motion, &[("x", x), ("dot(x)", v), ("z", z)], 1e-6);
        }
    }
}

#[test]
fn converter_with_a_diode_switches_off_at_its_limit() {
    // The diode lets no current back: a switch whose halves differ by 100 V stands in the rate that the limit looks at.
    let text = "parameters { vin: V = 12, ell: H = 1e-3, c: F = 1e-4, r: Ohm = 3 } states { i: A, v: V, on }
        let back = if i >= 0 [A] { 0 [V] } else { 100 [V] }
        rates { i: (vin*on - v + back)/ell, v: (i - v/r)/c }
        when i >= 3 [A] { on = 0 } when v <= 4.8 [V] { on = 1 } start { on: 1 } horizon 4 [ms]";
    for motion in motions(text) {
        // tools/peers/textbook.py.
        ends(&motion, &[("i", 2.491_015_498), ("v", 6.304_902_224)], 1e-6);
        let times: Vec<f64> = motion.events.iter().map(|event| event.time).collect();
        assert_eq!(times.len(), 11);
        assert!((times[10] - 3.915_813_155e-3).abs() < 1e-9, "{times:?}");
    }
}

/// A text whose function `x` has the rate `push t^p - jump t^q s` by its sign `s` from zero on, for each way to write that.
fn kinds(push: f64, jump: f64, (p, q): (i32, i32)) -> Vec<(&'static str, String)> {
    let power = |factor: f64, power: i32| match power {
        0 => format!("({factor})"),
        _ => format!("({factor})*(t*1 [1/s])^{power}"),
    };
    let (f, g) = (power(push, p), power(jump, q));
    let states = |rate: String, more: &str| format!("states {{ x }} rates {{ x: {rate} }} {more}");
    // The jump as a state, which moves.
    let grows = match q {
        0 => "0".to_owned(),
        _ => power(jump * f64::from(q), q - 1),
    };
    let from = if q == 0 { jump } else { 0.0 };
    let damper = format!(
        "coordinates {{ s: m }} lagrangian dot(s)^2/2*1 [kg] forces {{ s: ({f} - {g}*sign(dot(s)))*1 [N] }}"
    );
    let two = format!(
        "coordinates {{ a: m, b: m }} let w = dot(a) - dot(b) lagrangian (dot(a)^2 + dot(b)^2)/2*1 [kg]
        let force = if w >= 0 [m/s] {{ {g} }} else {{ -({g}) }}
        forces {{ a: ({f} - force/2)*1 [N], b: force/2*1 [N] }}"
    );
    vec![
        ("sign", states(format!("{f} - {g}*sign(x)"), "")),
        ("scaled", states(format!("{f} - {g}*sign(1e4*x)"), "")),
        ("mirrored", states(format!("{f} + {g}*sign(-x)"), "")),
        ("step", states(format!("{f} - {g}*(2*step(x) - 1)"), "")),
        (
            "if",
            states(format!("{f} - (if x >= 0 {{ {g} }} else {{ -({g}) }})"), ""),
        ),
        (
            "one branch",
            states(
                format!("{f} - {g} + (if x >= 0 {{ 0 }} else {{ 2*{g} }})"),
                "",
            ),
        ),
        (
            "elsewhere",
            states(format!("{f} - {g}*sign(x - 5)"), "start { x: 5 }"),
        ),
        (
            "moving threshold",
            states(format!("{f} + 1 - {g}*sign(x - t*1 [1/s])"), ""),
        ),
        (
            "a state as jump",
            format!(
                "states {{ x, y }} rates {{ x: {f} - y*sign(x), y: {grows} }} start {{ y: {from} }}"
            ),
        ),
        (
            "beside a kink",
            format!("states {{ x, y }} rates {{ x: {f} - {g}*sign(x), y: |x| }}"),
        ),
        ("damper", damper),
        ("damper between two", two),
        (
            "twice",
            states(format!("{f} - ({g})/2*sign(x) - ({g})/2*sign(2*x)"), ""),
        ),
    ]
}

/// Of every kind and every order in which the rate and the jump vanish: the first derivative of the function that does not vanish decides,
/// along the motion of each side by itself.
#[test]
fn leading_derivative_decides_whatever_vanishes_before_it() {
    let orders = (0..4).flat_map(|p| (0..3).map(move |q| (p, q)));
    for (p, q) in orders {
        for (push, jump) in [
            (0.8, 0.3),
            (-0.8, 0.3),
            (0.3, 0.7),
            (0.6, -0.4),
            (-0.2, -0.5),
        ] {
            let crosses = p < q || p == q && f64::abs(push) > f64::abs(jump);
            let side = f64::signum(push);
            // On one side until 1 s, by integration; otherwise both sides lead back, or both lead away.
            let way = |order: i32, factor: f64| factor / f64::from(order + 1);
            let end = if crosses {
                way(p, push) - side * way(q, jump)
            } else {
                0.0
            };
            for (kind, text) in kinds(push, jump, (p, q)) {
                let text = format!("{text} horizon 1 [s]");
                let case = format!("{kind}: t^{p}, t^{q}, {push}, {jump}");
                if !crosses && jump < 0.0 {
                    for why in refusals(&text) {
                        assert!(why.contains("not unique"), "{case}: {why}");
                    }
                    continue;
                }
                if crosses && end * side < 0.0 || !crosses && push.abs() > jump {
                    continue;
                }
                let (name, end) = match kind {
                    "elsewhere" => ("x", 5.0 + end),
                    "moving threshold" => ("x", 1.0 + end),
                    "damper" => ("dot(s)", end),
                    // Half of the momentum, and of the difference.
                    "damper between two" => ("dot(a)", (way(p, push) + end) / 2.0),
                    _ => ("x", end),
                };
                println!("{case}");
                for motion in motions(&text) {
                    ends(&motion, &[(name, end)], 1e-6);
                }
            }
        }
    }
}
