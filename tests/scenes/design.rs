//! Free parameters: each optimum against a closed form, or against a scan of the same scene with the parameter given.

use hangtime::ocp::{Settings, Solution};
use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

fn scene(text: &str) -> TextScene {
    of_text("scene.hang", text).expect("no mistakes")
}

/// The optimum with all free parameters as unknowns.
fn designed(text: &str, intervals: usize) -> Solution {
    let scene = scene(text);
    let solution = solve(&scene).intervals(intervals).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

/// A plan with the free parameters at these values, from one that is near, as other orders of contacts have other optima.
fn given(
    text: &str,
    near: Option<&Solution>,
    intervals: usize,
    values: &[(&str, f64)],
) -> Solution {
    let mut scene = scene(text);
    let declared = scene.declaration().parameters;
    let mut settings = Settings::default();
    if let Some(previous) = near.and_then(|near| near.previous.clone()) {
        settings.guess = Guess::Previous(Box::new(previous));
    }
    for &(name, value) in values {
        let index = declared.iter().position(|known| known.name == name);
        let index = index.expect("declared");
        scene.set_parameter(index, value);
        settings.given_parameters.push(index);
    }
    let solution = solve(&scene).settings(settings).intervals(intervals).run();
    let solution = solution.expect("accepted");
    assert!(
        solution.parameters.is_empty() && solution.motion.is_some(),
        "{solution}"
    );
    solution
}

/// Where the polynomial through values at `-2, -1, 0, 1, 2` is lowest, near 0; and its value there.
fn lowest([a, b, c, d, e]: [f64; 5]) -> (f64, f64) {
    // c + p x + q x^2/2 + r x^3/6 + s x^4/24
    let p = (a - 8.0 * b + 8.0 * d - e) / 12.0;
    let q = (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / 12.0;
    let r = 0.5 * (e - 2.0 * d + 2.0 * b - a);
    let s = a - 4.0 * b + 6.0 * c - 4.0 * d + e;
    let mut x = 0.0;
    for _ in 0..20 {
        let slope = p + x * (q + x * (r / 2.0 + x * s / 6.0));
        x -= slope / (q + x * (r + x * s / 2.0));
    }
    (
        x,
        c + x * (p + x * (q / 2.0 + x * (r / 6.0 + x * s / 24.0))),
    )
}

/// Compares an optimum with the best of a scan around it.
fn compare_with_scan(text: &str, intervals: usize, name: &str, step: f64) -> Solution {
    let solution = designed(text, intervals);
    let found = solution.parameters[0];
    assert_eq!(found.name, name);
    // The values of the scan lie beside the one that was found.
    let centre = found.value + 0.3 * step;
    let near = given(text, None, intervals, &[(name, found.value)]);
    let at = |k: f64| {
        let values = [(name, centre + k * step)];
        given(text, Some(&near), intervals, &values).objective
    };
    let (place, objective) = lowest([-2.0, -1.0, 0.0, 1.0, 2.0].map(at));
    let best = centre + place * step;
    let size = solution.objective.abs();
    assert!(
        (solution.objective - objective).abs() < 1e-6 * size,
        "{} {objective}",
        solution.objective
    );
    let at = near.objective;
    // What an optimum costs by different paths agrees to a hundred tolerances of the programs.
    assert!(
        (solution.objective - at).abs() < 1e-7 * size,
        "{} {at}",
        solution.objective
    );
    assert!(
        (found.value - best).abs() < 1e-6 * found.value,
        "{} {best}",
        found.value
    );
    solution
}

const RAMP: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, goal: m = 2 }
    free angle: rad in 0.2..=1.4 = 0.5
    coordinates { s: m }
    lagrangian m/2*dot(s)^2 + m*g*s*sin(angle)
    minimize time
    finally { s*cos(angle) == goal }
";

#[test]
fn parameter_says_where_it_ends_and_is_none_where_it_is_given() {
    let solution = designed(RAMP, 2);
    let found = solution.parameters[0];
    assert_eq!((found.unit, found.at_bound()), ("rad", None));
    // The motion is one of the scene, without the parameter.
    let motion = solution.motion.as_ref().expect("a motion");
    assert_eq!(motion.declaration.coordinates.len(), 1);
    assert!(motion.trajectory.q.iter().all(|q| q.len() == 1));
    let found = designed(&RAMP.replace("0.2..=1.4", "0.2..=0.6"), 2).parameters[0];
    assert_eq!(found.at_bound(), Some("upper"));
    assert_eq!(
        found.to_string(),
        "angle = 0.6 rad, at the upper end of its range"
    );
    let text = RAMP.replace("finally", "constraint flat: 2*angle <= 1.2 [rad] finally");
    let found = designed(&text, 2).parameters[0];
    assert!(found.at_bound().is_none(), "{found}");
    let kept = given(&text, None, 2, &[("angle", 0.5)]).objective;
    let time = (4.0 / (9.81 * 0.5_f64.sin() * 0.5_f64.cos())).sqrt();
    assert!((kept - time).abs() < 1e-7, "{kept} {time}");
}

/// A spring throws a ball from a table; a stiffer one is heavier, and flies along.
const THROW: &str = "
    parameters { m: kg = 0.1, g: m/s^2 = 9.81, press: m = 0.1, density: kg m/N = 2e-5 }
    free stiffness: N/m in 100..=20000 = 500
    coordinates { x: m, z: m }
    let total = m + density*stiffness
    let speed = sqrt(stiffness*press^2/total)
    let drag = 0.02 [N s^2/m^2]
    lagrangian total/2*(dot(x)^2 + dot(z)^2) - total*g*z
    forces { x: -drag*dot(x)*dot(x), z: 0 [N] }
    start { z: 0.5 [m], dot(x): 0.8*speed, dot(z): 0.6*speed }
    horizon 1 [s]
    minimize -x/1 [m] + 1e-3*stiffness/1 [N/m]
    finally { z == 0 [m], dot(z) <= 0 [m/s], time <= 5 [s] }
";

#[test]
fn spring_that_throws_farthest_is_that_of_a_scan() {
    compare_with_scan(THROW, 2, "stiffness", 20.0);
}

/// A ball that bounces to a height.
const BOUNCING: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81 }
    free e in 0.1..=0.95 = 0.5
    coordinates { z: m }
    lagrangian m/2*dot(z)^2 - m*g*z
    surface floor: z >= 0
    impact floor: restitution e
    start { z: 1 [m] }
    horizon 0.8 [s]
    minimize (z - 0.4 [m])^2/1 [m^2] + 0.01*e
