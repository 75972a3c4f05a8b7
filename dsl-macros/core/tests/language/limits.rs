//! Declarations that are nested too deeply, or grow too large.

use super::mistakes_in as messages;

#[test]
fn deep_nesting_is_refused_without_exhausting_the_stack() {
    for open in ["(", "-", "sin(", "|"] {
        let close = match open {
            "|" => "|",
            "-" => "",
            _ => ")",
        };
        let source = format!(
            "S {{ coordinates {{ y }} lagrangian {}y{} }}",
            open.repeat(400),
            close.repeat(400)
        );
        let messages = messages(&source);
        assert!(
            messages
                .iter()
                .any(|text| text.contains("nested too deeply"))
                || open == "|" && !messages.is_empty(),
            "{open}: {messages:?}"
        );
    }
}

#[test]
fn long_chains_of_functions_are_refused_without_exhausting_the_stack() {
    let mut source = String::from("S { parameters { k: kg = 1 } coordinates { y } fn f0(x) = x ");
    for i in 1..2000 {
        source += &format!("fn f{i}(x) = f{}(x) ", i - 1);
    }
    source += "lagrangian k*dot(y)^2 forces { y: f1999(y) } }";
    assert!(
        messages(&source).contains(
            &"E22: the functions used here are nested too deeply; simplify them".to_owned()
        )
    );
}

#[test]
fn functions_that_use_each_other_twice_are_refused_in_reasonable_time() {
    // Evaluated for the start only, after the units have been looked at.
    let source = "S { parameters { k: 1/m = 1 } coordinates { y: m } fn f(x) = g(x) + g(2*x) \
                  fn g(x) = f(x) + f(x + 1) lagrangian k*dot(y)^2 start { y: f(k) } }";
    let messages = messages(source);
    assert!(
        messages
            .iter()
            .any(|text| text.starts_with("function `f` uses itself")),
        "{messages:?}"
    );
}

#[test]
fn functions_that_double_their_argument_are_refused_when_they_grow_too_large() {
    let mut source = String::from("S { coordinates { y } fn f0(x) = x + x^2 ");
    for i in 1..40 {
        source += &format!("fn f{i}(x) = f{}(x) + f{}(2*x) ", i - 1, i - 1);
    }
    source += "lagrangian f39(dot(y)) }";
    assert_eq!(
        messages(&source),
        ["E22: the declaration grows too large when its functions are inserted; simplify it"]
    );
}

/// Repeats a statement with its number in the place of `#` and the one before it in the place of `@`.
fn repeated(statement: &str, count: usize) -> String {
    let one = |i: usize| statement.replace('#', &i.to_string());
    (1..=count)
        .map(|i| one(i).replace('@', &(i - 1).to_string()))
        .collect()
}

#[test]
fn declarations_that_grow_with_each_line_are_refused() {
    for (begin, statement, count, end) in [
        (
            "fn f0(x) = cos(x) + x",
            " fn f#(x) = f@(f@(x))",
            14,
            "f14(z)",
        ),
        ("let a0 = z", " let a# = a@*a@ - 2*z", 400, "a400"),
        ("let r0 = rotation(z)", " let r# = r@*r@", 20, "r20[1][0]"),
    ] {
        let grown = repeated(statement, count);
        let source =
            format!("S {{ coordinates {{ z }} {begin}{grown} lagrangian dot(z)^2/2 + {end} }}");
        let found = messages(&source);
        assert!(
            found.len() == 1 && found[0].starts_with("E22: "),
            "{statement}: {found:?}"
        );
        // The same with few lines is a scene.
        let grown = repeated(statement, 3);
        let end = end.replace(&count.to_string(), "3");
        let source =
            format!("S {{ coordinates {{ z }} {begin}{grown} lagrangian dot(z)^2/2 + {end} }}");
        assert_eq!(messages(&source), ["accepted"], "{statement}");
    }
}

#[test]
fn long_sums_and_products_are_accepted() {
    let terms: Vec<String> = (1..=1200).map(|i| format!("{i}*sin({i}*z)")).collect();
    let factors = vec!["(z + 1)"; 1200].join("*");
    for value in [
        terms.join(" + "),
        terms.join(" - "),
        format!("({factors})/({factors})"),
    ] {
        let source = format!("S {{ coordinates {{ z }} lagrangian dot(z)^2/2 - {value} }}");
        assert_eq!(messages(&source), ["accepted"]);
    }
    // In a vector each step is one of its own.
    let vectors = vec!["(z, 2*z)"; 1000].join(" + ");
    let source = format!("S {{ coordinates {{ z }} lagrangian dot(z)^2/2 - ({vectors}).z }}");
    assert_eq!(messages(&source), ["accepted"]);
}
