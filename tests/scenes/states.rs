//! States of first order and switches of what acts: motions against closed forms and independent integration.

use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::prelude::*;
use hangtime::rk::Scheme;
use hangtime_scene_files::of_text;

use super::both::{ends, motions};

/// Whether the events are these, at times that are known to the accuracy `promise`.
fn events(motion: &Simulation, wanted: &[(EventKind, &str, f64)], promise: f64) {
    let found: Vec<(EventKind, &str)> = motion
        .events
        .iter()
        .map(|e| (e.kind, e.contact_name))
        .collect();
    let known: Vec<(EventKind, &str)> =
        wanted.iter().map(|&(kind, name, _)| (kind, name)).collect();
    assert_eq!(found, known);
    for (event, &(.., time)) in motion.events.iter().zip(wanted) {
        assert!((event.time - time).abs() < promise, "{event} at {time}");
    }
}

#[test]
fn motor_with_an_inductance_is_a_damped_oscillation() {
    let text =
        "parameters { j: kg m^2 = 0.01, k: V s = 0.1, r: Ohm = 1, ell: H = 0.5, volt: V = 12 }
        coordinates { phi: rad } states { i: A } lagrangian j/2*dot(phi)^2 forces { phi: k*i }
        rates { i: (volt - r*i - k*dot(phi))/ell } outputs { torque: N m = k*i } horizon 2 [s]";
    // i'' + 2 i' + 2 i = 0 with i = 0 and i' = 24 A/s at first; the wheel has taken (volt - r i - ell i')/k.
    let i = 24.0 * (-2.0_f64).exp() * 2.0_f64.sin();
    let rate = 24.0 * (-2.0_f64).exp() * (2.0_f64.cos() - 2.0_f64.sin());
    let speed = (12.0 - i - 0.5 * rate) / 0.1;
    for motion in motions(text) {
        // Of values up to 240, known to a share of 1e-9 and better.
        ends(
            &motion,
            &[("i", i), ("torque", 0.1 * i), ("dot(phi)", speed)],
            3e-8,
        );
    }
}

#[test]
fn van_der_pol_agrees_with_another_integrator() {
    let text = "parameters { mu = 5 } states { x, y } rates { x: y, y: mu*(1 - x^2)*y - x } start { x: 2 } horizon 20";
    for motion in motions(text) {
        // scipy 1.17, DOP853 with rtol 1e-13. A default run promises 1e-6 of the largest values, here 2 and 7.
        ends(
            &motion,
            &[("x", -1.601_296_879_5), ("y", 0.198_326_676_3)],
            1e-6,
        );
    }
}

#[test]
fn state_is_continuous_through_impacts() {
    // A battery that takes what the weight of a ball does: its charge is a function of the height throughout.
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81, share = 0.1 } coordinates { z: m } states { charge: J in 0..=10 }
        lagrangian m/2*dot(z)^2 - m*g*z rates { charge: -share*m*g*dot(z) } surface floor: z >= 0
        impact floor: restitution 0.8 start { z: 1, charge: 5 } horizon 2 [s]";
    for motion in motions(text) {
        assert_eq!(motion.events.len(), 3);
        for (q, v) in motion.trajectory.q.iter().zip(&motion.trajectory.v) {
            let charge = 5.0 - 0.981 * (q[0] - 1.0);
            assert!((v[1] - charge).abs() < 1e-10, "{} for {charge}", v[1]);
        }
        for event in &motion.events {
            assert_eq!(event.v_before[1], event.v_after[1]);
        }
    }
}

#[test]
fn potential_energy_of_a_state_acts_on_coordinates_only() {
    // A magnet that grows as exp(t) would: x'' = a, a' = a.
    let text = "coordinates { x } states { a } lagrangian dot(x)^2/2 + a*x rates { a: a } start { a: 1 } horizon 1";
    let e = std::f64::consts::E;
    for motion in motions(text) {
        ends(
            &motion,
            &[("a", e), ("dot(x)", e - 1.0), ("x", e - 2.0)],
            1e-9,
        );
    }
}

