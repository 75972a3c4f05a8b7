//! Families that are written as texts, as users write them: how many bodies and contacts a scene has is drawn as well.

use std::f64::consts::PI;
use std::fmt::Write;

use super::draw::Draw;

/// Draws a scene as a text.
type Family = fn(&mut Draw) -> String;

/// The families by their names.
pub(crate) const FAMILIES: [(&str, Family); 7] = [
    ("mixed", mixed),
    ("floors", floors),
    ("wheels", wheels),
    ("piles", piles),
    ("clearances", clearances),
    ("linkages", linkages),
    ("spatial", spatial),
];

/// The text of a scene of a family.
pub(crate) fn text(name: &str, draw: &mut Draw) -> String {
    let family = FAMILIES.iter().find(|(family, _)| *family == name);
    family.map_or_else(String::new, |(_, family)| family(draw))
}

/// Lines of a text.
#[derive(Default)]
struct Text(String);

impl Text {
    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }
}

/// An impact law: inelastic, or with restitution.
fn law(draw: &mut Draw) -> String {
    if draw.chance(0.5) {
        "inelastic".to_owned()
    } else {
        format!("restitution {:.3}", draw.between(0.05, 0.9))
    }
}

/// Balls on a line with springs, dry friction, walls that stand or move, and gaps between neighbours.
fn mixed(draw: &mut Draw) -> String {
    let count = 2 + draw.below(4);
    let mut text = Text::default();
    let all = |name: &str| {
        let each = (0..count).map(|k| format!("{name}{k}"));
        each.collect::<Vec<_>>().join(", ")
    };
    text.line(&format!("coordinates {{ {} }}", all("x")));
    let mut energy = String::new();
    for k in 0..count {
        let mass = draw.between(0.2, 3.0);
        let _ = write!(energy, " + {:.4}*dot(x{k})^2", 0.5 * mass);
        if k > 0 && draw.chance(0.5) {
            let (stiff, gap) = (draw.between(1.0, 40.0), draw.between(0.6, 1.4));
            let _ = write!(energy, " - {stiff:.4}*(x{k} - x{} - {gap:.4})^2", k - 1);
        }
    }
    text.line(&format!("lagrangian{}", energy.trim_start_matches(" +")));
    let pull = draw.between(-3.0, 3.0);
    text.line(&format!("forces {{ x0: {pull:.4} }}"));
    for k in 1..count {
        let gap = draw.between(0.2, 0.5);
        text.line(&format!("surface c{k}: x{k} - x{} - {gap:.4} >= 0", k - 1));
        text.line(&format!("impact c{k}: {}", law(draw)));
    }
    let (size, rate) = (draw.between(0.0, 0.3), draw.between(0.5, 6.0));
    let wall = if draw.chance(0.5) {
        format!("x0 + 0.8 - {size:.4}*sin({rate:.4}*t) >= 0")
    } else {
        "x0 + 0.8 >= 0".to_owned()
    };
    text.line(&format!("surface left: {wall}"));
    text.line(&format!("impact left: {}", law(draw)));
    if draw.chance(0.5) {
        let far = count as f64 + 0.3;
        text.line(&format!("surface right: {far:.4} - x{} >= 0", count - 1));
        text.line(&format!("impact right: {}", law(draw)));
    }
    for k in 0..count {
        if draw.chance(0.4) {
            let bound = draw.between(0.1, 3.0);
            text.line(&format!(
                "dry friction f{k}: bound {bound:.4}, sliding dot(x{k})"
            ));
        }
    }
    let starts = (0..count).map(|k| {
        let speed = draw.between(-3.0, 3.0);
        format!("x{k}: {}, dot(x{k}): {speed:.4}", k as f64)
    });
    text.line(&format!(
        "start {{ {} }}",
        starts.collect::<Vec<_>>().join(", ")
    ));
    text.line("horizon 2");
    text.0
}

/// Whether a floor is rough: its friction.
fn floor_friction(draw: &mut Draw) -> Option<f64> {
    draw.chance(0.5).then(|| draw.between(0.1, 0.9))
}

/// Adds the contact of a point of a body with the floor.
fn on_the_floor(text: &mut Text, name: &str, point: &str, (law, mu): (&str, Option<f64>)) {
    text.line(&format!("let {name} = {point}"));
    text.line(&format!("surface on_{name}: {name}.z >= 0"));
    match mu {
        Some(mu) => text.line(&format!(
            "impact on_{name}: {law}, friction {mu:.4}, sliding dot({name}.y)"
        )),
        None => text.line(&format!("impact on_{name}: {law}")),
    }
}

