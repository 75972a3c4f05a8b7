//! Pieces that several statements are made of: names, blocks, lists, ranges, targets.

use super::cursor::Cursor;
use super::expression::expression;
use super::slips;
use crate::ast::{Assignment, Expr, Name};
use crate::diagnostics::{Checked, Reported};
use crate::words;
use proc_macro2::{Delimiter, TokenTree};

/// A name that is no word of the language; `what` it names.
pub(super) fn name(cursor: &mut Cursor, what: &str) -> Checked<Name> {
    if cursor
        .ident()
        .is_some_and(|ident| words::is_keyword(&ident.to_string()))
    {
        return Err(cursor.said().report(
            "E11",
            cursor.place(),
            format!(
                "{} is a word of the language; choose another name",
                cursor.describe()
            ),
        ));
    }
    match cursor.eat_name() {
        Some(name) => Ok(name),
        None => Err(cursor.unexpected(what)),
    }
}

/// The name in front of a colon; `message` says how it is written.
pub(super) fn named(cursor: &mut Cursor, message: &str) -> Checked<Name> {
    let begin = cursor.place();
    let named = cursor.ident().is_some().then(|| name(cursor, "a name"));
    match named.transpose()?.filter(|_| cursor.eat_symbol(":")) {
        Some(name) => Ok(name),
        None => Err(cursor.said().syntax(begin, message)),
    }
}

/// What is said of a name; where that fails, the name is known all the same.
pub(super) fn said_of<T>(
    name: &Name,
    cursor: &mut Cursor,
    said: impl FnOnce(&mut Cursor) -> Checked<T>,
) -> Checked<T> {
    let said = said(cursor);
    if said.is_err() {
        cursor.said().poison(&name.text);
    }
    said
}

/// The sign `=`.
pub(super) fn equals(cursor: &mut Cursor) -> Checked<()> {
    if cursor.eat_symbol("=") {
        Ok(())
    } else {
        Err(cursor.unexpected("`=`"))
    }
}

/// The inside of the block behind a word.
pub(super) fn block(cursor: &mut Cursor, word: &Name) -> Checked<Cursor> {
    match cursor.eat_group(Delimiter::Brace) {
        Some(group) => Ok(cursor.inside(&group)),
        None => {
            let example = match cursor.ident() {
                Some(first) => format!(
                    "`{{` after `{0}`, as in `{0} {{ {first}: ... }}`",
                    word.text
                ),
                None => format!("`{{` after `{}`", word.text),
            };
            Err(cursor.unexpected(&example))
        }
    }
}

/// Entries between commas; a faulty entry is skipped, the others are kept.
pub(super) fn entries<T>(
    mut inner: Cursor,
    mut entry: impl FnMut(&mut Cursor) -> Checked<T>,
) -> Vec<T> {
    let mut found = Vec::new();
    while !inner.is_empty() {
        let result = entry(&mut inner);
        match result {
            Ok(item) => {
                found.push(item);
                if inner.ident().is_some() {
                    let message = format!("a comma is missing before {}", inner.describe());
                    inner.said().syntax(inner.place(), message);
                    continue;
                }
                if !inner.is_empty() && !inner.at_symbol(",") {
                    inner.unexpected("`,` or `}`");
                    inner.skip_until(|cursor| cursor.at_symbol(","));
                }
            }
            Err(Reported) => inner.skip_until(|cursor| cursor.at_symbol(",")),
        }
        inner.eat_symbol(",");
    }
    found
}

/// A target and its value behind a sign, `:` or `=`.
pub(super) fn assignment(cursor: &mut Cursor, sign: &str) -> Checked<Assignment> {
    let (target, velocity) = target(cursor)?;
    if !cursor.eat_symbol(sign) {
        let wanted = match (sign, velocity) {
            (":", _) => "`:`".to_owned(),
            (_, true) => format!("`{sign}`, as in `dot({}) {sign} 1`", target.text),
            (_, false) => format!("`{sign}`, as in `{} {sign} 1`", target.text),
        };
        return Err(cursor.unexpected(&wanted));
    }
    let value = expression(cursor)?;
    Ok(Assignment {
        target,
        velocity,
        value,
    })
}

/// A block of values behind colons.
pub(super) fn assignments(cursor: &mut Cursor, word: &Name) -> Checked<Vec<Assignment>> {
    let inner = block(cursor, word)?;
    Ok(entries(inner, |cursor| assignment(cursor, ":")))
}

/// Bounds of a quantity, if it has any.
pub(super) type Bounds = Option<(Expr, Expr)>;

/// `in lower..=upper`, if it stands there.
pub(super) fn range(cursor: &mut Cursor) -> Checked<Bounds> {
    if !cursor.eat_word("in") {
        return Ok(None);
    }
    if let Some(message) = slips::interval(cursor) {
        return Err(cursor.said().syntax(cursor.place(), message));
    }
    let lower = expression(cursor)?;
    if !cursor.eat_symbol("..=") {
        if cursor.at_symbol("..") {
            let message = format!(
                "the upper bound belongs to the range; write `{lower}..=` and the upper bound"
            );
            return Err(cursor.said().syntax(cursor.place(), message));
        }
        return Err(cursor.unexpected("`..=` between lower and upper bound"));
    }
    let upper = expression(cursor)?;
    Ok(Some((lower, upper)))
}

/// `name` or `dot(name)`; whether it is the latter.
pub(super) fn target(cursor: &mut Cursor) -> Checked<(Name, bool)> {
    let velocity = cursor.at_word("dot")
        && matches!(cursor.peek_at(1), Some(TokenTree::Group(group))
            if group.delimiter() == Delimiter::Parenthesis);
    if cursor.peek().is_some_and(is_parenthesis) {
        let message = "each entry is of one coordinate, not of a vector; write one for each, as in `y: ..., z: ...`";
        return Err(cursor.said().syntax(cursor.place(), message));
    }
    if !velocity {
        let target = name(cursor, "a coordinate")?;
        let own = &target.text;
        let (code, message) = if cursor.at_symbol(".") {
            (
                "E27",
                format!("`{own}` is no part in use; write `{own}: leg(..)` for that"),
            )
        } else if matches!(cursor.peek(), Some(TokenTree::Group(_))) {
            (
                "E26",
                format!(
                    "`{own}` is declared with no index; write `coordinates {{ {own}[n]: m }}` for that"
                ),
            )
        } else {
            return Ok((target, false));
        };
        return Err(cursor.said().report(code, cursor.place(), message));
    }
    cursor.advance();
    let group = cursor.eat_group(Delimiter::Parenthesis);
    let mut inner = group
        .as_ref()
        .map_or_else(|| cursor.clone(), |group| cursor.inside(group));
    let target = name(&mut inner, "a coordinate")?;
    if !inner.is_empty() {
        return Err(inner.unexpected("`)`"));
    }
    Ok((target, true))
}

fn is_parenthesis(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis)
}