#[test]
fn motion_crosses_a_jump_of_its_rate() {
    let text = "states { x } rates { x: if x >= 0 { 3 } else { 1 } } start { x: -1 } horizon 2";
    for motion in motions(text) {
        events(&motion, &[(EventKind::Switch, "x >= 0", 1.0)], 1e-12);
        ends(&motion, &[("x", 3.0)], 1e-12);
    }
}

#[test]
fn relay_slides_with_the_load_that_holds_its_temperature() {
    let text = "parameters { power: K/s = 1, loss: 1/s = 0.04, wanted: K = 20 } states { x: K }
        rates { x: power*step(wanted - x) - loss*x } outputs { load = step(wanted - x) } horizon 60 [s]";
    for motion in motions(text) {
        let time = 25.0 * 5.0_f64.ln();
        events(
            &motion,
            &[(EventKind::Slide, "step(wanted - x)", time)],
            1e-8,
        );
        ends(&motion, &[("x", 20.0), ("load", 0.8)], 1e-9);
    }
}

#[test]
fn sliding_ends_where_it_has_to() {
    let text = "states { x } rates { x: t - sign(x) } start { x: 0.3 } horizon 2";
    for motion in motions(text) {
        let time = 1.0 - 0.4_f64.sqrt();
        let wanted = [
            (EventKind::Slide, "sign(x)", time),
            (EventKind::Switch, "sign(x)", 1.0),
        ];
        events(&motion, &wanted, 1e-10);
        ends(&motion, &[("x", 0.5)], 1e-10);
    }
}

#[test]
fn motion_that_both_sides_push_away_is_called_ambiguous() {
    let text = "states { x } rates { x: sign(x) } horizon 1";
    let scene = of_text("scene.hang", text).expect("a scene");
    for motion in [
        simulate(&scene).run(),
        simulate(&scene).method(EventDriven::default()).run(),
    ] {
        let status = motion.expect("a run").status;
        assert!(
            matches!(status, SimulationStatus::AmbiguousContact(_)),
            "{status}"
        );
        let text = status.to_string();
        assert!(
            text.contains("not unique") && text.contains("`sign(x)`"),
            "{text}"
        );
    }
    // Beside it there is one motion.
    for motion in motions("states { x } rates { x: sign(x) } start { x: 0.25 } horizon 1") {
        events(&motion, &[], 0.0);
        ends(&motion, &[("x", 1.25)], 1e-12);
    }
}

/// The oscillator of the finite elements with switch detection: it turns one way inside of the unit circle and the other way
/// outside, and grows like `exp(t)`; on the circle at 1 (Nurkanovic et al., Numerische Mathematik 2024).
const OSCILLATOR: &str =
    "parameters { w = 6.283185307179586 } states { x, y } let c = x^2 + y^2 - 1
    rates { x: if c >= 0 { x - w*y } else { x + w*y }, y: if c >= 0 { w*x + y } else { -w*x + y } }
    start { x: 0.36787944117144233 } horizon 1.5707963267948966";

/// Where it is at its horizon.
fn end_of_the_oscillator() -> [f64; 2] {
    let time = std::f64::consts::FRAC_PI_2;
    let (size, angle) = ((time - 1.0).exp(), std::f64::consts::TAU * (time - 2.0));
    [size * angle.cos(), size * angle.sin()]
}

#[test]
fn oscillator_switches_at_one() {
    let [x, y] = end_of_the_oscillator();
    for motion in motions(OSCILLATOR) {
        // A default run promises 1e-6.
        events(&motion, &[(EventKind::Switch, "c >= 0", 1.0)], 1e-8);
        ends(&motion, &[("x", x), ("y", y)], 1e-7);
    }
}

