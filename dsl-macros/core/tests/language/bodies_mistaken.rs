//! Mistakes of bodies, shapes, contacts and joints: each is told where it stands, with what to write instead.

use crate::repetition::{assert_told, described};
use hangtime_dsl::{describe_text, in_used};

/// A scene with slips in the place of `SLIP`.
pub(crate) const SCENE: &str = "parameters { m: kg = 1, j: kg*m^2 = 0.01, r: m = 0.1 }
    coordinates { x: m, z: m, phi: rad, y: m }
    body block: mass m, inertia j at (x, z) angle phi, tip = (r, 0)
    body ground: fixed
    body wall: fixed at (1 [m], 0) angle 90 [deg]
    body ball: mass m at (y, 0)
    shape block.lid: rectangle (r, r) at (0, r)
    shape ground: half plane
    SLIP
    start { z: 1 [m] }";

/// Slips, and what is told of them.
const BODIES: &[(&str, &str)] = &[
    (
        "body <<block>>: mass m at (x, y)",
        "E19: `block` is declared twice; rename this body",
    ),
    (
        "body <<rod>>: inertia j at (x, y) angle phi",
        "E27: body `rod` has no mass; write `mass m`, or `fixed` if it has no motion of its own",
    ),
    (
        "body <<rod>>: mass m, inertia j at (x, y)",
        "E27: body `rod` has an inertia, and no angle by which it turns; add `angle phi`",
    ),
    (
        "body <<rod>>: mass m",
        "E27: body `rod` is nowhere; say where, as in `at (x, z)` with two coordinates",
    ),
    (
        "body <<rod>>: mass m, fixed at (0, 0)",
        "E27: body `rod` is fixed, so that its mass does nothing; leave `fixed` out, or the mass",
    ),
    (
        "body rod: <<mas m>> at (x, y)",
        "E27: `mas` says nothing of body `rod`; did you mean `mass`?",
    ),
    (
        "body rod: mass m at (x, y), <<colour 3>>",
        "E27: `colour` says nothing of body `rod`; it knows `mass`, `inertia`, `centre`, `at`, `angle`, `turn`, `fixed`",
    ),
    (
        "body rod: mass m, <<mass m>> at (x, y)",
        "`mass` stands twice; keep one",
    ),
    (
        "body rod: <<mass>>, at (x, y)",
        "`mass` needs its value behind it",
    ),
    (
        "body rod: mass <<r>> at (x, y)",
        "E03: units differ: `r` is in m, where kg is needed (`rod.mass` is declared so)",
    ),
    (
        "body rod: mass m at <<(phi, 0)>>",
        "E03: units differ: `(phi, 0)` has no unit, where m is needed (`rod` is declared so)",
    ),
    (
        "body rod: mass m at (x, y), <<tip>> = (r, 0)",
        "E27: body `rod` has no angle, and a place on it needs it; write `angle phi` where the body is declared, or `angle 0` if it \
             never turns",
    ),
    (
        "body rod: mass m at (x, y) angle phi, <<angle>> = (r, 0)",
        "E19: `rod.angle` is something else of this body; choose another name for the point",
    ),
    (
        "body rod: mass m <<at (x, y, z)>>",
        "E27: body `rod` has 3 components, and the bodies of this scene are in the plane; write two, as in `(0, -g)`",
    ),
    (
        "gravity (0, -9.81 [m/s^2]) body <<rod>>: mass m at (x, y) turn rotation_z(phi)",
        "E27: body `rod` is in the plane, where it turns by an angle; write `angle phi`, or a `gravity` with three components",
    ),
    (
        "body rod: mass m, <<inertia (j, j)>> at (x, y) angle phi",
        "E27: body `rod` has one moment of inertia in the plane",
    ),
    (
        "<<body rod>>",
        "a colon and what is said of `rod` are missing; write `body block: mass m, inertia j, at (x, z), angle phi`",
    ),
    (
        "<<body>>: mass m",
        "`body` is written as in `body block: mass m, inertia j, at (x, z), angle phi`",
    ),
    (
        "gravity (0, -9.81 [m/s^2]) <<gravity>> (0, 1 [m/s^2])",
        "E19: `gravity` is declared twice; it is that of all bodies",
    ),
    (
        "part leg(a) { <<gravity>> (0, -a) } left: leg(1 [m/s^2])",
        "E27: `gravity` is that of all bodies; declare it in the scene, outside of parts",
    ),
    (
        "outputs { height: m = block.<<tap>>.z }",
        "E27: part `block` has no `tap`; did you mean `block.tip`?",
    ),
];

