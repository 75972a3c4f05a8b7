//! Bodies, shapes and contacts: what is written out has the functions of the scene that an author would have written.

use crate::repetition::assert_told;
use crate::{described, formatted};
use hangtime_dsl::description::{Description, Kernel, Source};

/// A scene with slips in the place of `SLIP`.
const SCENE: &str = "parameters { m: kg = 1, j: kg*m^2 = 0.01, r: m = 0.1 }
    coordinates { x: m, z: m, phi: rad, y: m }
    body block: mass m, inertia j at (x, z) angle phi, tip = (r, 0)
    body ground: fixed
    body wall: fixed at (1 [m], 0) angle 90 [deg]
    body ball: mass m at (y, 0)
    shape block.lid: rectangle (r, r) at (0, r)
    shape ground: half plane
    SLIP
    start { z: 1 [m] }";

/// The outputs of a kernel at numbers that stand in no relation to each other.
fn values(kernel: &Kernel) -> Vec<f64> {
    let number = |salt: f64, k: u32| 0.4 + (f64::from(k) * 0.618 + salt).fract();
    let mut found: Vec<f64> = Vec::new();
    for &operation in &kernel.operations {
        let given = |source| match source {
            Source::Parameter(k) => number(0.1, k),
            Source::Input(k) => number(0.5, k),
            Source::Weight(k) => number(0.9, k),
            Source::Constant(value) => value,
        };
        let value = operation.value(given, |k| found[k as usize]);
        found.push(value);
    }
    let outputs = kernel.outputs.iter();
    outputs.map(|&output| found[output as usize]).collect()
}

/// A scene and its twin without bodies have functions with the same values; what is drawn aside.
fn assert_alike(text: &str, twin: &str) -> Description {
    let [own, twin] = [text, twin].map(described);
    let kernels = |scene: &Description| -> Vec<Vec<f64>> {
        let kernels = scene
            .kernels
            .iter()
            .filter(|kernel| !["picture", "positive"].contains(&kernel.name.as_str()));
        kernels.map(values).collect()
    };
    let [left, right] = [&own, &twin].map(kernels);
    assert_eq!(left.len(), right.len(), "{text}");
    for (k, (left, right)) in left.iter().zip(&right).enumerate() {
        assert_eq!(left.len(), right.len(), "{k} of {text}");
        for (a, b) in left.iter().zip(right) {
            assert!(
                a == b || (a - b).abs() <= 1e-9 * (1.0 + b.abs()),
                "{a} {b} in {k} of {text}"
            );
        }
    }
    own
}

/// A box on a floor by hand.
const BOX: &str =
    "parameters { m: kg = 1, j: kg*m^2 = 0.01, g: m/s^2 = 9.81, w: m = 0.4, h: m = 0.2, mu = 0.3 }
    coordinates { x: m, z: m, phi: rad }
    let p = (x, z)
    let a = p + rotation(phi)*(w/2, h/2)
    let b = p + rotation(phi)*(-w/2, h/2)
    let c = p + rotation(phi)*(-w/2, -h/2)
    let d = p + rotation(phi)*(w/2, -h/2)
    lagrangian m/2*|dot(p)|^2 + j/2*dot(phi)^2 - m*g*z
    surface block_ground_1: a.z >= 0
    surface block_ground_2: b.z >= 0
    surface block_ground_3: c.z >= 0
    surface block_ground_4: d.z >= 0
    impact block_ground_1: inelastic, friction mu, sliding dot(a).x
    impact block_ground_2: inelastic, friction mu, sliding dot(b).x
    impact block_ground_3: inelastic, friction mu, sliding dot(c).x
    impact block_ground_4: inelastic, friction mu, sliding dot(d).x
    start { z: h/2, dot(x): 1 }";

#[test]
fn box_on_a_floor_is_its_corners() {
    assert_alike(
        "parameters { m: kg = 1, j: kg*m^2 = 0.01, g: m/s^2 = 9.81, w: m = 0.4, h: m = 0.2, mu = 0.3 }
         coordinates { x: m, z: m, phi: rad }
         gravity (0, -g)
         body block: mass m, inertia j at (x, z) angle phi
         body ground: fixed
         shape block: rectangle (w, h)
         shape ground: half plane
         contact block, ground: inelastic, friction mu
         start { z: h/2, dot(x): 1 }",
        BOX,
    );
}

