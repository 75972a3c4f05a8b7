//! What the language says: texts of messages, pages, slips that people make, malformed declarations.

use hangtime_dsl::TextMistake;
use hangtime_dsl::description::Description;

/// Tests that texts are answered by these messages.
macro_rules! texts {
    ($($name:ident: $how:ident $source:expr => $($text:expr),+;)*) => {
        $(#[test]
        fn $name() {
            assert_eq!($how($source), vec![$($text),+]);
        })*
    };
}

/// Tests that the texts of tables are answered as these say, in scenes.
macro_rules! answers {
    ($($name:ident: $scene:expr => $table:expr;)*) => {
        $(#[test]
        fn $name() {
            crate::assert_answers($scene, $table);
        })*
    };
}

/// Each text, a line that stands in a scene, with its mistakes in order, on indented lines: the code unless it is plain syntax, the place,
/// and behind `=>` parts of the message. The lines of a table begin at its ninth column.
fn assert_answers(scene: impl Fn(&str) -> String, table: &str) {
    let lines = table.lines().map(|line| line.get(8..).unwrap_or_default());
    let mut lines = lines
        .filter(|line| !line.is_empty() && !line.starts_with("//"))
        .peekable();
    while let Some(statements) = lines.next() {
        let text = scene(&statements.replace("\\n", "\n"));
        let found = mistakes_or_warnings(&text);
        let shown: Vec<String> = found.iter().map(TextMistake::text).collect();
        let mut wanted = Vec::new();
        while let Some(line) = lines.next_if(|line| line.starts_with(' ')) {
            let answer = line.trim().split_once(" => ");
            wanted.push(answer.expect("a place and a message"));
        }
        assert_eq!(found.len(), wanted.len(), "{text}\n{shown:#?}");
        for (mistake, (place, parts)) in found.iter().zip(wanted) {
            let code = mistake.code.map(|code| format!("{code} "));
            let found = code.unwrap_or_default() + &text[mistake.place.clone()];
            assert_eq!(found, place, "{text}\n{shown:#?}");
            for part in parts.split(" … ") {
                assert!(mistake.message.contains(part), "{text}\n{shown:#?}\n{part}");
            }
        }
    }
}

/// Mistakes of a text, or else its warnings.
fn mistakes_or_warnings(text: &str) -> Vec<TextMistake> {
    match hangtime_dsl::describe_text(text, "scene") {
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

/// What is derived of a text without mistakes, and its warnings.
fn derived(text: &str) -> (Description, Vec<TextMistake>) {
    let found = hangtime_dsl::describe_text(text, "scene");
    found.unwrap_or_else(|mistakes| panic!("{mistakes:?}\n{text}"))
}

/// What is derived of a text without mistakes and warnings.
fn described(text: &str) -> Description {
    let (description, warnings) = derived(text);
    assert!(warnings.is_empty(), "{warnings:?}\n{text}");
    description
}

/// A text in the settled style, which stays as it is.
fn formatted(text: &str) -> String {
    let format = |text: &str| hangtime_dsl::format_text(text, "s").expect("no mistakes");
    let formatted = format(text);
    assert_eq!(format(&formatted), formatted);
    formatted
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
mod states;
mod stumbles;
mod texts;
mod tokens;