#[test]
fn slips_of_bodies_are_told_where_they_stand() {
    for &(slip, wanted) in BODIES {
        assert_told(&SCENE.replace("SLIP", slip), wanted);
    }
}

/// Slips, and what is told of them.
const SHAPES: &[(&str, &str)] = &[
    (
        "shape <<ghost>>: circle r",
        "E27: there is no body `ghost` above; declare it before, as in `body ghost: mass m, at (x, z)` or `body ghost: fixed`",
    ),
    (
        "shape <<bloc>>: circle r",
        "E27: there is no body `bloc` above; did you mean `block`?",
    ),
    (
        "shape ball: <<rectangle (r, r)>>",
        "E27: body `ball` has no angle, and a shape `rectangle` needs it; write `angle phi` where the body is declared, or `angle 0` \
             if it never turns",
    ),
    (
        "shape <<ground>>: circle r",
        "E19: `ground` is declared twice; give this shape a name of its own, as in `shape ground.lid: ..`",
    ),
    (
        "shape <<block.tip>>: circle r",
        "E19: `block.tip` is declared twice; give this shape a name of its own, as in `shape block.lid: ..`",
    ),
    (
        "shape block: <<circel r>>",
        "E27: `circel` says nothing of the shape of `block`; did you mean `circle`?",
    ),
    (
        "shape block: circle r, <<tip = (r, 0)>>",
        "E27: `tip` says nothing of the shape of `block`; it knows `circle`, `rectangle`, `polygon`, `half`, `below`, `capsule`, `segment`, \
             `point`, `sphere`, `box`, `at`, `angle`",
    ),
    (
        "shape block: <<xyz r>>",
        "E27: `xyz` says nothing of the shape of `block`; it knows `circle`, `rectangle`, `polygon`, `half`, `below`, `capsule`, `segment`, \
             `point`, `sphere`, `box`, `at`, `angle`",
    ),
    (
        "shape block: <<rectangle r>>",
        "E27: `rectangle` has two lengths, as in `rectangle (w, h)`",
    ),
    (
        "shape block: circle <<-r>>",
        "E10: the size of a shape is positive",
    ),
    (
        "parameters { bad: m = -0.1 } shape block: circle <<bad>>",
        "E10: the size of a shape is positive",
    ),
    (
        "shape block: circle <<0 [m]>>",
        "E10: the size of a shape is positive",
    ),
    (
        "shape block: circle <<m>>",
        "E03: units differ: `m` is in kg, where m is needed (`block.radius` is declared so)",
    ),
    (
        "shape block: <<polygon ((0, 0), (r, 0))>>",
        "E27: a polygon has three corners at least, each with two lengths, as in `polygon ((0, 0), (l, 0), (0, l))`",
    ),
    (
        "shape block: polygon ((0, 0), (2*r, 0), <<(r/4, 3 [cm])>>, (0, 2*r))",
        "E27: the outline does not turn the same way round at corner 3 of the polygon, which has to be convex; make it of several, \
             as in `shape block.lid: polygon ..`",
    ),
    (
        "shape block: polygon ((0, 3*r), (-2*r, -3*r), (3*r, r), <<(-3*r, r)>>, (2*r, -3*r))",
        "E27: the outline goes round more than once up to corner 4 of the polygon, which has to be convex; make it of several, as in \
             `shape block.lid: polygon ..`",
    ),
    (
        "shape block: <<polygon ((0, 0), (y, 0), (0, r))>>",
        "E27: the corners of a polygon are computed from numbers and parameters, so that it is known to be convex",
    ),
    (
        "shape ball: <<polygon ((0, 0), (r, 0), (0, r))>>",
        "E27: body `ball` has no angle, and a shape `polygon` needs it; write `angle phi` where the body is declared, or `angle 0` if \
             it never turns",
    ),
    (
        "shape block: <<sphere r>>",
        "E27: the shape of `block` is one of `circle r`, `rectangle (w, h)`, `polygon ((0, 0), (l, 0), (0, l))`, `half plane`, \
             `below h`, `capsule (l, r)`, `segment l`, `point`",
    ),
    (
        "shape ball: <<point r>>",
        "nothing stands behind `point` but a comma or the next word",
    ),
    (
        "<<shape>> block",
        "a shape is written as in `shape block: rectangle (w, h)`, behind the name of its body",
    ),
];

