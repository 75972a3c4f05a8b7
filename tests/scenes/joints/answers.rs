//! What is refused, and in which words.

use super::scene;
use hangtime::baselines::Smooth;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator, step_sizes};

const HEAD: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, z: m, phi: rad }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) + m*l^2/2*dot(phi)^2 - m*g*z
    horizon 1 [s]
";

#[test]
fn methods_that_do_not_hold_joints_say_so_by_name() {
    let rod = scene(&format!(
        "{HEAD} joint rod: x^2 + z^2 == l^2  start {{ x: 1, z: -1 }}"
    ));
    let problem = InitialValueProblem::of(&rod, None).expect("a horizon");
    let refused = Smooth::default().simulate(&rod, &problem, &mut |_| true);
    assert_eq!(
        refused.expect_err("smoothed steps").to_string(),
        "joint `rod` by smoothed steps is not supported; simulate by finite elements, from event to event or by fixed \
         steps, which hold joints"
    );
}

#[test]
fn joints_add_their_rows_to_elements_and_nothing_else() -> Result<(), InputError> {
    let groups = |statements: &str| {
        let scene = scene(&format!("{HEAD} {statements}"));
        let problem = InitialValueProblem::of(&scene, None)?;
        let sizes = step_sizes(&scene, &problem, &Fesd::default())?;
        let named = |name: &str| {
            let found = sizes[0].groups.iter().find(|group| group.name == name);
            found.map_or((0, 0), |group| {
                (group.size.variables, group.size.jacobian_nonzeros)
            })
        };
        Ok::<_, InputError>((named("state"), named("joints")))
    };
    let (free, none) = groups("")?;
    assert_eq!(none, (0, 0));
    // What moves positions and velocities onto it at the end of the element.
    let (held, joints) = groups("joint rod: x^2 + z^2 == l^2  start { x: l }")?;
    assert_eq!((held.0, joints), (free.0, (2, 1)));
    let (rolled, rolling) = groups("joint roll: dot(x) == l*dot(phi)")?;
    assert_eq!((rolled.0, rolling), (free.0, (1, 1)));
    Ok(())
}
