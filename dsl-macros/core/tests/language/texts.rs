//! Declarations as texts of files.

use hangtime_dsl::{describe_text, expand, expand_text};

const BODY: &str = "parameters { m: kg = 1, g: m/s^2 = 9.81 } coordinates { z: m } // height
    lagrangian m/2*dot(z)^2 - m*g*z surface floor: z >= 0 impact floor: inelastic start { z: 1 }";

#[test]
fn text_with_and_without_a_header_is_the_declaration_of_the_macro() {
    let declared = format!("/// A ball.\n pub Ball {{ {BODY} }}");
    let wanted = expand(declared.parse().unwrap()).to_string();
    for text in [
        declared,
        format!("//! A ball.\n{BODY}"),
        format!("/// A ball.\n{BODY}"),
    ] {
        let expanded = expand_text(&text, "ball").map(|(tokens, _)| tokens.to_string());
        assert_eq!(expanded.ok().as_ref(), Some(&wanted), "{text}");
        let (described, warnings) = describe_text(&text, "ball").unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let declaration = described.structure.declaration;
        let written = (declaration.name, declaration.documentation);
        assert_eq!(written, ("Ball", "A ball."));
    }
}

#[test]
fn words_of_the_language_are_no_names_in_the_first_block_either() {
    let text = "parameters { dry: s = 1, at = 2, when = 3, free = 4, start = 5 } states { x } rates { x: -x*1[1/s] }
        horizon 1 [s]";
    let refused = |word| format!("E11: `{word}` is a word of the language; choose another name");
    let wanted = ["dry", "at", "when", "free", "start"].map(refused);
    assert_eq!(crate::mistakes_in_file(text), wanted);
}

#[test]
fn numbers_may_begin_with_their_point_and_units_have_fractional_powers() {
    let text = "parameters { k: N/m^1.5 = .5e3, c: m^3 s^-1 Pa^-0.5 = 20, p: Pa = 4 } coordinates { x: m } lagrangian dot(x)^2/2*1[kg]
        forces { x: -k*max(0 [m], x)^1.5 - .25 [N/m]*x } outputs { flow: m^3/s = c*sqrt(p) } horizon 1 [s]";
    let (derived, warnings) = describe_text(text, "s").expect("no mistakes");
    assert!(warnings.is_empty(), "{warnings:?}");
    let k = derived.structure.declaration.parameters[0];
    assert_eq!((k.unit, k.default), ("N/m^1.5", 500.0));
    let formatted = crate::formatted(text);
    assert!(formatted.contains("- .25[N/m]*x"), "{formatted}");
}

#[test]
fn mistakes_of_a_text_are_those_of_the_macro_with_their_place() {
    let text = format!(
        "\u{feff}//! \u{e4}\r\n{}",
        BODY.replace("dot(z)^2 -", "dot(zz)^2 -")
            .replace("start { z: 1 }", "")
    );
    let (stub, mistakes) = expand_text(&text, "ball").unwrap_err();
    let shown: Vec<(&str, &str)> = mistakes
        .iter()
        .map(|mistake| {
            (
                mistake.code.unwrap_or_default(),
                &text[mistake.place.clone()],
            )
        })
        .collect();
    assert_eq!(shown, [("E01", "zz")]);
    assert_eq!(Err(mistakes), describe_text(&text, "ball"));
    assert!(stub.to_string().contains("pub struct Ball"), "{stub}");
}

#[test]
fn text_that_is_no_declaration_is_answered_by_a_message() {
    let long = "// x\n".repeat(60_000);
    for (text, words) in [
        ("", "declares no coordinates"),
        ("Ball", "expected `{` after the name `Ball`"),
        (
            "model! { pub Ball { } }",
            "leave out `model!` and its braces",
        ),
        ("hangtime::model! { pub Ball { } }", "leave out `model!`"),
        ("pub Ball { } pub Other { }", "after the scene"),
        (
            "coordinates { y } lagrangian dot(y)^2/2 + 0x",
            "begins here",
        ),
        ("#![no_std]", "only doc comments may stand here"),
        (&long, "more than 262144"),
    ] {
        let mistakes = describe_text(text, "ball").unwrap_err();
        let shown: Vec<String> = mistakes
            .iter()
            .map(hangtime_dsl::TextMistake::text)
            .collect();
        assert!(
            shown.iter().any(|shown| shown.contains(words)),
            "{text}: {shown:?}"
        );
    }
}

#[test]
fn product_of_two_thousand_factors_is_derived_on_a_stack_of_a_megabyte() {
    // Where there are no threads of one's own the stack is that of the host, a megabyte in browsers.
    let factors = "cos(z/1[m])*".repeat(2000);
    let text = format!(
        "coordinates {{ z: m }} lagrangian 1[kg]/2*dot(z)^2 - 1[N]*z*({factors}1) start {{ z: 1 }} horizon 1[s]"
    );
    let derived = std::thread::Builder::new()
        .stack_size(1 << 20)
        .spawn(move || hangtime_dsl::describe_text(&text, "power").is_ok());
    assert!(derived.unwrap().join().unwrap());
}

/// What stands behind the first statement of a scene, for `BALL`.
fn with_ball(text: &str) -> String {
    let ball = "lagrangian dot(z)^2/2 surface floor: z >= 0 impact floor: inelastic start { z: 1 }";
    text.replace("BALL", ball)
}

answers! {
    misspelt_statement_at_the_begin_of_a_text_is_named_there_once: with_ball => r"
        coordnate x
            coordnate => `coordinates`
        Coordinate { z }
            Coordinate => `coordinates`
        coordnates { z } BALL
            coordnates => `coordinates`
        parmeters { m = 1 } coordinates { z } BALL
            parmeters => `parameters`
        bogus { m: kg = 1 } coordinates { z } BALL
            bogus => begins with `parameters`, `coordinates`
        coordinates { z } lagrangian dot(z)^2/2 surfce floor: z >= 0 impact floor: inelastic start { z: 1 }
            surfce => `surface`
        lagrangean dot(z)^2/2 coordinates { z }
            lagrangean => `lagrangian`
        fun hill(y) = y^2 coordinates { z } lagrangian dot(z)^2/2 - hill(z)
            fun => `fn`
        12 coordinates { z } lagrangian dot(z)^2/2
            12 => a statement such as
    ";
}
