//! What is recorded and drawn: declarations that are accepted, and the text of every message.

/// Messages about a ball above a rough floor, with further statements behind it.
fn ball(statements: &str) -> Vec<String> {
    let source = format!(
        "pub S {{ parameters {{ m: kg = 1, g: m/s^2 = 9.81, r: m = 0.1 }} coordinates {{ y: m, z: m, a: rad }} \
         controls {{ u: N }} let p = (y, z) \
         lagrangian m/2*|dot(p)|^2 + m*r^2/4*dot(a)^2 - m*g*z forces {{ y: u }} \
         surface floor: z >= r impact floor: inelastic, friction 0.3, sliding dot(y + r*a) \
         surface wall: y <= 3[m] impact wall: restitution 0.5 start {{ z: 1 }} {statements} }}"
    );
    crate::mistakes_in(&source)
}

texts! {
    everything_is_accepted: ball
        "outputs { /// How fast it is.
             speed: km/h = |dot(p)|, power: W = u*dot(y), height = z - r, limit: N = 3, \
             push: N = force(floor), rub = friction_force(floor)/m, both: N = push + force(wall), \
             hit: N s = impulse(wall), scraped: kg m/s = friction_impulse(floor) + hit } \
         minimize integral(power) + 1 [W]*time constraint slow: power <= 90 [W] finally { height == 0 } \
         picture { circle ball at p radius r angle a, point p, rectangle box at (y, r + z) size (r, 2*r), \
             polygon roof at (0, 1[m]) angle a/2 corners ((0, 0), (r, 0), (0, r)), link ball to (0, 0), \
             spring p to roof, curve ground: (w, r*sin(w/r)) over w, curve arc: (r*cos(s), r) over s in 0..=2*pi }"
        => "accepted";

    // Outputs.
    output_without_an_expression: ball "outputs { speed: m/s, height: m = z }" =>
        "output `speed` needs an expression, as in `speed: m/s = ...`";
    output_with_bounds: ball "outputs { height: m in 0..=3 = z }" =>
        "output `height` has no bounds; limit it by `constraint limit: height <= ...`";
    output_in_another_unit: ball "outputs { height: m/s = z }" =>
        "E03: units differ: `z` is in m, where m/s is needed (output `height` is declared so)";
    force_in_another_unit: ball "outputs { push: J = force(floor) }" =>
        "E03: units differ: `force(floor)` is in N, where J is needed (output `push` is declared so)";
    impulse_in_the_unit_of_a_force: ball "outputs { hit: N = impulse(wall) }" =>
        "E03: units differ: `impulse(wall)` is in N s, where N is needed (output `hit` is declared so)";
    impulse_of_nothing: ball "outputs { hit: N s = impulse(flor), all: N s = impulse() }" =>
        "E01: there is no surface `flor` above; did you mean `floor`?",
        "E02: `impulse` takes the name of a surface, as in `impulse(ground)`";
    friction_impulse_of_a_contact_without: ball "outputs { rub: N s = friction_impulse(wall) }" =>
        "E24: contact `wall` has no friction; declare it by `impact wall: ..., friction mu`, or leave \
         `friction_impulse(wall)` out";
    impulse_at_the_end: ball "finally { impulse(floor) <= 3 [N s] }" =>
        "E24: `impulse(floor)` is that of one impact, and there may be several; write `sum(impulse(floor))`, which adds \
         up over all of them, or limit each by `constraint limit: impulse(floor) <= ...`";
    impulse_as_a_final_cost: ball "minimize impulse(floor)^2" =>
        "E24: `impulse(floor)` is that of one impact, and there may be several; write `sum(impulse(floor))`, which adds \
         up over all of them, or limit each by `constraint limit: impulse(floor) <= ...`";
    integral_of_an_impulse: ball "minimize integral(impulse(floor)^2)" =>
        "E24: `impulse(floor)` acts at the instant of an impact, so that it has no integral; write \
         `sum(impulse(floor)^2)` in `minimize`, which adds up over all impacts";
    output_of_an_impulse_in_a_constraint: ball
        "outputs { hit: N s = impulse(floor) } constraint soft: hit <= 3 [N s]" =>
        "E24: `hit` contains the sum of impulses until each instant, which is recorded only; a condition on each impact \
         is written with `impulse(...)` itself";
    output_of_an_impulse_in_an_objective: ball
        "outputs { hit: N s = impulse(floor) } minimize integral(hit) + sum(hit)" =>
        "E24: `hit` contains the sum of impulses until each instant, which is recorded only; write `sum(...)` with \
         `impulse(...)` itself, which adds up over all impacts";
    forces_and_impulses_in_optimal_control: ball
        "outputs { push: N = force(floor) - force(wall) } \
         minimize integral(push^2 + friction_force(floor)*dot(y)*1 [N s/m]) + 2*sum(impulse(wall)^2)/1 [s] + \
            force(floor)*1 [N s] \
         constraint strong: push <= 100 [N] constraint soft: impulse(wall) + impulse(floor) <= 3 [N s] \
         finally { push >= 1 [N], sum(z*friction_impulse(floor)) <= 1 [J s] }"
        => "accepted";
    sum_of_a_force: ball "minimize sum(force(floor)^2)" =>
        "E24: `force(floor)` acts over a time, and `sum` adds up over impacts; write `integral(force(floor)^2)` in \
         `minimize`, or an impulse";
    sum_of_an_output_of_a_force: ball "outputs { push: N = force(floor) } minimize sum(push)" =>
        "E24: `push` contains the force of a contact, which acts over a time, and `sum` adds up over impacts; write \
         `integral(...)` in `minimize`";
    sum_without_an_impulse: ball "minimize sum(z^2)" =>
        "E24: `z^2` contains no impulse, and `sum` adds up over impacts; use `impulse(...)` of a surface in it";
    sum_of_what_jumps: ball "minimize sum(impulse(floor)*dot(y)) + sum(u*impulse(floor))" =>
        "E24: `impulse(floor)*dot(y)` stands where impulses act, at impacts, and contains a velocity, which jumps there; \
         use coordinates, the time and impulses",
        "E24: `u*impulse(floor)` stands where impulses act, at impacts, and contains a control, which has no part in it; \
         use coordinates, the time and impulses";
    sum_of_several: ball "minimize sum(impulse(floor), impulse(wall))" =>
        "E02: `sum` takes 1 argument, found 2";
    sum_in_other_places: ball "constraint soft: sum(impulse(floor)) <= 3 [N s] minimize integral(sum(impulse(floor)^2))" =>
        "E24: `sum` adds a function of impulses up over all impacts; it stands in `minimize` and `finally` only, and not \
         within `integral` or another `sum`";
    sum_in_another_unit: ball "finally { sum(impulse(floor)^2) <= 3 [N s] }" =>
        "E03: units differ: `sum(impulse(floor)^2)` is in kg^2 m^2/s^2, `3 [N s]` is in N s; both sides of a terminal \
         condition must agree";
    impulse_beside_what_jumps: ball "constraint soft: impulse(floor) <= m*dot(y)" =>
        "E24: `m*dot(y)` stands where impulses act, at impacts, and contains a velocity, which jumps there; use \
         coordinates, the time and impulses";
    impulse_beside_a_force: ball "constraint soft: impulse(floor) + force(wall)*1 [s] <= 3 [N s]" =>
        "E24: `impulse(floor) + force(wall)*1 [s]` stands where impulses act, at impacts, and contains a force, which has \
         no part in it; use coordinates, the time and impulses";
    root_of_a_force: ball "minimize integral(sqrt(force(floor)))" =>
        "E13: `sqrt(force(floor))` has a root, a logarithm or the reciprocal of the force or impulse of a contact, which \
         is 0 while the contact is open; use powers of it, as in `force(ground)^2`";
    reciprocal_of_an_impulse: ball "minimize sum(1/impulse(wall))" =>
        "E13: `sum(1/impulse(wall))` has a root, a logarithm or the reciprocal of the force or impulse of a contact, which is 0 \
         while the contact is open; use powers of it, as in `force(ground)^2`";
    friction_of_a_contact_without_in_an_objective: ball "minimize integral(friction_force(wall)^2)" =>
        "E24: contact `wall` has no friction; declare it by `impact wall: ..., friction mu`, or leave \
         `friction_force(wall)` out";
    rate_of_an_impulse: ball "outputs { push: N = dot(impulse(floor)) }" =>
        "`dot(impulse(floor))` needs the derivative of what a contact does, which may jump; take `dot` of positions only";
    edges_are_recorded_and_drawn: ball
        "fn roof(w) = max(-w, w/2, r) outputs { depth: m = max(r - z, 0 [m], y), far: m = |y| + abs(z) - min(y, z) } \
         picture { circle ball at (|y|, roof(y)) radius min(r, 1 [m]) angle |a|, curve top: (w, roof(w)) over w }"
        => "accepted";
    edges_of_other_units: ball "outputs { depth: m = max(r - z, 0) } picture { point ball at (max(y, 1 [s]), z) }" =>
        "E03: units differ: `y` is in m, `1 [s]` is in s; the arguments of `max` must agree";
    output_with_an_edge_in_an_objective: ball
        "outputs { depth: m = max(r - z, 0) } minimize integral(depth)" =>
        "E12: `depth` contains `max`, `min` or `|x|`, which have no derivative at the edge; it can be used in `outputs` and \
         `picture` only";
    output_with_an_edge_at_the_end: ball "outputs { depth: m = max(r - z, 0) } finally { depth == 0 [m] }" =>
        "E12: `depth` contains `max`, `min` or `|x|`, which have no derivative at the edge; it can be used in `outputs` and \
         `picture` only";
    output_with_an_edge_in_a_surface: ball "outputs { depth: m = max(r - z, 0) } surface roof: depth >= y" =>
        "E12: `depth` contains `max`, `min` or `|x|`, which have no derivative at the edge; it can be used in `outputs` and \
         `picture` only";
    rate_of_an_edge: ball "outputs { speed: m/s = dot(|y|) }" =>
        "E12: `|y|` contains `max`, `min` or `|x|`, which have no derivative at the edge; differentiate the pieces";
    jump_in_an_output: ball "outputs { way = sign(dot(y)), side = if y >= 0 [m] { 1 } else { -1 } }" => "accepted";
    rounding_in_an_output: ball "outputs { way = floor(y/r) }" =>
        "E12: `floor` has a kink or a jump, which smooth dynamics must not have; declare a `surface` where the motion \
         switches";
    output_twice: ball "outputs { z: m = y, height: m = z, height: m = z }" =>
        "E19: `z` is declared twice; rename this output",
        "E19: `height` is declared twice; rename this output";
    vector_as_an_output: ball "outputs { place: m = p }" =>
        "E02: `p` is a vector with 2 components, and an output is a number; record its components one by one, as in \
         `place_y = (p).y`";
    output_before_it_is_declared: ball "constraint low: height <= 3[m] outputs { height: m = z }" =>
        "E01: `height` is declared further down; move its declaration up";
    output_with_an_unknown_name: ball "outputs { height: m = zz, twice: m = 2*height }" =>
        "E01: `zz` is not declared; add it to `parameters` or `coordinates` (declared: `a`, `g`, `m`, `p`, `r`, `u`, `y`, \
         `z`)";
    force_of_nothing: ball "outputs { push: N = force(flor), a1: N = force(z + 1), a2: N = force(roof, wall) }" =>
        "E01: there is no surface `flor` above; did you mean `floor`?",
        "E02: `force` takes the name of a surface, as in `force(ground)`";
    force_of_a_surface_below: ball "outputs { push: N = force(ramp) } surface ramp: z >= y impact ramp: inelastic" =>
        "E01: there is no surface `ramp` above (declared: `floor`, `wall`)";
    friction_of_a_contact_without: ball "outputs { rub: N = friction_force(wall) }" =>
        "E24: contact `wall` has no friction; declare it by `impact wall: ..., friction mu`, or leave \
         `friction_force(wall)` out";
    force_in_the_dynamics: ball "dissipation force(floor)*dot(y)^2" =>
        "E24: `force` of a contact follows from the motion; it can be used in `outputs`, `minimize`, `constraint` and \
         `finally` only";
    output_of_a_force_in_the_dynamics: ball "outputs { push: N = force(floor) } forces { y: push }" =>
        "E24: `push` contains the force or the impulse of a contact, which follows from the motion; it can be used in \
         `outputs`, `minimize`, `constraint` and `finally` only";
    rate_of_a_force: ball "outputs { push: N/s = dot(force(floor)) }" =>
        "`dot(force(floor))` needs the derivative of what a contact does, which may jump; take `dot` of positions only";

    // Pictures.
    unknown_shape: ball "picture { points p, ellipse q }" =>
        "unknown shape `points`; did you mean `point`?",
        "unknown shape `ellipse`; a picture is made of `point`, `circle`, `rectangle`, `polygon`, `link`, `spring`, \
         `curve`";
    shapes_without_their_form: ball "picture { circle ball at p, rectangle box at p, polygon roof at p }" =>
        "circle `ball` needs a radius, as in `circle ball at (y, z) radius 0.1 [m]`",
        "rectangle `box` needs a size, as in `rectangle box at (y, z) size (0.2 [m], 0.1 [m])`",
        "polygon `roof` needs its corners, as in `polygon roof at (y, z) corners ((0, 0), (l, 0), (0, l))`";
    property_of_another_shape: ball "picture { point ball at p radius r, circle disc at p radius r radius r }" =>
        "a point has `at`, `angle`, no `radius`",
        "`radius` is given twice for `disc`; keep one";
    missing_comma: ball "picture { point p point ball at p }" =>
        "a comma is missing before `point`";
    bare_lengths: ball "picture { circle ball at (y, 1) radius 0.2 }" =>
        "E03: units differ: `1` has no unit, where m is needed (it is a place in the picture); a bare number has no \
         unit, write it in brackets, as in `1 [m]`",
        "E03: units differ: `0.2` has no unit, where m is needed (it is the size of `ball`); a bare number has no \
         unit, write it in brackets, as in `0.2 [m]`";
    angle_that_is_a_length: ball "picture { point ball at p angle z }" =>
        "E03: units differ: `the angle of a body` needs a pure number, `z` is in m";
    place_of_other_components: ball "picture { point ball at z, point other at (y, z, z), link p to 2*r }" =>
        "E02: `z` is no place in the picture; write a horizontal and a vertical component, as in `(y, z)`",
        "E02: `(y, z, z)` has 3 components, and a picture shows 2; write the two that are to be seen, as in `(p.x, p.z)`",
        "E02: `2*r` is no place in the picture; write a horizontal and a vertical component, as in `(y, z)`";
    body_without_a_place: ball "picture { point ball }" =>
        "E01: `ball` is not declared; add it to `parameters` or `coordinates` (declared: `a`, `g`, `m`, `p`, `r`, `u`, \
         `y`, `z`)";
    end_at_no_body: ball "picture { link ball to p }" =>
        "E01: there is no body `ball` above; draw it before, as in `point ball at (y, z)`, or write a place";
    drawn_twice: ball "picture { point ball at p, curve ball: (w, 0) over w }" =>
        "E19: `ball` is drawn twice; rename one";
    form_that_moves: ball "picture { circle ball at p radius z, curve ground: (w, z) over w }" =>
        "E24: the form of `ball` depends on the coordinate `z`; it may depend on parameters only, what moves is the place \
         and the angle of a body",
        "E24: the form of `ground` depends on the coordinate `z`; it may depend on parameters only, what moves is the \
         place and the angle of a body";
    force_in_a_picture: ball "picture { point ball at (y, z + r*force(floor)/(m*g)) }" =>
        "E24: `force` of a contact follows from the motion; it can be used in `outputs`, `minimize`, `constraint` and \
         `finally` only";
    curve_without_its_number: ball "picture { curve ground: (w, 0), curve other (w, 0) over w }" =>
        "expected `over` and the number that runs along the curve, as in `(w, h(w)) over w`, found `,`",
        "expected `:` after the curve's name, as in `curve track: (w, h(w)) over w`, found `(`";
    range_of_two_units: ball "picture { curve ground: (0, 0) over w in 1[s]..=2[m] }" =>
        "E03: units differ: `1 [s]` is in s, `2 [m]` is in m; both ends of `w` must agree";
    two_corners: ball "picture { polygon line at p corners ((0, 0), (r, r)) }" =>
        "a polygon has three corners or more, as in `((0, 0), (l, 0), (0, l))`";
    two_pictures: ball "picture { point p } picture { point p }" =>
        "a scene has one `picture`; put all shapes into it";
    line_without_an_end: ball "picture { link p }" =>
        "expected `to`, as in `link a to b`, found the end";
}