#[test]
fn slips_of_shapes_are_told_where_they_stand() {
    for &(slip, wanted) in SHAPES {
        assert_told(&SCENE.replace("SLIP", slip), wanted);
    }
}

/// Slips, and what is told of them.
const CONTACTS: &[(&str, &str)] = &[
    (
        "<<contact>> block: inelastic",
        "a contact is that of two shapes with a law, as in `contact block, ground: inelastic, friction mu`",
    ),
    (
        "contact <<ball>>, ground: inelastic",
        "E27: body `ball` has no shape above that could touch anything; declare one before, as in `shape ball: circle r`",
    ),
    (
        "shape ball: <<circel r>> contact ball, ground: inelastic",
        "E27: `circel` says nothing of the shape of `ball`; did you mean `circle`?",
    ),
    (
        "contact block, <<floor>>: inelastic",
        "E27: there is no body `floor` above; declare it before, as in `body floor: mass m, at (x, z)` or `body floor: fixed`",
    ),
    (
        "shape block.hat: circle r contact <<block.hat, block.lid>>: inelastic",
        "E27: `block.hat` and `block.lid` never move against each other, on one body or on fixed ones; leave the contact out",
    ),
    (
        "shape wall: half plane contact <<wall, ground>>: inelastic",
        "E27: `wall` and `ground` never move against each other, on one body or on fixed ones; leave the contact out",
    ),
    (
        "shape ball: circle r contact <<ball, ground>>: inelastic, friction 0.3",
        "E27: body `ball` has no angle, and friction, which turns it, needs it; write `angle phi` where the body is declared, or \
             `angle 0` if it never turns",
    ),
    (
        "contact block, ground: inelastic, friction 0.3, <<sliding>> dot(x)",
        "E27: the sliding velocity of a contact is derived from its bodies; leave `sliding` out",
    ),
    (
        "shape wall: segment r contact <<block, wall>>: inelastic",
        "E27: there is no contact between a rectangle and a segment; give one of them a radius, as a circle or a capsule has",
    ),
    (
        "fn hill(s) = s^2/r shape wall: below hill shape ball: circle r contact <<ball, wall>>: inelastic",
        "E27: there is no contact between a circle and a curve in points that a formula tells; what has corners alone touches a \
             curve, as a polygon and a `point` do",
    ),
    (
        "contact block, ground: inelastic contact <<block, ground>>: inelastic",
        "E19: `block.lid.ground` is declared twice; keep one contact between two shapes",
    ),
    (
        "contact block, ground: <<elastic>>",
        "there is no law `elastic`; a rebound is `restitution 1`, no rebound is `inelastic`",
    ),
];