/// A body of `corners` corners at equal angles, or a rectangle, above a floor.
fn body_on_floor(draw: &mut Draw, corners: &[(f64, f64)], start: &str) -> String {
    let mut text = Text::default();
    text.line("coordinates { y: m, z: m, phi: rad }");
    let (mass, inertia) = (draw.between(0.5, 3.0), draw.between(0.02, 0.3));
    text.line(&format!(
        "lagrangian {:.4} [kg]*(dot(y)^2 + dot(z)^2)/2 + {:.4} [kg m^2]*dot(phi)^2/2 - {:.4} [N]*z",
        mass,
        inertia,
        9.81 * mass
    ));
    let (law, mu) = (law(draw), floor_friction(draw));
    for (k, (a, b)) in corners.iter().enumerate() {
        let point = format!(
            "(y + {a:.6} [m]*cos(phi) - {b:.6} [m]*sin(phi), z + {a:.6} [m]*sin(phi) + {b:.6} [m]*cos(phi))"
        );
        on_the_floor(&mut text, &format!("p{k}"), &point, (&law, mu));
    }
    text.line(start);
    text.line("horizon 1.2 [s]");
    text.0
}

/// A box with four corners over a flat floor.
fn floors(draw: &mut Draw) -> String {
    let (a, b) = (draw.between(0.1, 0.6), draw.between(0.1, 0.4));
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b)];
    let start = format!(
        "start {{ z: {:.4} [m], phi: {:.4} [rad], dot(y): {:.4} [m/s], dot(phi): {:.4} [rad/s] }}",
        a.hypot(b) + draw.between(0.01, 0.6),
        draw.between(-PI, PI),
        draw.between(-2.0, 2.0),
        draw.between(-4.0, 4.0),
    );
    body_on_floor(draw, &corners, &start)
}

/// A wheel without a rim, of three to eight spokes, over a flat floor.
fn wheels(draw: &mut Draw) -> String {
    let count = 3 + draw.below(6);
    let radius = draw.between(0.2, 0.6);
    let spoke = |k: usize| {
        let angle = 2.0 * PI * k as f64 / count as f64;
        (radius * angle.cos(), radius * angle.sin())
    };
    let corners: Vec<(f64, f64)> = (0..count).map(spoke).collect();
    let start = format!(
        "start {{ z: {:.4} [m], phi: {:.4} [rad], dot(y): {:.4} [m/s], dot(phi): {:.4} [rad/s] }}",
        radius + draw.between(0.001, 0.3),
        draw.between(-PI, PI),
        draw.between(0.0, 3.0),
        draw.between(-6.0, 0.0),
    );
    body_on_floor(draw, &corners, &start)
}

/// Boxes that slide above each other on rough faces, the lowest on a floor that may shake.
fn piles(draw: &mut Draw) -> String {
    let count = 2 + draw.below(3);
    let mut text = Text::default();
    let names = (0..count).map(|k| format!("y{k}, z{k}"));
    text.line(&format!(
        "coordinates {{ {} }}",
        names.collect::<Vec<_>>().join(", ")
    ));
    let mut energy = String::new();
    for k in 0..count {
        let mass = draw.between(0.3, 3.0);
        let (half, weight) = (0.5 * mass, 9.81 * mass);
        let _ = write!(
            energy,
            " + {half:.4}*(dot(y{k})^2 + dot(z{k})^2) - {weight:.4}*z{k}"
        );
    }
    text.line(&format!("lagrangian{}", energy.trim_start_matches(" +")));
    let shakes = draw.chance(0.5);
    let (size, rate) = (draw.between(0.0, 0.02), draw.between(5.0, 30.0));
    for k in 0..count {
        let below = match k {
            0 if shakes => format!("{size:.4}*sin({rate:.4}*t)"),
            0 => "0".to_owned(),
            _ => format!("z{} + 0.2", k - 1),
        };
        let slides = match k {
            0 => "dot(y0)".to_owned(),
            _ => format!("dot(y{k}) - dot(y{})", k - 1),
        };
        text.line(&format!("surface s{k}: z{k} - {below} >= 0"));
        let (law, mu) = (law(draw), draw.between(0.05, 0.8));
        text.line(&format!(
            "impact s{k}: {law}, friction {mu:.4}, sliding {slides}"
        ));
    }
    let starts = (0..count).map(|k| {
        let (height, speed) = (
            0.2 * k as f64 + draw.between(0.01, 0.3) + 0.3 * k as f64,
            draw.between(-2.0, 2.0),
        );
        format!("z{k}: {height:.4}, dot(y{k}): {speed:.4}")
    });
    text.line(&format!(
        "start {{ {} }}",
        starts.collect::<Vec<_>>().join(", ")
    ));
    text.line("horizon 1.5");
    text.0
}

