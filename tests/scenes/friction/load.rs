//! Dry friction whose bound follows a control, a velocity, or the force of a surface or a joint.

use super::{ends, events, motions, motions_under, refusal, scene};
use hangtime::baselines::Moreau;
use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;

#[test]
fn clutch_engages_when_its_control_has_taken_the_difference_of_speeds() {
    let text = "parameters { j1: kg m^2 = 1, j2: kg m^2 = 2 } coordinates { a: rad, b: rad } controls { p: N m in 0..=10 }
        lagrangian j1/2*dot(a)^2 + j2/2*dot(b)^2
        dry friction clutch: bound p, sliding dot(a) - dot(b)
        start { dot(a): 100 [rad/s] } outputs { energy: J = j1/2*dot(a)^2 + j2/2*dot(b)^2 } horizon 15 [s]";
    // A torque that grows by c a second: (1/j1 + 1/j2) c t^2/2 = 100.
    let c = 1.2;
    let controls = ControlSignal::PiecewiseLinear {
        times: vec![0.0, 15.0],
        values: vec![vec![0.0], vec![15.0 * c]],
    };
    let time = (2.0 * 100.0 / (1.5 * c)).sqrt();
    for motion in motions_under(text, None, &controls) {
        events(&motion, &[(EventKind::Stick, time)], 1e-7);
        let heat = 5000.0 - motion.at(15.0).expect("the end")["energy"];
        // j1 j2/(j1 + j2)/2 100^2, of an energy of 5000 J.
        assert!((heat - 1e4 / 3.0).abs() < 1e-5, "{heat}");
        ends(
            &motion,
            &[("dot(a)", 100.0 / 3.0), ("dot(b)", 100.0 / 3.0)],
            1e-7,
        );
    }
}

#[test]
fn clutch_slips_again_where_its_control_falls() {
    // The torque of the engine wants (j2/(j1 + j2)) 3 N m through the clutch, which lets go below that.
    let text = "parameters { j1: kg m^2 = 1, j2: kg m^2 = 2 } coordinates { a: rad, b: rad } controls { p: N m in 0..=10 }
        lagrangian j1/2*dot(a)^2 + j2/2*dot(b)^2 forces { a: 3 [N m] }
        dry friction clutch: bound p, sliding dot(a) - dot(b) horizon 4 [s]";
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![2.5], vec![1.5]],
    };
    for motion in motions_under(text, None, &controls) {
        events(&motion, &[(EventKind::Slip, 1.0)], 1e-12);
        // Then a'' = 3 - 1.5 and b'' = 0.75.
        ends(
            &motion,
            &[("dot(a)", 1.0 + 4.5), ("dot(b)", 1.0 + 2.25)],
            1e-9,
        );
    }
}

/// A wheel between pads that are pressed by a force which changes with time.
const BRAKE: &str = "parameters { m: kg = 2, j: kg m^2 = 0.1, r: m = 0.2, mu = 0.4, f: N = 12, g: m/s^2 = 9.81 }
    coordinates { z: m, w: rad } lagrangian m/2*dot(z)^2 + j/2*dot(w)^2 - m*g*z
    forces { z: -f*(1 + sin(t/1 [s])/2) } surface pad: z >= 0 impact pad: inelastic
    dry friction brake: bound mu*r*force(pad), sliding dot(w) start { dot(w): 30 [rad/s] } horizon 3 [s]";

/// When the wheel has stopped: `0.8 ((m g + f) t + f (1 - cos t)/2) = 30`, by Newton's method.
fn stops() -> f64 {
    let mut time = 1.0_f64;
    for _ in 0..20 {
        let taken = 0.8 * (31.62 * time + 6.0 * (1.0 - time.cos()));
        time -= (taken - 30.0) / (0.8 * (31.62 + 6.0 * time.sin()));
    }
    time
}

