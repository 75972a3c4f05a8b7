//! What the language says: texts of messages, pages, slips that people make, malformed declarations.

/// Tests that texts are answered by these messages.
macro_rules! texts {
    ($($name:ident: $how:ident $source:expr => $($text:expr),+;)*) => {
        $(#[test]
        fn $name() {
            assert_eq!($how($source), vec![$($text),+]);
        })*
    };
}

/// Messages for a whole declaration, or "accepted".
fn mistakes_in(source: &str) -> Vec<String> {
    let tokens = source.parse().expect("the source is made of tokens");
    let mistakes = hangtime_dsl::mistakes(tokens);
    match mistakes.is_empty() {
        true => vec!["accepted".to_owned()],
        false => mistakes.iter().map(hangtime_dsl::Mistake::text).collect(),
    }
}

/// Messages for the text of a file, none if it is accepted.
fn mistakes_in_file(text: &str) -> Vec<String> {
    let mistakes = hangtime_dsl::describe_text(text, "s").err();
    let code = |code: Option<&str>| code.map_or(String::new(), |code| format!("{code}: "));
    let mistakes = mistakes.unwrap_or_default().into_iter();
    mistakes
        .map(|known| code(known.code) + &known.message)
        .collect()
}

mod advice;
mod bodies;
mod conditions;
mod described;
mod design;
mod format;
mod fuzz;
mod joints;
mod limits;
mod measured;
mod messages;
mod pages;
mod repetition;
mod sensitivities;
mod shown;
mod sizes;
mod slips;
mod states;
mod stumbles;
mod texts;
mod tokens;
