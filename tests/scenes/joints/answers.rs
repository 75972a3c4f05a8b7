//! What is refused, and in which words.

use super::scene;
use hangtime::baselines::Smooth;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator, step_sizes};
use hangtime_scene_files::of_text;

const HEAD: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, z: m, phi: rad }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) + m*l^2/2*dot(phi)^2 - m*g*z
    horizon 1 [s]
";

#[test]
fn starts_that_joints_do_not_allow_are_refused_with_what_is_left() {
    for (statements, words) in [
        (
            "joint rod: x^2 + z^2 == l^2  joint wall: x == 2 [m]  start { x: 1, z: -1 }",
            "the start cannot be completed (E25): joint `",
        ),
        (
            "joint left: x == 1 [m]  joint right: x == 2 [m]",
            "the start cannot be completed (E25): joint",
        ),
        (
            "joint slow: dot(x) == 1 [m/s]  joint fast: dot(x) == 2 [m/s]",
            "no velocities fulfil all joints at the start (E25): the velocity of joint `fast` is off by",
        ),
        (
            "joint flat: z == 0 [m]  surface floor: z >= 0  impact floor: inelastic",
            "joints hold the gap of surface `floor` at the start (E25)",
        ),
        (
            "joint cross: x^2 == z^2",
            "the start is a singular configuration (E25)",
        ),
    ] {
        let refused = simulate(&scene(&format!("{HEAD} {statements}"))).run();
        let error = refused.expect_err(statements).to_string();
        assert!(error.contains(words), "{statements}\n{error}");
    }
}

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
    let refused = simulate(&rod).gradient(["m"]).expect_err("derivatives");
    let refused = refused.to_string();
    assert!(
        refused.contains("a gradient of `Scene` is not supported: joints complete its start"),
        "{refused}"
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

#[test]
fn mistakes_with_joints_are_answered() {
    for (statements, words) in [
        (
            "joint x^2 == l^2",
            "a joint has a name, as in `joint loop: left == right`",
        ),
        (
            "joint rod: x = l",
            "the two sides of a joint are joined by `==`",
        ),
        (
            "joint rod: x >= l",
            "a joint holds both ways, so that it is an equation `==`",
        ),
        (
            "joint rod: x == z == l",
            "a joint is one equation; declare two joints",
        ),
        ("joint rod: x == phi", "units differ"),
        ("joint rod: x == dot(z)", "units differ"),
        (
            "joint rod: (x, z) == (l, l, l)",
            "compares a vector with 2 components with a vector with 3 components",
        ),
        (
            "joint rod: dot(x)^2 == 1 [m^2/s^2]",
            "is not linear in the velocities",
        ),
        (
            "joint rod: l == 1 [m]",
            "depends on no coordinate, so that it holds nothing",
        ),
        (
            "joint rod: (x - l)^2 == 0",
            "is a square that is 0, whose gradient vanishes where it holds",
        ),
        (
            "joint rod: x == l  joint rod: z == l",
            "joint `rod` is declared twice; rename one",
        ),
        (
            "joint rod: (x, dot(z)*1 [s]) == (l, l)",
            "declare two joints",
        ),
        (
            "controls { u: m } joint rod: x == u",
            "depends on the control `u`",
        ),
        (
            "joint rod: x == l  outputs { f = impulse(rod) }",
            "joint `rod` has no `impulse`; what it carries is `force(rod)`",
        ),
        (
            "joint rod: x == l  forces { z: force(rod) }",
            "is the force of a joint, which follows from the motion",
        ),
        (
            "joint rod: x == l  outputs { f: m = force(rod) }",
            "units differ",
        ),
        (
            "states { a: m } rates { a: -a/1 [s] } joint rod: x == a",
            "joint `rod` depends on a state, which changes by its rate alone",
        ),
        (
            "joint rod: x == l  surface floor: z >= 0  impact floor: inelastic, along (0, 1, 0)",
            "the impulse direction `along` of `floor` is not known to joints",
        ),
    ] {
        let error = match of_text("scene.hang", &format!("{HEAD} {statements}")) {
            Ok(_) => panic!("accepted: {statements}"),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(words), "{statements}\n{error}");
        println!(
            "{statements}\n    {}",
            error.lines().next().unwrap_or_default()
        );
    }
}
