//! Friction in space: slides along two directions, their ends, and impacts.

use super::{ends, events, motions, motions_under, refusal, scene};
use hangtime::baselines::Moreau;
use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;

/// A body without rotation above a floor, with sliding velocities of its choice.
fn stone(sliding: &str, law: &str, start: &str) -> String {
    format!(
        "parameters {{ m: kg = 0.7, g: m/s^2 = 9.81, mu = 0.35, tilt = 0, c = 0.8, s = 0.6 }}
        coordinates {{ x: m, y: m, z: m }}
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) - m*g*(z + tilt*x)
        surface ground: z >= 0
        impact ground: {law}, friction mu, sliding {sliding}
        start {{ {start} }} horizon 3 [s]"
    )
}

#[test]
fn stone_thrown_obliquely_slides_straight_on_and_stops() {
    let text = stone(
        "(dot(x), dot(y))",
        "inelastic",
        "z: 1.3, dot(x): 3, dot(y): 4, dot(z): 1",
    );
    // It lands at t_1 with v_z, which takes mu v_z of the speed 5; mu g brakes the rest.
    let fall = (1.0_f64 + 2.0 * 9.81 * 1.3).sqrt();
    let lands = (1.0 + fall) / 9.81;
    let speed = 5.0 - 0.35 * fall;
    let braking = 0.35 * 9.81;
    let stops = lands + speed / braking;
    let way = 5.0 * lands + speed * speed / (2.0 * braking);
    let wanted = [(EventKind::Impact, lands), (EventKind::Stick, stops)];
    for motion in motions(&text) {
        events(&motion, &wanted, 1e-9);
        let end = [
            ("x", 0.6 * way),
            ("y", 0.8 * way),
            ("z", 0.0),
            ("dot(x)", 0.0),
            ("dot(y)", 0.0),
        ];
        ends(&motion, &end, 1e-9);
        let impulse = motion.events[0].friction_impulse[0];
        assert!((impulse - 0.7 * 0.35 * fall).abs() < 1e-9, "{impulse}");
    }
    let moreau = Moreau {
        steps: 3000,
        ..Moreau::default()
    };
    let motion = simulate(&scene(&text))
        .method(moreau)
        .run()
        .expect("a scene");
    // First order: steps of 1 ms at 5 m/s.
    ends(&motion, &[("x", 0.6 * way), ("y", 0.8 * way)], 1e-2);
}

#[test]
fn impact_on_a_rough_floor_stops_inside_of_the_cone_and_slips_outside() {
    // p = (1 + e) 4 of the velocity, and the cone takes up to 0.35 p of it.
    for (e, sliding) in [(0.0, 1.5), (0.5, 1.5), (0.0, 1.2), (0.5, 2.5)] {
        let text = stone(
            "(dot(x), dot(y))",
            &format!("restitution {e}"),
            &format!(
                "z: 0.5, dot(x): {}, dot(y): {}, dot(z): -4",
                -0.28 * sliding,
                0.96 * sliding
            ),
        )
        .replace("= 9.81", "= 0");
        let left = f64::max(sliding - 0.35 * (1.0 + e) * 4.0, 0.0);
        for motion in motions(&text) {
            let end = [
                ("dot(x)", -0.28 * left),
                ("dot(y)", 0.96 * left),
                ("dot(z)", 4.0 * e),
            ];
            ends(&motion, &end, 1e-12);
        }
    }
}

#[test]
fn sideways_slide_on_a_slope_turns_downhill_and_stops_when_the_closed_form_says() {
    // With the pull f along the slope, friction c f and the angle th between them: d/dt v (c + cos th) = f (1 - c^2).
    let (pull, ratio) = (0.2 * 9.81, 0.35 / 0.2);
    let text = stone("(dot(x), dot(y))", "inelastic", "dot(x): 1, dot(y): 2")
        .replace("tilt = 0", "tilt = 0.2");
    let speed = 5.0_f64.sqrt();
    let stops = speed * (ratio - 1.0 / speed) / (pull * (ratio * ratio - 1.0));
    for motion in motions(&text) {
        events(&motion, &[(EventKind::Stick, stops)], 1e-6);
        let [x, y] = independent(stops);
        ends(&motion, &[("x", x), ("y", y)], 1e-6);
    }
}