#[test]
fn slips_of_contacts_are_told_where_they_stand() {
    for &(slip, wanted) in CONTACTS {
        assert_told(&SCENE.replace("SLIP", slip), wanted);
    }
}

/// Slips, and what is told of them.
const JOINTS_OF_BODIES: &[(&str, &str)] = &[
    (
        "hinge pin: <<(0, 0) == (x, z)>>",
        "E27: neither side of `pin` is a body or a point of one; what holds between other places is a `joint pin: left == right`",
    ),
    (
        "hinge pin: <<block.tip>>",
        "`hinge` joins two sides by `==`, as in `hinge elbow: upper.tip == lower.base`",
    ),
    (
        "<<hinge block>>.tip == ball",
        "a colon and what is said of `block` are missing; write `hinge elbow: upper.tip == lower.base`",
    ),
    (
        "slider <<rail>>: block on ground",
        "E27: slider `rail` has no direction; add it as its second body has it, as in `slider rail: block on frame along (1, 0)`",
    ),
    (
        "hinge pin: block.tip == ball <<angle 1>>",
        "E27: `angle` says nothing of joint `pin`; leave it out",
    ),
    (
        "weld <<pin>>: block.tip == ball",
        "E27: body `ball` has no angle, and joint `pin` needs it; write `angle phi` where the body is declared, or `angle 0` if it \
             never turns",
    ),
    (
        "hinge <<block>>: block.tip == ball",
        "E19: `block` is declared twice; rename this joint",
    ),
    (
        "rolling <<grip>>: block on ground",
        "E27: a rectangle does not roll on a half plane in one point; a circle rolls on a half plane or on a circle",
    ),
    (
        "<<ball>> pin: block.tip == ground",
        "E27: in the plane a point is held on a point by `hinge`",
    ),
    (
        "hinge pin: block.tip == ground, <<stop 1>>",
        "`stop` has both ends of a range, as in `stop -1..=1`",
    ),
    (
        "hinge pin: block.tip == ground, stop <<2..=1>>",
        "E10: the range of a stop begins below where it ends, as in `stop -1..=1`",
    ),
    (
        "hinge pin: block.tip == ground, <<restitution 0.5>>",
        "E27: joint `pin` strikes nothing; add `stop -1..=1`, or leave `restitution` out",
    ),
    (
        "hinge pin: block.tip == ground, stop -1..=1, restitution <<2>>",
        "E10: coefficient of restitution 2 is outside [0, 1]: 0 keeps no normal velocity, 1 all of it",
    ),
    (
        "hinge pin: block.tip == ball, <<motor 1 [N m]>>",
        "E27: body `ball` has no angle, and `motor` needs it; write `angle phi` where the body is declared, or `angle 0` if it never \
             turns",
    ),
    (
        "weld pin: block.tip == ground, <<motor 1 [N m]>>",
        "E27: `motor` says nothing of joint `pin`; leave it out",
    ),
    (
        "hinge pin: block.tip == ground, motor <<1 [N]>>",
        "E03: units differ: `1 [N]` is in N, where N m is needed (a force on `pin.angle` is the Lagrangian's unit over that of the name)",
    ),
    (
        "forces { block.tip: <<1 [N]>> }",
        "E02: the force on `block.tip` has 2 components, as that has",
    ),
    (
        "let speed = dot(block.tip) forces { <<speed>>: (1 [N], 1 [N]) }",
        "E07: a force acts on a position, and `speed` depends on the velocity `dot(x)`",
    ),
    (
        "forces { <<r>>: 1 [N] }",
        "E01: `r` is not a coordinate (coordinates: `x`, `z`, `phi`, `y`)",
    ),
    (
        "hinge pin: block.<<tup>> == ball",
        "E27: part `block` has no `tup`; did you mean `block.tip`?",
    ),
];

#[test]
fn slips_of_joints_of_bodies_are_told_where_they_stand() {
    for &(slip, wanted) in JOINTS_OF_BODIES {
        assert_told(&SCENE.replace("SLIP", slip), wanted);
    }
}