#[test]
fn wheel_stops_when_pads_that_are_pressed_have_taken_its_momentum() {
    for motion in motions(BRAKE) {
        events(&motion, &[(EventKind::Stick, stops())], 1e-8);
        // The bound is recorded as its normal force.
        let bound = 0.08 * (31.62 + 6.0 * 3.0_f64.sin());
        ends(&motion, &[("dot(w)", 0.0), ("force(brake)", bound)], 1e-8);
    }
    let moreau = Moreau {
        steps: 3000,
        ..Moreau::default()
    };
    let motion = simulate(&scene(BRAKE))
        .method(moreau)
        .run()
        .expect("a scene");
    // First order: a step of 1 ms beside a second.
    let stopped = motion
        .trajectory
        .v
        .iter()
        .position(|v| v[1] == 0.0)
        .expect("it stops");
    assert!((motion.trajectory.time[stopped] - stops()).abs() < 3e-3);
}

#[test]
fn pads_that_lift_off_brake_no_longer() {
    // The pad is pulled away at t = 1 s; the torque until then is mu r m g.
    let text = "parameters { m: kg = 2, j: kg m^2 = 0.1, r: m = 0.2, mu = 0.4, g: m/s^2 = 9.81 } controls { u: N }
        coordinates { z: m, w: rad } lagrangian m/2*dot(z)^2 + j/2*dot(w)^2 - m*g*z forces { z: u }
        surface pad: z >= 0 impact pad: inelastic
        dry friction brake: bound mu*r*force(pad), sliding dot(w) start { dot(w): 30 [rad/s] } horizon 1.5 [s]";
    let controls = ControlSignal::PiecewiseConstant {
        times: vec![0.0, 1.0],
        values: vec![vec![0.0], vec![30.0]],
    };
    for motion in motions_under(text, None, &controls) {
        ends(
            &motion,
            &[
                ("dot(w)", 30.0 - 0.8 * 19.62),
                ("friction_force(brake)", 0.0),
            ],
            1e-9,
        );
    }
}

#[test]
fn bound_of_the_speed_is_the_friction_of_a_damper_that_also_holds() {
    // v' = -(1 + v): v = 2 exp(-t) - 1 from v = 1, at rest from t = ln 2 on.
    let text = "parameters { m: kg = 1, f: N = 1, c: N s/m = 1 } coordinates { x: m } lagrangian m/2*dot(x)^2
        dry friction rail: bound f + c*speed, sliding dot(x) start { dot(x): 1 } horizon 2 [s]";
    for motion in motions(text) {
        events(&motion, &[(EventKind::Stick, 2.0_f64.ln())], 1e-7);
        ends(&motion, &[("x", 1.0 - 2.0_f64.ln())], 1e-7);
    }
}

#[test]
fn bounds_that_make_no_sense_are_refused_with_what_to_write() {
    for (bound, words) in [
        ("mu*r*force(pad)^2/1 [N]", "no sum of forces of surfaces"),
        ("-mu*r*force(pad)", "change the sign"),
        ("mu*r*impulse(pad)/1 [s]", "normal forces of surfaces"),
        ("0.4*force(pad)", "bound of `brake`"),
    ] {
        let message = refusal(&BRAKE.replace("mu*r*force(pad)", bound));
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(message.contains(words), "{bound}: {message}");
    }
}

/// A drum that a lever brakes: its pad, at the arm `a`, lies on the drum by a joint, and what rubs pulls the lever by the arm `h`.
fn lever(start: &str, horizon: f64) -> String {
    format!(
        "parameters {{ j: kg m^2 = 0.3, i: kg m^2 = 0.05, r: m = 0.25, a: m = 0.4, l: m = 0.9, h: m = 0.35, f: N = 6, mu = 0.45, c: N m/s = 1 }}
        coordinates {{ w: rad, th: rad }} controls {{ u: N m }}
        lagrangian j/2*dot(w)^2 + i/2*dot(th)^2
        forces {{ w: u, th: -f*l }}
        joint pad: a*th == 0 [m]
        dry friction brake: bound mu*force(pad), sliding r*dot(w) - h*dot(th)
        outputs {{ press: N = force(pad) }}
        start {{ {start} }} horizon {horizon} [s]"
    )
}