";

/// A block that slides on a rough floor until it stops.
const RUBBING: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, v: m/s = 2 }
    free mu in 0.05..=0.9 = 0.7
    coordinates { y: m, z: m }
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    surface floor: z >= 0
    impact floor: inelastic, friction mu, sliding dot(y)
    start { dot(y): v }
    horizon 1 [s]
    minimize (y - 0.6 [m])^2/1 [m^2] + 0.01*mu
";

#[test]
fn time_freezing_finds_the_same_parameters_in_flight_and_in_the_laws_of_contact() {
    for (text, intervals, name) in [(RAMP, 2, "angle"), (BOUNCING, 1, "e"), (RUBBING, 1, "mu")] {
        let best = designed(text, intervals);
        let freezing = Formulation::TimeFreezing(hangtime::ocp::TimeFreezingSettings::default());
        let scene = scene(text);
        let run = solve(&scene).formulation(freezing).intervals(intervals);
        let solution = run.run().expect("accepted");
        let [found, right] = [&solution, &best].map(|own| own.parameters[0].value);
        assert!((found - right).abs() < 1e-6, "{name}: {found} {right}");
        assert!((solution.objective - best.objective).abs() < 1e-9, "{name}");
        let report = solution.time_freezing.expect("a report");
        assert!(report.relaxed.led_to_motion, "{name}");
    }
}

#[test]
fn mass_of_a_hammer_is_that_of_a_scan() {
    let text = "
        parameters { nail: kg = 0.05 }
        free head: kg in 0.02..=5 = 0.5
        coordinates { x: m, y: m }
        controls { u: N in 0..=40 }
        lagrangian head/2*dot(x)^2 + nail/2*dot(y)^2
        forces { x: u - 4 [N s/m]*dot(x) }
        surface face: y - x >= 0
        impact face: restitution 0.5
        start { y: 0.4 [m] }
        horizon 0.3 [s]
        minimize -dot(y)/1 [m/s]
    ";
    let solution = compare_with_scan(text, 2, "head", 0.002);
    assert!(!solution.planned_events.is_empty());
}

/// A sledge that slides over waves, pushed a little.
const WAVES: &str = "
    parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.3 }
    free w: rad/m in 0.4..=1.6 = 0.8
    coordinates { y: m, z: m }
    controls { u: N in -1..=1 }
    fn ground(y) = a*cos(w*y)
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    forces { y: u }
    surface track: z - ground(y) >= 0
    impact track: inelastic
    start { z: a, dot(y): 1.2 [m/s] }
    horizon 2 [s]
    minimize time
    finally { y == 4 [m] }
";