#[test]
fn discs_strike_where_their_middles_are_a_sum_of_radii_apart() {
    assert_alike(
        "count n = 3
         parameters { m: kg = 1, r: m = 0.1, mu = 0.2 }
         coordinates { x[n]: m, z[n]: m, phi[n]: rad }
         body disc[k in 1..=n]: mass m, inertia m*r^2/2, at (x[k], z[k]), angle phi[k]
         shape disc[k in 1..=n]: circle r
         contact disc[i in 2..=n], disc[j in 1..i]: restitution 0.5, friction mu
         start { x[k in 1..=n]: k*1 [m] }",
        &twin_of_discs(),
    );
}

fn twin_of_discs() -> String {
    let mut text = "parameters { m: kg = 1, r: m = 0.1, mu = 0.2 }
         coordinates { x_1: m, x_2: m, x_3: m, z_1: m, z_2: m, z_3: m, phi_1: rad, phi_2: rad, phi_3: rad }
         lagrangian m/2*(dot(x_1)^2 + dot(z_1)^2) + m*r^2/4*dot(phi_1)^2 + m/2*(dot(x_2)^2 + dot(z_2)^2) + m*r^2/4*dot(phi_2)^2
            + m/2*(dot(x_3)^2 + dot(z_3)^2) + m*r^2/4*dot(phi_3)^2\n"
        .to_owned();
    text += "start { x_1: 1 [m], x_2: 2 [m], x_3: 3 [m] }";
    for (i, j) in [(2, 1), (3, 1), (3, 2)] {
        text += &format!(
            "let p_{i}{j} = (x_{i} - x_{j}, z_{i} - z_{j})
             let n_{i}{j} = p_{i}{j}/|p_{i}{j}|
             surface disc_{i}_disc_{j}: |p_{i}{j}| - r - r >= 0
             impact disc_{i}_disc_{j}: restitution 0.5, friction mu,
                sliding n_{i}{j}[1]*dot(p_{i}{j})[0] - n_{i}{j}[0]*dot(p_{i}{j})[1] + dot(phi_{i})*r
                    + dot(phi_{j})*(n_{i}{j} . (p_{i}{j}) - r)\n"
        );
    }
    text
}

#[test]
fn rectangle_on_a_rectangle_is_each_corner_on_all_sides_of_the_other() {
    let own = described(
        "parameters { m: kg = 1, w: m = 0.4, h: m = 0.2, j: kg*m^2 = 0.01 }
         coordinates { x[2]: m, z[2]: m, phi[2]: rad }
         body block[k in 1..=2]: mass m, inertia j, at (x[k], z[k]), angle phi[k]
         shape block[k in 1..=2]: rectangle (w, h)
         contact block[1], block[2]: inelastic
         start { z[1]: 1 [m] }",
    );
    let contacts = own.structure.declaration.contacts;
    let names: Vec<&str> = contacts.iter().map(|contact| contact.name).collect();
    assert_eq!(names.len(), 32);
    assert_eq!(names[0], "block[1].block[2][1].1");
    assert_eq!(names[31], "block[1].block[2][8].4");
}

#[test]
fn pendulum_on_a_hinge_and_by_its_angle() {
    let own = described(
        "parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
         coordinates { x: m, z: m, phi: rad }
         gravity (0, -g)
         body rod: mass m, inertia m*l^2/12, at (x, z), angle phi, top = (0, l/2)
         hinge pivot: (0, 0) == rod.top
         outputs { angle: rad = pivot.angle, pull: N = |force(pivot)| }
         start { z: -l/2 }",
    );
    let joints = own.structure.declaration.joints.expect("joints");
    assert_eq!(joints.list[0].name, "pivot");
    assert_alike(
        "parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
         coordinates { theta: rad }
         gravity (0, -g)
         body rod: mass m, inertia m*l^2/12, centre (0, -l/2), at (0, 0), angle theta, tip = (0, -l)
         outputs { height: m = rod.tip.z }
         start { theta: 1 }",
        "parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
         coordinates { theta: rad }
         let p = l/2*(sin(theta), -cos(theta))
         lagrangian m/2*|dot(p)|^2 + m*l^2/24*dot(theta)^2 - m*g*p.z
         outputs { height: m = -l*cos(theta) }
         start { theta: 1 }",
    );
}

