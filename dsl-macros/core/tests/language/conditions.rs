//! `when condition { ... }` and `start(...)`: what is accepted, and what each mistake says.

use crate::formatted;
use hangtime_dsl::{describe_held, describe_text};

/// Messages for the statements beside a mass on a line and a state, or "accepted".
fn messages(statements: &str) -> Vec<String> {
    let source = format!(
        "S {{ coordinates {{ x: m }} controls {{ u: N }} states {{ on }} lagrangian dot(x)^2/2*1 [kg]
         forces {{ x: u + on*1 [N] }} {statements} }}"
    );
    super::mistakes_in(&source)
}

/// Messages of the scene with a rate.
fn with_rate(statements: &str) -> Vec<String> {
    messages(&format!("rates {{ on: 0 }} {statements}"))
}

/// Messages of a problem of optimal control with a rate and a free place.
fn solved(statements: &str) -> Vec<String> {
    with_rate(&format!(
        "minimize integral(u^2) free {{ x }} horizon 1 [s] {statements}"
    ))
}

texts! {
    discrete_state_needs_no_rate: messages "when x >= 1 [m] { on = 1, dot(x) = -dot(x)/2 }" => "accepted";
    condition_that_is_an_equation: with_rate "when x == 1 [m] { on = 1 }" =>
        "`when` waits for a side to be passed; write `when x >= 1 [m] { ... }`, or `<=`";
    condition_that_stays: with_rate "when 2 >= 1 { on = 1 }" =>
        "E07: `2 >= 1` depends on nothing that changes, so that it never comes true; use coordinates, velocities, states or the time";
    condition_in_two_units: with_rate "when x >= 1 [s] { on = 1 }" =>
        "E03: units differ: `x` is in m, `1 [s]` is in s; both sides of a condition must agree";
    condition_on_a_control: with_rate "when u >= 1 [N] { on = 1 }" =>
        "E07: `u` depends on the control `u`, which may jump where the condition comes true; use what moves and the time";
    coordinate_that_is_set: with_rate "when x >= 1 [m] { x = 0 [m] }" =>
        "E04: `x` is a coordinate, and bodies do not jump; set its velocity, `dot(x) = ...`, or a state";
    velocity_in_another_unit: with_rate "when x >= 1 [m] { dot(x) = 1 [m] }" =>
        "E03: units differ: `1 [m]` is in m, where m/s is needed (`dot(x)` is set to it)";
    place_at_a_time: solved "at 0.5 [s] { x == 1 [m], dot(x) >= 0 }" => "accepted";
    place_at_a_time_that_is_found: solved "at gate in 0.2..=0.9 [s] { x == 1 [m] }" => "accepted";
    time_in_another_unit: solved "at 0.5 [m] { x == 1 [m] }" =>
        "E03: units differ: `0.5 [m]` is in m, where s is needed (conditions hold at a time)";
    place_at_a_time_in_another_unit: solved "at 0.5 [s] { x == 1 [s] }" =>
        "E03: units differ: `x` is in m, `1 [s]` is in s; both sides of a condition must agree";
    time_that_moves: solved "at x*1 [s/m] { x == 1 [m] }" =>
        "E15: `at x*1 [s/m]` depends on the coordinate `x`; a time is a number or follows from parameters, and one that is to be found is written `at gate in 0.5..=2 [s] { ... }`";
    time_before_the_motion: solved "at 0 [s] { x == 1 [m] }" =>
        "E17: `at 0 [s]` is at 0 s, where the motion has not begun; what holds at the start is written in `start`";
    time_after_the_motion: solved "at 1.5 [s] { x == 1 [m] }" =>
        "E17: `at 1.5 [s]` is at 1.5 s, and the motion ends at 1 s; what holds at its end is written in `finally`";
    control_at_a_time: solved "at 0.5 [s] { u <= 1 [N] }" =>
        "E07: `u` depends on the control `u`, which may jump where the condition comes true; use what moves and the time";
    condition_at_a_time_that_stays: solved "at 0.5 [s] { t <= 1 [s] }" =>
        "E15: `t <= 1 [s]` is the same for every motion, so it is no condition; use coordinates, velocities or states";
    time_that_is_found_without_a_name: solved "at 0.5 in 0.2..=0.9 [s] { x == 1 [m] }" =>
        "a time that is to be found has a name, as in `at gate in 0.2..=0.9 [s] { ... }`";
    nothing_at_a_time: solved "at 0.5 [s] { }" => "`at 0.5 [s]` asks for nothing; write what holds then, as in `at 0.5 [s] { x == 1 }`";
    values_at_times: with_rate "minimize integral(u^2)*1 [1/(N^2 s)] + at(0.5 [s], x)^2*1 [1/m^2] + at(0.5 [s], on) horizon 1 [s]" => "accepted";
    condition_between_times: solved "finally { at(0.5 [s], dot(x)) == 2*at(0.25 [s], dot(x)), x >= at(0.25 [s], x + 1 [m]) }" => "accepted";
    condition_at_a_time_on_another_one: solved "at 0.5 [s] { x == 2*at(0.25 [s], x) }" => "accepted";
    value_at_a_time_that_is_found: solved "at gate in 0.2..=0.9 [s] { x == 1 [m] } finally { at(gate, dot(x)) >= 1 [m/s] }" => "accepted";
    condition_on_a_time_after_it: solved "at 0.5 [s] { x == 2*at(0.75 [s], x) }" =>
        "E17: `at(0.75 [s], x)` is not known at 0.5 s, where `at 0.5 [s]` reads it; a condition between times is written in `finally`, as in \
         `finally { at(2 [s], x) == 2*at(1 [s], x) }`";
    value_at_a_time_in_another_unit: solved "finally { at(0.5 [s], x) == 2 [m/s] }" =>
        "E03: units differ: `at(0.5 [s], x)` is in m, `2 [m/s]` is in m/s; both sides of a terminal condition must agree";
    value_at_no_time: solved "finally { at(0.5 [m], x) == 2 [m] }" =>
        "E03: units differ: `0.5 [m]` is in m, where s is needed (conditions hold at a time)";
    value_at_a_time_after_the_end: solved "finally { at(2 [s], x) == 2 [m] }" =>
        "E17: `at 2 [s]` is at 2 s, and the motion ends at 1 s; what holds at its end is written in `finally`";
    value_of_a_control_at_a_time: solved "finally { at(0.5 [s], u) == 2 [N] }" =>
        "E07: `u` depends on the control `u`, which may jump where the condition comes true; use what moves and the time";
    value_at_a_time_in_a_force: with_rate "forces { x: at(0.5 [s], x)*1 [N/m] }" =>
        "E15: `at(time, value)` is known to `minimize`, `finally` and `at` only, which judge a motion as a whole; elsewhere a state that \
         `when t >= 1 [s] { ... }` sets says the same";
    value_at_a_time_in_a_peak: solved "finally { peak(x - at(0.5 [s], x)) <= 2 [m] }" =>
        "E15: `at(0.5 [s], x)` is one number of the motion, and stands inside of `peak`, which asks for all of the motion, also before that \
         time; write it outside";
    value_at_a_time_of_another: solved "finally { at(0.5 [s], at(0.2 [s], x)) <= 2 [m] }" =>
        "E15: `at(0.2 [s], x)` is one number of the motion, and stands inside of another `at`; write one value for each time";
    value_at_a_time_of_nothing: solved "finally { at(0.5 [s]) <= 2 [m] }" =>
        "E02: `at` takes 2 arguments, a time and what is asked for then, as in `at(1 [s], x)`; found 1";
    state_that_is_set_twice: with_rate "when x >= 1 [m] { on = 1, on = 0 }" => "`on` is set twice at once; keep one";
    condition_that_sets_nothing: with_rate "when x >= 1 [m] { }" =>
        "`when x >= 1 [m]` sets nothing; write what it sets, as in `{ on = 1 }`";
    what_is_set_is_written_with_an_equals_sign: with_rate "when x >= 1 [m] { on: 1 }" =>
        "expected `=`, as in `on = 1`, found `:`";

    start_in_objective_and_conditions: solved
        "constraint far: x - start(x) <= 3 [m] finally { dot(x) == -start(dot(x)) + 1 [m/s], 2*x == start(2*x) } free { dot(x), on }" =>
        "accepted";
    start_in_a_force: with_rate "forces { x: start(x)*1 [N/m] }" =>
        "E15: `start(x)` is known to `minimize`, `constraint` and `finally` only, which judge a motion as a whole; elsewhere a parameter \
         that `start` names says the same";
    start_of_a_control: solved "finally { x == start(u)*1 [m/N] }" =>
        "E15: `start(u)` contains a control, which acts over a time; `start` takes coordinates, velocities, states and what follows from \
         them";
    start_of_a_start: solved "finally { x == start(start(x)) }" =>
        "E15: `start(start(x))` contains a value at the start already; `start` takes coordinates, velocities, states and what follows \
         from them";
    start_of_two: solved "finally { x == start(x, x) }" => "E02: `start` takes 1 argument, found 2";
    start_in_another_unit: solved "finally { x == start(dot(x)) } free { dot(x) }" =>
        "E03: units differ: `x` is in m, `start(dot(x))` is in m/s; both sides of a terminal condition must agree";
    start_that_nobody_freed: solved "finally { dot(x) == start(dot(x)) }" =>
        "E15: `start(dot(x))` is the value that `start` gives, as `dot(x)` is not free there; write `free { dot(x) }` if it is to be \
         found, or the value itself";
    start_of_a_state_that_nobody_freed: solved "finally { on == start(on) + 1 }" =>
        "E15: `start(on)` is the value that `start` gives, as `on` is not free there; write `free { on }` if it is to be found, or the \
         value itself";
    conditions_on_a_given_start: solved "finally { start(dot(x)) == 1 [m/s] }" =>
        "E15: `start(dot(x))` is the value that `start` gives, as `dot(x)` is not free there; write `free { dot(x) }` if it is to be \
         found, or the value itself",
        "E15: `start(dot(x)) == 1 [m/s]` is the same for every motion, as nothing in it is free at the start; list what is to be found \
         in `free { ... }`";
}

