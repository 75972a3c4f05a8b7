//! Friction that changes with the speed of sliding and with the place, and friction of rest.

use super::{events, motions, motions_under, refusal, scene};
use hangtime::baselines::Smooth;
use hangtime::prelude::*;

/// A block on a belt, held by a spring.
fn popp(friction: &str) -> String {
    format!(
        "parameters {{ m: kg = 1.3, k: N/m = 2.1, belt: m/s = 0.4, g: m/s^2 = 9.81, vs: m/s = 0.25 }}
        coordinates {{ x: m, z: m }}
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z - k/2*x^2
        surface ground: z >= 0
        impact ground: inelastic, friction {friction}, sliding dot(x) - belt
        start {{ x: 0 }} horizon 20 [s]"
    )
}

/// One step of the classical method of fourth order for `(x, x')` of the block that slides in the sense -1 or 1.
fn step(state: [f64; 2], h: f64, sense: f64) -> [f64; 2] {
    let slope = |[x, v]: [f64; 2]| {
        let mu = 0.1 + 0.2 * (-(sense * (v - 0.4)) / 0.25).exp();
        [v, -2.1 / 1.3 * x - sense * mu * 9.81]
    };
    let at = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
    let first = slope(state);
    let second = slope(at(first, 0.5 * h));
    let third = slope(at(second, 0.5 * h));
    let last = slope(at(third, h));
    [0, 1].map(|i| state[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i]))
}

/// Slides until the velocity is that of the belt; returns the place and the time that it took.
fn slide(mut state: [f64; 2], sense: f64) -> (f64, f64) {
    // An error of h^4 beside changes within a second: about 1e-13.
    let (h, mut time) = (5e-4, 0.0);
    loop {
        let next = step(state, h, sense);
        if time > 0.01 && sense * (next[1] - 0.4) <= 0.0 {
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match sense * (step(state, middle, sense)[1] - 0.4) > 0.0 {
                    true => low = middle,
                    false => high = middle,
                }
            }
            return (step(state, low, sense)[0], time + low);
        }
        (state, time) = (next, time + h);
    }
}

#[test]
fn oscillator_of_popp_with_stribeck_friction_has_the_events_of_an_independent_integration() {
    // It slides against the belt at first, sticks until the spring holds the friction of rest, and slides backward.
    let breaks = 0.3 * 1.3 * 9.81 / 2.1;
    let (mut place, mut time) = slide([0.0, 0.0], -1.0);
    let mut wanted = vec![(EventKind::Stick, time)];
    while wanted.len() < 5 {
        time += (breaks - place) / 0.4;
        wanted.push((EventKind::Slip, time));
        let (next, took) = slide([breaks, 0.4], -1.0);
        (place, time) = (next, time + took);
        wanted.push((EventKind::Stick, time));
    }
    for motion in motions_under(
        &popp("0.1 + 0.2*exp(-speed/vs)"),
        Some(1e-11),
        &ControlSignal::Zero,
    ) {
        let mut motion = motion;
        motion.events.truncate(wanted.len());
        events(&motion, &wanted, 1e-8);
    }
}

#[test]
fn block_on_a_belt_breaks_loose_at_the_friction_of_rest_and_slides_with_that_of_sliding() {
    // From rest beside the belt at x = mu_s m g/k it swings about mu_k m g/k, and back to the speed of the belt.
    let omega = (2.1_f64 / 1.3).sqrt();
    let (rest, middle) = (0.3 * 1.3 * 9.81 / 2.1, 0.2 * 1.3 * 9.81 / 2.1);
    let amplitude = rest - middle;
    let slides = 2.0 / omega * (std::f64::consts::PI - (amplitude * omega / 0.4).atan());
    let sticks = 2.0 * amplitude / 0.4;
    for motion in motions_under(
        &popp("static 0.3, kinetic 0.2"),
        Some(1e-11),
        &ControlSignal::Zero,
    ) {
        let first = motion
            .events
            .iter()
            .position(|event| event.kind == EventKind::Slip);
        let periods = &motion.events[first.expect("it slips")..];
        assert!(periods.len() >= 4);
        for pair in periods.windows(2) {
            let took = pair[1].time - pair[0].time;
            let wanted = if pair[0].kind == EventKind::Slip {
                slides
            } else {
                sticks
            };
            // Of ten promises of 1e-11 and two locations.
            assert!((took - wanted).abs() < 1e-9, "{took} for {wanted}");
        }
        // The force is that of sliding, at once.
        let event = &periods[0];
        let after = motion.at(event.time + 1e-3).expect("a state");
        let force = after["friction_force(ground)"];
        assert!((force - 0.2 * 1.3 * 9.81).abs() < 1e-6, "{force}");
    }
}