/// Where that slide is when it stops at `time`: by the classical method of fourth order in the time that is left, `exp(-s)`, in which the
/// end of the slide is smooth.
fn independent(time: f64) -> [f64; 2] {
    let slope = |s: f64, y: [f64; 4]| {
        let rate = time * (-s).exp();
        let size = y[2].hypot(y[3]);
        let brake = 0.35 * 9.81 / size;
        [y[2], y[3], -0.2 * 9.81 - brake * y[2], -brake * y[3]].map(|value| rate * value)
    };
    let (mut y, h) = ([0.0, 0.0, 1.0, 2.0], 1e-3);
    for k in 0..16_000 {
        let s = f64::from(k) * h;
        let at = |slope: [f64; 4], h: f64| [0, 1, 2, 3].map(|i| y[i] + h * slope[i]);
        let first = slope(s, y);
        let second = slope(s + 0.5 * h, at(first, 0.5 * h));
        let third = slope(s + 0.5 * h, at(second, 0.5 * h));
        let last = slope(s + h, at(third, h));
        y = [0, 1, 2, 3]
            .map(|i| y[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i]));
    }
    [y[0], y[1]]
}

/// A ball with two of its turns, which slides and then rolls.
fn ball(start: &str) -> String {
    format!(
        "parameters {{ m: kg = 1.7, r: m = 0.11, g: m/s^2 = 9.81, mu = 0.3 }}
        coordinates {{ x: m, y: m, z: m, a: rad, b: rad }}
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) + m*r^2/5*(dot(a)^2 + dot(b)^2) - m*g*z
        surface ground: z >= r
        impact ground: inelastic, friction mu, sliding (dot(x) - r*dot(a), dot(y) - r*dot(b))
        start {{ z: r, {start} }} horizon 2 [s]"
    )
}

#[test]
fn ball_slides_first_and_rolls_with_five_sevenths_of_its_speed() {
    let rolls = 2.0 * 5.0 / (7.0 * 0.3 * 9.81);
    for motion in motions(&ball("dot(x): 3, dot(y): 4")) {
        events(&motion, &[(EventKind::Stick, rolls)], 1e-9);
        ends(
            &motion,
            &[("dot(x)", 15.0 / 7.0), ("dot(y)", 20.0 / 7.0)],
            1e-9,
        );
    }
}

#[test]
fn spinning_ball_flies_a_parabola_on_the_ground_until_it_rolls() {
    // The point of contact slides along (1.2, -0.5) all the time, so that friction is constant.
    let spin = "dot(x): 2, dot(y): 1, dot(a): 0.8 [m/s]/r, dot(b): 1.5 [m/s]/r";
    let rolls = 2.0 * 1.3 / (7.0 * 0.3 * 9.81);
    let lost = 2.0 / 7.0;
    let (v_x, v_y) = (2.0 - lost * 1.2, 1.0 + lost * 0.5);
    // The mean velocity until it rolls, and the velocity of rolling from then on.
    let x = 0.5 * (2.0 + v_x) * rolls + v_x * (2.0 - rolls);
    let y = 0.5 * (1.0 + v_y) * rolls + v_y * (2.0 - rolls);
    for motion in motions(&ball(spin)) {
        events(&motion, &[(EventKind::Stick, rolls)], 1e-9);
        ends(
            &motion,
            &[("x", x), ("y", y), ("dot(x)", v_x), ("dot(y)", v_y)],
            1e-8,
        );
    }
}

