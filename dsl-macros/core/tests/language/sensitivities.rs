//! Derivatives by parameters are derived where they are asked for, and only there.

use hangtime_dsl::description::Description;
use hangtime_dsl::{describe_differentiated, describe_text, expand_text};

const BALL: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.5, mu = 0.1, height: m = 3, unused_by_motion: s = 4 }
    coordinates { y: m, z: m }
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    surface floor: z >= 0
    impact floor: restitution e^2, friction mu, sliding dot(y)
    outputs { energy: J = m*g*z }
    start { z: height }
    horizon 2*unused_by_motion
";

fn derived(parameters: &[&str]) -> Description {
    describe_differentiated(BALL, "ball", parameters)
        .expect("no mistakes")
        .0
}

#[test]
fn nothing_is_derived_that_nobody_asks_for() {
    let plain = describe_text(BALL, "ball").expect("no mistakes").0;
    assert!(plain.structure.sensitivity.is_none());
    let declaration = plain.structure.declaration;
    assert_eq!(plain.structure.columns(), declaration.inputs());
    assert_eq!(derived(&[]), plain);
    assert_eq!(derived(&["no_parameter"]), plain);
    let names = |scene: &Description| -> Vec<String> {
        scene
            .kernels
            .iter()
            .map(|kernel| kernel.name.clone())
            .collect()
    };
    assert!(
        names(&plain)
            .iter()
            .all(|name| !name.ends_with("derivative"))
    );
    assert!(names(&derived(&["g"])).contains(&"start_derivative".to_owned()));
}

#[test]
fn columns_of_parameters_stand_behind_those_of_the_inputs() {
    let scene = derived(&["height", "g", "e", "mu", "unused_by_motion"]);
    let declaration = scene.structure.declaration;
    let columns = scene.structure.columns();
    assert_eq!((declaration.inputs(), columns), (4, 9));
    let sensitivity = scene.structure.sensitivity.expect("asked for");
    // In order of declaration: g, e, mu, height, unused_by_motion.
    assert_eq!(sensitivity.parameters, [1, 2, 3, 4, 5]);
    assert_eq!(declaration.free_jacobian.entries, [(1, 4)]);
    assert!(declaration.free_hessian.entries.is_empty());
    assert_eq!(sensitivity.start.pattern.entries, [(1, 3)]);
    let horizon = sensitivity.horizon.as_ref().expect("declared");
    assert_eq!(horizon.pattern.entries, [(0, 4)]);
    let contact = &sensitivity.contacts[0];
    let restitution = contact.restitution.as_ref().expect("declared");
    assert_eq!(restitution.pattern.entries, [(0, 1)]);
    let friction = contact.friction.as_ref().expect("declared");
    assert_eq!(friction.coefficient.pattern.entries, [(0, 2)]);
    // The energy, by z and g; behind the inputs stand the time and four numbers of the contact.
    let outputs = sensitivity.outputs.as_ref().expect("declared");
    assert_eq!(outputs.pattern.entries, [(0, 1), (0, 4 + 1 + 4)]);
    assert_eq!(scene.kernels[outputs.kernel].outputs.len(), 2);
}

/// Names of all kernels.
fn kernels(text: &str) -> Vec<String> {
    let scene = describe_text(text, "ball").expect("no mistakes").0;
    let names = scene.kernels.iter().map(|kernel| kernel.name.clone());
    names.collect()
}

#[test]
fn scenes_without_free_parameters_carry_nothing_of_them() {
    // Motion, contact, law, and what is declared once.
    let all = [
        "free_acceleration",
        "free_jacobian",
        "free_hessian",
        "mass_matrix",
        "energy",
        "gap_floor",
        "contact_floor",
        "contact_jacobian_floor",
        "contact_hessian_floor",
        "restitution_floor",
        "tangent_floor",
        "tangent_jacobian_floor",
        "tangent_hessian_floor",
        "friction_floor",
        "outputs",
        "horizon",
        "start_coordinates",
        "start_velocities",
        "lower_bounds",
        "upper_bounds",
    ];
    assert_eq!(kernels(BALL), all);
    // What is found has a range, and no kernel more before a solve asks for it.
    let given = format!("{BALL} minimize -z/1[m]");
    let free = given
        .replace("e = 0.5, ", "")
        .replace("coordinates", "free e in 0..=1 = 0.5 coordinates");
    let mut names = kernels(&free);
    names.retain(|name| !kernels(&given).contains(name));
    assert_eq!(names, ["free_parameters_lower", "free_parameters_upper"]);
    let rust = |text: &str| {
        expand_text(text, "ball")
            .expect("no mistakes")
            .0
            .to_string()
    };
    assert!(!rust(BALL).contains("_derivative"), "{}", rust(BALL));
}

#[test]
fn what_conditions_set_is_differentiated_where_that_is_asked_for() {
    let text = "
        parameters { share = 0.5, top: m = 1 }
        coordinates { z: m }
        states { seen: m/s }
        lagrangian 1[kg]/2*dot(z)^2
        when z >= top { dot(z) = -share*dot(z), seen = dot(z) + t*share*1[m/s^2] }
        horizon 1 [s]
    ";
    assert!(
        kernels(text)
            .iter()
            .all(|name| !name.ends_with("derivative"))
    );
    let (scene, _) = describe_differentiated(text, "ball", &["share"]).expect("no mistakes");
    let sensitivity = scene.structure.sensitivity.expect("asked for");
    let reset = sensitivity.contacts[0]
        .reset
        .as_ref()
        .expect("it sets something");
    // Coordinates z and that of the state, their velocities, the time, and the parameter: both velocities by those that they read.
    let (velocity, time, share) = (2, 4, 5);
    assert_eq!(
        reset.pattern.entries,
        [
            (0, velocity),
            (0, share),
            (1, velocity),
            (1, time),
            (1, share)
        ]
    );
}