#[test]
fn mistakes_stand_where_they_were_made() {
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { y: m, z: m } \
        lagrangian m/2*|dot((y, z))|^2 - m*g*z surface floor: z >= 0 impact floor: inelastic \
        outputs { high, push: N = force(flor), place = (y, z) } \
        picture { circle ball at (y, z), point nose at z, link ball to nose, link nose to hook, elipse egg, \
            point eye at (y, z) radius m, curve track: (w, y) over w } \
        finally { impulse(floor) <= 3 [N s] }";
    let mistakes = hangtime_dsl::describe_text(text, "ball").unwrap_err();
    let found: Vec<_> = mistakes
        .iter()
        .map(|found| (found.code, &text[found.place.clone()]))
        .collect();
    let wanted = [
        (None, "high"),
        (Some("E01"), "flor"),
        (Some("E02"), "(y, z)"),
        (None, "ball"),
        (Some("E02"), "z"),
        (Some("E01"), "hook"),
        (None, "elipse"),
        (None, "radius"),
        (Some("E24"), "(w, y)"),
        (Some("E24"), "impulse(floor)"),
    ];
    assert_eq!(found, wanted);
}

#[test]
fn units_are_checked_at_each_number() {
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81, r: m = 1 } coordinates { y: m, z: m } \
        lagrangian m/2*|dot((y, z))|^2 - m*g*z surface floor: z >= 0 impact floor: inelastic \
        outputs { speed: m = dot(y), push: J = force(floor) } \
        picture { circle ball at (y, 2*g) radius 3, rectangle box at (y, z) size (r, m) angle r, \
            polygon roof at (y, z) corners ((0, 0), (r, 0), (0, r^2)), curve track: (w, w^2) over w, \
            curve arc: (r*cos(s), r) over s in 0 [m]..=1 [m], link (0, m) to ball }";
    let mistakes = hangtime_dsl::describe_text(text, "ball").unwrap_err();
    assert!(
        mistakes.iter().all(|mistake| mistake.code == Some("E03")),
        "{mistakes:?}"
    );
    let found: Vec<_> = mistakes
        .iter()
        .map(|found| &text[found.place.clone()])
        .collect();
    let wanted = [
        "dot(y)",
        "force(floor)",
        "2*g",
        "3",
        "m",
        "r",
        "r^2",
        "w^2",
        "s",
        "m",
    ];
    assert_eq!(found, wanted);
}
