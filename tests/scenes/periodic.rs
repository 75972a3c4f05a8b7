//! Periodic motions: what is remembered of their starts, and a hopper. Closed forms of limit cycles stand in `tests/cases`.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

/// The start of a solution, without what is remembered of it.
fn start(solution: &Solution) -> (Vec<f64>, Vec<f64>) {
    let trajectory = &solution.motion.as_ref().expect("a motion").trajectory;
    (trajectory.q[0].clone(), trajectory.v[0].clone())
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
fn what_is_remembered_of_the_start_is_a_variable_each_and_nothing_where_nothing_is() {
    use hangtime::ocp::{Problem, Settings, program_size};
    let variables = |goals: &str| {
        let scene = of_text("scene.hang", &shaken(goals, "2")).expect("no mistakes");
        let own = program_size(&scene, &Problem::of(&scene, 10), &Settings::default());
        own.expect("accepted").size.variables
    };
    let plain = variables("x == 0 [m], dot(x) == 0 [m/s]");
    assert_eq!(variables("x == start(x), dot(x) == 0 [m/s]"), plain + 1);
    assert_eq!(
        variables("x == start(x), dot(x) == start(dot(x))"),
        plain + 2
    );
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
    // By the other method the end is the start as well, as near as the plan says.
    let tolerance = 1e-6 + 2.0 * solution.resimulation_velocity_error;
    assert!(tolerance < 1e-3, "{solution}");
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
            (end[name] - wanted).abs() < tolerance,
            "{name}: {} for {wanted}",
            end[name]
        );
    }
}
