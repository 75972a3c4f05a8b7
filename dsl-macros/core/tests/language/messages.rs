//! The text of every message, by calling the expander directly.

use super::mistakes_in as messages;

/// A point mass in a plane with further statements.
fn with(statements: &str) -> Vec<String> {
    messages(&format!(
        "pub S {{ parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ y: m, z: m }} {statements} }}"
    ))
}

/// Messages of the scene with a correct Lagrangian.
fn beside(statements: &str) -> Vec<String> {
    with(&format!(
        "lagrangian m/2*|dot((y, z))|^2 - m*g*z {statements}"
    ))
}

/// A cart with a control, and further statements.
fn cart(statements: &str) -> Vec<String> {
    messages(&format!(
        "pub S {{ parameters {{ m: kg = 1 }} coordinates {{ y: m in -1..=3 }} controls {{ u: N }} lagrangian \
         m/2*dot(y)^2 forces {{ y: u }} {statements} }}"
    ))
}

texts! {
    point_mass_is_accepted: beside "" => "accepted";
    explicit_time_is_accepted: messages "S { coordinates { y } lagrangian dot(y)^2/2 + t*y }" => "accepted";
    scene_without_units_takes_bare_numbers: messages
        "S { coordinates { y } lagrangian dot(y)^2/2 - 9.81*y surface s: y >= 3 impact s: inelastic start { y: 4 } }"
        => "accepted";

    surface_of_two_inequalities: beside "surface corner: z >= 0, y >= 0 impact corner: inelastic" =>
        "a surface is one inequality; declare one more for what follows, as in `surface corner_2: ...`, and name both in the law, as in `impact corner, corner_2: inelastic`";
    surface_before_a_comma: beside "surface floor: z >= 0, impact floor: inelastic" => "accepted";
    parameter_without_a_value_is_one_mistake: messages
        "S { parameters { m: kg = 1, e } coordinates { y: m in 0..=e*1 [m] } lagrangian m/2*dot(y)^2 surface s: y >= 0 impact s: restitution e start { y: 0.5 } }" =>
        "parameter `e` needs a default value, as in `e = 1`";
    parameter_of_one_further_down: messages
        "S { parameters { m: kg = 1, h: m = 2*k, k: m = 3 } coordinates { y: m } lagrangian m/2*dot(y)^2 + m*y*h*k/1 [m s^2] }" =>
        "the default of parameter `h` must be a number; abbreviations of other parameters belong to `let`";
    two_powers_with_a_base_in_parentheses: beside "dissipation 1 [N s/m]*|dot((y, z))|^2*(z/1 [m])^2^3" =>
        "two powers in a row are easily misread; put the inner one in parentheses, as in `(z/1 [m])^(2^3)`";

    // E01
    misspelt_names_are_all_reported: with "lagrangian m/2*dot(y)^2 + m/2*dott(z)^2 - mm*g*z" =>
        "E01: function `dott` is not declared; did you mean `dot`?",
        "E01: `mm` is not declared; add it to `parameters` or `coordinates` (declared: `g`, `m`, `y`, `z`)";
    name_used_before_its_declaration: with "lagrangian m/2*dot(y)^2 + m/2*dot(z)^2 - v let v = m*g*z" =>
        "E01: `v` is declared further down; move its declaration up";
    force_on_something_else: beside "controls { u: N } forces { x: u, m: u }" =>
        "E01: `x` is not declared (coordinates: `y`, `z`)",
        "E01: `m` is not a coordinate (coordinates: `y`, `z`)";
    misspelt_block_gives_one_message: messages "S { parametres { a = 3 } coordinates { y } lagrangian a*dot(y)^2 }" =>
        "unknown statement `parametres`; did you mean `parameters`?";
    objective_that_is_to_be_large: messages "S { parameters { m = 3 } coordinates { y } lagrangian m*dot(y)^2 maximize y }" =>
        "there is no statement `maximize`; what is to be large is minimized with its sign changed, as in `minimize -(...)`";

    conditions_of_other_languages: messages "S { parameters { m = 3 } coordinates { y } lagrangian m*dot(y)^2 subject { y == 1 } }" =>
        "there is no statement `subject`; conditions at the end stand in `finally { ... }`, others in `constraint`";

    // E02
    product_of_vectors: with "lagrangian m/2*dot((y, z))*dot((y, z))" =>
        "E02: `m/2*dot((y, z))*dot((y, z))` multiplies two vectors; write `dot(m/2*dot((y, z)), dot((y, z)))`";
    vector_for_number: with "lagrangian m/2*dot((y, z))" =>
        "E02: `m/2*dot((y, z))` is a vector with 2 components where a number is needed; take a component, `|...|^2` or `dot(a, b)`";
    missing_component: with "let p = (y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.x" =>
        "E02: `p` has 2 components, `y`, `z`; there is no `x`";
    wrong_number_of_arguments: with "fn f(a, b) = a*b lagrangian m/2*|dot((y, z))|^2 - m*g*f(z)" =>
        "E02: `f` takes 2 arguments, found 1";
    direction_of_wrong_length: beside "surface wall: y >= 0 impact wall: inelastic, along (1, 2, 3)" =>
        "E02: the impulse direction has 3 components; it needs one for each of the 2 coordinates, in their order";

    vector_before_matrix: with "let p = (y, z)*rotation(1) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E02: `*` between a vector with 2 components (`(y, z)`) and a 2 by 2 matrix (`rotation(1)`); the matrix stands on the left, as in `transpose(m)*v`";
    sum_of_matrices_of_different_sizes: with "let p = (rotation(1) + rotation_x(1))*(y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E02: `+` between a 2 by 2 matrix (`rotation(1)`) and a 3 by 3 matrix (`rotation_x(1)`); both must have the same size";
    rows_of_different_lengths: with "let p = ((1, 2), (3, 4, 5))*(y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E02: the rows of a matrix have the same length: `(1, 2)` has 2 components, `(3, 4, 5)` is a vector with 3 components";
    matrix_for_number: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*rotation(1)" =>
        "E02: `-` between a number (`m/2*|dot((y, z))|^2`) and a 2 by 2 matrix (`m*g*z*rotation(1)`); both must have the same size";
    component_of_matrix: with "let q = rotation(1) lagrangian m/2*|dot((y, z))|^2 - m*g*q.z" =>
        "E02: `q` is a matrix; its first row is `q[0]`, an entry `q[0][1]`";
    row_out_of_range: with "let q = rotation(1) lagrangian m/2*|dot((y, z))|^2 - m*g*z*q[2][0]" =>
        "E02: `q` has 2 rows, counted from 0; there is no [2]";
    norm_of_matrix: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*|rotation(1)|" =>
        "E02: `rotation(1)` is a matrix; only vectors have a length";
    square_of_matrix: with "let p = rotation(1)^2*(y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E02: a matrix has no power here; write the product, as in `rotation(1)*rotation(1)`";
    matrix_function_of_something_else: with "let p = transpose(y)*(y, z) let q = rotation(y, z)*(y, z) let r = diagonal(m)*(y, z) lagrangian m/2*|dot((y, z))|^2 - m*g*z" =>
        "E02: `transpose` takes one matrix; found a number",
        "E02: `rotation` takes one angle; found a number, a number",
        "E02: `diagonal` takes two or more numbers, the entries of the diagonal; found a number";
    division_by_a_matrix: with "let p = (y, z)/rotation(1) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E02: `/` between a vector with 2 components (`(y, z)`) and a 2 by 2 matrix (`rotation(1)`); only a number can divide";

    // E03
    rotation_by_a_length: with "let p = rotation(y)*(y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E03: units differ: `rotation` needs a pure number, `y` is in m";
    matrix_product_with_terms_of_different_units: with "let p = ((1, m), (0, 1))*(y, z) lagrangian m/2*|dot(p)|^2 - m*g*p.z" =>
        "E03: units differ: the terms of the product `((1, m), (0, 1))*(y, z)` are in m and kg m";
    inertia_in_wrong_unit: with "let w = (dot(y), dot(z)) lagrangian w . (diagonal(m, 2)*w)/2 - m*g*z" =>
        "E03: units differ: the terms of the inner product are in J and m^2/s^2";
    height_forgotten: with "lagrangian m/2*|dot((y, z))|^2 - m*g" =>
        "E03: units differ: `m/2*|dot((y, z))|^2` is in J, `m*g` is in N; both sides of `-` must agree";
    mass_forgotten: with "lagrangian m/2*|dot((y, z))|^2 - g*z" =>
        "E03: units differ: `m/2*|dot((y, z))|^2` is in J, `g*z` is in m^2/s^2; both sides of `-` must agree";
    square_forgotten: with "lagrangian m/2*dot(y)^2 + m/2*dot(z) - m*g*z" =>
        "E03: units differ: `m/2*dot(y)^2` is in J, `m/2*dot(z)` is in N s; both sides of `+` must agree";
    bare_number_beside_a_length: beside "surface wall: y >= 3 impact wall: inelastic" =>
        "E03: units differ: `y` is in m, `3` has no unit; both sides of surface `wall` must agree; a bare number has no unit, write it in brackets, as in `3 [m]`";
    swapped_units_of_start: beside "start { y: 3 [m/s], dot(z): 2 [m] }" =>
        "E03: units differ: `3 [m/s]` is in m/s, where m is needed (it is the start value of `y`)",
        "E03: units differ: `2 [m]` is in m, where m/s is needed (it is the start value of `dot(z)`)";
    sine_of_a_length: beside "surface wall: y >= 1 [m]*sin(z) impact wall: inelastic" =>
        "E03: units differ: `sin` needs a pure number, `z` is in m";
    force_in_wrong_unit: beside "controls { u: kg } forces { y: u }" =>
        "E03: units differ: `u` is in kg, where N is needed (a force on `y` is the Lagrangian's unit over that of the coordinate)";
    inferred_unit_contradicts_itself: messages
        "S { parameters { m: kg = 1, k = 2, c = 1 } coordinates { y: m } lagrangian m/2*dot(y)^2 - k/2*y^2 - c*k*y + c*y^2 }" =>
        "E03: units differ: `m/2*dot(y)^2 - k/2*y^2 - c*k*y` is in J, `c*y^2` is in m^3; both sides of `+` must agree";
    horizon_is_a_time: beside "horizon 3 [m]" =>
        "E03: units differ: `3 [m]` is in m, where s is needed (the horizon is a time)";

    // E04, E05, E06
    potential_only: with "lagrangian -m*g*z" =>
        "E04: the Lagrangian contains no velocity, so nothing moves; add the kinetic energy, e.g. `m/2*dot(y)^2`";
    no_lagrangian: messages "S { coordinates { y: m } }" =>
        "E04: scene `S` declares no Lagrangian; write `lagrangian` kinetic minus potential energy";
    no_coordinates: messages "S { lagrangian 1 }" =>
        "E04: scene `S` declares no coordinates; write `coordinates { y: m, z: m }`";
    coordinate_without_inertia: with "lagrangian m/2*dot(y)^2 - m*g*z" =>
        "E05: coordinate `z` carries no inertia: the Lagrangian is not quadratic in `dot(z)`; add its kinetic energy, or make it a parameter or a control";
    inertia_in_one_direction_only: with "lagrangian m/2*(dot(y) + dot(z))^2 - m*g*z" =>
        "E06: the mass matrix is not positive definite whatever the parameters: `z` carries no inertia of its own; add its kinetic energy or leave the coordinate out";

    // E07, E09
    surface_with_two_relations: beside "surface wall: 0 [m] <= y <= 2 [m] impact wall: inelastic" =>
        "a surface compares two sides; declare two surfaces, the second one with `y` on its left";
    start_value_of_another_one: messages
        "S { coordinates { y, z } lagrangian dot(y)^2/2 + dot(z)^2/2 start { y: 2, z: y^2 + 1 } }" =>
        "the start value of `z` depends on the coordinate `y`; make the start value of `y` a parameter, and use that in both";
    surface_without_coordinate: beside "surface wall: m >= 3 [kg] impact wall: inelastic" =>
        "E07: surface `wall` depends on no coordinate; use one of `y`, `z`";
    surface_with_velocity: beside "surface wall: dot(y) >= 0 impact wall: inelastic" =>
        "E07: surface `wall` depends on the velocity `dot(y)`; a surface bounds positions only";
    surface_with_control: beside "controls { u: m } surface wall: y >= u impact wall: inelastic" =>
        "E07: surface `wall` depends on the control `u`; a surface bounds positions only";
    surface_that_cancels: beside "surface wall: y - y >= 0 impact wall: inelastic" =>
        "E09: the coordinates cancel out of surface `wall`, so it has no normal; check both sides of the inequality";
    squared_gap: beside "surface wall: y^2 >= 0 impact wall: inelastic" =>
        "E09: the gradient of surface `wall` is zero where it is touched, as the gap is a square; write the distance itself";
    tangential_impulse: beside "surface wall: y >= 0 impact wall: inelastic, along (0, 1)" =>
        "E09: the impulse direction of `wall` is tangential to the surface, so it cannot stop the motion into it; give it a normal component";

    // E10, E11, E12, E13
    restitution_above_one: beside "surface wall: y >= 0 impact wall: restitution 1.5" =>
        "E10: coefficient of restitution 1.5 is outside [0, 1]: 0 keeps no normal velocity, 1 all of it";
    restitution_above_one_by_its_default: messages
        "S { parameters { m: kg = 1, e = 1.2 } coordinates { y: m } lagrangian m/2*dot(y)^2 surface wall: y >= 0 impact wall: restitution 1 - e/10, friction -e, sliding dot(y) }" =>
        "E10: coefficient of friction -e = -1.2 is below 0: the force would drive the sliding instead of braking it; change its sign";
    inertia_of_products_only: with "lagrangian m*dot(y)*dot(z) - m*g*z" =>
        "E06: the mass matrix is not positive definite whatever the parameters: `y` carries no inertia of its own; add its kinetic energy or leave the coordinate out";
    dissipation_linear_in_a_velocity: beside "dissipation 3 [N]*dot(y) + 2 [N s/m]*dot(z)^2" =>
        "E10: the dissipation is linear in `dot(y)`: its force is the same at any velocity, so it feeds in energy one way; a damper is quadratic or of higher degree, as in `c/2*dot(y)^2`, and friction of constant size is `dry friction`, as in `dry friction rail: bound f, sliding dot(y)`";
    dissipation_linear_after_simplification: beside "let w = 1 [m/s] dissipation 1 [N s/m]/2*((dot(z) - w)^2 - (dot(z) + w)^2)" =>
        "E10: the dissipation is linear in `dot(z)`: its force is the same at any velocity, so it feeds in energy one way; a damper is quadratic or of higher degree, as in `c/2*dot(z)^2`, and friction of constant size is `dry friction`, as in `dry friction rail: bound f, sliding dot(z)`";
    dissipation_of_any_other_kind: messages
        "S { parameters { m: kg = 1, c: N s/m = 1, d: N s^2/m^2 = 1, e: m/s = 0.1, w: m/s = 1 } coordinates { y: m, z: m } lagrangian m/2*|dot((y, z))|^2
         dissipation c/2*dot(y)^2 + c/2*(dot(y) - w*sin(t/1[s]))^2 + d/3*(dot(z)^2 + e^2)^(3/2) + c/2*(1 + y^2/1[m^2])*|dot((y, z))|^2 + c/2*(dot(y) - dot(z) - w)^2 }"
        => "accepted";
    restitution_that_changes: beside "surface wall: y >= 0 impact wall: restitution z/y" =>
        "the coefficient of restitution depends on the coordinate `y`; it may depend on parameters only";
    coefficients_with_units: beside "surface wall: y >= 0 impact wall: restitution 0.5 [m], friction m/80 [s]" =>
        "E03: units differ: `0.5 [m]` is in m, where a pure number is needed (a coefficient of restitution is a ratio)",
        "E03: units differ: `m/80 [s]` is in N s/m, where a pure number is needed (a coefficient of friction is a ratio)";
    sliding_velocity_without_time: beside "surface wall: y >= 0 impact wall: inelastic, friction 0.3, sliding dot(z)/1 [m]" =>
        "E03: units differ: `dot(z)/1 [m]` is in 1/s, where m/s is needed (the sliding velocity of `wall` has the unit of its gap over s)";
    sliding_velocity_that_is_none: beside "surface wall: y >= 0 surface top: z <= 1 [m] impact wall: inelastic, friction 0.3, sliding dot(z)*dot(y)/1 [m/s] impact top: inelastic, friction 0.3, sliding z/1 [s]" =>
        "E07: `dot(z)*dot(y)/1 [m/s]` is no sliding velocity: that is a sum of velocities times functions of positions, such as `dot(y)`, less the speed of a ground that moves",
        "E07: the sliding velocity `z/1 [s]` contains no velocity; write e.g. `dot(y)`";
    sliding_velocity_into_the_surface: beside "surface floor: z >= 0 impact floor: inelastic, friction 0.3, sliding dot(z) - 2 [m/s]" =>
        "E20: the sliding velocity of `floor` is the velocity into the surface, the rate of its gap, or a multiple of it; friction brakes the motion along the surface, so write the velocity of the touching point along it behind `sliding`";
    sliding_velocity_into_a_slope: beside "let a = m/2 [kg] surface slope: 2*(z*cos(a) + y*sin(a)) >= 0 impact slope: inelastic, friction 0.3, sliding dot(z)*cos(a) + dot(y)*sin(a)" =>
        "E20: the sliding velocity of `slope` is the velocity into the surface, the rate of its gap, or a multiple of it; friction brakes the motion along the surface, so write the velocity of the touching point along it behind `sliding`";
    sliding_velocity_on_a_guide_that_leads_into_the_surface: messages
        "S { parameters { m: kg = 1, a: rad = 0.5 } coordinates { s: m, y: m } lagrangian m/2*|dot((s, y))|^2 surface wall: s*cos(a) >= 0 impact wall: inelastic, friction 0.3, sliding dot(s)*sin(a) surface floor: y >= 0 impact floor: inelastic, friction 0.1, sliding dot(s) + dot(y) }"
        => "accepted";
    friction_beyond_a_point_mass: messages
        "S { parameters { m: kg = 1, mu = 0.3 } coordinates { y: m, z: m, s: m } lagrangian m/2*|dot((y, z, s))|^2 surface wall: y >= 0 impact wall: inelastic, friction mu }" =>
        "E20: `friction` of `wall` needs the sliding velocity, which follows by itself for one point mass in two Cartesian coordinates on a surface at rest only; add that of the touching point along the surface, scaled like the gap, as in `impact wall: ..., friction mu, sliding dot(y)`";
    friction_on_a_moving_surface: beside "surface wall: z >= 1 [m/s]*t impact wall: inelastic, friction 0.3" =>
        "E20: `friction` of `wall` needs the sliding velocity, which follows by itself for one point mass in two Cartesian coordinates on a surface at rest only; add that of the touching point along the surface, scaled like the gap, as in `impact wall: ..., friction 0.3, sliding dot(y)`";
    everything_held: beside "surface wall: y >= 0 impact wall: inelastic, holding y" =>
        "E09: all coordinates that the gap of `wall` depends on are held, so no impulse can stop the motion into it; hold fewer";
    sliding_held: beside "surface wall: y >= 0 impact wall: inelastic, holding z, friction 0.1, sliding dot(z)" =>
        "E09: all coordinates that the sliding velocity of `wall` depends on are held, so friction cannot brake it; hold fewer";
    holding_something_else: beside "surface wall: y >= 0 impact wall: inelastic, holding m, w" =>
        "E01: `m` is not a coordinate (coordinates: `y`, `z`)",
        "E01: `w` is not declared (coordinates: `y`, `z`)";
    reserved_names: messages "S { parameters { t: s = 3, clock = 1, type = 1, let = 2 } coordinates { y } lagrangian dot(y)^2 }" =>
        "E11: `let` is a word of the language; choose another name",
        "E11: `t` is reserved for the physical time; choose another name",
        "E11: `clock` is reserved for the clock of the time-freezing reformulation; choose another name",
        "E11: `type` is a word of Rust and cannot be a field; choose another name";
    one_field_of_two: messages "S { count n = 1 parameters { a[n] = 1, a_1 = 2 } coordinates { y } lagrangian a[1]*dot(y)^2 - a_1*y }" =>
        "E19: `a[1]` and `a_1` are both the field `a_1` in Rust; rename one";
    profile_without_order: beside "profile h(y: m): m { (0, 0), (2, 1), (1, 2) }" =>
        "the points of profile `h` must go from left to right: 1 follows 2";
    profile_of_too_few_points: beside "profile h(y: m): m { (0, 0), (2, 1) }" =>
        "profile `h` needs from 3 to 5000 points, and has 2";
    profile_of_something_else: beside "profile h(y: m): m { (0, 0), (1, m), (2, 2), 3 }" =>
        "`(1, m)` is no point; write two numbers without units, as in `(0.5, 0.1)`",
        "`3` is no point; write two numbers without units, as in `(0.5, 0.1)`";
    profile_without_an_argument: beside "profile h: m { (0, 0) }" =>
        "expected `(` and the argument, as in `profile track(s: m): m { (0, 0), (0.5, 0.1), (1, 0.3) }`, found `:`";
    profile_in_other_units: beside "profile h(y: m): N { (0, 0), (1, 2), (2, 0) } surface s: z >= h(y) surface w: y >= h(m) impact s, w: inelastic" =>
        "E03: units differ: `z` is in m, `h(y)` is in N; both sides of surface `s` must agree",
        "E03: units differ: the points of `h(y)` are in m, its argument is in kg";
    profile_is_a_function: beside "profile h(y: m): m { (0, -9), (1, -9), (2, -9.1) } surface s: z >= h(y) + diff(h)(y)*1 [m] impact s: inelastic" =>
        "accepted";
    profile_that_is_too_steep: beside "profile h(y: m): m { (0, -9), (1e-80, -9), (2, 1e300) } surface s: z >= h(y) impact s: inelastic" =>
        "E21: the points of profile `h` are too close or too far apart for the curve through them; choose units in which their numbers are closer to 1, and leave out points that nearly coincide";
    walls_on_both_sides: beside "surface wall: abs(y) <= 2 [m] impact wall: inelastic" => "accepted";
    block_with_edges: beside "fn block(y, z) = max(|y| - 1 [m], z) surface block: block(y, z + 2 [m]) >= 0 impact block: inelastic, friction 0.2" =>
        "accepted";
    surface_that_holds_everywhere: beside "surface wall: abs(y) >= 0 impact wall: inelastic" =>
        "E12: the surface holds everywhere, so that nothing ever touches it: two of its pieces are never negative together; check the signs, or write `min` where all pieces have to hold";
    edge_with_a_factor: beside "parameters { a = 1 } surface roof: z >= a*|y| impact roof: inelastic" =>
        "E12: `max`, `min` and `|x|` can be taken apart in sums and with numbers as factors only, as the sign of another factor is not known; write it inside, as in `|slope*y|` or `max(a*y, a*z)`";
    piece_of_two_edges: beside "surface s: min(max(y, z), max(y, z - y)) >= 0 impact s: inelastic" =>
        "E12: a piece belongs to more than one `max`, so that it is not clear where it acts; declare several surfaces, each with its own pieces";
    edge_in_other_units: beside "surface s: max(z, m*y) >= 0 impact s: inelastic" =>
        "E03: units differ: `z` is in m, `m*y` is in kg m; the arguments of `max` must agree";
    edge_without_a_coordinate: beside "surface s: max(z, 1 [m]) >= 0 impact s: inelastic" =>
        "E12: a piece of the surface contains no coordinate, so that nothing can touch it; leave it out";
    edge_without_arguments: beside "surface s: max(z) >= 0 impact s: inelastic" =>
        "E02: `max` takes 2 arguments or more, found 1";
    edge_with_one_sliding_velocity: beside "surface s: |y| <= 1 [m] impact s: inelastic, friction 0.1, sliding dot(z)" =>
        "E20: surface `s` has 2 smooth pieces, and `sliding` gives 1; give one velocity for each, as in `sliding (dot(y), dot(z))`";
    edge_with_its_sliding_velocities: beside "surface s: |y| <= 1 [m] impact s: inelastic, friction 0.1, sliding (dot(z), -dot(z))" =>
        "accepted";
    two_sliding_velocities_of_a_plane: beside "surface s: y >= 0 impact s: inelastic, friction 0.1, sliding (dot(z), -dot(z))" =>
        "E20: the two sliding velocities of `s` are along one direction; give those of the touching point along two directions of the surface that are perpendicular to each other, as in `sliding (dot(x), dot(y))`";
    three_sliding_velocities: beside "surface s: y >= 0 impact s: inelastic, friction 0.1, sliding (dot(z), -dot(z), dot(y))" =>
        "E20: surface `s` has no edges, and `sliding` gives 3 velocities; give one in the plane, as in `sliding dot(y)`, or two in space, as in `sliding (dot(x), dot(y))`, in an `impact` of its own where another surface takes several";
    two_sliding_velocities_on_an_edge: beside "surface s: |y| <= 1 [m] impact s: inelastic, friction 0.1, sliding ((dot(z), dot(y)), dot(z))" =>
        "E20: surface `s` has 2 smooth pieces, and two sliding velocities on one of them; declare the pieces as surfaces of their own, each with `sliding (v1, v2)`";
    friction_of_rest_alone: beside "surface s: y >= 0 impact s: inelastic, friction static 0.4, sliding dot(z)" =>
        "E20: `friction static mu_s` says what holds at rest only; add the coefficient of sliding, as in `friction static 0.5, kinetic 0.4`";
    friction_of_sliding_alone: beside "surface s: y >= 0 impact s: inelastic, friction kinetic 0.4, sliding dot(z)" =>
        "E20: `friction kinetic mu_k` says nothing of rest; write `friction static mu_s, kinetic mu_k`, or `friction mu` where one coefficient holds for both";
    friction_of_rest_below_that_of_sliding: beside "surface s: y >= 0 impact s: inelastic, friction static 0.3, kinetic 0.4, sliding dot(z)" =>
        "E10: the coefficient of friction at rest is 0.3, below 0.4 of sliding: a body would hold on less than it is braked, and could neither rest nor slide; exchange them";
    friction_of_a_velocity: beside "surface s: y >= 0 impact s: inelastic, friction 0.3 + dot(z)^2/1 [m^2/s^2], sliding dot(z)" =>
        "E07: the coefficient of friction depends on the velocity `dot(z)`; it may depend on positions, the time and `speed`, the size of the sliding velocity";
    friction_that_vanishes_at_rest: beside "surface s: y >= 0 impact s: inelastic, friction tanh(speed/1 [m/s]), sliding dot(z)" =>
        "E10: the coefficient of friction vanishes at rest, so that nothing holds the contact there and its force is smooth; write one that is above 0 at rest";
    friction_in_other_units: beside "surface s: y >= 0 impact s: inelastic, friction 0.3 + speed, sliding dot(z)" =>
        "E03: units differ: `0.3` has no unit, `speed` is in m/s; both sides of `+` must agree; a bare number has no unit, write it in brackets, as in `0.3 [m/s]`";
    sliding_velocity_in_other_units: beside "surface s: |y| <= 1 [m] impact s: inelastic, friction 0.1, sliding (dot(z), m*dot(z))" =>
        "E03: units differ: `m*dot(z)` is in N s, where m/s is needed (the sliding velocity of `s` has the unit of its gap over s)";
    edge_with_one_direction: beside "surface s: |y| <= 1 [m] impact s: inelastic, along (1, 0)" =>
        "E20: surface `s` has edges, and `along` is another direction on each of its pieces; declare the pieces as surfaces of their own";
    derivative_at_an_edge: beside "fn h(y) = max(y, 2*y) surface s: z + 1 [m] >= diff(h)(y)*1 [m] impact s: inelastic" =>
        "E12: `h` contains `max`, `min` or `|x|`, which have no derivative at the edge; differentiate the pieces";
    velocity_at_an_edge: beside "surface s: dot(|y|) >= 0 impact s: inelastic" =>
        "E12: `|y|` contains `max`, `min` or `|x|`, which have no derivative at the edge; differentiate the pieces";
    absolute_value: beside "let top = abs(y) surface wall: z + top >= 0 impact wall: inelastic" =>
        "E12: `top` contains a switch, which belongs to `forces`, `rates` and `outputs` only; everywhere else use smooth functions";
    bars_around_a_number: with "lagrangian m/2*|dot((y, z))|^2 - m*g*|z|" =>
        "E12: `|z|` of a number has a kink at 0, which energies and laws must not have; write what acts in `forces`, which may switch, or declare a `surface`, which may contain it, where the motion strikes";
    branch: with "lagrangian if y > 0 { 1 } else { 2 }" =>
        "E12: `if` has a kink or a jump, which energies and laws must not have; write what acts in `forces`, which may switch, or declare a `surface` where the motion strikes";
    norm_of_velocity: with "lagrangian m/2*|dot((y, z))|^2 + m*|dot((y, z))|*1 [m/s]" =>
        "E13: a root or norm of velocities is not differentiable at rest; square it, as in `|dot(p)|^2`";

    // E15 and what else optimal control knows
    size_of_a_control: cart "minimize integral(abs(u))" => "accepted";
    size_of_a_control_in_bars: cart "minimize integral(|u|)" => "accepted";
    size_that_is_to_be_large: cart "minimize -integral(|u|)" =>
        "E12: `|u|` would be better the larger a maximum, a size or a peak is, or the smaller a minimum: each of their parts leads to an optimum of its own, which no condition tells apart; write the part that is meant, or ask for it in `constraint` or `finally`";
    smallest_that_is_to_be_small: cart "minimize integral(u^2) + min(y, 2*y)*1 [N^2 s/m]" =>
        "E12: `min(y, 2*y)*1 [N^2 s/m]` would be better the larger a maximum, a size or a peak is, or the smaller a minimum: each of their parts leads to an optimum of its own, which no condition tells apart; write the part that is meant, or ask for it in `constraint` or `finally`";
    power_of_a_peak: cart "minimize peak(y)^2" =>
        "E12: `peak(y)`: `max`, `min`, `|x|` and `peak` are added up in an objective, with numbers and parameters as factors, whose sign is known; write another factor or a power inside, as in `|w*x|` and `peak(x^2)`";
    size_times_what_moves: cart "minimize integral(y*|u|)" =>
        "E12: `y*|u|`: `max`, `min`, `|x|` and `peak` are added up in an objective, with numbers and parameters as factors, whose sign is known; write another factor or a power inside, as in `|w*x|` and `peak(x^2)`";
    peak_in_a_constraint: cart "minimize integral(u^2) constraint low: peak(y) <= 1 [m]" =>
        "E15: `peak(y)` is the largest value over the motion: a `constraint` holds all the time by itself; write what is inside of `peak` in its place";
    peak_under_an_integral: cart "minimize integral(peak(y))" =>
        "E15: `peak(y)` is the largest value over the motion: an integral adds up over the motion what is one number of it; leave `peak` in front of it, as a term by itself";
    peak_of_two: cart "minimize peak(y, u)" => "E02: `peak` takes 1 argument, found 2";
    peak_that_is_a_value: cart "minimize integral(u^2) finally { peak(y) == 1 [m] }" =>
        "E12: `peak(y) == 1 [m]` asks a largest value to be exactly that; ask for at most that much, by `<=`";
    peak_that_is_to_be_large: cart "minimize integral(u^2) finally { peak(y) >= 1 [m] }" =>
        "E12: `peak(y)` would be better the larger a maximum, a size or a peak is, or the smaller a minimum: each of their parts leads to an optimum of its own, which no condition tells apart; write the part that is meant, or ask for it in `constraint` or `finally`";
    peak_in_another_unit: cart "minimize integral(u^2) finally { peak(y) <= 1 [s] }" =>
        "E03: units differ: `peak(y)` is in m, `1 [s]` is in s; both sides of a terminal condition must agree";
    control_in_a_maximum_at_the_end: cart "minimize max(u, 2*u)*1 [m]" =>
        "E15: the final cost depends on the control `u`, which acts over a time and has no value at the final instant; write `integral(max(u, 2*u)*1 [m])`";
    larger_of_two_at_the_end: cart "minimize integral(u^2) finally { max(y, 2*y) <= 1 [m] }" => "accepted";
    size_in_a_constraint: cart "minimize integral(u^2) constraint slow: |dot(y)| <= 1 [m/s]" => "accepted";
    one_of_two_in_a_constraint: cart "minimize integral(u^2) constraint fast: |dot(y)| >= 1 [m/s]" =>
        "E12: a condition that holds where one of several does is none of a smooth problem; state the one that is meant, or declare a `surface`, which the motion may pass on either side";
    product_of_a_size_in_a_constraint: cart "minimize integral(u^2) constraint slow: y*|dot(y)| <= 1 [m^2/s]" =>
        "E12: `max`, `min` and `|x|` can be taken apart in sums and with numbers as factors only, as the sign of another factor is not known; write it inside, as in `|slope*y|`";
    size_in_an_equation: cart "minimize integral(u^2) finally { |y| == 1 [m] }" =>
        "E12: `|y|` of a number has a kink at 0, which objectives, constraints and goals must not have; write a condition for each side, as `x <= c` and `x >= -c`, or square it";
    size_that_is_always_small: cart "minimize integral(u^2) finally { max(0*y, 0 [m]) <= 1 [m] }" =>
        "E15: `max(0*y, 0 [m]) <= 1 [m]` is the same for every motion, so it is no condition; use coordinates, velocities or the time";
    constraint_without_a_name: cart "minimize integral(u^2) constraint dot(y) <= 1 [m/s]" =>
        "a constraint has a name, as in `constraint speed: dot(y) <= 3 [m/s]`";
    constraint_without_a_name_from_a_number_on: cart "minimize integral(u^2) constraint -1 [m/s] <= dot(y)" =>
        "a constraint has a name, as in `constraint speed: dot(y) <= 3 [m/s]`";
    task_is_accepted: cart "minimize 1 [1/s]*time + integral(u^2)/1 [N^2 s] finally { y == 1 [m], dot(y) >= 0 } constraint power: u*dot(y) <= 3 [W] free { dot(y) in 0..=3 }" =>
        "accepted";
    control_in_a_final_cost: cart "minimize u^2" =>
        "E15: the final cost depends on the control `u`, which acts over a time and has no value at the final instant; write `integral(u^2)`";
    control_in_a_terminal_condition: cart "finally { y == 1 [m], u == 0 }" =>
        "E15: a terminal condition depends on the control `u`, which acts over a time and has no value at the final instant; a condition on it is a `constraint`";
    derivative_of_a_control: cart "minimize integral(dot(u)^2)" =>
        "E15: `dot(u)` needs the derivative of a control, which may jump; take `dot` of positions only";
    integral_of_a_constant: cart "minimize integral(1)" =>
        "E15: the integral of the constant `1` is that times the final time; write `time`";
    integral_of_a_sum_of_constants: cart "minimize integral(m + 2 [kg])" =>
        "E15: the integral of the constant `m + 2 [kg]` is that times the final time; write `(m + 2 [kg])*time`";
    integral_inside_a_function: cart "minimize sqrt(integral(u^2))" =>
        "E15: `integral` inside `sqrt(integral(u^2))`: an objective is a sum of final terms and of integrals, each possibly times a constant";
    integral_inside_an_integral: cart "minimize integral(y*integral(u^2))" =>
        "E15: `integral` inside `integral`: a running cost is integrated once, over the motion; add a coordinate for the inner one";
    integral_times_a_velocity: cart "minimize dot(y)*integral(u^2)" =>
        "E15: an integral times `dot(y)`, which depends on the velocity `dot(y)`: a weight may depend on parameters only; move it into the integral";
    integral_outside_of_an_objective: cart "finally { integral(u^2) <= 3 [N^2 s] }" =>
        "E15: `integral` is the running cost and stands in `minimize` only, as a term by itself, possibly times a constant; for an integral elsewhere add a coordinate whose force is what is integrated, which is its velocity then";
    constant_cost: cart "minimize 3*m" =>
        "E15: `3*m` is the same for every motion, so it cannot be minimized; leave it out";
    condition_on_nothing: cart "finally { m >= 0 } constraint c: 2*m == 3 [kg]" =>
        "E15: `m >= 0` is the same for every motion, so it is no condition; use coordinates, velocities or the time",
        "E15: `2*m == 3 [kg]` is the same for every motion, so it is no condition; use coordinates, velocities or the time";
    final_time_in_a_running_cost: cart "minimize integral(u^2*time) constraint c: y <= 1 [m/s]*time" =>
        "E01: `time` is the final time, known to final costs in `minimize` and to `finally` only; the time at each instant is `t`";
    terms_of_a_cost_in_other_units: cart "minimize time + integral(u^2)" =>
        "E03: units differ: `time` is in s, `integral(u^2)` is in kg^2 m^2/s^3; both sides of `+` must agree";
    condition_in_other_units: cart "finally { y == 1, dot(y) <= y }" =>
        "E03: units differ: `y` is in m, `1` has no unit; both sides of a terminal condition must agree; a bare number has no unit, write it in brackets, as in `1 [m]`",
        "E03: units differ: `dot(y)` is in m/s, `y` is in m; both sides of a terminal condition must agree";
    free_value_in_other_units: cart "free { y in 0..=1 [m/s], dot(y) in 0 [m]..=1 }" =>
        "E03: units differ: `1 [m/s]` is in m/s, where m is needed (it bounds `y`)",
        "E03: units differ: `0 [m]` is in m, where m/s is needed (it bounds `dot(y)`)";
    free_value_with_a_guess: cart "free { y: 2 }" =>
        "`free` says which initial values are to be found; the guess belongs to `start { y: ... }`";
    free_value_twice_or_unknown: cart "free { y, dot(y), y, z }" =>
        "`y` is listed in `free` twice; keep one",
        "E01: `z` is not declared (coordinates: `y`)";
    guess_outside_its_bounds: cart "free { y in 2..=1, dot(y) in 1..=3 }" =>
        "E17: lower bound 2 of `y` lies above its upper bound 1; exchange them",
        "E17: `dot(y)` starts at 0, outside its bounds 1..=3";
    guess_that_is_left_out: cart "free { dot(y) in 1..=3, y in 10..=40 [cm] } start { y: 0.5 }" =>
        "E17: `dot(y)` starts at 0, outside its bounds 1..=3",
        "E17: `y` starts at 0.5, outside its bounds 0.1..=0.4";
    two_objectives_and_names: cart "minimize time minimize y constraint c: y <= 1 [m] constraint c: y >= 0" =>
        "a scene has one `minimize`; add the terms up in it",
        "E19: constraint `c` is declared twice; rename one";
    single_equals_sign: cart "finally { y = 1 [m], dot(y) > 0 }" =>
        "a condition is written with `==`, `>=` or `<=`; one of them is meant here";
    chain_of_inequalities: cart "constraint c: 0 <= y <= 1 [m]" =>
        "a condition compares two sides; write two conditions, the second one with `y` on its left; bounds of a control stand where it is declared, as in `u in -1..=1`";
    norm_of_velocity_as_constraint: beside "constraint c: |dot((y, z))| <= 1 [m/s]" =>
        "E13: a root or norm of velocities is not differentiable at rest; square it, as in `|dot(p)|^2`";
    control_of_a_cost_is_used: beside "controls { u: N, slack: m, idle: N } forces { y: u } minimize integral(slack) constraint c: slack >= y" =>
        "E16: control `idle` is never used; let it act by `forces { ... }`";
    name_of_the_integral: messages "S { parameters { integral = 2 } coordinates { y } lagrangian integral*dot(y)^2 }" =>
        "E19: `integral` is the name of a function; choose another name";

    // E18
    surface_twice: beside "surface a: z >= 0 surface b: 3*z >= 0 impact a, b: inelastic" =>
        "E18: surfaces `a` and `b` are the same, so they are always touched together and no rule says which of their laws holds; leave one out";
    surface_from_both_sides: beside "surface a: z >= m*1 [m/kg] surface b: z <= m*1 [m/kg] impact a, b: inelastic start { z: m*1 [m/kg] }" =>
        "E18: surfaces `a` and `b` are the same from both sides, so they leave no room to move; leave one out, or describe the motion by a coordinate less";
    surface_through_a_corner_is_accepted: beside "surface a: z >= 0 surface b: y >= 0 surface c: y + m*2 [1/kg]*z >= 0 impact a, b, c: inelastic" =>
        "accepted";
    // The gaps of a turning rectangle fulfil a - b - c + d = 0 wherever the floor lies.
    corners_are_accepted: messages
        "S { coordinates { z, p } lagrangian dot(z)^2 + dot(p)^2
         surface a: z + 3*sin(p) + 2*cos(p) >= 7 surface b: z - 3*sin(p) + 2*cos(p) >= 7 surface c: z + 3*sin(p) - 2*cos(p) >= 7
         surface d: z - 3*sin(p) - 2*cos(p) >= 7 impact a, b, c, d: inelastic start { z: 20 } }" =>
        "accepted";
    tiles_side_by_side_are_accepted: beside
        "surface left: max(z, y) >= 0 surface right: max(z, -y) >= 0 impact left, right: inelastic" =>
        "accepted";
    same_surface_in_two_forms: messages
        "S { coordinates { y } lagrangian dot(y)^2 surface a: sin(y)^2 >= 1/4 surface b: 1 - cos(2*y) >= 1/2 impact a, b: inelastic start { y: 1 } }" =>
        "E18: surfaces `a` and `b` are the same, so they are always touched together and no rule says which of their laws holds; leave one out";
    box_is_accepted: beside "surface a: y >= 0 surface b: y <= 1 [m] surface c: z >= 0 surface d: z <= m*1 [m/kg] impact a, b, c, d: inelastic" =>
        "accepted";
    parallel_walls_are_accepted: beside "surface a: y >= 0 surface b: y <= 1 [m] surface c: y <= 2 [m] impact a, b, c: inelastic" =>
        "accepted";

    // E16, E17, E19, E20
    everything_unused: beside "controls { u: N } let a = y fn f(b) = b^2" =>
        "E16: control `u` is never used; let it act by `forces { ... }`",
        "E16: abbreviation `a` is never used; leave it out",
        "E16: function `f` is never used; leave it out";
    bounds_exchanged: messages "S { coordinates { y: m in 3..=1 } lagrangian dot(y)^2 }" =>
        "E17: lower bound 3 of `y` lies above its upper bound 1; exchange them";
    start_outside_bounds: messages "S { coordinates { y in 0..=1 } lagrangian dot(y)^2 start { y: 3 } }" =>
        "E17: `y` starts at 3, outside its bounds 0..=1";
    names_of_functions_and_twice: messages "S { parameters { sin = 2, a = 3, a = 4 } coordinates { y } lagrangian a*dot(y)^2 }" =>
        "E19: `sin` is the name of a function; choose another name",
        "E19: `a` is declared twice; rename this parameter";
    law_for_no_surface: beside "surface wall: y >= 0 impact wal: inelastic" =>
        "E20: there is no surface `wal`; did you mean `wall`?",
        "E20: surface `wall` has no impact law; write `impact wall: inelastic`";
    two_laws: beside "surface wall: y >= 0 impact wall: inelastic impact wall: inelastic" =>
        "E20: surface `wall` has two impact laws; keep one";

    parts_of_a_law_that_exclude_each_other: beside
        "surface a: y >= 0 surface b: y <= 1 [m] surface c: z >= 0 impact a: inelastic, restitution 0.5 impact b: inelastic, along (1, 0), holding z impact c: inelastic, along (0, 1), friction 0.3" =>
        "E20: `inelastic` and `restitution` exclude each other: `inelastic` is no rebound at all; keep one",
        "E20: `along` and `holding` both give the direction of the impulse; keep one",
        "E20: `along` and `friction` exclude each other: Coulomb's law bounds the tangential part of a force whose normal part acts along M^-1 grad gap, and `along` puts another direction in its place; leave one out";
    parts_of_a_law_that_are_missing: beside
        "surface a: y >= 0 surface b: z >= 0 impact a: friction 0.3 impact b: inelastic, sliding dot(z)" =>
        "E20: the impact law says nothing about the normal velocity; add `inelastic` or `restitution e`",
        "E20: `sliding` gives the velocity that friction brakes, and there is no `friction`; add `friction mu` or leave it out";
    part_of_a_law_twice: beside "surface a: y >= 0 impact a: friction 0.3, inelastic, friction 0.2" =>
        "E20: `friction` stands twice in one impact law; keep one";
    unknown_part_of_a_law: beside "surface a: y >= 0 impact a: inelastic, fricton 0.3" =>
        "unknown part `fricton` of an impact law; did you mean `friction`?";
    law_that_is_called_otherwise: beside "surface a: y >= 0 impact a: elastic" =>
        "there is no law `elastic`; a rebound is `restitution 1`, no rebound is `inelastic`";
    law_in_sequence: beside "surface a: y >= 0 surface b: z >= 0 impact a: inelastic, holding z, in sequence impact b: in sequence, restitution 0.2" =>
        "accepted";
    sequence_without_in: beside "surface a: y >= 0 impact a: inelastic, sequence" =>
        "contacts are struck one after the other `in sequence`; write both words";
    in_without_sequence: beside "surface a: y >= 0 impact a: inelastic, in order" =>
        "expected `sequence` behind `in`, for contacts that are struck one after the other, found `order`";
    sequence_twice: beside "surface a: y >= 0 impact a: in sequence, inelastic, in sequence" =>
        "E20: `in` stands twice in one impact law; keep one";
    part_without_comma: beside "surface a: y >= 0 impact a: inelastic friction 0.3" =>
        "a comma is missing before `friction`";
    friction_as_a_statement: beside "surface a: y >= 0 impact a: inelastic friction a: 0.3" =>
        "a comma is missing before `friction`";
    friction_far_from_its_law: beside "surface a: y >= 0 impact a: inelastic horizon 3 [s]; friction a: 0.3" =>
        "`friction` is part of an impact law; write `impact name: ..., friction mu`, or `dry friction name: bound f, sliding dot(q)` for friction without a surface";

    // dry friction
    dry_friction_in_any_order: beside "dry friction rail: bound m*g/10, sliding dot(y) dry friction post: sliding dot(z) - dot(y), bound 2 [N] + m*g*t/1 [s] outputs { rub: N = friction_force(post) }" => "accepted";
    bound_is_no_word_of_the_language: messages
        "S { parameters { bound = 1 } coordinates { y } lagrangian dot(y)^2/2 dry friction rail: bound bound, sliding dot(y) }" => "accepted";
    dry_friction_without_a_bound: beside "dry friction rail: sliding dot(y)" =>
        "E20: dry friction `rail` does not say how large its force may be; add `bound f`";
    dry_friction_without_a_velocity: beside "dry friction rail: bound 2 [N]" =>
        "E20: dry friction `rail` does not say which velocity it brakes; add `sliding dot(q)`";
    dry_friction_without_commas: beside "dry friction rail: bound 2 [N] sliding dot(y) dry friction post: sliding dot(z) bound 2 [N]" =>
        "a comma is missing before `sliding`",
        "a comma is missing before `bound`; a product is written `dot(z)*bound`";
    dry_friction_with_a_part_twice: beside "dry friction rail: bound 2 [N], bound 3 [N], sliding dot(y)" =>
        "E20: `bound` stands twice in one dry friction; keep one";
    dry_friction_with_a_coefficient: beside "dry friction rail: friction 0.3, sliding dot(y)" =>
        "unknown part `friction` of dry friction; write `dry friction rail: bound f, sliding dot(q)`, with the largest force and the velocity that it brakes";
    dry_friction_without_its_words: beside "dry rail: bound 2 [N], sliding dot(y)" =>
        "expected `friction` behind `dry`, as in `dry friction hinge: bound f, sliding dot(q)`, found `rail`";
    dry_friction_without_a_force: beside "dry friction rail: bound, sliding dot(y)" =>
        "`bound` needs the largest force, as in `bound 2 [N]`";
    bounds_in_other_units: beside "dry friction rail: bound 2 [m], sliding dot(y) dry friction post: bound 2 [N], sliding dot(z)/1 [m]" =>
        "E03: units differ: `2 [m]` is in m, where N is needed (the bound of `rail` is the Lagrangian's unit over that of its sliding velocity times s)",
        "E03: units differ: `2 [N]` is in N, where J is needed (the bound of `post` is the Lagrangian's unit over that of its sliding velocity times s)";
    bound_that_depends_on_the_velocity: beside "dry friction rail: bound 2 [N] + 2 [N s/m]*speed, sliding dot(y)" => "accepted";
    bound_that_depends_on_a_control: cart "dry friction rail: bound u, sliding dot(y)" => "accepted";
    bound_that_follows_a_surface: beside "surface s: z >= 0 impact s: inelastic dry friction rail: bound 1 [N] + 0.3*force(s), sliding dot(y)" => "accepted";
    bound_of_a_square_of_a_force: beside "surface s: z >= 0 impact s: inelastic dry friction rail: bound force(s)^2/1 [N], sliding dot(y)" =>
        "E07: the bound of dry friction `rail` is no sum of forces of surfaces and joints times what does not follow them; write one, as in `bound mu*force(pad)`, with the sign by which the force of a joint is positive";
    bound_that_falls_with_a_force: beside "surface s: z >= 0 impact s: inelastic dry friction rail: bound 5 [N] - force(s), sliding dot(y)" =>
        "E10: the bound of dry friction `rail` falls where a surface is pressed, and may fall below 0; change the sign in front of `force`";
    bound_that_follows_an_impulse: beside "surface s: z >= 0 impact s: inelastic dry friction rail: bound impulse(s)/1 [s], sliding dot(y)" =>
        "E24: the bound of a dry friction may follow normal forces of surfaces and forces of joints, as in `bound mu*r*force(pad)`, and not `impulse(s)`";
    bound_below_zero: beside "dry friction rail: bound -m*g, sliding dot(y)" =>
        "E10: the bound of dry friction `rail` is -9.81 < 0: the force would drive the sliding instead of braking it; change its sign";
    bound_with_a_kink: beside "dry friction rail: bound |2 [N]*y/1 [m]|, sliding dot(y)" =>
        "E12: `|2 [N]*y/1 [m]|` of a number has a kink at 0, which energies and laws must not have; write what acts in `forces`, which may switch, or declare a `surface`, which may contain it, where the motion strikes";
    place_instead_of_a_velocity: beside "dry friction rail: bound 2 [N], sliding y" =>
        "E07: the sliding velocity `y` contains no velocity; write e.g. `dot(y)`";
    dry_friction_with_a_law: beside "dry friction rail: bound 2 [N], sliding dot(y) impact rail: inelastic" =>
        "E20: there is no surface `rail`; declare it by `surface rail: ... >= ...`";
    dry_friction_named_like_a_surface: beside "surface rail: z >= 0 impact rail: inelastic dry friction rail: bound 2 [N], sliding dot(y)" =>
        "E20: dry friction `rail` is declared twice; rename one";
    surface_named_like_dry_friction: beside "dry friction rail: bound 2 [N], sliding dot(y) surface rail: z >= 0 impact rail: inelastic" =>
        "E20: surface `rail` is declared twice; rename one";
    normal_force_of_dry_friction: beside "dry friction rail: bound 2 [N], sliding dot(y) outputs { push: N = force(rail) }" =>
        "E24: dry friction `rail` has no normal force; its own is `friction_force(rail)`";
    impulse_of_dry_friction: beside "dry friction rail: bound 2 [N], sliding dot(y) outputs { hit: N s = friction_impulse(rail) }" =>
        "E24: dry friction `rail` has no impulse, as its force is bounded; its own is `friction_force(rail)`";

    // E21
    product_that_overflows: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*3e250*2e140" =>
        "E21: with `2e140` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    quotient_that_overflows: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z/4e-170/1e-160" =>
        "E21: with `1e-160` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    function_that_overflows: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*cosh(800)" =>
        "E21: with `cosh(800)` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    power_that_overflows: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*7^500" =>
        "E21: with `7^500` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    root_of_a_negative_number: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*sqrt(2 - 5)" =>
        "E21: with `sqrt(2 - 5)` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    product_that_is_too_small_is_zero: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*3e-250*2e-140" =>
        "accepted";
    function_that_is_too_small_is_zero: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*exp(-900)" =>
        "accepted";
    constants_that_cancel: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*(0.7 + 0.1 - 0.8)*1e19" =>
        "E21: with `0.8` constants cancel up to their rounding, so that no digit of the difference is right; write the difference itself, or leave the terms out if they cancel";
    terms_that_cancel_in_a_vector: with "let p = (1.1*y, z) + (2.2*y, z) - (3.3*y, z) lagrangian m/2*|dot((y, z))|^2 - m*g*p.z" =>
        "E21: with `(3.3*y, z)` constants cancel up to their rounding, so that no digit of the difference is right; write the difference itself, or leave the terms out if they cancel";
    constant_that_is_lost: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*(1 + 3e18 - 3e18)" =>
        "E21: with `3e18` constants are added of which one is lost, as it is more than 1e16 times smaller; leave it out, or write the sum otherwise";
    bumps_far_from_the_start: beside "fn road(y) = exp(-(y/1 [m] - 2)^2) + exp(-(y/1 [m] - 9)^2) parameters { far: m = 1 } start { z: far*road(0 [m]) }" =>
        "accepted";
    constant_that_is_lost_beside_a_cosine: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*(cos(1) + 3e18)" =>
        "E21: with `3e18` constants are added of which one is lost, as it is more than 1e16 times smaller; leave it out, or write the sum otherwise";
    constants_that_cancel_exactly_are_accepted: with "lagrangian m/2*|dot((y, z))|^2 - m*g*(z + 3e18 [m] - 3e18 [m])" =>
        "accepted";
    numbers_out_of_range: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*2e308 - m*g*y*3e-310" =>
        "E21: the number 2e308 is too large for double precision, which ends at 1.8e308";
    number_with_a_unit_out_of_range: messages "S { parameters { m: kg = 1e307 [t] } coordinates { y: m } lagrangian m/2*dot(y)^2 }" =>
        "E21: with `1e307 [t]` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    default_out_of_range: messages "S { parameters { l: um = 4e303 [m] } coordinates { y: m } lagrangian l*dot(y)^2 }" =>
        "E21: with `4e303 [m]` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller";
    derivative_out_of_range: with "lagrangian m/2*|dot((y, z))|^2 - m*g*y - m*1.7e308 [m/s^2]*z^3/1 [m^2]" =>
        "E21: a constant in the derivatives of the declaration has no finite value in double precision; choose units in which the numbers are closer to 1";

    // Slips of the pen
    apostrophe_of_a_velocity: with "lagrangian m/2*y'a^2" =>
        "an apostrophe is no operator here, as it is a token of another kind in Rust; write `dot(y)` for the rate of `y`; the derivative of a function is `diff(f)(y)`";
    function_without_parentheses: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*cos 2*pi" =>
        "`cos` is a function; its argument stands in parentheses, as in `cos(2*pi)`";
    unit_without_brackets: beside "horizon 2 s" =>
        "a unit stands in brackets; write `2 [s]`";
    method_of_rust: with "lagrangian m/2*dot(y).powi(2) + m/2*dot(z)^2 - m*g*z" =>
        "`.powi(...)` is a call of Rust; write `dot(y)^2`";
    unknown_method_of_rust: with "lagrangian m/2*dot(y).squared()" =>
        "`.squared(...)` is a call of Rust; write functions as `sin(x)`, powers as `x^2`";
    velocity_as_a_component: with "lagrangian m/2*y.dot^2" =>
        "E02: `y.dot`: the velocity is `dot(y)`";
    velocity_as_a_name: with "lagrangian m/2*y_dot^2 + m/2*dot(z)^2" =>
        "E01: `y_dot` is not declared; the velocity of `y` is `dot(y)`";
    pi_in_capitals: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*PI" =>
        "E01: `PI` is not declared; the number is `pi`";
    number_with_a_type: with "lagrangian m/2*|dot((y, z))|^2 - m*g*z*2.5_f64" =>
        "`2.5` carries the type `f64` of Rust; numbers here have no type, write `2.5`";
    decimal_comma: messages "S { parameters { a = 9,81, b = 1 } coordinates { y } lagrangian a*b*dot(y)^2 }" =>
        "a number has a decimal point, not a comma; write `9.81`";
    comma_missing_between_entries: messages "S { parameters { a = 9 b = 1 } coordinates { y } lagrangian a*b*dot(y)^2 }" =>
        "a comma is missing before `b`";
    restitution_without_a_number: beside "surface wall: y >= 0 impact wall: restitution start { y: 1 }" =>
        "`restitution` needs its coefficient, as in `restitution 0.5`";
    unit_error_beside_other_mistakes: with "lagrangian m/2*|dot((y, z))|^2 - m*g surface a: z >= 0 surface b: 3*z >= 0 impact a, b: inelastic" =>
        "E03: units differ: `m/2*|dot((y, z))|^2` is in J, `m*g` is in N; both sides of `-` must agree",
        "E18: surfaces `a` and `b` are the same, so they are always touched together and no rule says which of their laws holds; leave one out";
    unused_name_beside_other_mistakes: beside "let a = y surface ground: z <= 0 impact ground: inelastic start { z: 2 }" =>
        "E08: the start lies inside the ground: with the defaults of the parameters the gap of surface `ground` is -2 m < 0; start at a gap of 0 or more, or exchange `>=` and `<=` if the free side is the other one",
        "E16: abbreviation `a` is never used; leave it out";

    // Functions
    function_of_itself: messages "S { coordinates { y } fn f(x) = 1 + f(x) lagrangian f(1)*dot(y)^2 }" =>
        "function `f` uses itself; functions are inserted where they are used and cannot do that";
    functions_of_each_other: messages
        "S { parameters { k: 1/m = 1 } coordinates { y: m } fn f(x) = g(x) fn g(x) = f(x) lagrangian dot(y)^2 forces { y: f(y) } }" =>
        "function `f` uses itself; functions are inserted where they are used and cannot do that";

    // Syntax
    stacked_power: with "lagrangian m/2*dot(y)^2^2 + m/2*dot(z)^2" =>
        "two powers in a row are easily misread; put the inner one in parentheses, as in `dot(y)^(2^2)`";
    missing_operator: with "lagrangian m/2 dot(y)^2 + m/2*dot(z)^2" =>
        "an operator is missing before `dot(...)`; write a product as `m/2*dot(...)`";
    number_with_suffix: with "lagrangian m/2*dot(y)^2 + 2y" =>
        "`2y` is not a number; write a product as `2*y`";
    stars_for_power: with "lagrangian m**2" =>
        "`**` is no operator; write powers as `x^2`";
    acceleration: with "lagrangian m/2*dot(y)^2 + m/2*dot(dot(z))" =>
        "`dot(dot(z))` would be an acceleration, which follows from the Lagrangian; take `dot` once, of positions only";
    strict_inequality: beside "surface wall: y > 0 impact wall: inelastic" =>
        "a surface is an inequality `>=` or `<=`; equality holds in contact";
    unknown_unit: messages "S { parameters { a: sec = 3 } coordinates { y } lagrangian a*dot(y)^2 }" =>
        "unknown unit `sec`; did you mean `s`?";
    missing_default: messages "S { parameters { a: kg } coordinates { y } lagrangian a*dot(y)^2 }" =>
        "parameter `a` needs a default value, as in `a: kg = 1`";
    nothing: messages "" => "expected the name of the scene, found the end; write `pub Name { ... }`";
    name_alone: messages "pub S" => "expected `{` after the name `S`, found the end";
}

#[test]
fn messages_about_long_expressions_stay_short() {
    let terms = vec!["y"; 5000].join(" + ");
    let found = with(&format!(
        "lagrangian m/2*|dot((y, z))|^2 - m*g*({terms} + m)"
    ));
    assert_eq!(found.len(), 1);
    assert!(
        found[0].starts_with("E03: units differ") && found[0].len() < 1000,
        "{found:?}"
    );
}