#[test]
fn lever_brake_takes_hold_as_its_friction_presses_it() {
    // Of the lever: 0 = -f l + a N - h s; s = -mu N or mu N, which eases the pad or pulls it on.
    for (speed, sense) in [(20.0, 1.0), (-12.0, -1.0)] {
        let press = 6.0 * 0.9 / (0.4 + sense * 0.45 * 0.35);
        let braking = 0.45 * press * 0.25 / 0.3;
        let stops = f64::abs(speed) / braking;
        let text = lever(&format!("dot(w): {speed}"), stops + 0.5);
        for motion in motions(&text) {
            events(&motion, &[(EventKind::Stick, stops)], 1e-9);
            let way = sense * speed * speed / (2.0 * braking);
            // At rest nothing rubs.
            ends(
                &motion,
                &[("w", way), ("dot(w)", 0.0), ("press", 6.0 * 0.9 / 0.4)],
                1e-9,
            );
            let sliding = motion.at(stops / 2.0).expect("a state");
            assert!(
                (sliding["press"] - press).abs() < 1e-9,
                "{}",
                sliding["press"]
            );
            let rubs = sliding["friction_force(brake)"];
            assert!((rubs + sense * 0.45 * press).abs() < 1e-9, "{rubs}");
        }
    }
}

#[test]
fn lever_brake_that_is_pulled_lets_go_where_its_own_pull_says() {
    // s = -u/r until -s = mu N with a N = f l + h s.
    for sense in [1.0, -1.0] {
        let breaks = 0.45 * 6.0 * 0.9 * 0.25 / (0.4 + sense * 0.45 * 0.35);
        let controls = ControlSignal::PiecewiseLinear {
            times: vec![0.0, 4.0],
            values: vec![vec![0.0], vec![sense * 4.0 * 0.8]],
        };
        let loose = breaks / 0.8;
        for motion in motions_under(&lever("", 3.9), None, &controls) {
            events(&motion, &[(EventKind::Slip, loose)], 1e-9);
            // j w'' = c t - mu N r = c (t - loose), in its sense.
            let passed = 3.9 - loose;
            let speed = sense * 0.8 * passed * passed / 2.0 / 0.3;
            ends(&motion, &[("dot(w)", speed)], 1e-8);
        }
    }
}

#[test]
fn brake_that_locks_itself_ends_with_a_status() {
    // mu h > a: no force of the pad is in balance with its own friction.
    let text = lever("dot(w): -5", 1.0).replace("mu = 0.45", "mu = 1.3");
    for event_driven in [false, true] {
        let drum = scene(&text);
        let run = simulate(&drum);
        let run = match event_driven {
            true => run.method(EventDriven::default()).run(),
            false => run.run(),
        };
        let run = run.expect("a scene");
        assert!(!run.status.is_solved(), "{}", run.status);
    }
}

#[test]
fn guide_that_rubs_by_its_side_force_is_a_rail_with_friction() {
    let common = "parameters { j: kg m^2 = 0.4, m: kg = 1.2, r: m = 0.5, l: m = 1.3, mu = 0.2, g: m/s^2 = 9.81 }
        coordinates { phi: rad, x: m, z: m }
        lagrangian j/2*dot(phi)^2 + m/2*|dot((x, z))|^2 - m*g*z
        forces { phi: -1 [N m]*sin(2*t/1 [s]) }
        joint rod: |(x - r*cos(phi), z - r*sin(phi))|^2 == l^2
        horizon 2.5 [s]";
    // The rod moves its end by -w r x sin(phi)/(x - r cos(phi)), along the rail.
    let (sine, cosine) = 1.1_f64.sin_cos();
    let x = 0.5 * cosine + (1.69 - 0.25 * sine * sine).sqrt();
    let speed = -4.0 * 0.5 * x * sine / (x - 0.5 * cosine);
    let start = format!("start {{ phi: 1.1, x: {x}, dot(phi): 4, dot(x): {speed} }}");
    let guide = format!(
        "{common} {start} joint guide: z == 0 [m]
        dry friction rail: bound mu*force(guide), sliding dot(x)
        outputs {{ press: N = force(guide), rub: N = friction_force(rail) }}"
    );
    let rail = format!(
        "{common} {start} surface rail: z >= 0 impact rail: inelastic, friction mu, sliding dot(x)
        outputs {{ press: N = force(rail), rub: N = friction_force(rail) }}"
    );
    let tight = |text: &str| {
        let [_, event_driven] = motions_under(text, Some(1e-11), &ControlSignal::Zero);
        event_driven
    };
    let exact = tight(&rail);
    let turns: Vec<(EventKind, f64)> = exact
        .events
        .iter()
        .filter(|event| event.kind != EventKind::Impact)
        .map(|event| (event.kind, event.time))
        .collect();
    assert!(turns.len() >= 2, "{turns:?}");
    let end = exact.at(2.5).expect("the end");
    for motion in motions_under(&guide, Some(1e-10), &ControlSignal::Zero) {
        events(&motion, &turns, 1e-8);
        for name in ["phi", "x", "dot(phi)", "press", "rub"] {
            ends(&motion, &[(name, end[name])], 1e-7);
        }
    }
}

