//! Switches whose functions vanish together with their rates, of every kind and order, by both methods that locate switches; motions in
//! closed form stand in `tests/cases/meet.md`.

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
