//! How many operations the functions of a scene take: counts, which are deterministic.

use hangtime_dsl::description::Description;

/// What is derived of a scene, whatever it is warned of.
fn described(text: &str) -> Description {
    crate::derived(text).0
}

/// Operations of the kernels whose names begin so.
fn operations(scene: &Description, name: &str) -> usize {
    let kernels = scene.kernels.iter();
    let named = kernels.filter(|kernel| kernel.name.starts_with(name));
    named.map(|kernel| kernel.cost()).sum()
}

/// Numbers of coordinates and contacts.
fn bodies_and_contacts(scene: &Description) -> (usize, usize) {
    let declaration = scene.structure.declaration;
    (declaration.coordinates.len(), declaration.contacts.len())
}

/// A body in space by its rotation matrix, with these moments of inertia.
fn body(moments: &str) -> String {
    format!(
        "parameters {{ m: kg = 2, i_1: kg m^2 = 0.1, i_2: kg m^2 = 0.2, i_3: kg m^2 = 0.25, g: m/s^2 = 9.81 }}
         coordinates {{ x: m, y: m, z: m, psi: rad, theta: rad, phi: rad }}
         let r = rotation_z(psi)*rotation_x(theta)*rotation_z(phi)
         let w = transpose(r)*dot(r)
         let omega = (w[2][1], w[0][2], w[1][0])
         lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) + omega . (diagonal({moments})*omega)/2 - m*g*z
         start {{ theta: 0.3 [rad] }}"
    )
}

#[test]
fn body_in_space_takes_no_more_operations_than_its_mass_matrix_asks_for() {
    // By the momenta of this kinetic energy, which is that of a rotation matrix, it was 623 + 3199 + 7445.
    let scene = described(&body("i_1, i_2, i_3"));
    let free = ["free_acceleration", "free_jacobian", "free_hessian"];
    let counts = free.map(|name| operations(&scene, name));
    assert!(counts.iter().sum::<usize>() <= 1200, "{counts:?}");
    // A top of revolution: 589 + 3037 + 6614 before.
    let scene = described(&body("i_1, i_1, i_3"));
    let counts = free.map(|name| operations(&scene, name));
    assert!(counts.iter().sum::<usize>() <= 400, "{counts:?}");
}

/// `n` rods in absolute angles above a floor, whose ends may all touch it; with friction of the last of them or without.
fn chain(n: usize, law: &str) -> String {
    let each =
        |by: &str, one: &dyn Fn(usize) -> String| (1..=n).map(one).collect::<Vec<_>>().join(by);
    format!(
        "parameters {{ g: m/s^2 = 9.81, l: m = 0.1, h: m = {n} }} coordinates {{ {} }} let p0 = (0 [m], h) {} lagrangian {} {} impact \
         {}: inelastic{law}",
        each(", ", &|i| format!("q{i}")),
        each(" ", &|i| format!(
            "let p{i} = p{} + l*(sin(q{i}), -cos(q{i}))",
            i - 1
        )),
        each(" + ", &|i| format!(
            "1 [kg]*|dot(p{i})|^2/2 - 1 [kg]*g*p{i}.z"
        )),
        each(" ", &|i| format!("surface c{i}: p{i}.z >= 0")),
        each(", ", &|i| format!("c{i}")),
    )
}

#[test]
fn functions_of_a_contact_do_not_hold_the_inertia_of_a_chain() {
    let scene = described(&chain(10, ""));
    let shared = operations(&scene, "inertia");
    let all: usize = (1..=10)
        .map(|i| operations(&scene, &format!("direction_c{i}_")))
        .sum();
    // Each of the ten ends moves with up to ten angles: a normal, its derivatives and those of its weighted sum, three numbers an angle.
    assert!(all <= 10 * 10 * 6, "{all}");
    assert!(shared <= 3000, "{shared}");
    // It was 28,740 with a factorized system for each contact.
    assert!(operations(&scene, "") <= 10_000);
}

#[test]
fn derived_functions_of_a_chain_grow_with_the_square_of_its_links() {
    let count = |n: usize| operations(&described(&chain(n, "")), "motion");
    let (ten, twenty) = (count(10), count(20));
    // As many entries as pairs of links; one power more would be eight times.
    assert!(twenty < 5 * ten, "{ten} {twenty}");
}

#[test]
fn chain_of_forty_links_with_forty_contacts_is_no_declaration_too_large() {
    let scene = described(&chain(40, ""));
    assert_eq!(bodies_and_contacts(&scene), (40, 40));
    let largest = scene.kernels.iter().map(|kernel| kernel.cost()).max();
    assert!(
        largest.is_some_and(|largest| largest < 30_000),
        "{largest:?}"
    );
}

#[test]
fn scene_of_sixty_coordinates_with_a_hundred_contacts_is_no_declaration_too_large() {
    // Discs in a box, each with four walls and its neighbours.
    let n = 30;
    let list =
        |by: &str, one: &dyn Fn(usize) -> String| (1..=n).map(one).collect::<Vec<_>>().join(by);
    let walls = list(" ", &|i| {
        format!(
            "surface f{i}: z{i} >= 0.1 [m] surface l{i}: x{i} >= 0.1 [m] surface r{i}: 9 [m] - x{i} >= 0 impact f{i}, l{i}, r{i}: inelastic"
        )
    });
    let pairs: Vec<String> = (2..=n)
        .map(|i| {
            let j = i - 1;
            format!(
                "surface d{i}: |(x{i} - x{j}, z{i} - z{j})| - 0.2 [m] >= 0 impact d{i}: inelastic"
            )
        })
        .collect();
    let text = format!(
        "parameters {{ g: m/s^2 = 9.81 }} coordinates {{ {} }} lagrangian {} {walls} {} start {{ {} }}",
        list(", ", &|i| format!("x{i}: m, z{i}: m")),
        list(" + ", &|i| format!(
            "1 [kg]/2*(dot(x{i})^2 + dot(z{i})^2) - 1 [kg]*g*z{i}"
        )),
        pairs.join(" "),
        list(", ", &|i| format!(
            "x{i}: {:.1} [m], z{i}: 0.5 [m]",
            0.25 * i as f64
        )),
    );
    let scene = described(&text);
    assert_eq!(bodies_and_contacts(&scene), (60, 119));
}