#[test]
fn pin_that_rubs_by_its_tension_stops_a_pendulum_as_its_angle_says() {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5, mu = 0.4, rho: m = 0.3 } horizon 12 [s]";
    let pin = format!(
        "{common} coordinates {{ x: m, z: m }}
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        joint rod: x^2 + z^2 == l^2
        dry friction pin: bound -mu*rho*2*l*force(rod), sliding (x*dot(z) - z*dot(x))/l^2
        start {{ x: 1.2, z: -0.9 }}"
    );
    let angle = format!(
        "{common} coordinates {{ phi: rad }}
        lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
        dry friction pin: bound mu*rho*(m*g*cos(phi) + m*l*dot(phi)^2), sliding dot(phi)
        outputs {{ x: m = l*sin(phi) }}
        start {{ phi: asin(0.8) }}"
    );
    let [_, exact] = motions_under(&angle, Some(1e-12), &ControlSignal::Zero);
    let turns: Vec<(EventKind, f64)> = exact
        .events
        .iter()
        .map(|event| (event.kind, event.time))
        .collect();
    assert!(
        turns.iter().any(|turn| turn.0 == EventKind::Stick),
        "{turns:?}"
    );
    let x = exact.at(12.0).expect("the end")["x"];
    for motion in motions_under(&pin, Some(1e-10), &ControlSignal::Zero) {
        events(&motion, &turns, 1e-7);
        ends(&motion, &[("x", x)], 1e-8);
    }
}

#[test]
fn what_does_not_know_bounds_of_joints_says_so_with_what_to_write() {
    let drum = lever("dot(w): 3", 1.0);
    for (from, to, words) in [
        (
            "mu*force(pad)",
            "mu*|force(pad)|",
            "`|force(pad)|` of a number has a kink at 0",
        ),
        (
            "mu*force(pad)",
            "mu*force(pad)^2/1 [N]",
            "no sum of forces of surfaces and joints",
        ),
        ("mu*force(pad)", "mu*impulse(pad)/1 [s]", "has no `impulse`"),
        (
            "th: -f*l",
            "th: -f*l*step(t - 1 [s])",
            "is not known beside a switch",
        ),
    ] {
        let message = refusal(&drum.replace(from, to));
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(message.contains(words), "{to}: {message}");
    }
    let steered = scene(&format!(
        "{drum} minimize integral(u^2) finally {{ dot(w) == 0 }}"
    ));
    let refused = solve(&steered).run().expect_err("a refusal").to_string();
    assert!(refused.contains("`brake`"), "{refused}");
    let drum = scene(&drum);
    let frozen = simulate(&drum).method(Fesd {
        formulation: StepFormulation::TimeFreezing,
        ..Fesd::default()
    });
    let refused = frozen.run().expect_err("a refusal").to_string();
    assert!(
        refused.contains("follows forces of surfaces or joints, of `brake`"),
        "{refused}"
    );
}