#[test]
fn both_coefficients_may_stand_beside_a_function_of_the_speed() {
    // At rest 1.5 times the friction of a slow slide.
    let [default, event_driven] = motions_under(
        &popp("static 0.45, kinetic 0.1 + 0.2*exp(-speed/vs)").replace("horizon 20", "horizon 40"),
        Some(1e-10),
        &ControlSignal::Zero,
    );
    let slips = |motion: &Simulation| -> Vec<(f64, f64)> {
        let slips = motion
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Slip);
        slips.map(|event| (event.time, event.q[0])).collect()
    };
    let (one, other) = (slips(&default), slips(&event_driven));
    assert!(one.len() >= 2 && one.len() == other.len());
    for ((time, place), (its, _)) in one.iter().zip(&other) {
        assert!((time - its).abs() < 1e-7, "{time} and {its}");
        assert!((place - 0.45 * 1.3 * 9.81 / 2.1).abs() < 1e-9);
    }
}

#[test]
fn coefficient_of_the_place_brakes_as_its_integral_says() {
    // v'(x) v = -g (mu_0 + c x): v^2 = v_0^2 - 2 g (mu_0 x + c x^2/2).
    let text = "parameters { m: kg = 2, g: m/s^2 = 9.81, c: 1/m = 0.1 } coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z surface ice: z >= 0
        impact ice: inelastic, friction 0.05 + c*x, sliding dot(x) start { dot(x): 3 } horizon 4 [s]";
    let stop = (-0.05 + (0.05_f64.powi(2) + 0.1 * 9.0 / 9.81).sqrt()) / 0.1;
    for motion in motions(text) {
        super::ends(&motion, &[("x", stop), ("dot(x)", 0.0)], 1e-6);
    }
}

#[test]
fn impact_takes_the_coefficient_of_the_speed_before_it() {
    // |v_t| = 2 before it: mu = 0.1 + 0.4/(1 + 2) and p = 1.5 m.
    let text = "parameters { m: kg = 2 } coordinates { x: m, z: m } lagrangian m/2*(dot(x)^2 + dot(z)^2)
        surface wall: z >= 0 impact wall: restitution 0.5, friction 0.1 + 0.4/(1 + speed/1 [m/s]), sliding dot(x)
        start { z: 1, dot(x): 2, dot(z): -1 } outputs { given: N s = friction_impulse(wall) } horizon 2 [s]";
    let mu = 0.1 + 0.4 / 3.0;
    for motion in motions(text) {
        super::ends(
            &motion,
            &[("dot(x)", 2.0 - 1.5 * mu), ("given", -3.0 * mu)],
            1e-9,
        );
    }
}

#[test]
fn coefficients_that_make_no_sense_are_refused_with_what_to_write() {
    for (friction, code, words) in [
        ("static 0.2, kinetic 0.3", "E10", "exchange them"),
        ("static 0.2", "E20", "`friction static 0.5, kinetic 0.4`"),
        ("kinetic 0.2", "E20", "`friction static mu_s, kinetic mu_k`"),
        ("0.3*dot(x)/belt", "E07", "`speed`"),
        ("tanh(speed/vs)", "E10", "vanishes at rest"),
        ("0.3*speed", "E03", "ratio"),
        (
            "static 0.5, kinetic 0.2 + 0.1*sin(x/1 [m])",
            "E07",
            "the same at all places",
        ),
    ] {
        let message = refusal(&popp(friction));
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(message.contains(words), "{friction}: {message}");
        assert!(code == "E03" || !message.is_empty(), "{code}");
    }
    let rough = scene(&popp("static 0.3, kinetic 0.2"));
    let refused = simulate(&rough).method(Smooth::default()).run();
    assert!(refused.is_err());
}