#[test]
fn oscillator_has_the_order_of_the_scheme_through_its_switch() {
    let scene = of_text("scene.hang", OSCILLATOR).expect("a scene");
    let [x, y] = end_of_the_oscillator();
    for (kind, stages, grids) in [
        (Scheme::RadauIia, 1, [400, 800, 1600]),
        (Scheme::RadauIia, 2, [40, 80, 160]),
        (Scheme::RadauIia, 3, [20, 40, 80]),
        (Scheme::RadauIia, 4, [10, 20, 40]),
        (Scheme::GaussLegendre, 1, [100, 200, 400]),
        (Scheme::GaussLegendre, 2, [20, 40, 80]),
        (Scheme::GaussLegendre, 3, [10, 20, 40]),
        (Scheme::GaussLegendre, 4, [7, 14, 28]),
    ] {
        let errors = grids.map(|steps| {
            let method = Fesd::default()
                .with_scheme(kind, stages)
                .with_grid(steps, 1);
            let motion = simulate(&scene).method(method).run().expect("a run");
            assert!(
                motion.status.is_solved(),
                "{stages} {steps}: {}",
                motion.status
            );
            let v = motion.trajectory.v.last().expect("a motion");
            (v[0] - x).hypot(v[1] - y)
        });
        // Radau IIA: 2 s - 1, Gauss-Legendre: 2 s; the leading term dominates within some per cent on these grids.
        let order = (errors[1] / errors[2]).log2();
        let even = 2 * u32::try_from(stages).expect("few");
        let wanted = f64::from(even - u32::from(kind == Scheme::RadauIia));
        assert!(
            (order - wanted).abs() < 0.35,
            "{stages} stages: {order}, {errors:?}"
        );
    }
}

#[test]
fn stick_slip_has_the_published_period() {
    // Friction that falls with the sliding velocity, of a mass on a belt.
    let text = "coordinates { x } lagrangian dot(x)^2/2 - x^2/2
        forces { x: if dot(x) >= 0.2 { -1/(dot(x) + 0.8) } else { 1/(1.2 - dot(x)) } } start { x: 1 } horizon 40";
    for motion in motions(text) {
        let leaves = motion
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Switch);
        let times: Vec<f64> = leaves.map(|event| event.time).collect();
        assert_eq!(times.len(), 4);
        for pair in times.windows(2) {
            let period = pair[1] - pair[0];
            assert!((period - 9.230_770_458).abs() < 5e-9, "{period}");
        }
    }
}

#[test]
fn friction_by_the_sign_of_a_velocity_is_dry_friction() {
    let law = "parameters { m: kg = 2, f: N = 3, k: N/m = 5 } coordinates { x: m } lagrangian m/2*dot(x)^2 - k/2*x^2
        start { x: 3 } horizon 10 [s]";
    let [by_sign, _] = motions(&format!("{law} forces {{ x: -f*sign(dot(x)) }}"));
    let [by_name, _] = motions(&format!(
        "{law} dry friction guide: bound f, sliding dot(x)"
    ));
    // Each half period takes 2 f/k off the amplitude: 3, 1.8, 0.6, from where the spring pulls no more.
    let half = std::f64::consts::PI * (2.0_f64 / 5.0).sqrt();
    let wanted = [
        (EventKind::Switch, "sign(dot(x))", half),
        (EventKind::Slide, "sign(dot(x))", 2.0 * half),
    ];
    events(&by_sign, &wanted, 1e-8);
    ends(&by_sign, &[("x", 0.6)], 1e-8);
    for (one, other) in by_sign.events.iter().zip(&by_name.events) {
        assert!((one.time - other.time).abs() < 1e-12, "{one} {other}");
    }
}

#[test]
fn two_relays_slide_one_after_the_other() {
    let text = "states { x, y } rates { x: 0.3 - sign(x) + 0.1*sign(y), y: -0.2 - sign(y) } start { x: 1, y: -2 } horizon 6";
    for motion in motions(text) {
        let wanted = [
            (EventKind::Slide, "sign(x)", 1.25),
            (EventKind::Slide, "sign(y)", 2.5),
        ];
        events(&motion, &wanted, 1e-12);
        ends(&motion, &[("x", 0.0), ("y", 0.0)], 1e-12);
    }
}