#[test]
fn start_that_is_free_is_a_coordinate_that_decides_it_and_nothing_where_it_is_not_read() {
    let text = |goal: &str| {
        format!(
            "coordinates {{ x: cm, y: m }} states {{ a: A }} controls {{ u: N }} lagrangian (dot(x)^2 + dot(y)^2)/2*1 [kg]
             forces {{ x: u }} rates {{ a: dot(y)*1 [A/m] }} free {{ x in 0..=5, dot(x), a in 1..=2 }} start {{ x: 3, a: 1 }}
             minimize integral(u^2) finally {{ {goal} }} horizon 1 [s]"
        )
    };
    let read = text("dot(x) == start(dot(x)), a == start(a)");
    let (plain, _) = describe_text(&read, "s").expect("no mistakes");
    // (q, v) with a place for the integral of the state: dot(x) is 3, the state 5.
    assert_eq!(
        (
            plain.structure.remembered,
            plain.structure.declaration.coordinates.len()
        ),
        (&[3, 5][..], 3)
    );
    let (held, _) = describe_held(&read, "s", &[]).expect("no mistakes");
    let known = held.structure.held.expect("held").declared;
    assert_eq!(known.starts, [3, 5]);
    let coordinates = &held.structure.declaration.coordinates[3..];
    let names: Vec<&str> = coordinates.iter().map(|c| c.name).collect();
    assert_eq!(names, ["start(dot(x))", "start(a)"]);
    let units: Vec<&str> = coordinates.iter().map(|c| c.unit).collect();
    assert_eq!(units, ["cm/s", "A"]);
    use hangtime_dsl::declaration::Given;
    // Among (q, v) with five coordinates.
    assert_eq!(known.given, [Given::Start(5), Given::Start(7)]);
    assert_eq!(known.jacobian.entries, [(0, 3), (1, 4)]);
    let task = held.structure.declaration.optimal_control;
    let task = task.expect("declared");
    assert_eq!(task.free_start, [0, 3, 4]);
    let (unread, _) = describe_text(&text("dot(x) == 0 [m/s]"), "s").expect("no mistakes");
    assert!(unread.structure.remembered.is_empty());
    let (unheld, _) = describe_held(&text("dot(x) == 0 [m/s]"), "s", &[]).expect("no mistakes");
    assert!(unheld.structure.held.is_none() && unheld == unread);
}

