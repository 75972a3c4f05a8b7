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

mod advice;
mod conditions;
mod design;
mod format;
mod fuzz;
mod joints;
mod measured;
mod messages;
mod pages;
mod sensitivities;
mod shown;
mod slips;
mod states;
mod stumbles;
mod texts;
mod tokens;