#[test]
fn step_in_time_ends_an_element_there() {
    let text = "states { x } rates { x: step(t - 0.3)*exp(-x) } horizon 2";
    for motion in motions(text) {
        events(&motion, &[(EventKind::Switch, "step(t - 0.3)", 0.3)], 1e-14);
        ends(&motion, &[("x", 2.7_f64.ln())], 1e-9);
    }
}

#[test]
fn muscle_is_activated_and_relaxes() {
    let text =
        "parameters { rise: s = 0.02, fall: s = 0.06 } coordinates { x: m } states { a in 0..=1 }
        lagrangian 1 [kg]/2*dot(x)^2 forces { x: 30 [N]*a }
        rates { a: if t <= 0.1 [s] { (1 - a)/rise } else { -a/fall } } horizon 0.3 [s]";
    let top = 1.0 - (-5.0_f64).exp();
    let end = top * (-0.2_f64 / 0.06).exp();
    // 30 N times the integral of the activation.
    let speed = 30.0 * (0.1 - 0.02 * top + 0.06 * (top - end));
    for motion in motions(text) {
        events(&motion, &[(EventKind::Switch, "0.1 [s] >= t", 0.1)], 1e-14);
        ends(&motion, &[("a", end), ("dot(x)", speed)], 1e-8);
    }
}

#[test]
fn spring_that_changes_its_stiffness_ends_an_element_at_zero() {
    let text = "parameters { k = 4 } coordinates { x } lagrangian dot(x)^2/2 forces { x: max(0, -x) - k*max(0, x) }
        start { x: 1 } horizon 9.424777960769379";
    let half = std::f64::consts::FRAC_PI_2;
    let name = "max(0, -x)";
    let times = [0.5 * half, 2.5 * half, 3.5 * half, 5.5 * half];
    for motion in motions(text) {
        events(
            &motion,
            &times.map(|time| (EventKind::Switch, name, time)),
            1e-8,
        );
        // Twice a half period of each side: all is as at the start.
        ends(&motion, &[("x", 1.0), ("dot(x)", 0.0)], 1e-7);
    }
}

#[test]
fn kink_is_left_to_the_side_where_the_motion_goes() {
    for motion in motions("coordinates { x } lagrangian dot(x)^2/2 forces { x: 1 - |x| } horizon 3")
    {
        // From rest at the kink: x = 1 - cos(t).
        events(&motion, &[], 0.0);
        ends(&motion, &[("x", 1.0 - 3.0_f64.cos())], 1e-9);
    }
    // At rest at a kink for ever.
    for motion in motions("coordinates { x } lagrangian dot(x)^2/2 forces { x: -|x| } horizon 3") {
        ends(&motion, &[("x", 0.0), ("dot(x)", 0.0)], 1e-12);
    }
}

#[test]
fn power_of_a_kink_is_smooth() {
    let text = "coordinates { x } lagrangian dot(x)^2/2 forces { x: -|dot(x)|*dot(x) - 1 } start { dot(x): 1 } horizon 2";
    for motion in motions(text) {
        // v = tan(pi/4 - t) upwards, -tanh(t - pi/4) downwards.
        events(&motion, &[], 0.0);
        let speed = -(2.0 - std::f64::consts::FRAC_PI_4).tanh();
        ends(&motion, &[("dot(x)", speed)], 1e-6);
    }
}

#[test]
fn sliding_goes_on_through_impacts() {
    let text = "coordinates { z } states { x } lagrangian dot(z)^2/2 - 9.81*z rates { x: dot(z) - 6*sign(x) }
        surface floor: z >= 0 impact floor: restitution 0.8 outputs { value = sign(x) } start { z: 1 } horizon 1.2";
    for motion in motions(text) {
        assert!(
            motion
                .events
                .iter()
                .all(|event| event.kind == EventKind::Impact)
        );
        for event in &motion.events {
            for state in [motion.just_before(event.time), motion.at(event.time)] {
                let state = state.expect("a state");
                assert!(
                    state["x"].abs() < 1e-12
                        && (state["value"] - state["dot(z)"] / 6.0).abs() < 1e-10
                );
            }
        }
    }
}

