//! Starts that contacts and joints leave inconsistent: what is said of them, and the motions that follow.

use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator};
use hangtime_scene_files::of_text;

use super::both::{ends, motions, scene};

/// What is said of a start that strikes.
fn strikes(run: &Simulation) -> Vec<&String> {
    let notes = run.notes.iter();
    notes.filter(|note| note.contains("is struck")).collect()
}

fn ball(law: &str, start: &str) -> String {
    format!(
        "parameters {{ g: m/s^2 = 10 }} coordinates {{ z: m }} controls {{ u: N in -20..=20 }}
        lagrangian (dot(z)^2/2 - g*z)*1 [kg] forces {{ z: u }} surface floor: z >= 0.3 [m] impact floor: {law}
        start {{ {start} }} horizon 0.15 [s]"
    )
}

#[test]
fn velocity_into_a_closed_contact_is_an_impact_at_once_that_every_method_names() {
    let bounces = ball("restitution 0.5", "z: 0.3, dot(z): -2");
    let words = "`floor` is closed at the start and the velocities there lead into it with 2 m/s: it is struck at t = 0";
    for run in motions(&bounces) {
        assert!(strikes(&run)[0].starts_with(words), "{:?}", run.notes);
        assert_eq!(run.events[0].kind, EventKind::Impact);
        ends(&run, &[("z", 0.3 + 0.15 - 5.0 * 0.0225)], 1e-9);
    }
    let rests = scene(&ball("inelastic", "z: 0.3, dot(z): -2"));
    let methods: [(&dyn Simulator, f64); 3] = [
        (&FixedStep::default(), 1e-9),
        // A step of 0.15 ms with 2 m/s, and the width in which a body hovers.
        (&Moreau::default(), 1e-3),
        (&Smooth::default(), 1e-2),
    ];
    for (method, accuracy) in methods {
        let problem = InitialValueProblem::of(&rests, None).expect("a horizon");
        let run = method
            .simulate(&rests, &problem, &mut |_| true)
            .expect("accepted");
        let said = strikes(&run);
        assert!(
            said.len() == 1 && said[0].contains("with 2 m/s"),
            "{said:?}"
        );
        let z = run.trajectory.q.last().expect("a motion")[0];
        assert!((z - 0.3).abs() < accuracy, "{}: {z}", method.name());
    }
}

#[test]
fn rounding_of_a_start_is_mended_in_silence() {
    let slope = |start: &str| {
        format!(
            "parameters {{ g: m/s^2 = 10, s: rad = 0.3, way: m = 7, v: m/s = 3 }} coordinates {{ x: m, z: m }}
            lagrangian (|dot((x, z))|^2/2 - g*z)*1 [kg] surface slope: z*cos(s) + x*sin(s) >= 0
            impact slope: restitution 0.4 start {{ {start} }} horizon 0.5 [s]"
        )
    };
    // Along the slope, to rounding; and below it by a share of 1e-10.
    let along = slope("x: way*cos(s), z: -way*sin(s), dot(x): v*cos(s), dot(z): -v*sin(s)");
    let below =
        slope("x: way*cos(s), z: -way*sin(s)*1.0000000001, dot(x): v*cos(s), dot(z): -v*sin(s)");
    let way = 7.0 + 3.0 * 0.5 + 10.0 * 0.3_f64.sin() * 0.125;
    for (text, accuracy) in [(along, 1e-9), (below, 1e-8)] {
        for run in motions(&text) {
            assert!(run.events.is_empty() && run.notes.is_empty(), "{run}");
            let end = [("x", way * 0.3_f64.cos()), ("z", -way * 0.3_f64.sin())];
            ends(&run, &end, accuracy);
        }
    }
}

#[test]
fn start_below_a_surface_by_more_is_refused_with_the_gap_and_its_unit() {
    let text = ball("inelastic", "z: 0.2999");
    let refused = of_text("scene.hang", &text)
        .expect_err("refused")
        .to_string();
    assert!(
        refused.contains("E08") && refused.contains("-0.0001 m"),
        "{refused}"
    );
}

