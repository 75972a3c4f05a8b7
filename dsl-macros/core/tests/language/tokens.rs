//! What an expansion makes of the tokens that it is given, beyond their text: invisible groups, and nothing else.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// A scene whose text holds `<<` and `>>` around what a macro hands over: there stands a group with these
/// delimiters.
fn scene(text: &str, delimiter: Delimiter) -> TokenStream {
    let text = text.replace("<<", "@ {").replace(">>", "}");
    grouped(text.parse().expect("tokens"), delimiter)
}

fn grouped(stream: TokenStream, delimiter: Delimiter) -> TokenStream {
    let mut tokens = TokenStream::new();
    let mut marked = false;
    for token in stream {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '@' => marked = true,
            TokenTree::Group(group) => {
                let inside = grouped(group.stream(), delimiter);
                let own = if marked { delimiter } else { group.delimiter() };
                marked = false;
                tokens.extend([TokenTree::Group(Group::new(own, inside))]);
            }
            token => tokens.extend([token]),
        }
    }
    tokens
}

fn expanded(tokens: TokenStream) -> Result<String, Vec<String>> {
    match hangtime_dsl::try_expand(tokens) {
        Ok(tokens) => Ok(tokens.to_string()),
        Err(mistakes) => Err(mistakes.iter().map(hangtime_dsl::Mistake::text).collect()),
    }
}

/// An expansion without the text of the scene in it, and that text.
fn split(expansion: &str) -> (String, String) {
    let (before, rest) = expansion
        .split_once("new (& __STRUCTURE , \"")
        .expect("a text");
    let (text, after) = rest.split_once("\") ;").expect("its end");
    (format!("{before}{after}"), text.to_owned())
}

/// Code is equal, and so is what the texts of the scene in it say when they are read again.
fn assert_same(one: &str, other: &str) {
    let (one, other) = (split(one), split(other));
    assert_eq!(one.0, other.0);
    let again = |text: &str| match hangtime_dsl::describe_text(text, "s") {
        Ok((description, _)) => description.kernels,
        Err(mistakes) => panic!("{text}: {mistakes:?}"),
    };
    assert_eq!(again(&one.1), again(&other.1), "{}", one.1);
}

#[test]
fn invisible_groups_in_expressions_bind_like_parentheses() {
    for lagrangian in [
        "dot(z)^2/2 - 3*<<k + 4>>*z",
        "dot(z)^2/2 - k*<<-5>>^2*z",
        "dot(z)^2/2 - z/<<k*7>>",
        "dot(z)^2/2 - <<k - <<2 - z>>>>",
        "dot(z)^2/2 - 2^<<1 + 2>>*k*z",
        "dot(z)^2/2 - k*((z, z) . <<(1, 2) + (3, 4)>>)",
        "dot(z)^2/2 - k*<<(z, 2*z) + (1, 0)>>.z",
        "dot(z)^2/2 - k*-<<z - 3>>",
        "dot(z)^2/2 - k*sin(<<z + 1>>*2)",
        "<<dot(z)^2/2 - k*z>>",
    ] {
        let text =
            format!("S {{ parameters {{ k = 2 }} coordinates {{ z }} lagrangian {lagrangian} }}");
        let visible = expanded(scene(&text, Delimiter::Parenthesis)).expect("accepted");
        let hidden = expanded(scene(&text, Delimiter::None)).expect("accepted");
        assert_same(&hidden, &visible);
    }
}

#[test]
fn invisible_groups_elsewhere_are_read_through() {
    let with = |text: &str| scene(text, Delimiter::None);
    let marked = "<<pub(crate)>> S { parameters { m: <<kg>> = 3, g: <<m/s^2>> = 9.81 } coordinates { z: m in \
                  <<0>>..=<<2*3>> } lagrangian m/2*dot(z)^2 - m*g*z surface <<ground>>: <<z >= 0.5 [m]>> impact ground: \
                  inelastic start { z: <<-2>> [m] } }";
    let plain = marked.replace("<<", " ").replace(">>", " ");
    // The start lies below the ground, which shows that its sign and unit were read.
    let mistakes = expanded(with(&plain));
    assert!(
        matches!(&mistakes, Err(texts) if texts.iter().any(|text| text.contains("-2"))),
        "{mistakes:?}"
    );
    assert_eq!(expanded(with(marked)), mistakes);
    let accepted = marked
        .replace("<<-2>>", "<<1 + 2>>")
        .replace(" [m] } }", " } }");
    let plain = accepted.replace("<<", " ").replace(">>", " ");
    let plain = expanded(with(&plain)).expect("accepted");
    assert_same(&expanded(with(&accepted)).expect("accepted"), &plain);
}

#[test]
fn group_that_begins_with_a_sign_is_no_second_operand() {
    let text = "S { coordinates { z } lagrangian dot(z)^2/2 - z <<-3>> }";
    assert_eq!(
        expanded(scene(text, Delimiter::None)),
        Err(vec![
            "an operator is missing before `...`; write a product as `z*...`".to_owned()
        ])
    );
}

/// A mechanism with all that makes the derivation try several forms.
const MECHANISM: &str = "/// Two links. \n pub Links { parameters { m: kg = 2, l: m = 0.7, g: m/s^2 = 9.81, mu = 0.2 } \
    coordinates { a: rad, b: rad } controls { u: N m in -3..=3 } let p = (l*sin(a), -l*cos(a)) let q = p + \
    (l*sin(b), -l*cos(b)) lagrangian m/2*|dot(p)|^2 + m/2*|dot(q)|^2 - m*g*(p.z + q.z) forces { a: u } surface floor: \
    q.z >= -1.5 [m] impact floor: inelastic, friction mu, sliding dot(q.y) minimize time + integral(u^2)/1 [J^2] \
    finally { a == 1 } start { a: 0.1 } }";

/// Set for the test below when it runs as another process.
const PRINTS: &str = "HANGTIME_PRINTS_EXPANSION";

#[test]
fn expansion_in_another_process_is_the_same() {
    let here = expanded(MECHANISM.parse().expect("tokens")).expect("accepted");
    if std::env::var_os(PRINTS).is_some() {
        println!("{here}");
        return;
    }
    assert!(here.contains("free_acceleration"));
    // After other scenes, and in another process with other random seeds of its tables.
    expanded(scene(
        "T { coordinates { z } lagrangian dot(z)^2 }",
        Delimiter::None,
    ))
    .expect("accepted");
    assert_eq!(
        expanded(MECHANISM.parse().expect("tokens")),
        Ok(here.clone())
    );
    let other = std::process::Command::new(std::env::current_exe().expect("this program"))
        .args([
            "--exact",
            "tokens::expansion_in_another_process_is_the_same",
            "--nocapture",
        ])
        .env(PRINTS, "1")
        .output()
        .expect("it runs again");
    let printed = String::from_utf8(other.stdout).expect("text");
    assert!(printed.lines().any(|line| line == here), "{printed}");
}