#[test]
fn chain_of_bodies_hangs_each_on_the_one_before() {
    assert_alike(
        "count n = 3
         parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
         coordinates { theta[n]: rad }
         gravity (0, -g)
         body link[k in 1..=n]: mass m, centre (0, -l) at if k > 1 { link[k - 1].tip } else { (0, 0) } angle theta[k], tip = (0, -l)
         start { theta[k in 1..=n]: 0.1*k }",
        "count n = 3
         parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81 }
         coordinates { theta[n]: rad }
         let p[k in 1..=n] = p[k-1] + l*(sin(theta[k]), -cos(theta[k])), p[0] = (0, 0)
         lagrangian sum(k in 1..=n: m/2*|dot(p[k])|^2 - m*g*p[k][1])
         start { theta[k in 1..=n]: 0.1*k }",
    );
}

#[test]
fn wheel_that_rolls_holds_two_equations() {
    assert_alike(
        "parameters { m: kg = 1, r: m = 0.3, g: m/s^2 = 9.81, s: rad = 0.3 }
         coordinates { x: m, z: m, phi: rad }
         gravity (g*sin(s), -g*cos(s))
         body wheel: mass m, inertia m*r^2/2 at (x, z) angle phi
         body ground: fixed
         shape wheel: circle r
         shape ground: half plane
         rolling grip: wheel on ground
         start { z: r }",
        "parameters { m: kg = 1, r: m = 0.3, g: m/s^2 = 9.81, s: rad = 0.3 }
         coordinates { x: m, z: m, phi: rad }
         lagrangian m/2*|dot((x, z))|^2 + m*r^2/4*dot(phi)^2 + m*g*(x*sin(s) - z*cos(s))
         joint ground: z - r == 0
         joint roll: dot(x) + r*dot(phi) == 0
         start { z: r }",
    );
}

#[test]
fn sliders_and_welds_hold_a_line_and_an_angle() {
    let text = "parameters { m: kg = 1, j: kg*m^2 = 0.1, g: m/s^2 = 9.81 }
         coordinates { x: m, z: m, phi: rad, a: rad, u: m, w: m, v: rad }
         gravity (0, -g)
         body beam: mass m, inertia j at (0, 0) angle a
         body block: mass m, inertia j at (x, z) angle phi, side = (0.1 [m], 0)
         body plate: mass m, inertia j at (u, w) angle v
         slider rail: block on beam along (3, 4)
         weld seam: block.side == plate angle 90 [deg]
         outputs { way: m = rail.way }
         start { u: 0.1 [m], v: 90 [deg] }";
    let by_hand = "parameters { m: kg = 1, j: kg*m^2 = 0.1, g: m/s^2 = 9.81 }
         coordinates { x: m, z: m, phi: rad, a: rad, u: m, w: m, v: rad }
         lagrangian j/2*dot(a)^2 + m/2*(dot(x)^2 + dot(z)^2) + j/2*dot(phi)^2 + m/2*(dot(u)^2 + dot(w)^2) + j/2*dot(v)^2
            - m*g*(z + w)
         let e = rotation(a)*(3, 4)/|(3, 4)|
         joint rail: e[0]*z - e[1]*x == 0
         joint rail_turn: a - phi == 0
         joint seam: (x, z) + rotation(phi)*(0.1 [m], 0) == (u, w)
         joint seam_turn: v - phi == 90 [deg]
         outputs { way: m = e . (x, z) }
         start { u: 0.1 [m], v: 90 [deg] }";
    assert_alike(text, by_hand);
}

#[test]
fn words_of_bodies_are_names_elsewhere() {
    described(
        "parameters { m: kg = 1, j: kg*m^2 = 1 }
         coordinates { x: m, z: m, turn: rad, motor: m }
         body ball: mass m, inertia j, at (x, z), angle turn, point = (0, 1 [m])
         body box: mass m at (motor, 0)
         forces { ball.point: (1 [N], 0 [N]) }
         start { motor: 1 }",
    );
    described(
        "parameters { body: kg = 1, gravity: m/s^2 = 9.81, mass: kg = 1, shape: m = 1 }
         coordinates { contact: m, hinge: rad }
         fn rolling(a) = 2*a
         lagrangian (body + mass)/2*dot(contact)^2 + body*shape^2/2*dot(hinge)^2 - body*gravity*contact
         surface weld: contact >= 0
         impact weld: inelastic
         forces { contact: rolling(1 [N])*hinge }",
    );
    let own = described(
        "parameters { body: kg = 1, mass: kg = 1, shape: kg*m^2 = 1 }
         part leg(n) { coordinates { q: m } lagrangian += n*1 [kg]*dot(q)^2 }
         coordinates { x: m, y: m, phi: rad }
         lagrangian += dot(x)^2/2*mass
         left: leg(1)
         lagrangian += dot(y)^2/2*body
         right: leg(2)
         surface stop: x >= 0
         impact stop: inelastic
         rear: leg(3)
         body angle: mass body, inertia shape angle phi, at (x, y)
         contacts: leg(4)",
    );
    assert_eq!(own.structure.declaration.coordinates.len(), 7);
}