#[test]
fn wave_number_of_a_track_is_that_of_a_scan() {
    compare_with_scan(WAVES, 4, "w", 0.002);
}

#[test]
#[ignore = "long"]
fn wave_number_of_a_pump_track_for_15_km_per_hour_is_that_of_a_scan() {
    let track = include_str!("../../models/scenes/pump-track.hang");
    let track = track.replace("    k: 1/m = 2,\n", "");
    let text = track.replace(
        "coordinates {",
        "free k: 1/m in 1.2..=2.6 = 2\ncoordinates {",
    );
    assert_ne!(text, track);
    // Within the scan the same controls are at their bounds.
    let solution = compare_with_scan(&text, 6, "k", 0.0005);
    assert_eq!(
        solution.motion.expect("a motion").trajectory.v[0][0],
        15.0 / 3.6
    );
}

/// Derivatives of an optimum against central differences of solves.
fn compare_gradient(text: &str, intervals: usize, steps: &[(&str, f64)]) {
    let scene = scene(text);
    let names: Vec<&str> = steps.iter().map(|step| step.0).collect();
    let solution = solve(&scene)
        .intervals(intervals)
        .gradient(names.clone())
        .run();
    let solution = solution.expect("accepted");
    let gradient = solution.gradient.as_ref().expect("asked for");
    assert_eq!(gradient.names, names);
    for (k, &(name, step)) in steps.iter().enumerate() {
        let declared = scene.declaration().parameters;
        let index = declared
            .iter()
            .position(|known| known.name == name)
            .expect("declared");
        let at = |offset: f64| {
            let mut moved = scene.clone();
            moved.set_parameter(index, scene.parameter(index) + offset);
            let solution = solve(&moved).intervals(intervals).run().expect("accepted");
            [solution.objective, solution.horizon]
        };
        let [far, near] = [step, 0.5 * step].map(|h| {
            let (ahead, behind) = (at(h), at(-h));
            [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * h))
        });
        // Richardson's extrapolation of both differences.
        let wanted = [0, 1].map(|i| (4.0 * near[i] - far[i]) / 3.0);
        let found = [
            gradient.objective[k],
            gradient.final_time[k].expect("determined"),
        ];
        for i in 0..2 {
            let close = (found[i] - wanted[i]).abs() < 1e-5 * wanted[i].abs().max(0.1);
            assert!(close, "{name}: {found:?} {wanted:?}");
        }
    }
}

#[test]
fn gradient_of_an_optimum_agrees_with_differences_of_solves() {
    let waves = WAVES
        .replace("free w: rad/m in 0.4..=1.6 = 0.8", "")
        .replace("a: m = 0.3", "a: m = 0.3, w: rad/m = 0.8");
    compare_gradient(&waves, 4, &[("w", 0.002), ("m", 0.01), ("a", 0.002)]);
}

/// A pendulum that a force swings, as a point on a rod.
fn swung(start: &str) -> String {
    format!(
        "
        parameters {{ m: kg = 1.6, g: m/s^2 = 9.7, l: m = 1.3 }}
        coordinates {{ x: m, z: m }}
        controls {{ u: N in -40..=40 }}
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        forces {{ x: u }}
        joint rod: x^2 + z^2 == l^2
        start {{ {start} }}
        minimize integral(u^2)
        finally {{ x == -0.2 [m] }}
        horizon 0.8 [s]
        "
    )
}

#[test]
fn optimum_whose_start_joints_complete_moves_with_what_moves_the_joints() {
    // The same by its angle, which is that of the guess whatever the length is.
    let angle = "
        parameters { m: kg = 1.6, g: m/s^2 = 9.7, l: m = 1.3 }
        coordinates { phi: rad }
        controls { u: N in -40..=40 }
        lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
        forces { phi: u*l*cos(phi) }
        start { phi: atan2(0.8, 0.6) }
        minimize integral(u^2)
        finally { l*sin(phi) == -0.2 [m] }
        horizon 0.8 [s]
    ";
    let by = |text: &str| {
        let scene = scene(text);
        let solution = solve(&scene).intervals(4).gradient(["l", "m", "g"]).run();
        let solution = solution.expect("accepted");
        assert!(solution.status.is_solved(), "{solution}");
        solution.gradient.expect("asked for").objective
    };
    let right = by(angle);
    for start in [
        "x: 0.8, z: -0.6",
        "x: 1.04, z: -0.78",
        "x: 0.8*l, z: -0.6*l",
    ] {
        for (found, right) in by(&swung(start)).iter().zip(&right) {
            // Both are collocations of the same order in other coordinates.
            let close = (found - right).abs() < 1e-5 * right.abs();
            assert!(close, "{start}: {found} {right}");
        }
    }
}