#[test]
fn turned_sliding_velocities_give_the_same_motion() {
    let start = "z: 0.4, dot(x): 1, dot(y): 2";
    let end = |sliding: &str, tilt: &str| {
        let text = stone(sliding, "restitution 0.3", start).replace("tilt = 0", tilt);
        motions(&text).map(|motion| {
            let times: Vec<f64> = motion.events.iter().map(|event| event.time).collect();
            let end = motion.trajectory.q.last().expect("a motion").clone();
            (times, end)
        })
    };
    // Rounding error of some hundred steps where it slides straight on; what a direction is, near the end of a slide that
    // turns, is told by 1e-8 of a speed whose terms depend on the axes.
    for (tilt, accuracy) in [("tilt = 0", 1e-11), ("tilt = 0.1", 1e-8)] {
        let declared = end("(dot(x), dot(y))", tilt);
        let turned = end("(c*dot(x) + s*dot(y), c*dot(y) - s*dot(x))", tilt);
        for ((times, place), (its, other)) in declared.iter().zip(&turned) {
            assert_eq!(times.len(), its.len());
            for (a, b) in times.iter().zip(its).chain(place.iter().zip(other)) {
                assert!((a - b).abs() < accuracy, "{a} and {b}");
            }
        }
    }
}

#[test]
fn block_that_is_pushed_around_breaks_loose_where_the_push_leaves_the_cone() {
    // The size of the push (2 t, t^2) reaches mu m g = 3 N at t^2 (4 + t^2) = 9.
    let text = "parameters { m: kg = 1, g: m/s^2 = 10, mu = 0.3 } coordinates { x: m, y: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) - m*g*z
        forces { x: 2*t*1 [N/s], y: t^2*1 [N/s^2] } surface ground: z >= 0
        impact ground: inelastic, friction mu, sliding (dot(x), dot(y)) horizon 2 [s]";
    let breaks = (13.0_f64.sqrt() - 2.0).sqrt();
    let [one, other] = motions_under(text, Some(1e-10), &ControlSignal::Zero);
    for motion in [&one, &other] {
        events(motion, &[(EventKind::Slip, breaks)], 1e-9);
        let trajectory = &motion.trajectory;
        let held = trajectory.time.iter().zip(&trajectory.friction_force);
        for (&time, force) in held.filter(|(time, _)| **time < breaks) {
            let push = f64::hypot(2.0 * time, time * time);
            assert!((force[0] - push).abs() < 1e-9, "{} for {push}", force[0]);
        }
    }
    // What follows has no closed form: the methods share no line of it.
    for name in ["x", "y", "dot(x)", "dot(y)"] {
        let [a, b] = [&one, &other].map(|motion| motion.at(2.0).expect("a state")[name]);
        assert!((a - b).abs() < 1e-7, "{name}: {a} and {b}");
    }
}

/// A block on a floor that forces pull along it, with coefficients of its own at rest and in sliding.
fn pulled(forces: &str, gravity: &str) -> String {
    format!(
        "parameters {{ m: kg = 0.7, g: m/s^2 = 9.81, c: N/s = 1.6, w: rad/s = 0.5, ca = 0.28, sa = 0.96 }}
        coordinates {{ x: m, y: m, z: m }} controls {{ u: N, v: N }}
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2)
        forces {{ {forces}, z: -m*{gravity} }}
        surface ground: z >= 0
        impact ground: inelastic, friction static 0.45, kinetic 0.3, sliding (dot(x), dot(y))"
    )
}

#[test]
fn block_in_space_breaks_loose_at_the_friction_of_rest_and_slides_with_that_of_sliding() {
    let text = pulled("x: c*t*ca, y: c*t*sa", "g") + "horizon 3 [s]";
    // It breaks loose at c t = mu_s m g; then m v' = c t - mu_k m g along the pull.
    let loose: f64 = 0.45 * 0.7 * 9.81 / 1.6;
    let (passed, rate, held): (f64, f64, f64) = (3.0 - loose, 1.6 / 0.7, 0.15 * 9.81);
    let way = rate * passed.powi(3) / 6.0 + held * passed * passed / 2.0;
    let speed = rate * passed * passed / 2.0 + held * passed;
    for motion in motions(&text) {
        events(&motion, &[(EventKind::Slip, loose)], 1e-9);
        let wanted = [
            ("x", 0.28 * way),
            ("y", 0.96 * way),
            ("dot(x)", 0.28 * speed),
            ("friction_force(ground)", 0.3 * 0.7 * 9.81),
        ];
        ends(&motion, &wanted, 1e-8);
    }
}

