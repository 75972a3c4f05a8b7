//! Joints in programs of the time-freezing system.

use super::control::wheel_against_a_wall;
use super::{assert_close, scene};
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_size};
use hangtime::prelude::*;
use hangtime_scene_files::TextScene;

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
        program_size(&scene, &Problem::of(&scene, 3), &settings)
    };
    let (free, held) = (sizes("")?, sizes("joint rod: x^2 + z^2 == l^2")?);
    assert_eq!(held.size.variables, free.size.variables);
    assert_eq!(held.size.equalities, free.size.equalities);
    Ok(())
}