/// A bicycle as one body with a front wheel, which its brake `p` slows down; the rear wheel carries its load.
fn bicycle(brake: f64, horizon: f64) -> String {
    format!(
        "parameters {{ m: kg = 95, i: kg m^2 = 14, j: kg m^2 = 0.16, g: m/s^2 = 9.81, a: m = 0.6, b: m = 0.5, h: m = 1.05, r: m = 0.34, mu = 0.4 }}
        coordinates {{ x: m, z: m, th: rad, w: rad }}
        lagrangian m/2*(dot(x)^2 + dot(z)^2) + i/2*dot(th)^2 + j/2*dot(w)^2 - m*g*z
        surface front: z - a*sin(th) - (h - r)*cos(th) - r >= 0
        surface rear: z + b*sin(th) - (h - r)*cos(th) - r >= 0
        impact front: inelastic, friction mu, sliding dot(x + a*cos(th) - (h - r)*sin(th)) - r*dot(w)
        impact rear: inelastic
        dry friction brake: bound {brake} [N m], sliding dot(w) - dot(th)
        start {{ z: h, dot(x): 8, dot(w): 8 [m/s]/r }} horizon {horizon} [s]"
    )
}

/// Masses, lengths and coefficients of [`bicycle`]: `(m, j, g, a, b, h, r, mu)`.
const BICYCLE: (f64, f64, f64, f64, f64, f64, f64, f64) =
    (95.0, 0.16, 9.81, 0.6, 0.5, 1.05, 0.34, 0.4);

#[test]
fn braked_bicycle_shifts_its_load_to_the_front_wheel_that_rolls() {
    let (m, j, g, a, b, h, r, _) = BICYCLE;
    // w' = -p/(j + m r^2), and the ground brakes with m r w'; about the center of mass F h + N_f a - N_r b = -j w'.
    let p = 40.0;
    let slows = p / (j + m * r * r);
    let front = (m * g * b + (m * r * h + j) * slows) / (a + b);
    for motion in motions(&bicycle(p, 1.5)) {
        assert!(motion.events.is_empty());
        let wanted = [
            ("dot(x)", 8.0 - r * slows * 1.5),
            ("force(front)", front),
            ("force(rear)", m * g - front),
            ("friction_force(front)", -m * r * slows),
        ];
        ends(&motion, &wanted, 1e-8);
    }
}

#[test]
fn braked_bicycle_whose_front_wheel_locks_slides_with_the_load_that_friction_shifts() {
    let (m, j, g, a, b, h, r, mu) = BICYCLE;
    // While the wheel slows down, j w' = mu N r - p; then it is locked.
    let p = 150.0;
    let first = (m * g * b + p) / (a + b - mu * h + mu * r);
    let locks = 8.0 / r * j / (p - mu * first * r);
    let locked = m * g * b / (a + b - mu * h);
    let speed = 8.0 - mu * first / m * locks;
    let stops = locks + speed * m / (mu * locked);
    let horizon = 3.0;
    assert!(stops < horizon && locks < 0.1);
    for motion in motions(&bicycle(p, horizon)) {
        let sticks = motion.events.iter();
        let sticks: Vec<f64> = sticks
            .filter(|event| event.kind == EventKind::Stick)
            .map(|event| event.time)
            .collect();
        assert_eq!(sticks.len(), 2, "{sticks:?}");
        assert!(
            (sticks[0] - locks).abs() < 1e-8,
            "{} for {locks}",
            sticks[0]
        );
        assert!(
            (sticks[1] - stops).abs() < 1e-8,
            "{} for {stops}",
            sticks[1]
        );
        let way =
            8.0 * locks - mu * first / m * locks * locks / 2.0 + speed * (stops - locks) / 2.0;
        ends(&motion, &[("x", way)], 1e-7);
        let slides = motion.at(1.0).expect("a state");
        assert!(
            (slides["force(front)"] - locked).abs() < 1e-6,
            "{}",
            slides["force(front)"]
        );
    }
}