/// Slips, and what is told of them.
const BODIES_IN_SPACE: &[(&str, &str)] = &[
    (
        "body <<rod>>: mass m, inertia j at (x, y, u) angle phi",
        "E27: body `rod` is in space, where an angle does not say how it is turned; write `turn (q0, q1, q2, q3)`, or `turn \
             rotation_z(phi)`",
    ),
    (
        "body <<rod>>: mass m, inertia j at (x, y, u)",
        "E27: body `rod` has an inertia, and nothing by which it turns; add `turn (q0, q1, q2, q3)`, or `turn rotation_z(phi)`",
    ),
    (
        "body <<rod>>: mass m",
        "E27: body `rod` is nowhere; say where, as in `at (x, y, z)` with three coordinates",
    ),
    (
        "body rod: mass m <<at (x, y)>>",
        "E27: body `rod` has 2 components, and the bodies of this scene are in space; write three, as in `(0, 0, -g)`",
    ),
    (
        "body rod: mass m at (x, y, u) <<turn (q0, q1, q2)>>",
        "E27: body `rod` has a quaternion of four components or a matrix that turns it, as in `turn (q0, q1, q2, q3)` or `turn \
             rotation_z(phi)`",
    ),
    (
        "body rod: mass m, <<inertia (j, j)>> at (x, y, u) turn rotation_z(phi)",
        "E27: body `rod` has one moment of inertia for all axes or three, as in `inertia (jx, jy, jz)`",
    ),
    (
        "body rod: mass m at (x, y, u), <<tip>> = (0, 0, r)",
        "E27: body `rod` has no turn, and a place on it needs it; write `turn (q0, q1, q2, q3)` where the body is declared, or `turn \
             diagonal(1, 1, 1)` if it never turns",
    ),
    (
        "shape ball: <<circle r>>",
        "E27: the shape of `ball` is in space one of `sphere r`, `box (a, b, c)`, `half space`, `capsule (l, r)`, `point`",
    ),
    (
        "shape die.lid: <<box (r, r)>>",
        "E27: `box` has three lengths, as in `box (a, b, c)`",
    ),
    (
        "shape die.lid: <<half plane>>",
        "a half space is written as in `shape table: half space`; `at` stands behind that",
    ),
    (
        "shape table.lid: box (r, r, r) contact <<die, table.lid>>: inelastic",
        "E27: there is no contact between a box and a box in space; a half space touches all shapes, a sphere and a point all but a \
             point",
    ),
    (
        "shape ball: sphere r contact <<ball, table>>: inelastic, friction 0.3",
        "E27: body `ball` has no turn, and friction, which turns it, needs it; write `turn (q0, q1, q2, q3)` where the body is \
             declared, or `turn diagonal(1, 1, 1)` if it never turns",
    ),
    (
        "body stone: mass m, inertia j, at (u, 0, r), turn rotation_z(phi) shape stone: sphere r
             contact <<stone, die>>: inelastic, friction 0.3",
        "E27: there is no contact between a sphere and a box with friction in space; leave `friction` out, or let a half space or a \
             sphere touch",
    ),
    (
        "<<hinge>> pin: die == ball",
        "E27: this is a joint of the plane; in space `ball` holds a point on a point, and a `joint` what else is equal",
    ),
    (
        "ball pin: die == ball, <<motor 1 [N]>>",
        "E27: `motor` says nothing of joint `pin`; leave it out",
    ),
];