/// A slider-crank whose slider has play in its guide: its four corners hit the walls.
fn clearances(draw: &mut Draw) -> String {
    let (crank, rod) = (draw.between(0.1, 0.2), draw.between(0.35, 0.6));
    let (length, height, play) = (
        draw.between(0.03, 0.08),
        draw.between(0.02, 0.05),
        draw.between(0.0005, 0.004),
    );
    let mut text = Text::default();
    text.line("coordinates { a: rad, b: rad, c: rad }");
    text.line(&format!(
        "let pin = ({crank:.5} [m]*cos(a) + {rod:.5} [m]*cos(b), {crank:.5} [m]*sin(a) + {rod:.5} [m]*sin(b))"
    ));
    let (disc, bar, mass) = (
        draw.between(0.002, 0.02),
        draw.between(0.002, 0.01),
        draw.between(0.02, 0.2),
    );
    text.line(&format!(
        "lagrangian {disc:.5} [kg m^2]*dot(a)^2/2 + {bar:.5} [kg m^2]*dot(b)^2/2 + {:.7} [kg m^2]*dot(c)^2/2 + {mass:.5} [kg]*|dot(pin)|^2/2",
        mass * (length * length + height * height) / 3.0
    ));
    let torque = draw.between(-0.2, 0.2);
    text.line(&format!("forces {{ a: {torque:.5} [N m] }}"));
    let law = law(draw);
    for (k, (x, z)) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .into_iter()
        .enumerate()
    {
        let (x, z) = (x * length, z * height);
        text.line(&format!(
            "let p{k} = pin.z + {x:.6} [m]*sin(c) + {z:.6} [m]*cos(c)"
        ));
        let wall = height + play;
        let (sign, name) = if z < 0.0 { ("+", "low") } else { ("-", "high") };
        text.line(&format!(
            "surface {name}{k}: {wall:.6} [m] {sign} p{k} >= 0"
        ));
        text.line(&format!("impact {name}{k}: {law}"));
    }
    let angle = draw.between(-PI, PI);
    let other = -(crank / rod * angle.sin()).asin();
    let speed = draw.between(-20.0, 20.0);
    let follows = -crank * angle.cos() * speed / (rod * other.cos());
    text.line(&format!(
        "start {{ a: {angle:.9} [rad], b: {other:.9} [rad], dot(a): {speed:.6} [rad/s], dot(b): {follows:.6} [rad/s] }}"
    ));
    text.line("horizon 0.6 [s]");
    text.0
}

/// Rods that are pinned to each other and to a pivot by joints, each a body with three coordinates, with stops between neighbours, over a
/// rough floor that the end strikes; sometimes with the end on a rail, which closes a loop.
fn linkages(draw: &mut Draw) -> String {
    let count = 1 + draw.below(3);
    let closed = count > 1 && draw.chance(0.3);
    let mut text = Text::default();
    let names = (0..count).map(|k| format!("x{k}: m, z{k}: m, a{k}: rad"));
    let names = names.collect::<Vec<_>>().join(", ");
    text.line(&format!("coordinates {{ {names} }}"));
    let (mut energy, mut joints, mut stops) = (String::new(), Text::default(), Text::default());
    let mut start = Vec::new();
    let (mut pin, mut place, mut before) = ("(0 [m], 0 [m])".to_owned(), (0.0, 0.0), None);
    let stop_law = law(draw);
    for k in 0..count {
        let (length, mass) = (draw.between(0.5, 1.5), draw.between(0.5, 2.0));
        let (angle, half) = (draw.between(0.3, 1.2), 0.5 * length);
        let (dx, dz) = (half * angle.cos(), half * angle.sin());
        start.push(format!(
            "x{k}: {}, z{k}: {}, a{k}: {angle}, dot(a{k}): {:.4}",
            place.0 + dx,
            place.1 + dz,
            draw.between(-2.0, 2.0)
        ));
        let _ = write!(
            energy,
            " + {mass:.4} [kg]/2*(dot(x{k})^2 + dot(z{k})^2) + {:.6} [kg m^2]/2*dot(a{k})^2 - {:.4} [N]*z{k}",
            mass * length * length / 12.0,
            9.81 * mass
        );
        let end = |sign: char| {
            format!("(x{k} {sign} {half} [m]*cos(a{k}), z{k} {sign} {half} [m]*sin(a{k}))")
        };
        joints.line(&format!("joint pin{k}: {} == {pin}", end('-')));
        if let Some(other) = before
            && draw.chance(0.6)
        {
            let limit: f64 = f64::abs(angle - other) + draw.between(0.1, 1.5);
            let bend = format!("a{k} - a{}", k - 1);
            stops.line(&format!("surface up{k}: {bend} <= {limit:.4} [rad]"));
            stops.line(&format!("surface down{k}: {bend} >= -{limit:.4} [rad]"));
            stops.line(&format!("impact up{k}, down{k}: {stop_law}"));
        }
        (pin, before) = (end('+'), Some(angle));
        place = (place.0 + 2.0 * dx, place.1 + 2.0 * dz);
    }
    if closed {
        joints.line(&format!("joint rail: ({pin}).y == {} [m]", place.0));
    }
    text.line(&format!("lagrangian{}", energy.trim_start_matches(" +")));
    text.0.push_str(&joints.0);
    text.0.push_str(&stops.0);
    let floor = draw.between(-0.6, -0.2);
    text.line(&format!("let tip = {pin}"));
    text.line(&format!("surface floor: tip.z >= {floor:.4} [m]"));
    let law = law(draw);
    match floor_friction(draw) {
        Some(mu) => text.line(&format!(
            "impact floor: {law}, friction {mu:.4}, sliding dot(tip.y)"
        )),
        None => text.line(&format!("impact floor: {law}")),
    }
    text.line(&format!("start {{ {} }}", start.join(", ")));
    text.line("horizon 1 [s]");
    text.0
}

