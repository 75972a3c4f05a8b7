//! Units: `kg m/s^2` after a colon or in brackets.

use super::cursor::Cursor;
use crate::ast::{Name, WrittenUnit};
use crate::diagnostics::{Checked, Place};
use crate::words;
use hangtime_units::Unit;
use proc_macro2::{Delimiter, Group, Spacing, TokenStream, TokenTree};

/// Most tokens of a unit without brackets.
const MOST: usize = 12;

/// Reads unit tokens up to the end, `=`, `,` or the word `in`.
pub(super) fn declared(cursor: &mut Cursor) -> Checked<Option<WrittenUnit>> {
    let start = cursor.place();
    let mut text = String::new();
    let mut last = start;
    while let Some(token) = cursor.peek() {
        if cursor.at_symbol("=") || cursor.at_symbol(",") || cursor.at_word("in") {
            break;
        }
        // The points of a profile.
        if matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace) {
            break;
        }
        // What was meant to be the file of a profile.
        if matches!(token, TokenTree::Literal(text) if text.to_string().starts_with('"')) {
            break;
        }
        // Behind a missing comma the next entry begins.
        if !text.is_empty() && is_named(cursor, 0) {
            break;
        }
        append(&mut text, token);
        last = cursor.place();
        cursor.advance();
    }
    read(cursor, &text, start.to(last))
}

/// Reads the unit in brackets after a number.
pub(super) fn bracketed(cursor: &Cursor, group: &Group) -> Checked<Option<WrittenUnit>> {
    let cursor = cursor.inside(group);
    let place = Place::at(group.span_open());
    let mut text = String::new();
    let mut index = 0;
    while let Some(token) = cursor.peek_at(index) {
        append(&mut text, token);
        index += 1;
    }
    read(&cursor, &text, place)
}

/// A unit in brackets behind the name of a quantity, which is reported and read.
pub(super) fn in_brackets(cursor: &mut Cursor, name: &Name) -> Option<WrittenUnit> {
    let place = cursor.place();
    let group = cursor
        .eat_group(Delimiter::Parenthesis)
        .or_else(|| cursor.eat_group(Delimiter::Bracket))?;
    let whole = place.to(cursor.previous());
    let unit = bracketed(cursor, &group).ok()??;
    let message = format!(
        "a unit stands behind a colon here; write `{}: {}`",
        name.text, unit.text
    );
    cursor.said().syntax(whole, message);
    Some(unit)
}

/// The longest unit that `begin` and the next tokens spell, and how many tokens that are. Products are left out, as
/// they are more likely ones of names.
pub(super) fn ahead(begin: &str, cursor: &Cursor) -> Option<(String, usize)> {
    let mut text = begin.to_owned();
    let mut found = None;
    for index in 0..=MOST {
        if !text.is_empty() && text.parse::<Unit>().is_ok() {
            found = Some((text.clone(), index));
        }
        match cursor.peek_at(index) {
            Some(TokenTree::Ident(word)) => {
                let word = word.to_string();
                if words::is_keyword(&word)
                    || word == "in"
                    || is_named(cursor, index)
                    || is_set(cursor, index)
                {
                    break;
                }
            }
            Some(TokenTree::Punct(punct)) if matches!(punct.as_char(), '/' | '^') => {}
            Some(TokenTree::Punct(punct)) if punct.as_char() == '-' && text.ends_with('^') => {}
            Some(TokenTree::Literal(_)) if text.ends_with(['^', '-']) => {}
            Some(TokenTree::Group(group))
                if group.delimiter() == Delimiter::Parenthesis && text.ends_with('/') => {}
            _ => break,
        }
        if let Some(token) = cursor.peek_at(index) {
            append(&mut text, token);
        }
    }
    found
}

/// Whether a name with a colon behind it, which begins an entry, stands `offset` tokens further.
fn is_named(cursor: &Cursor, offset: usize) -> bool {
    is_before(cursor, offset, ':')
}

/// Whether a name to which a value is given stands `offset` tokens further.
fn is_set(cursor: &Cursor, offset: usize) -> bool {
    is_before(cursor, offset, '=')
}

fn is_before(cursor: &Cursor, offset: usize, mark: char) -> bool {
    matches!(cursor.peek_at(offset), Some(TokenTree::Ident(_)))
        && matches!(cursor.peek_at(offset + 1), Some(TokenTree::Punct(punct))
            if punct.as_char() == mark && punct.spacing() == Spacing::Alone)
}

pub(super) fn read(cursor: &Cursor, text: &str, place: Place) -> Checked<Option<WrittenUnit>> {
    let text = text.trim();
    match text.parse::<Unit>() {
        Ok(_) if text.is_empty() => Err(cursor.said().syntax(
            place,
            "a unit is missing; write e.g. `m/s`, or `1` for none",
        )),
        Ok(unit) => Ok(Some(WrittenUnit {
            text: text.to_owned(),
            unit,
        })),
        Err(error) => Err(cursor.said().syntax(place, error.to_string())),
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
