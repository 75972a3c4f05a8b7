//! States of first order and switches: what is accepted, and what each mistake says.

use hangtime_dsl::declaration::{Declaration, Switching};

/// Messages for the statements beside a mass on a line and a state, or "accepted".
fn messages(statements: &str) -> Vec<String> {
    let source = format!(
        "S {{ parameters {{ m: kg = 1, k: N/A = 2, tau: s = 3 }} coordinates {{ x: m }} controls {{ u: A }} states {{ i: A }} {statements} }}"
    );
    super::mistakes_in(&source)
}

const LAW: &str = "lagrangian m/2*dot(x)^2";
const RATE: &str = "forces { x: k*i } rates { i: (u - i)/tau }";

/// Messages of the scene with the law of the mass.
fn beside(statements: &str) -> Vec<String> {
    messages(&format!("{LAW} {statements}"))
}

/// Messages of the scene with the law of the mass, a force and a rate.
fn complete(statements: &str) -> Vec<String> {
    beside(&format!("{RATE} {statements}"))
}

texts! {
    state_with_its_rate: complete "start { i: 2 } outputs { pull: N = k*i } horizon 1 [s]" => "accepted";
    state_in_the_potential: messages
        "lagrangian m/2*dot(x)^2 - k*i*x rates { i: (u - i)/tau }" => "accepted";
    state_without_a_rate: beside "forces { x: k*i + 0*u*k }" =>
        "E04: state `i` has no rate; write `rates { i: ... }`, with 0 for one that stays";
    rate_in_other_units: beside "forces { x: k*i } rates { i: (u - i)/1 [m] + 0*u/tau }" =>
        "E03: units differ: `(u - i)/1 [m] + 0*u/tau` is in A/m, where A/s is needed (the rate of `i` is the unit of the state over s)";
    two_rates: complete "rates { i: u/tau }" => "`i` has two rates; add them up in one";
    rate_with_dot: beside "forces { x: k*i } rates { dot(i): (u - i)/tau }" =>
        "the rate of `i` is written `i: ...`, without `dot`";
    rate_of_a_coordinate: complete "rates { x: dot(x) }" =>
        "E01: `x` is a coordinate, whose acceleration follows from the `lagrangian`; what acts on it stands in `forces { x: ... }`";
    rate_of_nothing: complete "rates { charge: i }" => "E01: `charge` is no state (states: `i`)";
    force_on_a_state: complete "forces { i: 1 [N] }" =>
        "E01: `i` is a state, not a coordinate; what it changes by stands in `rates { i: ... }`";
    start_of_a_rate: complete "start { dot(i): 1 }" =>
        "`i` is a state, whose rate stands in `rates`; its start value is written `i: ...`";
    two_start_values: complete "start { i: 1, i: 2 }" => "`i` has two start values; keep one";
    start_in_other_units: complete "start { i: 1 [m] }" =>
        "E03: units differ: `1 [m]` is in m, where A is needed (it is the start value of `i`)";
    rate_as_a_derivative: complete "outputs { pull: N = k*dot(i)*tau }" =>
        "`dot(i)` is the rate of a state; give what stands in `rates` a name by `let`, and use that";
    state_in_a_surface: complete "surface floor: x >= 1 [m/A]*i impact floor: inelastic" =>
        "E07: surface `floor` depends on the state `i`; a surface bounds positions only";
    state_in_a_sliding_velocity: complete "dry friction brake: bound 1 [N], sliding dot(x) - i*1 [m/(A s)]" =>
        "E07: the sliding velocity depends on the state `i`; it may depend on positions and velocities only";
    mass_that_changes: messages "lagrangian m*i/1 [A]/2*dot(x)^2 forces { x: k*i } rates { i: (u - i)/tau }" =>
        "E04: the kinetic energy depends on the state `i`, and does not say what becomes of the momentum when that changes; of a \
         body whose mass changes write the energies of a mass of 1, as in `dot(x)^2/2 - g*x`, and divide what acts by the mass, as \
         in `forces { x: thrust/m }`";

    switches_in_forces_and_rates: beside
        "let pull = k*max(i, 0 [A]) forces { x: pull - 1 [N]*sign(dot(x)) + 2 [N]*step(t - 1 [s]) } \
         rates { i: (if x >= 1 [m] { u - i } else { -i })/tau - |i|/tau } outputs { side = sign(dot(x)), strength: N = pull }" =>
        "accepted";
    three_ways_of_a_rate: beside
        "forces { x: k*i } rates { i: if x >= 2 [m] { -u/tau } else if x >= 1 [m] { -i/tau } else { u/tau } }" => "accepted";
    sides_of_other_units: beside "forces { x: k*i } rates { i: if x >= 1 [s] { u/tau } else { -i/tau } }" =>
        "E03: units differ: `x` is in m, `1 [s]` is in s; the arguments of `if` must agree";
    values_of_other_units: beside "forces { x: k*i } rates { i: if x >= 1 [m] { u/tau } else { u } }" =>
        "E03: units differ: `u/tau` is in A/s, `u` is in A; the arguments of `if` must agree";
    choice_without_else: beside "forces { x: k*i } rates { i: if x >= 1 [m] { u/tau } }" =>
        "`else` is missing, as what acts has a value on both sides; write `if c >= 0 { a } else { b }`";
    switch_by_a_switch: beside "forces { x: k*i } rates { i: u/tau*sign(|x| - 1 [m]) }" =>
        "E12: what `sign(|x| - 1 [m])` switches by switches itself, so that it has no rate where it would vanish; write \
         `clamp(x, low, high)` for what saturates on both sides, or switch by a \
         smooth function";
    switch_by_a_control: beside "forces { x: k*i } rates { i: u/tau*sign(u) }" =>
        "E07: what `sign(u)` switches by depends on a control, which may jump; switch by what moves, and let the control act in \
         its place";
    switch_by_nothing_that_moves: beside "forces { x: k*i } rates { i: u/tau*sign(m) }" =>
        "E07: what `sign(m)` switches by depends on nothing that changes, so that it never switches; write a parameter of 1 or -1 in \
         its place";
    product_of_switches: beside "forces { x: k*i } rates { i: u/tau*sign(x)*sign(dot(x)) }" =>
        "E12: what acts contains a product of the switches `sign(x)` and `sign(dot(x))`, as of one inside of the other, and where \
         both functions vanish the motion is not determined by that; write a sum of terms with one switch each, or switches by \
         functions that differ by a number, as in `if x >= 2 { a } else if x >= 1 { b } else { c }`";
    square_of_a_switch: beside "forces { x: k*i } rates { i: u/tau*sign(x)^2 }" =>
        "accepted";
    switch_in_an_energy: messages "lagrangian m/2*dot(x)^2 - 1 [N]*|x| rates { i: (u - i)/tau }" =>
        "E12: `|x|` of a number has a kink at 0, which energies and laws must not have; write what acts in `forces`, which may switch, \
         or declare a `surface`, which may contain it, where the motion strikes";
    named_switch_in_a_cost: complete "let far = |x| minimize integral(far)" =>
        "E12: `far` contains a switch, which belongs to `forces`, `rates` and `outputs` only; everywhere else use smooth functions";
    maximum_of_three: beside "forces { x: k*i } rates { i: max(i, u, 2*u)/tau }" =>
        "E02: `max` of 3 in what acts would switch where other switches do; write it of two smooth functions, and \
         `if c { a } else { b }` for more cases";
}