#[test]
fn methods_of_fixed_steps_come_near() {
    let text = "states { x } rates { x: t - sign(x) } start { x: 0.3 } horizon 2";
    let scene = of_text("scene.hang", text).expect("a scene");
    for (motion, promise) in [
        (simulate(&scene).method(FixedStep::default()).run(), 1e-2),
        (simulate(&scene).method(Smooth::default()).run(), 1e-2),
    ] {
        let motion = motion.expect("a run");
        assert!(motion.status.is_solved(), "{}", motion.status);
        ends(&motion, &[("x", 0.5)], promise);
    }
}

#[test]
fn what_knows_no_switches_refuses_them_by_name() {
    let text = "controls { u in -1..=1 } states { x } rates { x: u - sign(x) } start { x: 0.3 }
        minimize time finally { x == 0.1 }";
    let scene = of_text("scene.hang", text).expect("a scene");
    let refused = |error: Option<String>| {
        let error = error.expect("a refusal");
        assert!(error.contains("the switch `sign(x)`"), "{error}");
    };
    let horizon = || simulate(&scene).horizon(1.0);
    refused(
        horizon()
            .method(Moreau::default())
            .run()
            .err()
            .map(|error| error.to_string()),
    );
    let frozen =
        Fesd::default().with_formulation(hangtime::simulation::StepFormulation::TimeFreezing);
    refused(
        horizon()
            .method(frozen)
            .run()
            .err()
            .map(|error| error.to_string()),
    );
}

#[test]
fn optimal_control_knows_states() {
    // x' = u - x with the cost x^2 + u^2: u = -(sqrt(2) - 1) x.
    let text = "controls { u } states { x in -5..=5 } rates { x: u - x } start { x: 1 }
        minimize integral(x^2 + u^2) horizon 8";
    let scene = of_text("scene.hang", text).expect("a scene");
    let solution = solve(&scene).intervals(40).run().expect("a solution");
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    // Controls that are constant for 0.2 s cost some ten-thousandths.
    let cost = 2.0_f64.sqrt() - 1.0;
    assert!(
        (cost..cost + 6e-4).contains(&solution.objective),
        "{}",
        solution.objective
    );
    // A double integrator of two states: bang-bang in 2 s.
    let text = "controls { u in -1..=1 } states { x, v } rates { x: v, v: u } minimize time finally { x == 1, v == 0 }";
    let scene = of_text("scene.hang", text).expect("a scene");
    let solution = solve(&scene).intervals(10).run().expect("a solution");
    assert!(
        (solution.objective - 2.0).abs() < 1e-8,
        "{}",
        solution.objective
    );
}

/// Numbers between -1 and 1 with two decimals.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0) * 100.0
    }

    fn factor(&mut self) -> String {
        format!("({:.2})", self.number().round() / 100.0)
    }

    /// A linear function of three states, and the time.
    fn linear(&mut self) -> String {
        let terms = ["x", "y", "z", "sin(2*t)"].map(|name| format!("{}*{name}", self.factor()));
        format!("{} + {}", terms.join(" + "), self.factor())
    }
}