#[test]
fn velocity_that_a_joint_forbids_is_projected_and_said() {
    let text = "parameters { l: m = 2, g: m/s^2 = 10 } coordinates { x: m, z: m }
        lagrangian (|dot((x, z))|^2/2 - g*z)*1 [kg] joint rod: x^2 + z^2 == l^2
        start { x: 2, dot(x): 0.5, dot(z): 1 } horizon 0.2 [s]";
    let angles =
        "parameters { l: m = 2, g: m/s^2 = 10 } coordinates { a: rad } let p = l*(cos(a), sin(a))
        lagrangian (|dot(p)|^2/2 - g*p.z)*1 [kg] start { dot(a): 0.5 } horizon 0.2 [s]";
    let [angle, _] = motions(angles).map(|run| run.at(0.2).expect("its end")["a"]);
    for run in motions(text) {
        let said = run.notes.iter().find(|note| note.contains("`rod`"));
        let said = said.expect("a note");
        assert!(said.contains("dot(x) from 0.5 to 0 m/s"), "{said}");
        assert!(said.contains("2 m^2/s in the velocity of `rod`"), "{said}");
        ends(
            &run,
            &[("x", 2.0 * angle.cos()), ("z", 2.0 * angle.sin())],
            1e-8,
        );
    }
}

#[test]
fn plan_begins_after_the_impact_of_its_start() {
    let solved = |text: &str| {
        let scene = scene(text);
        let solution = solve(&scene).intervals(4).run().expect("accepted");
        assert!(solution.status.is_solved(), "{solution}");
        solution
    };
    let task = |start: &str| {
        let goal =
            "minimize integral(u^2) finally { z == 0.8 [m], dot(z) == 0 [m/s] } horizon 0.6 [s]";
        ball("restitution 0.5", start).replace("horizon 0.15 [s]", goal)
    };
    let struck = solved(&task("z: 0.3, dot(z): -2"));
    let after = solved(&task("z: 0.3, dot(z): 1"));
    let apart = (struck.objective - after.objective).abs();
    assert!(apart <= 1e-9 * after.objective, "{apart}");
    let motion = struck.motion.expect("a motion");
    assert_eq!(strikes(&motion).len(), 1, "{:?}", motion.notes);
    assert_eq!(motion.trajectory.v[0][0], 1.0);
}

#[test]
fn spring_about_its_rest_position_takes_steps_of_its_own() {
    // Off by 5e-10 of its length: the last digits of positions, times the stiffness, are more than errors of steps may be.
    let text = "parameters { k: N/m = 2000, g: m/s^2 = 9.81 } coordinates { z: m, s: m }
        lagrangian 0.5 [kg]*dot(z)^2 + 5 [kg]*dot(z + s)^2 - 1 [kg]*g*z - 10 [kg]*g*(z + s) - k/2*(s - 1 [m])^2
        surface floor: z >= 0 impact floor: inelastic start { s: 0.95095000055, dot(s): 6e-9 } horizon 0.08 [s]";
    let scene = scene(text);
    let problem = InitialValueProblem::of(&scene, None).expect("a horizon");
    let method = EventDriven {
        tolerance: 1e-12,
        ..EventDriven::default()
    };
    let run = method
        .simulate(&scene, &problem, &mut |_| true)
        .expect("accepted");
    // It swings with the frequency of the upper mass alone; a hundred steps are many for a tenth of a swing.
    assert!(run.counts.elements < 400, "{}", run.counts.elements);
    let (w, t) = (200.0_f64.sqrt(), 0.08);
    let s = 0.95095 + 5.5e-10 * (w * t).cos() + 6e-9 / w * (w * t).sin();
    let end = run.trajectory.q.last().expect("a motion")[1];
    assert!((end - s).abs() < 1e-13, "{end} for {s}");
}