#[test]
fn optimum_without_controls_has_the_derivatives_of_its_motion() {
    // A rod that joints put into its place swings against a wall.
    let text = "
        parameters { m: kg = 2, g: m/s^2 = 9.6, l: m = 1.4, e = 0.6 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        joint rod: x^2 + z^2 == l^2
        surface wall: x >= 0.15 [m]
        impact wall: restitution e
        start { x: 1.2, z: -0.9 }
        minimize x
        horizon 0.8 [s]
    ";
    let (scene, names) = (scene(text), ["l", "g", "e"]);
    let (run, of_motion) = simulate(&scene).tolerance(1e-12).gradient(names).unwrap();
    assert_eq!(of_motion.obstacle, None, "{run}");
    let right = of_motion.objective.expect("declared");
    let solution = solve(&scene).intervals(4).gradient(names).run();
    let solution = solution.expect("accepted");
    let found = &solution.gradient.as_ref().expect("asked for").objective;
    for (found, right) in found.iter().zip(&right) {
        let close = (found - right).abs() < 1e-6 * right.abs().max(1.0);
        assert!(close, "{found} {right}\n{solution}");
    }
}

hangtime::model! {
    /// The ramp, compiled.
    pub Ramp {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        free angle: rad in 0.2..=1.4 = 0.5
        coordinates { s: m }
        lagrangian m/2*dot(s)^2 + m*g*s*sin(angle)
        minimize time
        finally { s*cos(angle) == 2 [m] }
    }
}

#[test]
fn compiled_scene_does_what_its_text_does_bit_for_bit() {
    let ramp = Ramp {
        angle: 0.6,
        m: 1.25,
        ..Ramp::default()
    };
    assert_eq!(ramp.free_parameters(), [2]);
    let mut text = of_text("ramp.hang", ramp.text()).expect("derived");
    text.set_parameter(0, 1.25);
    text.set_parameter(2, 0.6);
    let [own, its] = [&ramp as &dyn hangtime::model::Model, &text]
        .map(|scene| solve(scene).intervals(2).run().expect("accepted"));
    assert!((own.parameters[0].value - std::f64::consts::FRAC_PI_4).abs() < 1e-7);
    assert_eq!(own.parameters[0].value, its.parameters[0].value);
    assert_eq!(own.objective, its.objective);
    let [own, its] = [&ramp as &dyn hangtime::model::Model, &text].map(|scene| {
        let run = simulate(scene).horizon(2.0);
        run.gradient(["angle", "g", "m", "s"]).expect("accepted").1
    });
    // s = g sin(angle) t^2/2 after two seconds.
    assert!((own.q[0][0] - 2.0 * 9.81 * 0.6_f64.cos()).abs() < 1e-9);
    assert_eq!((own.q, own.v), (its.q, its.v));
}

#[test]
fn what_cannot_be_done_with_free_parameters_is_refused_by_name() {
    let ramp = scene(RAMP);
    let refusal = solve(&ramp)
        .gradient(["angle"])
        .run()
        .expect_err("refused")
        .to_string();
    assert!(
        refusal.contains("declare it in `parameters { angle = ... }`"),
        "{refusal}"
    );
    let refusal = solve(&ramp)
        .gradient(["mass"])
        .run()
        .expect_err("refused")
        .to_string();
    assert!(
        refusal.contains("`mass`, which is no parameter") && refusal.contains("m, g, goal, angle"),
        "{refusal}"
    );
    let pushed = scene(
        "
        parameters { m: kg = 1, most: N = 1 }
        coordinates { y: m }
        controls { u: N in -most..=most }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == 1 [m] }
    ",
    );
    let refusal = solve(&pushed)
        .gradient(["most"])
        .run()
        .expect_err("refused")
        .to_string();
    assert!(
        refusal.contains("a bound of `u` depends on `most`"),
        "{refusal}"
    );
}

#[test]
fn free_parameter_is_one_variable_of_each_program_and_nothing_else() {
    use hangtime::ocp::{Problem, program_size};
    let size = |text: &str| -> [usize; 2] {
        let scene = scene(text);
        let problem = Problem::of(&scene, 4);
        let own = program_size(&scene, &problem, &Settings::default()).expect("accepted");
        [own.size.variables, own.size.equalities]
    };
    let plain = WAVES.replace(
        "free w: rad/m in 0.4..=1.6 = 0.8",
        "parameters { w: rad/m = 0.8 }",
    );
    let [n, m] = size(&plain);
    assert_eq!(size(WAVES), [n + 1, m]);
}
