//! Joints: what is accepted, how it is written, and what is derived.

/// A scene with two points and an angle, and further statements.
fn scene(statements: &str) -> String {
    format!(
        "parameters {{ m: kg = 1, l: m = 1.5 }} coordinates {{ x: m, y: m, phi: rad }} let p = (x, y)
         lagrangian m/2*|dot(p)|^2 + m*l^2/2*dot(phi)^2 {statements}"
    )
}

fn described(statements: &str) -> hangtime_dsl::description::Description {
    crate::described(&scene(statements))
}

#[test]
fn joints_are_named_counted_and_measured() {
    let derived = described(
        "joint rod: |p|^2 == l^2
         joint pin: p == l*(cos(phi), sin(phi))
         joint roll: dot(x) == l*dot(phi)
         joint still: dot(p) == 0
         joint drive: phi == 2 [1/s]*t",
    );
    let declaration = derived.structure.declaration;
    let joints = declaration.joints.expect("joints");
    let seen: Vec<(&str, &str, usize, bool)> = joints
        .list
        .iter()
        .map(|joint| (joint.name, joint.unit, joint.rows, joint.holonomic))
        .collect();
    let expected = [
        ("rod", "m^2", 1, true),
        ("pin", "m", 2, true),
        ("roll", "m", 1, false),
        ("still", "m", 2, false),
        ("drive", "", 1, true),
    ];
    assert_eq!(seen, expected);
    assert_eq!((joints.rows(), joints.jacobian.rows), (7, 14));
    assert!(declaration.explicit_time);
}

#[test]
fn force_of_a_joint_has_its_unit_and_components() {
    for (output, accepted) in [
        ("f: N = force(pin)[0]", true),
        ("f: N = force(pin)[1] + force(roll)", true),
        ("f: J = force(turn)", true),
        ("f: m = force(roll)", false),
        ("f: N = force(pin)", false),
        ("f: N = force(pins)", false),
    ] {
        let text = scene(&format!(
            "joint pin: (x, y) == (l, l)  joint roll: dot(x) == l*dot(phi)  joint turn: phi == 0
             outputs {{ {output} }}"
        ));
        let found = hangtime_dsl::describe_text(&text, "s");
        let why = found.as_ref().err().map(|mistakes| &mistakes[0].message);
        assert_eq!(found.is_ok(), accepted, "{output}: {why:?}");
    }
}

#[test]
fn equations_of_joints_are_shown() {
    let derived = described("joint rod: |p|^2 == l^2  joint roll: dot(x) == l*dot(phi)");
    let shown: Vec<String> = derived
        .structure
        .declaration
        .equations
        .iter()
        .filter(|known| known.left.contains("joint"))
        .map(|known| format!("{}: {}", known.left, known.right))
        .collect();
    assert_eq!(
        shown,
        [
            "joint(rod) = 0: x^2 + y^2 - l^2",
            "joint(rod)' = 0: 2*x*x' + 2*y*y'",
            "joint(roll) = 0: x' - l*phi'",
            "joints: M q'' = f + G' force, G = d joint'/dq', and M^-1 of contacts is that where all joints hold",
        ]
    );
}

#[test]
fn joint_is_formatted_as_one_line() {
    let text = "parameters { l: m = 1 }\ncoordinates { x: m, y: m }\nlagrangian 1 [kg]/2*(dot(x)^2 + dot(y)^2)\njoint rod :x^2+ y^2==l ^2 // length";
    let formatted = crate::formatted(text);
    assert!(
        formatted.ends_with("\njoint rod: x^2 + y^2 == l^2 // length\n"),
        "{formatted}"
    );
}

#[test]
fn scenes_without_joints_have_no_function_of_them() {
    let derived = described("");
    assert!(derived.structure.joints.is_none());
    assert!(
        derived
            .kernels
            .iter()
            .all(|kernel| !kernel.name.contains("joint"))
    );
}
