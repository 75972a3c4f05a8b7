//! Periodic and mirrored motions: what is free at the start, against closed forms of limit cycles.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

fn optimum(text: &str, intervals: usize) -> Solution {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let solution = solve(&scene).intervals(intervals).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

/// The start of a solution, without what is remembered of it.
fn start(solution: &Solution) -> (Vec<f64>, Vec<f64>) {
    let trajectory = &solution.motion.as_ref().expect("a motion").trajectory;
    (trajectory.q[0].clone(), trajectory.v[0].clone())
}

/// Collocation of order 7 on these grids is far more accurate than this.
const DIGITS: f64 = 1e-8;

fn close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < DIGITS, "{found} for {wanted}");
}

/// A damped oscillator under `cos(w t)`.
fn shaken(goals: &str, turns: &str) -> String {
    format!(
        "parameters {{ w: rad/s = 1.7, c: kg/s = 0.4 }} coordinates {{ x: m }} controls {{ u: N }}
        lagrangian dot(x)^2/2*1 [kg] - x^2/2*1 [N/m] forces {{ x: u + cos(w*t)*1 [N] - c*dot(x) }}
        start {{ x: 0.3 }} free {{ x, dot(x) }} minimize integral(u^2) finally {{ {goals} }} horizon {turns}*pi/w"
    )
}

#[test]
fn motion_that_repeats_itself_is_that_of_the_resonance_curve() {
    // x = Re exp(i w t)/(1 - w^2 + i c w).
    let (w, c) = (1.7_f64, 0.4_f64);
    let (re, im) = (1.0 - w * w, c * w);
    let size = re * re + im * im;
    for (goals, turns) in [
        ("x == start(x), dot(x) == start(dot(x))", "2"),
        ("x == -start(x), dot(x) == -start(dot(x))", "1"),
        // One condition of what follows from both, and one sum.
        (
            "x + dot(x)*1 [s] == start(x + dot(x)*1 [s]), x - start(x) == 0 [m]",
            "2",
        ),
    ] {
        let solution = optimum(&shaken(goals, turns), 20);
        let (q, v) = start(&solution);
        assert_eq!((q.len(), v.len()), (1, 1));
        close(q[0], re / size);
        close(v[0], w * im / size);
    }
}

#[test]
fn ball_on_a_shaken_table_repeats_itself_with_the_table() {
    let (g, e, a, w) = (9.81_f64, 0.55_f64, 0.02_f64, 24.0_f64);
    let text = format!(
        "parameters {{ m: kg = 0.2, g: m/s^2 = {g}, e = {e}, a: m = {a}, w: rad/s = {w} }} coordinates {{ y: m }} controls {{ u: N }}
        lagrangian m/2*dot(y)^2 - m*g*y forces {{ y: u }} surface table: y >= a*sin(w*t) impact table: restitution e
        start {{ y: 0.03, dot(y): 0.8 }} free {{ y, dot(y) }} minimize integral(u^2)
        finally {{ y == start(y), dot(y) == start(dot(y)) }} horizon 2*pi/w"
    );
    let solution = optimum(&text, 12);
    // It leaves with g T/2 and comes back with the same speed: the table has (1 - e)/(1 + e) of it, up or down its way.
    let (period, speed) = (std::f64::consts::TAU / w, g * std::f64::consts::PI / w);
    let phase = (speed * (1.0 - e) / (1.0 + e) / (a * w)).acos();
    let (q, v) = start(&solution);
    let cycles = [phase, std::f64::consts::TAU - phase].map(|phase| {
        let t = phase / w;
        (a * phase.sin() + speed * t - g * t * t / 2.0, g * t - speed)
    });
    assert!(
        cycles
            .iter()
            .any(|(y, rate)| (q[0] - y).abs() < DIGITS && (v[0] - rate).abs() < DIGITS),
        "{q:?} {v:?} {cycles:?} {period}"
    );
}