#[test]
fn plane_that_is_tilted_lets_go_at_the_angle_of_rest() {
    let text = pulled("x: m*g*sin(w*t)*ca, y: m*g*sin(w*t)*sa", "g*cos(w*t)") + "horizon 1.5 [s]";
    // tan(w t) = mu_s; then v' = g (sin(w t) - mu_k cos(w t)).
    let (w, g) = (0.5, 9.81);
    let loose = 0.45_f64.atan() / w;
    let ((s, c), (s0, c0)) = ((1.5 * w).sin_cos(), (loose * w).sin_cos());
    let passed = 1.5 - loose;
    let speed = g / w * ((c0 - c) - 0.3 * (s - s0));
    let way = g / w * (c0 * passed - (s - s0) / w + 0.3 * ((c - c0) / w + s0 * passed));
    for motion in motions(&text) {
        events(&motion, &[(EventKind::Slip, loose)], 1e-9);
        let wanted = [
            ("x", 0.28 * way),
            ("y", 0.96 * way),
            ("dot(y)", 0.96 * speed),
        ];
        ends(&motion, &wanted, 1e-8);
    }
}

#[test]
fn pull_between_both_frictions_keeps_a_slide_going_and_starts_none() {
    let text = pulled("x: u, y: v", "g") + "horizon 4 [s]";
    // mu_k m g = 2.06 N and mu_s m g = 3.09 N: 2.5 N start nothing, 4 N do, 2.5 N keep it going, and after 1 N ended it 2.5 N hold.
    let sizes = [2.5, 4.0, 2.5, 1.0, 2.5];
    let times = [0.0, 0.5, 1.0, 1.5, 3.5];
    let controls = ControlSignal::PiecewiseConstant {
        times: times.to_vec(),
        values: sizes.iter().map(|f| vec![0.6 * f, -0.8 * f]).collect(),
    };
    let rate = |force: f64| force / 0.7 - 0.3 * 9.81;
    let mut state = (0.0, 0.0);
    let mut advance = |force: f64, time: f64| {
        state = (
            state.0 + state.1 * time + rate(force) * time * time / 2.0,
            state.1 + rate(force) * time,
        );
        state
    };
    advance(4.0, 0.5);
    let (_, speed) = advance(2.5, 0.5);
    let stops = speed / -rate(1.0);
    let (way, _) = advance(1.0, stops);
    assert!(stops < 2.0);
    let wanted = [(EventKind::Slip, 0.5), (EventKind::Stick, 1.5 + stops)];
    for motion in motions_under(&text, None, &controls) {
        events(&motion, &wanted, 1e-8);
        let end = [
            ("x", 0.6 * way),
            ("y", -0.8 * way),
            ("friction_force(ground)", 2.5),
        ];
        ends(&motion, &end, 1e-8);
    }
}

