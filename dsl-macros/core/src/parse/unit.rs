//! Units: `kg m/s^2` after a colon or in brackets.

use super::cursor::Cursor;
use crate::ast::WrittenUnit;
use crate::diagnostics::{Checked, Diagnostics};
use hangtime_units::Unit;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// Reads unit tokens up to the end, `=`, `,` or the word `in`.
pub(super) fn declared(
    cursor: &mut Cursor,
    diagnostics: &mut Diagnostics,
) -> Checked<Option<WrittenUnit>> {
    let start = cursor.place();
    let mut text = String::new();
    let mut last = start;
    while let Some(token) = cursor.peek() {
        if cursor.at_symbol("=") || cursor.at_symbol(",") || cursor.at_word("in") {
            break;
        }
        append(&mut text, token);
        last = cursor.place();
        cursor.advance();
    }
    read(&text, diagnostics, start.to(last))
}

/// Reads the unit in brackets after a number.
pub(super) fn bracketed(
    group: &Group,
    diagnostics: &mut Diagnostics,
) -> Checked<Option<WrittenUnit>> {
    let cursor = Cursor::inside(group);
    let place = crate::diagnostics::Place::at(group.span_open());
    let mut text = String::new();
    let mut index = 0;
    while let Some(token) = cursor.peek_at(index) {
        append(&mut text, token);
        index += 1;
    }
    read(&text, diagnostics, place)
}

fn read(
    text: &str,
    diagnostics: &mut Diagnostics,
    place: crate::diagnostics::Place,
) -> Checked<Option<WrittenUnit>> {
    let text = text.trim();
    match text.parse::<Unit>() {
        Ok(_) if text.is_empty() => Err(diagnostics.syntax(
            place,
            "a unit is missing; write e.g. `m/s`, or `1` for none",
        )),
        Ok(unit) => Ok(Some(WrittenUnit {
            text: text.to_owned(),
            unit,
        })),
        Err(error) => Err(diagnostics.syntax(place, error.to_string())),
    }
}

/// Joins tokens as an author would write them: blanks between names only.
fn append(text: &mut String, token: &TokenTree) {
    match token {
        TokenTree::Group(group) => {
            if text.ends_with(char::is_alphanumeric) && group.delimiter() == Delimiter::Parenthesis
            {
                text.push(' ');
            }
            let (open, close) = match group.delimiter() {
                Delimiter::Parenthesis => ("(", ")"),
                Delimiter::Bracket => ("[", "]"),
                Delimiter::Brace => ("{", "}"),
                Delimiter::None => ("", ""),
            };
            text.push_str(open);
            text.push_str(&nested(group.stream()));
            text.push_str(close);
        }
        TokenTree::Punct(punct) => text.push(punct.as_char()),
        token => {
            if text.ends_with(char::is_alphanumeric) || text.ends_with(')') {
                text.push(' ');
            }
            text.push_str(&token.to_string());
        }
    }
}

fn nested(stream: TokenStream) -> String {
    // One level is enough for `J/(kg K)`; anything deeper is left to the compiler's own printing.
    let mut text = String::new();
    for token in stream {
        match token {
            TokenTree::Group(group) => text.push_str(&group.to_string()),
            token => append(&mut text, &token),
        }
    }
    text
}
