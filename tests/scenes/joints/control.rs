//! Sizes of programs and of elements of scenes with joints, and a wheel; optima stand in `tests/cases/optima.md`.

use super::scene;
use hangtime::ocp::{Problem, Settings, program_size};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, step_sizes};
use hangtime_scene_files::TextScene;

/// A wheel that runs into a wall and has to come back to a `place` \[m\] in a time \[s\]: rolling by a joint, and by its angle alone.
pub(super) fn wheel_against_a_wall(place: f64, time: f64) -> [TextScene; 2] {
    let common = format!(
        "parameters {{ m: kg = 2, r: m = 0.3, j: kg*m^2 = 0.09 }}
         controls {{ u: N*m in -3..=3 }}
         forces {{ phi: u }}
         impact wall: restitution 0.6
         minimize integral(u^2)
         horizon {time} [s]"
    );
    let rolling = scene(&format!(
        "coordinates {{ x: m, phi: rad }} {common}
         lagrangian m/2*dot(x)^2 + j/2*dot(phi)^2
         joint roll: dot(x) == r*dot(phi)
         surface wall: x <= 1 [m]
         start {{ dot(x): 2, dot(phi): 2 [m/s]/r }}
         finally {{ x == {place} [m], dot(x) == 0 }}"
    ));
    let angle = scene(&format!(
        "coordinates {{ phi: rad }} {common}
         lagrangian m/2*(r*dot(phi))^2 + j/2*dot(phi)^2
         surface wall: r*phi <= 1 [m]
         start {{ dot(phi): 2 [m/s]/r }}
         finally {{ r*phi == {place} [m], dot(phi) == 0 }}"
    ));
    [rolling, angle]
}

/// Rows of joints stand in the place of as many collocation equations.
#[test]
fn joints_add_neither_unknowns_nor_equations_to_a_program() -> Result<(), InputError> {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { x: m, z: m }
         controls { u: N }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces { x: u }
         start { x: 0.9, z: -1.2 }
         minimize integral(u^2)
         finally { x == -0.9 [m] }
         horizon 1 [s]";
    let sizes = |joint: &str| {
        let scene = scene(&format!("{common} {joint}"));
        program_size(&scene, &Problem::of(&scene, 3), &Settings::default())
    };
    let (free, held) = (sizes("")?, sizes("joint rod: x^2 + z^2 == l^2")?);
    assert_eq!(held.size.variables, free.size.variables);
    assert_eq!(held.size.equalities, free.size.equalities);
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
