//! Sizes of programs and of elements of scenes with joints; optima stand in `tests/cases/optima.md`.

use super::scene;
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_size};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, step_sizes};

/// Rows of joints stand in the place of as many collocation equations.
#[test]
fn joints_add_neither_unknowns_nor_equations_to_a_program() -> Result<(), InputError> {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { x: m, z: m }
         controls { u: N in -5..=5 }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces { x: u }
         start { x: 0.9, z: -1.2 }
         minimize integral(u^2)
         finally { x == -0.5 [m] }
         horizon 1 [s]";
    let mut freezing = Settings::default();
    freezing.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    let stop = "surface stop: x >= -0.6 [m] impact stop: inelastic";
    for (settings, more) in [(Settings::default(), ""), (freezing, stop)] {
        let size = |joint: &str| {
            let scene = scene(&format!("{common} {more} {joint}"));
            let own = program_size(&scene, &Problem::of(&scene, 3), &settings)?;
            Ok::<_, InputError>((own.size.variables, own.size.equalities))
        };
        assert_eq!(size("joint rod: x^2 + z^2 == l^2")?, size("")?);
    }
    Ok(())
}

const HEAD: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, z: m, phi: rad }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) + m*l^2/2*dot(phi)^2 - m*g*z
    horizon 1 [s]
";

#[test]
fn joints_add_neither_unknowns_nor_equations_to_elements() -> Result<(), InputError> {
    let size = |statements: &str| {
        let scene = scene(&format!("{HEAD} {statements}"));
        let problem = InitialValueProblem::of(&scene, None)?;
        let sizes = step_sizes(&scene, &problem, &Fesd::default())?;
        Ok::<_, InputError>((sizes[0].size.variables, sizes[0].size.equalities))
    };
    let free = size("")?;
    for joint in [
        "joint rod: x^2 + z^2 == l^2  start { x: l }",
        "joint roll: dot(x) == l*dot(phi)",
    ] {
        assert_eq!(size(joint)?, free);
    }
    Ok(())
}
