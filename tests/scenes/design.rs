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

/// The objective with the free parameters at these values.
fn given(text: &str, intervals: usize, values: &[(&str, f64)]) -> f64 {
    let mut scene = scene(text);
    let declared = scene.declaration().parameters;
    let mut settings = Settings::default();
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
    solution.objective
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
    let at = |k: f64| given(text, intervals, &[(name, centre + k * step)]);
    let (place, objective) = lowest([-2.0, -1.0, 0.0, 1.0, 2.0].map(at));
    let best = centre + place * step;
    let size = solution.objective.abs();
    assert!(
        (solution.objective - objective).abs() < 1e-6 * size,
        "{} {objective}",
        solution.objective
    );
    let at = given(text, intervals, &[(name, found.value)]);
    assert!(
        (solution.objective - at).abs() < 1e-8 * size,
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
fn ramp_to_a_wall_is_best_at_45_degrees() {
    let solution = designed(RAMP, 2);
    let found = solution.parameters[0];
    assert!(
        (found.value - std::f64::consts::FRAC_PI_4).abs() < 1e-7,
        "{found}"
    );
    assert!((solution.objective - 2.0 * (2.0_f64 / 9.81).sqrt()).abs() < 1e-9);
    assert_eq!((found.unit, found.at_bound()), ("rad", None));
    // The motion is one of the scene, without the parameter.
    let motion = solution.motion.as_ref().expect("a motion");
    assert_eq!(motion.declaration.coordinates.len(), 1);
    assert!(motion.trajectory.q.iter().all(|q| q.len() == 1));
}

#[test]
fn parameter_that_ends_at_a_bound_says_so() {
    let solution = designed(&RAMP.replace("0.2..=1.4", "0.2..=0.6"), 2);
    let found = solution.parameters[0];
    assert_eq!(found.at_bound(), Some("upper"));
    assert!((found.value - 0.6).abs() < 1e-8);
    // s = g sin(angle) t^2/2 along the ramp.
    let time = (4.0 / (9.81 * 0.6_f64.sin() * 0.6_f64.cos())).sqrt();
    assert!((solution.objective - time).abs() < 1e-7);
    assert_eq!(
        found.to_string(),
        "angle = 0.6 rad, at the upper end of its range"
    );
}

#[test]
fn condition_on_parameters_alone_bounds_them() {
    let text = RAMP.replace("finally", "constraint flat: 2*angle <= 1.2 [rad] finally");
    let found = designed(&text, 2).parameters[0];
    assert!(
        (found.value - 0.6).abs() < 1e-8 && found.at_bound().is_none(),
        "{found}"
    );
    let kept = given(&text, 2, &[("angle", 0.5)]);
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

#[test]
fn restitution_is_found_through_an_impact() {
    let solution = designed(BOUNCING, 1);
    // z = e v s - g s^2/2 with the time s after the impact at sqrt(2/g).
    let s = 0.8 - (2.0_f64 / 9.81).sqrt();
    let v = (2.0_f64 * 9.81).sqrt();
    let best = (0.4 + 0.5 * 9.81 * s * s - 0.005 / (v * s)) / (v * s);
    let found = solution.parameters[0];
    assert!((found.value - best).abs() < 1e-8, "{found} {best}");
}

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
fn friction_is_found_of_a_slide_that_stops() {
    let solution = designed(RUBBING, 1);
    // It stops after v^2/(2 mu g): 2 (y - 0.6) dy/dmu + 0.01 = 0.
    let mut mu = 4.0 / (2.0 * 0.6 * 9.81);
    for _ in 0..50 {
        let y = 0.6 + 0.005 * mu * mu * 2.0 * 9.81 / 4.0;
        mu = 4.0 / (2.0 * y * 9.81);
    }
    let found = solution.parameters[0];
    assert!((found.value - mu).abs() < 1e-7, "{found} {mu}");
}

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
fn start_and_horizon_that_depend_on_a_parameter_move_with_it() {
    // A ball is dropped from twice a height for twice a span and ends at 1 m: height = 1/2 + g span^2.
    let text = "
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        free height: m in 0.6..=5 = 1
        free span: s in 0.05..=2 = 0.3
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        start { z: 2*height }
        horizon 2*span
        minimize height/1 [m] - 3*span/1 [s]
        finally { z == 1 [m] }
    ";
    let solution = designed(text, 1);
    let span = 3.0 / (2.0 * 9.81);
    let [height, of_span] = [0, 1].map(|k| solution.parameters[k].value);
    assert!((of_span - span).abs() < 1e-8 && (height - 0.5 - 9.81 * span * span).abs() < 1e-8);
    assert!(
        (solution.horizon - 2.0 * span).abs() < 1e-8,
        "{}",
        solution.horizon
    );
    let motion = solution.motion.as_ref().expect("a motion");
    assert_eq!(motion.trajectory.q[0], [2.0 * height]);
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

#[test]
fn leg_length_of_a_hopper_is_that_of_a_scan() {
    // A leg pushes a body up from a crouch until it is stretched, and is pulled off the ground then; a longer one is heavier.
    let text = "
        parameters { m: kg = 2, g: m/s^2 = 9.81, push: N = 60, density: kg/m = 1, crouch: m = 0.2 }
        free leg: m in 0.3..=2.5 = 0.6
        coordinates { z: m, f: m }
        lagrangian m/2*dot(z)^2 + density*leg/2*dot(f)^2 - m*g*z - density*leg*g*f
        forces { z: push, f: -push }
        surface ground: f >= 0
        impact ground: inelastic
        surface stop: leg - (z - f) >= 0
        impact stop: inelastic
        start { z: crouch }
        horizon 0.6 [s]
        minimize -f/1 [m]
    ";
    let solution = designed(text, 2);
    let foot = |leg: f64| {
        let rate = 60.0 / 2.0 - 9.81;
        let time = (2.0 * (leg - 0.2) / rate).sqrt();
        let (speed, since) = (rate * time * 2.0 / (2.0 + leg), 0.6 - time);
        speed * since - 9.81 / 2.0 * since * since
    };
    // A scan, narrowed by thirds.
    let (mut low, mut high) = (0.3, 2.5);
    while high - low > 1e-9 {
        let third = (high - low) / 3.0;
        if foot(low + third) < foot(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    let found = solution.parameters[0].value;
    // Where a maximum is flat its place is known to the root of rounding.
    assert!((found - low).abs() < 1e-6, "{found} {low}");
    assert!((solution.objective + foot(low)).abs() < 1e-9, "{solution}");
    assert_eq!(solution.planned_events.len(), 2, "{solution}");
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

#[test]
fn optimum_with_two_bounds_that_are_one_has_a_derivative_to_each_side() {
    // Pushed and braked by a, T = 2 sqrt(d/a); more than 1 is not allowed in any case.
    let text = "
        parameters { d: m = 1.2, a: N = 1 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        constraint up: u <= a
        lagrangian 1[kg]/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == d, dot(y) == 0 }
    ";
    let solution = solve(&scene(text)).intervals(2).gradient(["d", "a"]).run();
    let solution = solution.expect("accepted");
    let gradient = solution.gradient.as_ref().expect("asked for");
    let close = |found: f64, right: f64| (found - right).abs() < 1e-5;
    assert_eq!(gradient.obstacles[0], None, "{gradient:?}");
    assert!(
        close(gradient.objective[0], 1.0 / 1.2_f64.sqrt()),
        "{gradient:?}"
    );
    assert!(gradient.obstacles[1].is_some() && gradient.objective[1].is_nan());
    let sides = gradient.sides[1].expect("to both sides");
    assert_eq!(Some(sides.objective), sides.final_time);
    assert!(close(sides.objective[0], -1.2_f64.sqrt()), "{sides:?}");
    assert!(close(sides.objective[1], 0.0), "{sides:?}");
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
    let mut text = of_text("ramp.hang", ramp.text().expect("declared")).expect("derived");
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
    let mut outside = scene(RAMP);
    outside.set_parameter(3, 1.5);
    let refusal = solve(&outside).run().expect_err("refused").to_string();
    assert!(
        refusal.contains("free parameter `angle` = 1.5 rad: must be within its range 0.2..=1.4"),
        "{refusal}"
    );
    let rubbing = RUBBING.replace("0.05..=0.9 = 0.7", "0..=0.9 = 0");
    let refusal = solve(&scene(&rubbing))
        .run()
        .expect_err("refused")
        .to_string();
    assert!(
        refusal.contains("friction of `floor`") && refusal.contains("above 0 where it begins"),
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
    use hangtime::ocp::{Problem, program_sizes};
    let sizes = |text: &str| -> Vec<[usize; 2]> {
        let scene = scene(text);
        let problem = Problem::of(&scene, 4);
        let sizes = program_sizes(&scene, &problem, &Settings::default()).expect("accepted");
        sizes
            .iter()
            .map(|known| [known.size().variables, known.size().equalities])
            .collect()
    };
    let plain = WAVES.replace(
        "free w: rad/m in 0.4..=1.6 = 0.8",
        "parameters { w: rad/m = 0.8 }",
    );
    let with_one_more: Vec<[usize; 2]> = sizes(&plain).iter().map(|&[n, m]| [n + 1, m]).collect();
    assert_eq!(sizes(WAVES), with_one_more);
}

/// The ranges of an optimum's derivatives by one parameter, below and above.
fn ranges(text: &str, intervals: usize, name: &str) -> [Option<(f64, String)>; 2] {
    let scene = scene(text);
    let solution = solve(&scene).intervals(intervals).gradient([name]).run();
    let solution = solution.expect("accepted");
    let gradient = solution.gradient.as_ref().expect("asked for");
    let range = &gradient.ranges[0];
    [&range.below, &range.above].map(|limit| {
        let limit = limit.as_ref()?;
        Some((limit.change, limit.because.clone()))
    })
}

#[test]
fn derivatives_of_an_optimum_hold_until_a_bound_is_reached() {
    // From rest to rest over the way in 1 s the control is 4 times the way, forwards and then backwards.
    let text = "
        parameters { way: m = 0.5 }
        controls { u: m/s^2 in -4..=4 }
        coordinates { x: m }
        lagrangian 1[kg]*dot(x)^2/2
        forces { x: u*1[kg] }
        start { x: 0 [m] }
        horizon 1 [s]
        minimize integral(u^2)/1[m^2/s^3]
        finally { x == way, dot(x) == 0 [m/s] }
    ";
    let [below, above] = ranges(text, 2, "way");
    let (change, words) = above.expect("the control ends it");
    // Linear, so that only the tolerance of the solver is left.
    assert!(
        (change - 0.5).abs() < 1e-6 && words.contains("`u`"),
        "{change} {words}"
    );
    let (change, words) = below.expect("the control ends it");
    assert!(
        (change + 1.5).abs() < 1e-6 && words.contains("`u`"),
        "{change} {words}"
    );
}

#[test]
fn derivatives_of_an_optimum_hold_until_a_bound_is_left() {
    // The control stays at its bound of 1 as long as more than that is wanted.
    let text = "
        parameters { wanted = 1.8 }
        controls { u in 0..=1 }
        states { x }
        rates { x: u*1[1/s] }
        start { x: 0 }
        horizon 1 [s]
        minimize integral((u - wanted)^2)/1[s]
    ";
    let [below, above] = ranges(text, 2, "wanted");
    let (change, words) = below.expect("the bound is left");
    assert!(
        (change + 0.8).abs() < 1e-6 && words.contains("leaves"),
        "{change} {words}"
    );
    assert!(above.is_none(), "{above:?}");
}