#[test]
fn random_relays_and_kinks_agree_with_the_event_driven_method() {
    let (mut solved, mut slides, mut crosses) = (0, 0, 0);
    for seed in 0..24 {
        let mut random = Random(seed);
        let switches = [
            format!("2*sign({})", random.linear()),
            format!("if {} >= 0 {{ 1 }} else {{ -1 }}", random.linear()),
            format!("2*max({}, 0)", random.linear()),
        ];
        let rates = ["x", "y", "z"].map(|name| {
            let acting: Vec<String> = (0..3)
                .map(|k| format!("{}*s{k}", random.factor()))
                .collect();
            format!(
                "{name}: {} - {name} + {}",
                random.linear(),
                acting.join(" + ")
            )
        });
        let lets: Vec<String> = switches
            .iter()
            .enumerate()
            .map(|(k, s)| format!("let s{k} = {s}"))
            .collect();
        let text = format!(
            "states {{ x, y, z }} {} rates {{ {} }} start {{ x: {}, y: {}, z: {} }} horizon 4",
            lets.join(" "),
            rates.join(", "),
            random.factor(),
            random.factor(),
            random.factor(),
        );
        let scene = of_text("scene.hang", &text).expect("a scene");
        let mut fesd = simulate(&scene).run().expect("a run");
        let event = simulate(&scene)
            .method(EventDriven::default())
            .run()
            .expect("a run");
        // A motion that is not unique is so for both.
        assert_eq!(
            fesd.status.is_solved(),
            event.status.is_solved(),
            "{text}: {} {}",
            fesd.status,
            event.status
        );
        if !fesd.status.is_solved() {
            continue;
        }
        solved += 1;
        slides += fesd
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Slide)
            .count();
        crosses += fesd
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Switch)
            .count();
        let (one, other) = (
            fesd.trajectory.v.pop().expect("an end"),
            event.trajectory.v.last().expect("an end"),
        );
        let size = other
            .iter()
            .fold(1.0_f64, |size, value| size.max(value.abs()));
        for (a, b) in one.iter().zip(other) {
            // Both promise 1e-6 of the largest values.
            assert!((a - b).abs() < 2e-6 * size, "{text}: {one:?} {other:?}");
        }
    }
    assert!(
        solved == 24 && slides > 10 && crosses > 50,
        "{solved} solved, {slides} slide, {crosses} switch"
    );
}

#[test]
fn switches_inside_of_each_other_by_functions_that_differ_by_a_number() {
    // A window in time, and three ranges of x: rates 1, 3 and 5, and then a wall of sliding at 3.
    let text = "states { x, w } rates { x: if x >= 3 { -1 } else if x >= 2 { 5 } else if x >= 1 { 3 } else { 1 }, w: step(t - 0.5)*step(2 - t) }
        horizon 3";
    for motion in motions(text) {
        let slides = 1.0 + 1.0 / 3.0 + 0.2;
        let wanted = [
            (EventKind::Switch, "step(t - 0.5)", 0.5),
            (EventKind::Switch, "x >= 1", 1.0),
            (EventKind::Switch, "x >= 2", 4.0 / 3.0),
            (EventKind::Slide, "x >= 3", slides),
            (EventKind::Switch, "step(2 - t)", 2.0),
        ];
        events(&motion, &wanted, 1e-12);
        ends(&motion, &[("x", 3.0), ("w", 1.5)], 1e-12);
    }
}

#[test]
fn drive_that_saturates_on_both_sides_leaves_saturation_exactly() {
    // x' = u within the bounds of u = k (r - x): at the bound until |r - x| = most/k, then an exponential.
    for (wanted, sign) in [(1.0, "<="), (-1.0, ">=")] {
        let text = format!(
            "parameters {{ k: 1/s = 2, r: m = {wanted}, most: m/s = 0.7 }} states {{ x: m }}
            rates {{ x: clamp(k*(r - x), -most, most) }} horizon 2 [s]"
        );
        let leaves: f64 = (1.0 - 0.35) / 0.7;
        let end = wanted * (1.0 - 0.35 * (-2.0 * (2.0 - leaves)).exp());
        let bound = if sign == "<=" { "most" } else { "-most" };
        let name = format!("k*(r - x) {sign} {bound}");
        for motion in motions(&text) {
            events(&motion, &[(EventKind::Switch, &name, leaves)], 1e-9);
            ends(&motion, &[("x", end)], 1e-8);
        }
    }
}
