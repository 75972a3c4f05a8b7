//! What a description says of a scene: equations as a person would write them, units, documentation, laws.

use crate::described;
use hangtime_dsl::description::Description;
use std::fs;

/// What is derived of a scene in a file.
fn of_file(path: &str) -> Description {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    described(&fs::read_to_string(format!("{root}/{path}")).expect("a scene"))
}

/// The right sides of the equations with that left side.
fn right(scene: &Description, left: &str) -> String {
    let equations = scene.structure.declaration.equations.iter();
    let found = equations.filter(|equation| equation.left == left);
    let found: Vec<&str> = found.map(|equation| equation.right).collect();
    found.join("; ")
}

/// Operations of the kernels with these names.
fn operations<const N: usize>(scene: &Description, names: [&str; N]) -> [usize; N] {
    names.map(|name| {
        let named = scene.kernels.iter().filter(|kernel| kernel.name == name);
        named.map(|kernel| kernel.cost()).sum()
    })
}

/// Bike and rider on a massless link, on a track, by this law.
fn pump(law: &str) -> Description {
    described(&format!(
        "parameters {{ m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }}
         coordinates {{ y: m, s: m, l: m in 0.27803..=0.59559 }}
         controls {{ u: N }}
         fn track(y) = a*(1 - cos(k*y))
         let bike = (y, track(y) + s)
         let rider = (y, track(y) + s + l)
         lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
         forces {{ l: u }}
         surface ground: s >= 0
         impact ground: inelastic, {law}"
    ))
}

#[test]
fn equations_read_as_a_person_would_write_them() {
    let along = pump("along (-diff(track)(y), 1, 0)");
    for (left, expected) in [
        (
            "kinetic energy",
            "m_b*(y'^2 + (s' + a*k*y'*sin(k*y))^2)/2 + m_r*(y'^2 + (s' + a*k*y'*sin(k*y) + l')^2)/2",
        ),
        ("y''", "0"),
        ("s''", "-g - a*k^2*cos(k*y)*y'^2 - u/m_b"),
        ("l''", "u/m_r + u/m_b"),
        ("gap(ground)'", "s'"),
        ("d(ground, y)", "-a*k*sin(k*y)"),
        ("D(ground)", "1/m_b + a^2*k^2*sin(k*y)^2/(m_b + m_r)"),
    ] {
        assert_eq!(right(&along, left), expected);
    }
    let holding = pump("holding l");
    for (left, expected) in [
        (
            "f_free",
            "(y', s', l', 0, -g - a*k^2*cos(k*y)*y'^2 - u/m_b, u/m_r + u/m_b, 1)",
        ),
        (
            "f_aux(ground)",
            "(0, 0, 0, -a_bar*a*k*sin(k*y)/(a^2*k^2*sin(k*y)^2 + 1), a_bar, 0, 0)",
        ),
        ("frozen(ground)", "gap(ground) < 0 and gap(ground)' < 0"),
    ] {
        assert_eq!(right(&holding, left), expected);
    }
    let hill = described(
        "parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.5, mu = 0.3, k: 1/m = 0.7 }
         coordinates { y: m, z: m }
         lagrangian m/2*|dot((y, z))|^2 - m*g*z
         surface ground: z >= 0.4 [m]*sin(k*y)
         surface wall: y <= 3 [m]
         impact ground: friction mu, restitution e
         impact wall: restitution e/2",
    );
    for (left, expected) in [
        ("gap(ground)", "z - 0.4*sin(k*y)"),
        ("slip(ground)", "y' + 0.4*k*z'*cos(k*y)"),
        (
            "frozen(wall)",
            "gap(wall) < 0, which goes on by gap(wall)' while q rests",
        ),
        ("f_aux(wall)", "(0, 0, -a_bar, 0, 0)"),
        (
            "f_aux(wall) opening",
            "restitution(wall)^2*f_aux(wall) where gap(wall)' > 0",
        ),
        (
            "f_aux(ground, slip > 0)",
            "(0, 0, -a_bar*(mu + 0.4*k*cos(k*y))/(0.16*k^2*cos(k*y)^2 + 1), a_bar*(1 - 0.4*mu*k*cos(k*y))/(0.16*k^2*cos(k*y)^2 + 1), 0)",
        ),
    ] {
        assert_eq!(right(&hill, left), expected);
    }
    // What would fill several lines is put together from what stands above it.
    let links = of_file("tests/declarations/scenes/rough-links.hang");
    let shown = right(&links, "e(wall)");
    let expected = "H b/D, b = d slip/dv, H = M^-1 with q1 locked, D = n' H n";
    assert_eq!(shown, expected);
    let shown = right(&links, "f_aux(wall, slip > 0)");
    assert_eq!(shown, "(0, a_bar*(d(wall) - friction(wall)*e(wall)), 0)");
}