#[test]
fn names_of_bodies_in_parts_have_those_of_the_part_in_front() {
    let own = described(
        "part wheel(middle, r: m) {
            coordinates { phi: rad }
            body rim: mass m, inertia m*r^2, at middle, angle phi, valve = (r, 0)
            shape rim: circle r
            contact rim, ground: inelastic, friction 0.5
         }
         part cart(n) {
            coordinates { x: m, z: m }
            body frame: mass 3*m at (x, z)
            rear: wheel(frame, 0.1 [m])
         }
         parameters { m: kg = 1, g: m/s^2 = 9.81 }
         gravity (0, -g)
         body ground: fixed
         shape ground: half plane
         car: cart(1)
         outputs { load: N = force(car.rear.rim.ground), valve: m = car.rear.rim.valve.z }
         start { car.z: 0.1 [m] }",
    );
    let declaration = own.structure.declaration;
    assert_eq!(declaration.contacts[0].name, "car.rear.rim.ground");
    assert_eq!(declaration.coordinates[2].name, "car.rear.phi");
}

#[test]
fn points_that_stand_apart_are_products_of_vectors() {
    let scene = |gap: &str, law: &str| {
        format!(
            "parameters {{ m: kg = 1, r: m = 0.1 }}
             coordinates {{ a: m, b: m, phi: rad }}
             fn ahead(s) = (cos(s), sin(s))
             let p = (a, b)
             let corner[k in 1..=2] = k*(r, r)
             lagrangian m/2*|dot(p)|^2 + m*r^2/2*dot(phi)^2
             surface wall: {gap} >= 0
             impact wall: inelastic, friction 0.1, sliding {law}
             start {{ a: 1 [m] }}"
        )
    };
    let by_hand = scene(
        "p . (ahead(phi)) + p . (corner[1])/r + p . (corner[2])/r",
        "cos(phi)*dot(b) - sin(phi)*dot(a) + r*dot(phi)",
    );
    let law = "(-sin(phi), cos(phi)) . dot(p) + r*dot(phi)";
    let own = scene("p . ahead(phi) + p . corner[1]/r + p . corner[2]/r", law);
    assert_alike(&own, &by_hand);
    // The text of a compiled scene is that of its tokens.
    let tokens: proc_macro2::TokenStream = format!("S {{ {own} }}").parse().expect("tokens");
    let code = hangtime_dsl::expand(tokens).to_string();
    assert!(!code.contains("compile_error"), "{code}");
    assert_told(
        &scene("<<p.dot(ahead(phi))>>", law),
        "`.dot(...)` is a call of Rust; write `dot(p, ahead(phi))`, or `p . dot(ahead(phi))` with the velocity",
    );
}

#[test]
fn laws_of_several_surfaces_repeat_each_by_its_own_indices() {
    let text = |laws: &str| {
        format!(
            "count n = 2
             coordinates {{ x[n]: m, y[n]: m, z: m }}
             lagrangian sum(k in 1..=n: 1 [kg]*(dot(x[k])^2 + dot(y[k])^2)) + 1 [kg]*dot(z)^2
             surface left[k in 1..=n]: x[k] >= 0
             surface right[k in 1..=n]: y[k] >= 0
             surface top: z >= 0
             {laws}
             start {{ z: 0 }}"
        )
    };
    assert_alike(
        &text("impact left[k in 1..=n], right[j in 1..=n], top: inelastic"),
        &text(
            "impact left[k in 1..=n]: inelastic impact right[j in 1..=n]: inelastic impact top: inelastic",
        ),
    );
    assert_alike(
        &text("impact left[k in 1..=n], right[k]: inelastic impact top: inelastic"),
        &text("impact left[1], left[2], right[1], right[2]: inelastic impact top: inelastic"),
    );
}