/// One or two balls in space, perhaps on a rod or on a rope to a pivot, over a floor that is tilted and mostly rough, and beside a wall.
fn spatial(draw: &mut Draw) -> String {
    let count = if draw.chance(0.4) { 2 } else { 1 };
    let mut text = Text::default();
    let names = (0..count).map(|k| format!("x{k}: m, y{k}: m, z{k}: m"));
    let names = names.collect::<Vec<_>>().join(", ");
    text.line(&format!("coordinates {{ {names} }}"));
    let (mut energy, mut start, mut places) = (String::new(), Vec::new(), Vec::new());
    let (tilt, heading) = (draw.between(0.0, 0.4), draw.between(0.0, 2.0 * PI));
    for k in 0..count {
        let mass = draw.between(0.5, 2.0);
        let _ = write!(
            energy,
            " + {mass:.4} [kg]/2*(dot(x{k})^2 + dot(y{k})^2 + dot(z{k})^2) - {:.4} [N]*z{k} + {:.4} [N]*x{k} + {:.4} [N]*y{k}",
            9.81 * mass * tilt.cos(),
            9.81 * mass * tilt.sin() * heading.cos(),
            9.81 * mass * tilt.sin() * heading.sin(),
        );
        let place = [
            draw.between(0.2, 0.9) * k as f64,
            draw.between(-0.6, 0.6),
            draw.between(0.2, 0.8),
        ];
        let [x, y, z] = place;
        start.push(format!("x{k}: {x}, y{k}: {y}, z{k}: {z}"));
        for name in ["x", "y", "z"] {
            start.push(format!("dot({name}{k}): {:.4}", draw.between(-2.0, 2.0)));
        }
        places.push(place);
    }
    text.line(&format!("lagrangian{}", energy.trim_start_matches(" +")));
    // Joints have the lengths of the start.
    let apart = |other: [f64; 3]| {
        let pairs = places[0].iter().zip(other);
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
    };
    let held = if count == 2 && draw.chance(0.7) {
        let rod = "(x0 - x1)^2 + (y0 - y1)^2 + (z0 - z1)^2";
        text.line(&format!("joint rod: {rod} == {} [m^2]", apart(places[1])));
        true
    } else if draw.chance(0.4) {
        let rope = "x0^2 + y0^2 + (z0 - 1.4 [m])^2";
        let square = apart([0.0, 0.0, 1.4]);
        text.line(&format!("joint rope: {rope} == {square} [m^2]"));
        true
    } else {
        false
    };
    obstacles(draw, (count, held), &mut text);
    text.line(&format!("start {{ {} }}", start.join(", ")));
    text.line("horizon 1.2 [s]");
    text.0
}

/// The floor and the wall of balls in space. Those that joints hold have fewer ways to slide than a rough floor holds, which is no motion
/// that is known: theirs is smooth.
fn obstacles(draw: &mut Draw, (count, held): (usize, bool), text: &mut Text) {
    let law = law(draw);
    let friction = match draw.below(3) {
        _ if held => None,
        0 => None,
        1 => Some(format!("{:.4}", draw.between(0.1, 0.8))),
        _ => {
            let rest = draw.between(0.2, 0.8);
            let sliding = rest * draw.between(0.5, 0.95);
            Some(format!("static {rest:.4}, kinetic {sliding:.4}"))
        }
    };
    let wall = draw.between(1.0, 1.5);
    for k in 0..count {
        text.line(&format!("surface floor{k}: z{k} >= 0"));
        let rubs = friction.as_ref().map_or(String::new(), |mu| {
            format!(", friction {mu}, sliding (dot(x{k}), dot(y{k}))")
        });
        text.line(&format!("impact floor{k}: {law}{rubs}"));
        text.line(&format!("surface wall{k}: x{k} <= {wall:.4} [m]"));
        text.line(&format!("impact wall{k}: restitution 0.5"));
    }
}