#[test]
fn largest_values_are_unknowns_of_what_is_solved_and_values_of_what_is_described() {
    use hangtime_dsl::declaration::Over;
    let text = "coordinates { x: m } controls { u: N } lagrangian dot(x)^2/2*1 [kg] forces { x: u } horizon 1 [s]
        minimize integral(|u|) + peak(max(x, 2*x))*1 [N s/m] + |x - 1 [m]|*1 [N s/m]";
    let (plain, _) = describe_text(text, "s").expect("no mistakes");
    let declaration = plain.structure.declaration;
    let sizes = (declaration.coordinates.len(), declaration.controls.len());
    assert_eq!(sizes, (1, 1));
    let known: Vec<(&str, Over, usize)> = plain
        .structure
        .epigraphs
        .iter()
        .map(|known| (known.name, known.over, known.rows))
        .collect();
    assert_eq!(
        known,
        [
            ("|u|", Over::Instants, 2),
            ("peak(max(x, 2*x))", Over::Motion, 2),
            ("|x - 1 [m]|*1 [N s/m]", Over::End, 2)
        ]
    );
    let task = declaration.optimal_control.expect("a task");
    assert_eq!((task.constraints.len(), task.goals.len()), (0, 0));
    let (held, _) = describe_held(text, "s", &[]).expect("no mistakes");
    let declaration = held.structure.declaration;
    let sizes = (declaration.coordinates.len(), declaration.controls.len());
    assert_eq!(sizes, (3, 2));
    let known = held.structure.held.expect("unknowns").declared;
    assert_eq!((known.largest, known.at_stages), (2, &[2][..]));
    let task = declaration.optimal_control.expect("a task");
    // Over the motion and at each instant; at the end, and of the peak at the start.
    assert_eq!((task.constraints.len(), task.goals.len()), (2 + 2, 2 + 2));
    // What has none is as before.
    let (plain, _) = describe_held(
        &text
            .replace("|u|", "u^2/1 [N]")
            .replace("peak(max(x, 2*x))", "x")
            .replace("|x - 1 [m]|", "x"),
        "s",
        &[],
    )
    .expect("no mistakes");
    assert!(plain.structure.held.is_none() && plain.structure.epigraphs.is_empty());
}