#[test]
fn pump_track_takes_no_more_operations_than_hand_derived_code() {
    // Hand-derived equations in a code generator take 26 for the value and 63 for all three, of which the derivation must not exceed
    // 30 and 40 more.
    let motion = ["free_acceleration", "free_jacobian", "free_hessian"];
    let [along, holding] = [
        "along (-diff(track)(y), 1 + diff(track)(y)^2, 0)",
        "holding l",
    ]
    .map(pump);
    assert_eq!(operations(&along, motion), [13, 18, 18]);
    // The inverse inertia of the whole system takes two operations more than that of the locked one.
    let contact = [
        "contact_ground",
        "contact_jacobian_ground",
        "contact_hessian_ground",
    ];
    assert_eq!(operations(&along, contact), [16, 22, 35]);
    assert_eq!(operations(&holding, contact), [14, 22, 35]);
    // What is not declared is not emitted.
    let mut names = holding.kernels.iter().map(|kernel| &kernel.name);
    assert!(names.all(|name| !name.starts_with("tangent") && !name.starts_with("path")));
}

#[test]
fn declaration_carries_laws_and_pieces() {
    let rod = of_file("tests/declarations/scenes/rough-rod.hang");
    let [floor, post] = rod.structure.declaration.contacts else {
        panic!("two contacts");
    };
    assert_eq!(
        format!("{:?} {:?}", floor.law, post.law),
        "Restitution Inelastic"
    );
    assert_eq!((floor.held, post.held), (&[][..], &[2, 3][..]));
    assert!(floor.friction.is_some() && post.friction.is_some() && !post.custom_direction);
    let edges = of_file("tests/declarations/scenes/edges.hang");
    let contacts = edges.structure.declaration.contacts.iter();
    let known: Vec<_> = contacts.map(|c| (c.name, c.alternatives)).collect();
    let pieces: [(&str, &[usize]); 4] = [
        ("ground.1", &[]),
        ("ground.2", &[2, 3]),
        ("ground.3", &[1, 3]),
        ("ground.4", &[1, 2]),
    ];
    assert_eq!(known, pieces);
}

#[test]
fn declaration_carries_the_task_of_optimal_control() {
    let cart = of_file("tests/declarations/scenes/cart.hang");
    let task = cart.structure.declaration.optimal_control.expect("a task");
    assert!(task.running_cost && task.final_cost && task.free_time);
    let conditions = [task.constraints, task.goals].concat();
    let said: Vec<_> = conditions
        .iter()
        .map(|c| (c.name, c.unit, c.equality, c.documentation))
        .collect();
    let expected = [
        ("ceiling", "m", false, "Room above the cart."),
        ("power", "W", false, ""),
        ("moving", "m", true, ""),
        ("y == target", "m", true, "At the target."),
        ("|dot(tip)|^2 <= 1 [m^2/s^2]", "m^2/s^2", false, ""),
        ("z >= 0.1 [m/s]*time", "m", false, ""),
        ("theta == omega*t", "", true, ""),
    ];
    assert_eq!(said, expected);
    // theta, z and dot(y) of (y, theta, z, dot(y), dot(theta), dot(z)).
    assert_eq!(task.free_start, [1, 2, 3]);
    // The final time is given where only `t` occurs, and the motion does not depend on it.
    let goal = described(
        "coordinates { q } controls { u } lagrangian dot(q)^2/2 forces { q: u } finally { q == 2*t } horizon 3",
    );
    let declaration = goal.structure.declaration;
    let task = declaration.optimal_control.expect("a task");
    assert!(!task.free_time && !declaration.explicit_time && !task.running_cost);
    let mut names = goal.kernels.iter().map(|kernel| &kernel.name);
    assert!(names.all(|name| !name.starts_with("path")));
}