#[test]
fn slips_of_bodies_in_space_are_told_where_they_stand() {
    let scene = "parameters { m: kg = 1, j: kg*m^2 = 0.01, r: m = 0.1, g: m/s^2 = 9.81 }
        coordinates { x: m, y: m, z: m, q0, q1, q2, q3, u: m, phi: rad }
        gravity (0, 0, -g)
        body die: mass m, inertia (j, j, 2*j), at (x, y, z), turn (q0, q1, q2, q3)
        body ball: mass m at (u, 0, 2*r)
        body table: fixed
        shape die: box (r, r, r)
        shape table: half space
        lagrangian += j*dot(phi)^2
        SLIP
        start { z: 1 [m], q0: 1 }";
    described(&scene.replace("SLIP", "contact die, table: inelastic, friction 0.3"));
    for &(slip, wanted) in BODIES_IN_SPACE {
        assert_told(&scene.replace("SLIP", slip), wanted);
    }
    assert_told(
        "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { x: m, y: m, z: m } gravity (0, -g)
         body ball: mass m <<at (x, y, z)>> start { z: 1 }",
        "E27: body `ball` has 3 components, and the bodies of this scene are in the plane; write two, as in `(0, -g)`",
    );
}

#[test]
fn slips_in_a_file_that_is_used_are_told_there() {
    let scene = "use \"wheel.hang\"
         parameters { m: kg = 1, g: m/s^2 = 9.81 }
         coordinates { x: m, z: m }
         gravity (0, -g)
         body ground: fixed
         shape ground: half plane
         rear: wheel((x, z), 0.1 [m])
         start { z: 0.1 [m] }";
    let wheel = "part wheel(middle, r: m) {
            coordinates { phi: rad }
            body rim: mass m, inertia m*r^2 at middle angle phi, valve = (r, 0)
            shape rim: circle r
            contact rim, ground: inelastic, friction 0.5
         }";
    let whole = |wheel: &str| hangtime_dsl::with_used(scene, |_| Ok(wheel.to_owned()));
    described(&whole(wheel).expect("files"));
    for (right, slip, wanted) in [
        (
            "angle phi,",
            "angle phi, <<radius r>>,",
            "E27: `radius` says nothing of body `rim`; it knows `mass`, `inertia`, `centre`, `at`, `angle`, `turn`, `fixed`",
        ),
        (
            "circle r",
            "circle <<-r>>",
            "E10: the size of a shape is positive",
        ),
        (
            "circle r",
            "circle <<phi>>",
            "E03: units differ: `rear.phi` has no unit, where m is needed (`rear.rim.radius` is declared so)",
        ),
        (
            "rim, ground",
            "rim, <<floor>>",
            "E27: there is no body `floor` above; declare it before, as in `body floor: mass m, at (x, z)` or `body floor: fixed`",
        ),
        (
            "shape rim",
            "shape <<rin>>",
            "E27: there is no body `rin` above; did you mean `rear.rim`?",
        ),
        (
            "circle r",
            "polygon ((0, 0), (r, 0), <<(r/4, r/4)>>, (0, r))",
            "E27: the outline does not turn the same way round at corner 3 of the polygon, which has to be convex; make it of several, \
             as in `shape rear.rim.lid: polygon ..`",
        ),
        (
            "rim, ground: inelastic, friction 0.5",
            "rim, ground: inelastic hinge hub: rim == ground, stop <<1..=1>>",
            "E10: the range of a stop begins below where it ends, as in `stop -1..=1`",
        ),
        (
            "friction 0.5",
            "friction <<z>>",
            "E03: units differ: `z` is in m, where a pure number is needed (a coefficient of friction is a ratio)",
        ),
    ] {
        let slipped = wheel.replace(right, slip);
        let text = whole(&slipped.replace("<<", "").replace(">>", "")).expect("files");
        let mistakes = describe_text(&text, "s").expect_err(slip);
        assert_eq!(mistakes[0].text(), wanted);
        let (file, own, place) = in_used(&text, &mistakes[0].place);
        assert_eq!(file, Some("wheel.hang"));
        let (_, rest) = slip.split_once("<<").expect("a mark");
        assert_eq!(
            own.get(place),
            rest.split_once(">>").map(|(inside, _)| inside)
        );
    }
}
