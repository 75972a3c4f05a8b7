//! Where newcomers stumble: a table of mistakes, each with its code, its place, and what the message says to write.

use hangtime_dsl::{TextMistake, describe_text};

/// What is found in a text: mistakes, or else warnings.
fn found(text: &str) -> Vec<TextMistake> {
    match describe_text(text, "scene") {
        Ok((_, warnings)) => {
            assert!(warnings.iter().all(|found| found.warning), "{text}");
            warnings
        }
        Err(mistakes) => {
            assert!(mistakes.iter().any(|found| !found.warning), "{text}");
            mistakes
        }
    }
}

/// A point mass in a plane, a pendulum, and what is written into them.
fn scene(statements: &str) -> String {
    let pendulum = statements.contains("theta");
    let quantities = if pendulum {
        "parameters { m: kg = 1, l: m = 1, g: m/s^2 = 9.81 } coordinates { theta: rad }"
    } else {
        "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { y: m, z: m }"
    };
    let lagrangian = if pendulum {
        "lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos(theta)"
    } else {
        "lagrangian m/2*|dot((y, z))|^2 - m*g*z"
    };
    let own = |word: &str| statements.trim_start().starts_with(word);
    match (own("parameters"), statements.contains("lagrangian")) {
        (true, true) => statements.to_owned(),
        (true, false) => format!("{statements} {lagrangian}"),
        (false, true) => format!("{quantities} {statements}"),
        (false, false) => format!("{quantities} {lagrangian} {statements}"),
    }
}

/// What is wanted of one mistake: code (empty for plain syntax), place, and a part of the message.
type Answer<'a> = (&'a str, &'a str, &'a str);