#[test]
fn puck_in_a_shaken_box_strikes_its_walls_in_turn() {
    let (b, a, w, e) = (0.3_f64, 0.05_f64, 6.0_f64, 0.8_f64);
    let text = format!(
        "parameters {{ b: m = {b}, a: m = {a}, w: rad/s = {w} }} coordinates {{ x: m }} controls {{ u: N }}
        lagrangian dot(x)^2/2*1 [kg] forces {{ x: u }} surface right: x <= b + a*sin(w*t) surface left: x >= a*sin(w*t) - b
        impact right, left: restitution {e} start {{ x: -0.1, dot(x): 1.2 }} free {{ x, dot(x) in 0.5..=3 }} minimize integral(u^2)
        finally {{ x == -start(x), dot(x) == -start(dot(x)) }} horizon pi/w"
    );
    let solution = optimum(&text, 10);
    let (q, v) = start(&solution);
    // It strikes the right wall with the phase p and goes from b + a sin p to the mirrored place in half a period, with the speed V, and the
    // wall comes towards it with V (1 - e)/(1 + e).
    let speed = |p: f64| 2.0 * w * (b + a * p.sin()) / std::f64::consts::PI;
    let towards = |p: f64| a * w * p.cos() + speed(p) * (1.0 - e) / (1.0 + e);
    let cycles = [1.8, 4.5].map(|guess| {
        let mut p: f64 = guess;
        for _ in 0..60 {
            let slope = (towards(p + 1e-6) - towards(p - 1e-6)) / 2e-6;
            p -= towards(p) / slope;
        }
        (p, speed(p))
    });
    // In half a period it strikes one of them: the right one at p/w, or the left one at p/w - pi/w.
    let fits = cycles.iter().any(|&(p, speed)| {
        let right = b + a * p.sin() - speed * p / w;
        let left = -b - a * p.sin() + speed * (p / w - std::f64::consts::PI / w);
        let near = |x: f64, rate: f64| (q[0] - x).abs() < 1e-7 && (v[0] - rate).abs() < 1e-7;
        near(right, speed) || near(left, -speed)
    });
    assert!(fits, "{q:?} {v:?} {cycles:?}");
    assert_eq!(solution.planned_events.len(), 1);
}

#[test]
fn current_under_an_alternating_voltage_repeats_itself() {
    // A state of first order: i = Re V exp(i w t)/(r + i w ell).
    let text = "parameters { r: Ohm = 2, ell: H = 0.1, w: rad/s = 12 } states { i: A } controls { u: V }
        rates { i: (10 [V]*cos(w*t) + u - r*i)/ell } free { i } minimize integral(u^2) finally { i == start(i) } horizon 2*pi/w";
    // An interval is half of the time constant: four stages are right to some 1e-10.
    let solution = optimum(text, 24);
    let trajectory = &solution.motion.as_ref().expect("a motion").trajectory;
    close(trajectory.v[0][0], 10.0 * 2.0 / (4.0 + 1.44));
}

#[test]
fn start_of_what_is_given_is_its_value() {
    let text = "coordinates { x: m } controls { u: N } lagrangian dot(x)^2/2*1 [kg] forces { x: u } start { x: 2 }
        minimize integral(u^2) finally { x == start(x) + 1 [m], dot(x) == 0 [m/s] } horizon 1 [s]";
    let scene = of_text("scene.hang", text).expect("accepted");
    assert!(
        scene
            .warnings()
            .contains("`start(x)` is the value that `start` gives")
    );
    let solution = solve(&scene).intervals(2).run().expect("accepted");
    let last = solution.motion.expect("a motion").trajectory.q;
    close(last.last().expect("its end")[0], 3.0);
}

#[test]
fn cost_may_read_the_start() {
    // From x = 0 with the best speed, 1 further on in 1 s, and no faster at the end than at first: nothing is needed at a speed of 1.
    let text = "coordinates { x: m } controls { u: N } lagrangian dot(x)^2/2*1 [kg] forces { x: u } free { dot(x) in 0..=5 }
        minimize integral(u^2)*1 [m^2/N^2/s^3] + (dot(x) - start(dot(x)))^2 finally { x == 1 [m] } horizon 1 [s]";
    let solution = optimum(text, 4);
    let (_, v) = start(&solution);
    close(v[0], 1.0);
}

#[test]
fn what_is_remembered_of_the_start_is_a_variable_each_and_nothing_where_nothing_is() {
    use hangtime::ocp::{Problem, Settings, program_sizes};
    let variables = |goals: &str| {
        let scene = of_text("scene.hang", &shaken(goals, "2")).expect("no mistakes");
        let sizes = program_sizes(&scene, &Problem::of(&scene, 10), &Settings::default());
        sizes.expect("accepted")[1].size().variables
    };
    let plain = variables("x == 0 [m], dot(x) == 0 [m/s]");
    assert_eq!(variables("x == start(x), dot(x) == 0 [m/s]"), plain + 1);
    assert_eq!(
        variables("x == start(x), dot(x) == start(dot(x))"),
        plain + 2
    );
}