#[test]
fn bodies_have_names_of_rust_where_they_are_compiled() {
    let scene = format!(
        "S {{ {} }}",
        SCENE.replace("SLIP", "contact block, ground: inelastic")
    );
    let code = hangtime_dsl::expand(scene.parse().expect("tokens")).to_string();
    assert!(!code.contains("compile_error"), "{code}");
}

#[test]
fn settled_style_keeps_bodies() {
    let wanted = "\
//! Bodies.

parameters { m: kg = 1, j: kg*m^2 = 0.1, l: m = 0.5, g: m/s^2 = 9.81 }
coordinates { x: m, z: m, phi: rad, theta: rad }
controls { u: N in -1..=1 }
forces { x: u }
gravity (0, -g)
body block: mass m, inertia j, at (x, z), angle -phi, tip = (-l, 0)
body rod: mass m, centre (0, -l/2) at block.tip angle theta
body ground: fixed at (0, 0) angle -l/l
shape block: rectangle (l, l/2) at (0, l)
shape ground: half plane angle 2 [deg]
contact block, ground: inelastic, friction 0.3
shape rod: polygon ((0, 0), (l, 0), (0, l)) at (0, -l)
hinge elbow: block.tip == ground, motor -2[N m]*phi, stop -1..=2, restitution 0.5
slider rail: block on ground along (1, 0)
minimize integral(u^2)
at 0.5 [s] { x == 0 }
start { z: 1 [m], x: 1 [m] }
horizon 2 [s]
";
    let loose = wanted
        .replace("at (", "at(")
        .replace("mass m, ", "mass m ,\n  ")
        .replace("angle -phi", "angle - phi");
    for text in [&loose, wanted] {
        assert_eq!(formatted(text), wanted);
    }
}

/// A cart that takes its wheel from a file, in which words in front of an arrow are replaced by those behind it.
fn with_wheel(change: &str) -> String {
    let (right, slip) = change.split_once(" -> ").expect("an arrow");
    let wheel = "part wheel(middle, r: m) {
            coordinates { phi: rad }
            body rim: mass m, inertia m*r^2 at middle angle phi, valve = (r, 0)
            shape rim: circle r
            contact rim, ground: inelastic, friction 0.5
         }";
    let scene = "use \"wheel.hang\"
         parameters { m: kg = 1, g: m/s^2 = 9.81 }
         coordinates { x: m, z: m }
         gravity (0, -g)
         body ground: fixed
         shape ground: half plane
         rear: wheel((x, z), 0.1 [m])
         start { z: 0.1 [m] }";
    let wheel = |_: &str| Ok(wheel.replace(right, slip));
    hangtime_dsl::with_used(scene, wheel).expect("files")
}

answers! {
    slips_in_a_file_that_is_used_are_told_there: with_wheel => r"
        circle r -> circle r
        angle phi, -> angle phi, radius r,
            E27 radius r => `radius` says nothing of body `rim`; it knows `mass`, `inertia`, `centre`, `at`, `angle`, `turn`, `fixed`
            E27 rim => there is no body `rear.rim` above
        circle r -> circle -r
            E10 -r => the size of a shape is positive
        circle r -> circle phi
            E03 phi => units differ: `rear.phi` has no unit, where m is needed (`rear.rim.radius` is declared so)
        rim, ground -> rim, floor
            E27 floor => there is no body `floor` above; declare it before, as in `body floor: mass m, at (x, z)` or `body floor: fixed`
        shape rim -> shape rin
            E27 rin => there is no body `rin` above; did you mean `rear.rim`?
            E27 rim => body `rear.rim` has no shape above that could touch anything
        circle r -> polygon ((0, 0), (r, 0), (r/4, r/4), (0, r))
            E27 (r/4, r/4) => at corner 3 of the polygon, which has to be convex; make it of several, as in `shape rear.rim.lid: polygon ..`
        rim, ground: inelastic, friction 0.5 -> rim, ground: inelastic hinge hub: rim == ground, stop 1..=1
            E10 1..=1 => the range of a stop begins below where it ends, as in `stop -1..=1`
        friction 0.5 -> friction z
            E03 z => units differ: `z` is in m, where a pure number is needed (a coefficient of friction is a ratio)
    ";
}
