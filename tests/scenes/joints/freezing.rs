//! Joints in the time-freezing system: its elements, its steps as complementarity problems, and its programs of optimal control.

use super::control::wheel_against_a_wall;
use super::{assert_close, last, scene, solved, tight};
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_sizes};
use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;
use hangtime_scene_files::TextScene;

/// A crank whose rod ends in a block that rubs on a rail, is held by it, and strikes a wall.
const PRESS: &str = "
    parameters { j: kg*m^2 = 0.4, m: kg = 1.2, r: m = 0.5, l: m = 1.3, mu = 0.15, g: m/s^2 = 9.81, pull: N*m = 2 }
    forces { phi: -pull }
    impact wall: restitution 0.6
    surface wall: x <= 1.72 [m]
    horizon 1.2 [s]
";

/// With a rod as joint, whose block lies on a rail. It is light beside what the rod presses it with.
fn on_a_rail() -> String {
    format!(
        "{PRESS} coordinates {{ phi: rad, x: m, z: m }}
         lagrangian j/2*dot(phi)^2 + m/2*|dot((x, z))|^2 - m*g*z
         joint rod: |(x - r*cos(phi), z - r*sin(phi))|^2 == l^2
         surface rail: z >= 0
         impact rail: inelastic, friction mu, sliding dot(x)
         start {{ phi: 1.1, x: r*cos(1.1) + sqrt(l^2 - (r*sin(1.1))^2), z: 0, dot(phi): -1 }}"
    )
}

#[test]
fn block_on_a_rail_behind_a_rod_moves_alike_in_numerical_time() {
    let press = scene(&on_a_rail());
    let exact = tight(&press);
    assert!(
        exact
            .events
            .iter()
            .any(|event| event.kind == EventKind::Impact)
    );
    let frozen = simulate(&press).method(Fesd {
        formulation: StepFormulation::TimeFreezing,
        ..Fesd::default()
    });
    let frozen = solved(frozen.tolerance(1e-9).run());
    assert_eq!(frozen.events.len(), exact.events.len());
    for (own, its) in frozen.events.iter().zip(&exact.events) {
        assert_eq!((own.kind, own.contact), (its.kind, its.contact));
        assert_close(own.time, its.time, 1e-8, "time of an event");
    }
    for name in ["phi", "x", "z", "dot(phi)"] {
        assert_close(last(&frozen, name), last(&exact, name), 1e-7, name);
    }
    let (phi, x, z) = (last(&frozen, "phi"), last(&frozen, "x"), last(&frozen, "z"));
    let length = f64::hypot(x - 0.5 * phi.cos(), z - 0.5 * phi.sin());
    assert_close(length, 1.3, 1e-14, "length of the rod");
}

/// Steps as complementarity problems hold joints with their order where nothing is struck, and to the length of an element where something is.
#[test]
fn steps_as_programs_hold_joints() {
    let swings = scene(
        "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { x: m, z: m }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         joint rod: x^2 + z^2 == l^2
         surface stop: x >= -0.9 [m]
         impact stop: inelastic
         start { x: 1.2, z: -0.9 }
         horizon 1 [s]",
    );
    let exact = tight(&swings);
    assert_eq!(
        exact.events.first().map(|event| event.kind),
        Some(EventKind::Impact)
    );
    let run = |steps: usize| {
        let method = Fesd {
            formulation: StepFormulation::Complementarity,
            steps: Some(steps),
            stages: Some(3),
            ..Fesd::default()
        };
        simulate(&swings).method(method)
    };
    // Radau's method of order 5 on 48 elements of 10 ms: 2e-10.
    let swing = solved(run(16).horizon(0.5).run());
    let half = solved(
        simulate(&swings)
            .horizon(0.5)
            .method(EventDriven::default())
            .tolerance(1e-13)
            .run(),
    );
    for name in ["x", "z", "dot(x)"] {
        assert_close(last(&swing, name), last(&half, name), 1e-8, name);
    }
    let programs = solved(run(20).run());
    // The time of the impact is known to the length of an element, at 3 m/s.
    assert_close(last(&programs, "x"), last(&exact, "x"), 0.05, "x");
    for k in 0..programs.trajectory.time.len() {
        let (x, z) = (programs["x"][k], programs["z"][k]);
        assert_close(x.hypot(z), 1.5, 1e-8, "length of the rod");
    }
}