/// Each text with its mistakes in order.
fn assert_answers(table: &[(&str, &[Answer<'_>])]) {
    for (statements, wanted) in table {
        let text = scene(statements);
        let found = found(&text);
        let shown: Vec<String> = found.iter().map(TextMistake::text).collect();
        assert_eq!(found.len(), wanted.len(), "{text}\n{shown:#?}");
        for (mistake, (code, place, remedy)) in found.iter().zip(*wanted) {
            assert_eq!(
                mistake.code.unwrap_or_default(),
                *code,
                "{text}\n{shown:#?}"
            );
            assert_eq!(&text[mistake.place.clone()], *place, "{text}\n{shown:#?}");
            assert!(
                mistake.message.contains(remedy),
                "{text}\n{shown:#?}\n{remedy}"
            );
        }
    }
}

#[test]
fn rates_and_functions_are_answered_by_what_to_write() {
    assert_answers(&[
        (
            "lagrangian m/2*y'^2 + m/2*z'^2",
            &[("", "y'", "`dot(y)`"), ("", "z'", "`dot(z)`")],
        ),
        (
            "fn h(a) = a lagrangian m/2*|dot((y, z))|^2 - m*g*z*h'(y)",
            &[("", "h'", "`diff(h)(...)`")],
        ),
        (
            "lagrangian m/2*y_dot^2 + m/2*zdot^2 - m*g*z",
            &[("E01", "y_dot", "`dot(y)`"), ("E01", "zdot", "`dot(z)`")],
        ),
        (
            "lagrangian m/2*y.dot^2 + m/2*dot(z)^2 - m*g*z",
            &[("E02", "y.dot", "`dot(y)`")],
        ),
        (
            "lagrangian m/2*y.dot()^2 + m/2*dot(z)^2 - m*g*z",
            &[("", "y.dot()", "write `dot(y)`")],
        ),
        (
            "lagrangian m/2*dot(y).powi(2) + m/2*dot(z).powf(2.0) - m*g*z",
            &[
                ("", "dot(y).powi(2)", "write `dot(y)^2`"),
                ("", "dot(z).powf(2.0)", "write `dot(z)^2.0`"),
            ],
        ),
        (
            "lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos theta",
            &[("", "cos", "`cos(theta)`")],
        ),
        (
            "lagrangian m/2*l^2*dot(theta)^2 + m*g*l*(theta/2).cos()",
            &[("", "(theta/2).cos()", "`cos(theta/2)`")],
        ),
        (
            "lagrangian m/2*l^2*dot(theta)^2 + m*g*l*cos 2*theta",
            &[("", "cos", "`cos(2*theta)`")],
        ),
    ]);
}

#[test]
fn numbers_are_answered_by_what_to_write() {
    assert_answers(&[
        (
            "parameters { m: kg = 1 kg, g = 9.81 m/s^2 } coordinates { y: m, z: m }",
            &[
                ("", "1 kg", "write `1 [kg]`"),
                ("", "9.81 m/s^2", "write `9.81 [m/s^2]`"),
            ],
        ),
        ("horizon 2 s", &[("", "2 s", "write `2 [s]`")]),
        ("horizon 2s", &[("", "2s", "write `2 [s]`")]),
        (
            "start { z: 2 m }",
            &[("", "m", "a unit as `2 [m]` and a product as `2*m`")],
        ),
        (
            "parameters { m: kg = 1, g: m/s^2 = 9,81 } coordinates { y: m, z: m }",
            &[("", "9,81", "write `9.81`")],
        ),
        (
            "horizon 1,5 [s] start { z: 0,5, y: 2 }",
            &[("", "1,5", "write `1.5`"), ("", "0,5", "write `0.5`")],
        ),
        (
            "lagrangian m/2*|dot((y, z))|^2 - m*9,81*z",
            &[("", "9,81", "write `9.81`")],
        ),
        (
            "lagrangian 2.0_f64*m/4*|dot((y, z))|^2 - m*g*z",
            &[("", "2.0_f64", "write `2.0`")],
        ),
        (
            "lagrangian m/2*|dot((y, z))|^2 - m*g*z*PI",
            &[("E01", "PI", "the number is `pi`")],
        ),
        (
            "lagrangian m/2*|dot((y, z))|^2 - m*g*z*std::f64::consts::PI",
            &[("", "std::f64::consts::PI", "write `pi`")],
        ),
    ]);
}

#[test]
fn missing_parts_are_answered_by_what_to_write() {
    let comma = |entry: &str| format!("a comma is missing before `{entry}`");
    let (y, z, velocity) = (comma("g"), comma("z"), comma("dot(z)"));
    assert_answers(&[
        (
            "parameters { m: kg = 1 g: m/s^2 = 9.81 } coordinates { y: m z: m }",
            &[("", "g", &y), ("", "z", &z)],
        ),
        ("start { y: 1 z: 2 }", &[("", "z", &z)]),
        ("start { y: 1 dot(z): 2 }", &[("", "dot", &velocity)]),
        ("finally { y == 1 [m] z == 2 [m] }", &[("", "z", &z)]),
        ("free { y z }", &[("", "z", &z)]),
        (
            "lagrangian m/2*|dot((y z))|^2 - m*g*z",
            &[("", "z", "components as `y, z`")],
        ),
        (
            "surface a: z >= 0 impact a: restitution",
            &[("", "restitution", "as in `restitution 0.5`")],
        ),
        (
            "surface a: z >= 0 impact a: restitution, friction 0.3",
            &[("", "restitution", "as in `restitution 0.5`")],
        ),
        (
            "surface a: z >= 0 impact a: restitution = 0.7",
            &[("", "=", "write `restitution 0.7`")],
        ),
    ]);
}

#[test]
fn habits_of_other_languages_are_answered_by_what_to_write() {
    assert_answers(&[
        (
            "lagrangian m/2*pow(dot(y), 2) + m/2*d(z)^2",
            &[("E01", "pow", "`x^2`"), ("E01", "d", "`dot(y)`")],
        ),
        (
            "lagrangian m/2*|dot((y, z))|^2 - mgz",
            &[("E01", "mgz", "write `m*g*z`")],
        ),
        (
            "lagrangian m/2|dot((y, z))|^2 - m*g*z",
            &[("", "|", "write a product as `m/2*|...|`")],
        ),
        (
            "lagrangian m/2*|dot((y, z))|^2 - m*g*z*sin^2(y/z)",
            &[("", "(", "write `sin(...)^2`")],
        ),
        (
            "parameters { m (kg) = 1, g [m/s^2] = 9.81 } coordinates { y: m, z: m }",
            &[
                ("", "(kg)", "write `m: kg`"),
                ("", "[m/s^2]", "write `g: m/s^2`"),
            ],
        ),
        (
            "controls { u: N = 0 in -1..=1 } forces { y: u }",
            &[("", "in", "bounds stand before the value")],
        ),
        (
            "# a comment that isn't one\nlet a = y'",
            &[("", "#", "write `//`"), ("", "y'", "`dot(y)`")],
        ),
        (
            "surface z >= 0",
            &[("", ">", "as in `surface ground: z >= 0`")],
        ),
    ]);
}

#[test]
fn surfaces_that_nothing_ever_touches_are_doubted() {
    let of = |gap: &str| format!("surface a: {gap} impact a: inelastic start {{ z: 1 [m] }}");
    let at_angle = |gap: &str| format!("surface a: {gap} impact a: inelastic");
    for (text, least) in [
        (at_angle("sin(theta) <= 2"), "nowhere less than 1;"),
        (of("y^2 + z^2 + 1 [m^2] >= 0"), "nowhere less than 1 m^2;"),
        (of("sqrt(y^2 + z^2) >= -0.25 [m]"), "0.25 m;"),
        (of("1/(1 + (y/1 [m])^2) <= 3"), "less than 2;"),
        (of("exp(-z/1 [m]) + tanh(y/1 [m]) >= -3"), "less than 2;"),
        (of("max(z, y^2/1 [m] + 2 [m]) >= 0"), "less than 2 m;"),
    ] {
        assert_answers(&[(&text, &[("E07", "a", least)])]);
    }
    // What can be touched at one place, or by one piece, is not.
    for gap in [
        "cos(y/1 [m]) <= 1",
        "exp(y/1 [m]) >= 0",
        "z^2/1 [m] + y >= -2 [m]",
        "min(z, y^2/1 [m] + 2 [m]) >= 0",
        "1/(y + 2 [m]) >= -1/1 [m]",
        "z >= 0.1*t*1 [m/s]",
    ] {
        assert_answers(&[(&of(gap), &[])]);
    }
}

#[test]
fn places_and_angles_are_doubted_where_they_are_written() {
    assert_answers(&[
        (
            "surface a: z >= 1 [m] impact a: inelastic start { y: 7, z: 0.25 }",
            &[("E08", "0.25", "gap of surface `a` is -0.75 m < 0")],
        ),
        (
            "surface a: z >= 1 [m] impact a: inelastic",
            &[("E08", "a", "write `start { z: ... }`")],
        ),
        (
            "constraint c: theta <= 30",
            &[("E23", "30", "write `30 [deg]`")],
        ),
        (
            "surface a: -90 <= theta impact a: inelastic",
            &[("E23", "-90", "write `-90 [deg]`")],
        ),
        ("start { theta: 45 }", &[("E23", "45", "write `45 [deg]`")]),
        (
            "constraint c: theta <= 30 [rad] start { theta: 45 [deg], dot(theta): 20 }",
            &[],
        ),
        ("constraint c: theta <= 2*pi", &[]),
        (
            "constraint c: sin(theta) <= sin(30)",
            &[("E23", "30", "the argument of `sin` is in rad")],
        ),
        ("constraint c: sin(theta) <= cos(30 [deg]) + sin(2)", &[]),
        ("let a = y", &[("E16", "a", "leave it out")]),
    ]);
}

#[test]
fn units_and_unused_names_hide_no_other_mistakes() {
    assert_answers(&[
        // Units that differ, an unused name, a start inside the ground.
        (
            "let a = y lagrangian m/2*|dot((y, z))|^2 - m*g surface f: z >= 1 [m] impact f: inelastic start { z: 0.5 }",
            &[
                ("E16", "a", "never used"),
                ("E03", "-", "`m*g` is in N"),
                ("E08", "0.5", "-0.5 m"),
            ],
        ),
        // A coordinate without inertia.
        (
            "lagrangian m/2*dot(y)^2 - m*g*y surface f: z >= 1 impact f: inelastic",
            &[("E05", "z", "kinetic energy"), ("E03", "z >= 1", "`1 [m]`")],
        ),
        // A negative kinetic energy, which shows in what is derived only.
        (
            "lagrangian m/2*dot(y)^2 - m/2*dot(z)^2 - m*g*z finally { y == 3 }",
            &[("E06", "z", "signs"), ("E03", "y == 3", "`3 [m]`")],
        ),
        // Two terms of one sum; the third one fits the first of them.
        (
            "lagrangian m/2*|dot((y, z))|^2 - m*g + m*z - m*g",
            &[
                ("E03", "-", "`m*g` is in N"),
                ("E03", "+", "`m*z` is in kg m"),
            ],
        ),
        // A name that is not declared hides no place.
        (
            "surface f: z >= 1 [m] impact f: inelastic forces { y: q } start { z: 0.5 }",
            &[("E01", "q", "not declared"), ("E08", "0.5", "-0.5 m")],
        ),
        // What could not be read is no start at zero.
        (
            "surface f: z >= 1 [m] impact f: inelastic start { z: 2 ~ }",
            &[("", "~", "expected `,` or `}`")],
        ),
    ]);
}
