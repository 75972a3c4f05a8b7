//! Numbers with the units behind them.

use super::cursor::Cursor;
use super::{slips, unit};
use crate::ast::Kind;
use crate::diagnostics::{Checked, Place};
use proc_macro2::{Delimiter, Literal, TokenTree};

/// A number of the tree, and where it stands.
pub(super) type Number = (Kind, Place);

/// The literal of a number that comes next, also of one that begins with its point.
pub(super) fn literal(cursor: &mut Cursor) -> Option<Literal> {
    let point = cursor.at_symbol(".");
    let Some(TokenTree::Literal(literal)) = cursor.peek_at(usize::from(point)) else {
        return None;
    };
    let mut literal = literal.clone();
    if point {
        let span = literal.span();
        literal = format!("0.{literal}").parse().ok()?;
        literal.set_span(span);
        cursor.advance();
    }
    cursor.advance();
    Some(literal)
}

/// A number that begins with this literal, with the unit behind it.
pub(super) fn number(cursor: &mut Cursor, literal: &Literal) -> Checked<Number> {
    let place = Place::at(literal.span());
    let text = literal.to_string();
    let digits = text.replace('_', "");
    let meant = match digits.parse::<f64>() {
        Ok(value) if value.is_infinite() => {
            let message = format!(
                "the number {text} is too large for double precision, which ends at 1.8e308"
            );
            return Err(cursor.said().report("E21", place, message));
        }
        Ok(value) if value < f64::MIN_POSITIVE && has_digits(&digits) => {
            let message = format!(
                "the number {text} is too small for double precision, which begins at 2.2e-308"
            );
            return Err(cursor.said().report("E21", place, message));
        }
        Ok(value) => {
            let meant = match cursor.at_invisible_group(0) {
                true => None,
                false => slips::unit_without_brackets(&text, "", cursor),
            };
            let Some(meant) = meant else {
                return with_unit(cursor, (value, text), place);
            };
            meant
        }
        Err(_) => slips::number(&digits, cursor)
            .map_err(|message| cursor.said().syntax(place, message))?,
    };
    for _ in 0..meant.unit.as_ref().map_or(0, |(_, tokens)| *tokens) {
        cursor.advance();
    }
    let whole = place.to(cursor.previous());
    let reported = cursor.said().syntax(whole, meant.message);
    let value = meant.number.parse().map_err(|_| reported)?;
    match meant.unit {
        None => with_unit(cursor, (value, meant.number), place),
        Some((unit, _)) => {
            let unit = unit::read(cursor, &unit, whole)?;
            let text = meant.number;
            Ok((Kind::Number { value, text, unit }, whole))
        }
    }
}

/// A number with the unit in brackets that may stand behind it.
pub(super) fn with_unit(
    cursor: &mut Cursor,
    (value, text): (f64, String),
    place: Place,
) -> Checked<Number> {
    let unit = match cursor.eat_group(Delimiter::Bracket) {
        Some(group) => unit::bracketed(cursor, &group)?,
        None => None,
    };
    let end = cursor.previous();
    Ok((Kind::Number { value, text, unit }, place.to(end)))
}

/// Whether a decimal number is written with a digit other than 0 before its exponent.
fn has_digits(text: &str) -> bool {
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
    mantissa.contains(|c| matches!(c, '1'..='9'))
}