#[test]
fn products_of_switches_that_follow_each_other_are_sums() {
    // A window in time, and three ranges: each switch acts by what it changes where it is.
    let scene = described(
        "states { a, b } rates { a: step(t - 1)*step(3 - t), b: if a >= 2 { 5 } else if a >= 1 { 3 } else { 1 } } horizon 1",
    );
    let names: Vec<&str> = scene.contacts.iter().map(|known| known.name).collect();
    assert_eq!(names, ["step(t - 1)", "step(3 - t)", "a >= 1", "a >= 2"]);
}

/// The scene that statements declare.
fn described(text: &str) -> Declaration {
    crate::described(text).structure.declaration
}

#[test]
fn states_stand_behind_coordinates_and_nothing_reads_their_integrals() {
    let scene = described(
        "parameters { k = 2 } coordinates { x } states { a in 0..=1, b } lagrangian dot(x)^2/2 - a*x^2/2
         forces { x: k*b } rates { a: -a, b: a - x }",
    );
    let names: Vec<&str> = scene.coordinates.iter().map(|known| known.name).collect();
    assert_eq!(names, ["x", "integral(a)", "integral(b)"]);
    let states: Vec<&str> = scene.states.iter().map(|known| known.name).collect();
    assert_eq!(states, ["a", "b"]);
    assert!(scene.optimal_control.is_none() && !scene.explicit_time);
    // x'' = k b - a x; a' = -a; b' = a - x of (x, ., ., x', a, b).
    assert_eq!(
        scene.free_jacobian.entries,
        [(0, 0), (0, 4), (0, 5), (1, 4), (2, 0), (2, 4)]
    );
}

#[test]
fn smooth_powers_of_kinks_are_no_switches_and_each_other_one_is_a_contact() {
    let scene = described(
        "coordinates { x } lagrangian dot(x)^2/2 forces { x: -|dot(x)|*dot(x) - max(0, x - 1)^2 } horizon 1",
    );
    assert!(scene.contacts.is_empty());
    let scene = described(
        "coordinates { x } states { a } lagrangian dot(x)^2/2
         forces { x: -max(0, x) - sign(dot(x)) + step(t - 1) + sign(dot(x)) } rates { a: -sign(a) } horizon 1",
    );
    let switches: Vec<(&str, Option<Switching>)> = scene
        .contacts
        .iter()
        .map(|known| (known.name, known.switch))
        .collect();
    // Two signs that cancel are none.
    assert_eq!(
        switches,
        [
            ("max(0, x)", Some(Switching::Passes)),
            ("step(t - 1)", Some(Switching::Passes)),
            ("sign(a)", Some(Switching::Slides)),
        ]
    );
    assert!(scene.explicit_time);
}

#[test]
fn choices_are_formatted_in_one_line() {
    let text = "states{x,y}\nrates{x:if x>=0{3}else if x>=-1{2}else{1},y:(if x<1{x-y}else{-y})+sign( x )*2}\nhorizon 2";
    let wanted = "\
states { x, y }
rates {
    x: if x >= 0 { 3 } else if x >= -1 { 2 } else { 1 },
    y: (if x < 1 { x - y } else { -y }) + sign(x)*2,
}
horizon 2
";
    assert_eq!(crate::formatted(text), wanted);
}