#[test]
fn compass_walker_repeats_its_step_with_the_published_angles_and_rates() {
    // The legs swap their parts in the impact of the swing foot, which keeps the angular momentum about that foot, and that of the leg
    // behind about the hip. Goswami, Thuilot, Espiau 1998: m = 5 kg, hip 10 kg, a = b = 0.5 m, 3 degrees.
    let text = "parameters { m: kg = 5, hip: kg = 10, a: m = 0.5, b: m = 0.5, g: m/s^2 = 9.81, slope: rad = 0.05235987755982988 }
        coordinates { s: rad, n: rad }
        let p_hip = (a + b)*(-sin(s), cos(s))
        let p_stance = a*(-sin(s), cos(s))
        let p_swing = p_hip + b*(sin(n), -cos(n))
        let foot = p_hip + (a + b)*(sin(n), -cos(n))
        lagrangian hip/2*|dot(p_hip)|^2 + m/2*|dot(p_stance)|^2 + m/2*|dot(p_swing)|^2
            - g*(hip*p_hip.z + m*p_stance.z + m*p_swing.z)
        fn new_swing(w) = a*(-cos(n), -sin(n))*w
        fn new_hip(w) = (a + b)*(-cos(n), -sin(n))*w
        fn new_stance(w, o) = new_hip(w) + b*(cos(s), sin(s))*o
        minimize (time - 0.7 [s])^2
        finally {
            s == start(n), n == start(s), s + n == -2*slope, time >= 0.6 [s], time <= 0.9 [s],
            hip*cross(p_hip - foot, new_hip(start(dot(s)))) + m*cross(p_swing - foot, new_swing(start(dot(s))))
                + m*cross(p_stance - foot, new_stance(start(dot(s)), start(dot(n))))
                == hip*cross(p_hip - foot, dot(p_hip)) + m*cross(p_swing - foot, dot(p_swing))
                + m*cross(p_stance - foot, dot(p_stance)),
            cross(p_stance - p_hip, new_stance(start(dot(s)), start(dot(n)))) == cross(p_stance - p_hip, dot(p_stance))
        }
        start { s: 0.21, n: -0.31, dot(s): -1.1, dot(n): -0.4 }
        free { s in 0..=0.5, n in -0.6..=0, dot(s) in -3..=0, dot(n) in -3..=3 }
        horizon 0.7 [s]";
    let solution = optimum(text, 4);
    let (q, v) = start(&solution);
    let published = [0.218669, -0.323389, -1.092386, -0.377377];
    for (found, wanted) in q.iter().chain(&v).zip(published) {
        // Six digits are published; the motion amplifies what it begins with by some ten.
        assert!((found - wanted).abs() < 1e-5, "{found} for {wanted}");
    }
}

#[test]
fn hopper_repeats_itself_by_a_motor_that_gives_back_what_each_landing_takes() {
    let scene = of_text(
        "hopper.hang",
        include_str!("../../models/gallery/hopper.hang"),
    );
    let scene = scene.expect("no mistakes");
    let solution = solve(&scene).intervals(10).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    // The least that is known; about a thousandth of what the weight does in the same time.
    assert!(solution.objective <= 2.17716, "{solution}");
    let motion = solution.motion.as_ref().expect("a motion");
    let mut landings = motion
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Impact);
    let landing = landings.next().expect("a landing");
    assert!(landings.next().is_none(), "{motion}");
    // The foot of 1 kg loses its speed, the body none.
    let lost = 0.5 * landing.v_before[0].powi(2);
    let leg = |k: usize| motion.at(0.06 * k as f64).expect("inside")["leg"];
    let pushes = solution.controls.iter().enumerate();
    let work: f64 = pushes.map(|(k, u)| u[0] * (leg(k + 1) - leg(k))).sum();
    // Plan and motion are 1e-5 apart in the velocities of masses of 10 kg.
    assert!((work - lost).abs() < 1e-3 * lost, "{work} for {lost}");
    // By the other method the end is the start as well.
    let (q, v) = start(&solution);
    let controls = ControlSignal::PiecewiseConstant {
        times: (0..10).map(|k| 0.06 * f64::from(k)).collect(),
        values: solution.controls.clone(),
    };
    let again = simulate(&scene)
        .start("leg", q[1])
        .start("dot(z)", v[0])
        .start("dot(leg)", v[1])
        .controls(controls)
        .run()
        .expect("accepted");
    let end = again.at(0.6).expect("its end");
    for (name, wanted) in [
        ("z", 0.1),
        ("leg", q[1]),
        ("dot(z)", v[0]),
        ("dot(leg)", v[1]),
    ] {
        assert!(
            (end[name] - wanted).abs() < 1e-4,
            "{name}: {} for {wanted}",
            end[name]
        );
    }
}

#[test]
fn shaken_pendulum_repeats_itself_as_by_shooting() {
    // Without a closed form: scipy's DOP853 at 1e-13 and Newton's method on the return map; any other motion needs a torque.
    let text = "coordinates { phi: rad } controls { u: N m } lagrangian dot(phi)^2/2*1 [kg m^2] + cos(phi)*1 [J]
        forces { phi: u - 0.2 [N m s]*dot(phi) + 0.6 [N m]*cos(1.3 [rad/s]*t) } free { phi in -2..=2, dot(phi) in -2..=2 }
        minimize integral(u^2) finally { phi == start(phi), dot(phi) == start(dot(phi)) } horizon 4.83321946706122 [s]";
    let solution = optimum(text, 10);
    let (q, v) = start(&solution);
    for (found, wanted) in [(q[0], -0.707_411_715_3), (v[0], 0.311_654_259_3)] {
        assert!((found - wanted).abs() < 1e-7, "{found} for {wanted}");
    }
}