#[test]
fn steps_as_programs_on_grids_that_nobody_named_tell_how_late_a_release_is() {
    // A pendulum leaves its stop right after it has struck: known to the length of an element only, whatever the order.
    let swings = scene(
        "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { phi: rad }
         lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
         surface stop: l*sin(phi) >= -0.9 [m]
         impact stop: inelastic
         start { phi: 0.92 }
         horizon 1 [s]",
    );
    let exact = tight(&swings);
    let method = Fesd::default().with_formulation(StepFormulation::Complementarity);
    let run = simulate(&swings).method(method).run().expect("accepted");
    let off = (last(&run, "phi") - last(&exact, "phi")).abs();
    let estimate = run.error_estimate.expect("two grids");
    assert!(
        off <= 1e-6 || !run.status.is_solved() && off <= 10.0 * estimate,
        "{} {off:e} {estimate:e}",
        run.status
    );
}

/// The optimum of the time-freezing formulation, which has to be certified, and whose program has to end exactly.
fn frozen(scene: &TextScene, intervals: usize) -> Solution {
    let formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    let solution = solve(scene)
        .intervals(intervals)
        .formulation(formulation)
        .run();
    let solution = solution.unwrap_or_else(|error| panic!("{error}"));
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

/// What the program of the time-freezing system itself ends at.
fn of_the_program(solution: &Solution) -> f64 {
    let report = solution.time_freezing.as_ref().expect("a report");
    assert!(report.residuals.complementarity <= 1e-10, "{report:?}");
    report.objective
}

#[test]
fn wheel_that_rolls_by_a_joint_comes_back_from_a_wall_as_its_angle_does() {
    let [rolling, angle] = wheel_against_a_wall(0.4, 1.4);
    let (own, its) = (frozen(&rolling, 5), frozen(&angle, 5));
    // Accelerations are constant on intervals: both schemes are exact, up to what the lengths of elements are kept even for.
    assert_close(own.objective / its.objective, 1.0, 1e-9, "objective");
    let programs = of_the_program(&own) / of_the_program(&its);
    assert_close(programs, 1.0, 1e-6, "objective of the programs");
}

#[test]
fn rod_that_swings_against_a_stop_costs_what_its_angle_does() {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         controls { u: N in -20..=20 }
         impact stop: inelastic
         minimize integral(u^2)
         horizon 1.1 [s]";
    let rod = scene(&format!(
        "{common} coordinates {{ x: m, z: m }}
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces {{ x: u }}
         joint rod: x^2 + z^2 == l^2
         surface stop: x >= -0.6 [m]
         start {{ x: 0.9, z: -1.3 }}
         free {{ x in 0..=1.2 [m], z }}
         finally {{ x == -0.6 [m], dot(x) == 0 }}"
    ));
    let angle = scene(&format!(
        "{common} coordinates {{ phi: rad }}
         lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
         forces {{ phi: u*l*cos(phi) }}
         surface stop: l*sin(phi) >= -0.6 [m]
         start {{ phi: 0.65 }}
         free {{ phi in 0..=0.9272952180016122 [rad] }}
         finally {{ l*sin(phi) == -0.6 [m], dot(phi) == 0 }}"
    ));
    let (own, its) = (frozen(&rod, 6), frozen(&angle, 6));
    // Cartesian coordinates of a circle have an error of their own.
    let scale = its.objective.abs().max(1.0);
    assert_close(
        own.objective / scale,
        its.objective / scale,
        1e-5,
        "objective",
    );
}

/// Rows of joints stand in the place of as many rows of collocation, and a scene without has none.
#[test]
fn joints_add_neither_unknowns_nor_equations_to_a_time_freezing_program() -> Result<(), InputError>
{
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { x: m, z: m }
         controls { u: N in -5..=5 }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces { x: u }
         surface stop: x >= -0.6 [m]
         impact stop: inelastic
         start { x: 0.9, z: -1.2 }
         minimize integral(u^2)
         finally { x == -0.5 [m] }
         horizon 1 [s]";
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    let sizes = |joint: &str| {
        let scene = scene(&format!("{common} {joint}"));
        let sizes = program_sizes(&scene, &Problem::of(&scene, 3), &settings)?;
        Ok::<_, InputError>(sizes[0].clone())
    };
    let (free, held) = (sizes("")?, sizes("joint rod: x^2 + z^2 == l^2")?);
    assert_eq!(held.size().variables, free.size().variables);
    assert_eq!(held.size().equalities, free.size().equalities);
    let of_joints = |size: &hangtime::simulation::FormulationSize| {
        let found = size.groups.iter().find(|group| group.name == "joints");
        found.map_or(0, |group| group.size.equalities)
    };
    assert_eq!(of_joints(&free), 0);
    // A position and a velocity at each stage of each element.
    assert!(of_joints(&held) > 0 && of_joints(&held).is_multiple_of(2 * 3));
    Ok(())
}