#[test]
fn conditions_are_formatted_like_the_statements_around_them() {
    let text = "states{x,on}\nrates{x:1 [1/s]+on / 3 [s]}\nwhen  x>=1{on=1}// once\nwhen x<=0 { on=0,x=  x+1}\n";
    assert_eq!(
        formatted(text),
        "states { x, on }\nrates { x: 1 [1/s] + on/3[s] }\nwhen x >= 1 { on = 1 } // once\nwhen x <= 0 { on = 0, x = x + 1 }\n"
    );
    let text = "coordinates { x: m }\nlagrangian dot(x)^2/2*1 [kg]\nminimize peak( x )\nat  gate in 0.5..=2 [s]{x==1 [m],// here\ndot(x)>=0}\nhorizon 3 [s]\n";
    assert_eq!(
        formatted(text),
        "coordinates { x: m }\nlagrangian dot(x)^2/2*1[kg]\nminimize peak(x)\nat gate in 0.5..=2 [s] {\n    x == 1 [m], // here\n    dot(x) >= 0,\n}\nhorizon 3 [s]\n"
    );
    let text = "coordinates { x: m }\nlagrangian dot(x)^2/2*1 [kg]\nfree { x }\nminimize (x -start( x ) )^2\nfinally { x==-start(x) + 1 [m] }\n";
    assert_eq!(
        formatted(text),
        "coordinates { x: m }\nlagrangian dot(x)^2/2*1[kg]\nfree { x }\nminimize (x - start(x))^2\nfinally { x == -start(x) + 1 [m] }\n"
    );
    let text = "coordinates { x: m }\nlagrangian dot(x)^2/2*1 [kg]\nminimize  at( 0.5 [s],x )^2\nat (1 [s]) {x==at(0.5 [s],x)}\nhorizon 3 [s]\n";
    assert_eq!(
        formatted(text),
        "coordinates { x: m }\nlagrangian dot(x)^2/2*1[kg]\nminimize at(0.5 [s], x)^2\nat(1 [s]) { x == at(0.5 [s], x) }\nhorizon 3 [s]\n"
    );
}

#[test]
fn value_at_a_time_is_a_state_and_its_time_another_one_unless_a_condition_has_it() {
    let states = |judged: &str| {
        let text = format!(
            "coordinates {{ x: m }} controls {{ u: N }} lagrangian dot(x)^2/2*1 [kg] forces {{ x: u }} horizon 3 [s] minimize integral(u^2) {judged}"
        );
        let (plain, _) = describe_text(&text, "s").expect("no mistakes");
        let states = plain.structure.declaration.states.iter();
        states.map(|state| state.name).collect::<Vec<&str>>()
    };
    assert!(states("finally { x == 1 [m] }").is_empty());
    assert_eq!(
        states(
            "finally { x == 2*at(1 [s], x) + at(1 [s], x)^2/1 [m], at(1 [s], dot(x)) >= 0 [m/s] }"
        ),
        ["t >= 1 [s]", "at(1 [s], x)", "at(1 [s], dot(x))"]
    );
    assert_eq!(
        states("at 1 [s] { dot(x) >= 0 [m/s] } finally { x == 2*at(1 [s], x) }"),
        ["dot(x) >= 0 [m/s] at 1 [s]", "at(1 [s], x)"]
    );
}