#[test]
fn slide_that_breaks_loose_across_its_pull_is_curved_as_its_integration_says() {
    let text = pulled("x: 2 [N], y: c*t", "g") + "horizon 2.5 [s]";
    let loose = (3.09015_f64 * 3.09015 - 4.0).sqrt() / 1.6;
    // Runge's method from a little after, where the direction of the velocity is that of the pull up to that little.
    let rate = |time: f64, [_, _, vx, vy]: [f64; 4]| {
        let speed = f64::hypot(vx, vy);
        let braking = 0.3 * 9.81 / speed;
        [
            vx,
            vy,
            2.0 / 0.7 - braking * vx,
            1.6 * time / 0.7 - braking * vy,
        ]
    };
    let little = 1e-5;
    let pull = [2.0 / 0.7, 1.6 * loose / 0.7];
    let share = 1.0 - 0.3 * 9.81 / f64::hypot(pull[0], pull[1]);
    let mut state = [0.0, 0.0, pull[0] * share * little, pull[1] * share * little];
    let steps = 40_000;
    let begin = loose + little;
    for step in 0..steps {
        let (from, to) = (f64::from(step), f64::from(step + 1));
        // Steps that grow evenly from the start.
        let at = |k: f64| begin + (2.5 - begin) * (k / f64::from(steps)).powi(3);
        let (time, h) = (at(from), at(to) - at(from));
        let moved = |k: [f64; 4], share: f64| -> [f64; 4] {
            std::array::from_fn(|i| state[i] + share * h * k[i])
        };
        let k1 = rate(time, state);
        let k2 = rate(time + h / 2.0, moved(k1, 0.5));
        let k3 = rate(time + h / 2.0, moved(k2, 0.5));
        let k4 = rate(time + h, moved(k3, 1.0));
        state = std::array::from_fn(|i| {
            state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        });
    }
    for motion in motions(&text) {
        events(&motion, &[(EventKind::Slip, loose)], 1e-9);
        // What the first 1e-5 s miss: their square in the velocity.
        let wanted = [
            ("x", state[0]),
            ("y", state[1]),
            ("dot(x)", state[2]),
            ("dot(y)", state[3]),
        ];
        ends(&motion, &wanted, 1e-8);
    }
}

#[test]
fn impact_sticks_by_the_friction_of_rest_and_slips_by_that_of_sliding() {
    let falls = |speed: f64| {
        let start = format!(
            "start {{ dot(z): -2, dot(x): {}, dot(y): {} }}",
            0.28 * speed,
            0.96 * speed
        );
        pulled("x: 0 [N], y: 0 [N]", "g") + &start + " horizon 0.01 [s]"
    };
    // An impact of 2 m/s stops up to 0.9 m/s; beyond, it takes 0.6 m/s.
    for (speed, left) in [(0.85, 0.0), (0.95, 0.35)] {
        for motion in motions(&falls(speed)) {
            let after = &motion.events[0].v_after;
            assert!((after[0] - 0.28 * left).abs() < 1e-12, "{after:?}");
            assert!((after[1] - 0.96 * left).abs() < 1e-12, "{after:?}");
        }
    }
}

#[test]
fn what_does_not_know_friction_in_space_says_so_with_what_to_write() {
    let text = stone("(dot(x), dot(y))", "inelastic", "dot(x): 1");
    let rough = scene(&text);
    let refused = simulate(&rough).method(Fesd {
        formulation: StepFormulation::TimeFreezing,
        ..Fesd::default()
    });
    let message = refused.run().expect_err("a refusal").to_string();
    assert!(
        message.contains("friction in space") && message.contains("`ground`"),
        "{message}"
    );
    for (sliding, law, words) in [
        ("(dot(x), 2*dot(x))", "inelastic", "along one direction"),
        ("(dot(x), dot(y), dot(z))", "inelastic", "two in space"),
        ("(dot(x), dot(z))", "inelastic", "into the surface"),
    ] {
        let message = refusal(&stone(sliding, law, "dot(x): 1"));
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(message.contains(words), "{sliding}: {message}");
    }
    let speed = text.replace("friction mu", "friction mu*exp(-speed/1 [m/s])");
    assert!(refusal(&speed).contains("two sliding velocities"));
}

#[test]
fn scenes_without_friction_and_in_the_plane_have_no_part_of_it() {
    let smooth = "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z surface floor: z >= 0 impact floor: restitution 0.5
        start { z: 1, dot(x): 2 } horizon 0.8 [s]";
    let falls = (2.0_f64 / 9.81).sqrt();
    for motion in motions(smooth) {
        events(&motion, &[(EventKind::Impact, falls)], 1e-9);
        ends(&motion, &[("x", 1.6), ("dot(x)", 2.0)], 1e-9);
    }
}
