//! What is meant by common slips, and what to write instead.

use super::cursor::Cursor;
use super::unit;
use crate::ast::{Expr, Kind};
use crate::diagnostics::{Checked, closest};
use crate::words;
use proc_macro2::{Delimiter, Spacing, TokenTree};

/// The types of numbers in Rust that a suffix may name.
const TYPES: [&str; 7] = ["f64", "f32", "i32", "u32", "usize", "i64", "u64"];

/// A number as it was meant, with its unit and how many tokens that takes; and the message.
pub(super) struct Meant {
    pub(super) number: String,
    pub(super) unit: Option<(String, usize)>,
    pub(super) message: String,
}

/// A unit without brackets behind a number, if what stands there is no name of the scene.
pub(super) fn unit_without_brackets(number: &str, suffix: &str, cursor: &Cursor) -> Option<Meant> {
    if suffix.is_empty() {
        cursor.ident()?;
    }
    let (unit, tokens) = unit::ahead(suffix, cursor)?;
    let words = unit.split(|c: char| !c.is_alphabetic());
    let mut words = words.filter(|word| !word.is_empty());
    if words.all(|word| cursor.said().is_declared(word)) {
        return None;
    }
    Some(Meant {
        number: number.to_owned(),
        message: format!("a unit stands in brackets; write `{number} [{unit}]`"),
        unit: Some((unit, tokens)),
    })
}

/// What was meant by a literal that is no decimal number, or the message alone.
pub(super) fn number(text: &str, cursor: &Cursor) -> Result<Meant, String> {
    let end = text
        .find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E'))
        .unwrap_or(text.len());
    let (number, suffix) = text.split_at(end);
    if !text.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(format!(
            "{text} is not a number; expressions are made of numbers and names"
        ));
    }
    if number.parse::<f64>().is_err() || suffix.is_empty() {
        return Err(format!("`{text}` is not a decimal number"));
    }
    if TYPES.contains(&suffix) {
        return Ok(Meant {
            number: number.to_owned(),
            unit: None,
            message: format!(
                "`{number}` carries the type `{suffix}` of Rust; numbers here have no type, write `{number}`"
            ),
        });
    }
    if let Some(meant) = unit_without_brackets(number, suffix, cursor) {
        return Ok(meant);
    }
    let is_unit = suffix.parse::<hangtime_units::Unit>().is_ok();
    Err(match cursor.said().is_declared(suffix) {
        true if is_unit => format!(
            "`{text}` is not a number; write a unit as `{number} [{suffix}]` and a product as `{number}*{suffix}`"
        ),
        _ => format!("`{text}` is not a number; write a product as `{number}*{suffix}`"),
    })
}

/// What is said where `right` stands at the cursor, behind an expression without an operator.
fn juxtaposed(cursor: &Cursor, left: &Expr, right: &str, list: bool) -> String {
    if is_equation_of_motion(cursor) {
        EQUATIONS_FOLLOW.to_owned()
    } else {
        missing_operator(left, right, list)
    }
}

/// The remedy where `right` stands behind an expression without an operator; `list` tells whether a comma may be meant.
fn missing_operator(left: &Expr, right: &str, list: bool) -> String {
    // The last term is what the missing operator would multiply.
    let last = match &left.kind {
        Kind::Chain(_, rest) if rest[0].operator.is_additive() => {
            rest.last().map_or(left, |link| &link.operand)
        }
        _ => left,
    };
    let factor = match &last.kind {
        Kind::Chain(_, rest) => rest.last().map_or(last, |link| &link.operand),
        _ => last,
    };
    if let Kind::Number {
        text, unit: None, ..
    } = &factor.kind
        && right.parse::<hangtime_units::Unit>().is_ok()
    {
        return format!(
            "an operator is missing before `{right}`; write a unit as `{text} [{right}]` and a product as \
             `{text}*{right}`"
        );
    }
    if matches!(&factor.kind, Kind::Name(name) if name.text == words::INTEGRAL) {
        return format!(
            "what is integrated stands in parentheses; write `integral({right})`, with all of it between them"
        );
    }
    if let Kind::Power { base, exponent, .. } = &factor.kind
        && let Kind::Name(function) = &base.kind
        && words::is_function(&function.text)
    {
        let (function, argument) = (&function.text, right.trim_matches(['(', ')']));
        return format!(
            "the power of a function stands behind its argument; write `{function}({argument})^{exponent}`"
        );
    }
    let shown = match last.to_string() {
        long if long.chars().count() > 24 => "...".to_owned(),
        short => short,
    };
    if right == words::DRY_PARTS[0] {
        format!("a comma is missing before `{right}`; a product is written `{shown}*{right}`")
    } else if list {
        format!(
            "an operator or a comma is missing before `{right}`; write a product as `{shown}*{right}`, components as \
             `{shown}, {right}`"
        )
    } else {
        format!("an operator is missing before `{right}`; write a product as `{shown}*{right}`")
    }
}

/// What begins another entry of a list here, such as `z:` or `dot(z):`; behind a comparison also `z ==`.
fn next_entry(cursor: &Cursor, compared: bool) -> Option<String> {
    let mut ahead = cursor.clone();
    let mut shown = ahead.eat_name()?.text;
    if let Some(group) = ahead.eat_group(Delimiter::Parenthesis) {
        shown += &group.to_string();
    }
    let begins = match ahead.peek() {
        Some(TokenTree::Punct(punct)) => match punct.as_char() {
            ':' => !ahead.at_symbol("::"),
            '=' if punct.spacing() == Spacing::Alone => true,
            '=' | '<' | '>' => compared,
            _ => false,
        },
        _ => false,
    };
    begins.then_some(shown)
}

/// What an apostrophe behind an expression means.
fn apostrophe(left: &Expr) -> String {
    let mut factor = left;
    loop {
        factor = match &factor.kind {
            Kind::Chain(_, rest) => match rest.last() {
                Some(link) => &link.operand,
                None => break,
            },
            Kind::Negate(inner) => inner,
            _ => break,
        };
    }
    let name = match &factor.kind {
        Kind::Name(name) => name.text.as_str(),
        _ => "y",
    };
    format!(
        "an apostrophe is no operator here, as it is a token of another kind in Rust; write `dot({name})` for the rate of \
         `{name}`; the derivative of a function is `diff(f)(y)`"
    )
}

/// Whether what stands here is the argument of a function that was written without parentheses.
pub(super) fn is_argument(cursor: &Cursor) -> bool {
    match cursor.peek() {
        Some(TokenTree::Ident(ident)) => {
            let text = ident.to_string();
            !words::is_keyword(&text) && text != "in" && next_entry(cursor, false).is_none()
        }
        Some(TokenTree::Literal(literal)) => literal
            .to_string()
            .starts_with(|c: char| c.is_ascii_digit()),
        _ => false,
    }
}

/// What a statement that is misspelt declares, `offset` tokens further, is known by name, so that its uses give no messages.
pub(super) fn expect_name_of(statement: &str, cursor: &Cursor, offset: usize) {
    let names_something = ["let", "fn", "profile", "surface"].contains(&statement);
    if let Some(TokenTree::Ident(name)) = cursor.peek_at(offset).filter(|_| names_something) {
        cursor.said().poison(&name.to_string());
    }
}

/// What is written in place of bounds in brackets, `in [lower, upper]`.
pub(super) fn interval(cursor: &Cursor) -> Option<String> {
    let mut ahead = cursor.clone();
    let group = ahead
        .eat_group(Delimiter::Bracket)
        .or_else(|| ahead.eat_group(Delimiter::Parenthesis))
        .filter(|_| ahead.is_empty() || ahead.at_symbol(",") || ahead.at_symbol("="))?;
    let inside = group.stream().to_string();
    let (lower, upper) = inside.split_once([',', ';'])?;
    let [lower, upper] = [lower, upper].map(|bound| bound.trim().replace("- ", "-"));
    if lower.is_empty() || upper.is_empty() || upper.contains(',') {
        return None;
    }
    Some(format!(
        "bounds are written with dots between them, as in `in {lower}..={upper}`"
    ))
}

/// Most tokens of an equation that are looked at.
const LOOKED_AT: usize = 60;

/// Whether an equation of motion stands here, with an acceleration and an equals sign before the next statement.
pub(super) fn is_equation_of_motion(cursor: &Cursor) -> bool {
    let mut ahead = cursor.clone();
    let (mut accelerates, mut equals) = (false, false);
    for _ in 0..LOOKED_AT {
        match ahead.peek() {
            Some(TokenTree::Ident(word)) if words::is_keyword(&word.to_string()) => break,
            Some(TokenTree::Ident(word)) => {
                accelerates |= ["ddot", "acc"].contains(&word.to_string().as_str())
            }
            Some(TokenTree::Punct(punct)) => equals |= punct.as_char() == '=',
            Some(_) => {}
            None => break,
        }
        ahead.advance();
    }
    accelerates && equals
}

/// What is written in place of equations of motion.
pub(super) const EQUATIONS_FOLLOW: &str = "equations of motion are not written, they follow from the `lagrangian`, which is \
     kinetic minus potential energy; what acts besides stands in `forces { x: ... }`";

/// Two factors without an operator between them: whether the expression `left` ends at the cursor, which may stand before words of a
/// picture if it is `pictured`. `list` tells whether a comma may be meant, `compared` whether a comparison stands on the left.
pub(super) fn no_factor(
    cursor: &Cursor,
    (left, list): (&Expr, bool),
    (compared, pictured): (bool, bool),
) -> Checked<()> {
    let right = match cursor.peek() {
        _ if cursor.at_invisible_group(0) => "...".to_owned(),
        _ if cursor.at_symbol("|") => "|...|".to_owned(),
        Some(TokenTree::Punct(punct)) if punct.as_char() == '\'' => {
            return Err(cursor.said().syntax(cursor.place(), apostrophe(left)));
        }
        Some(TokenTree::Literal(literal)) if literal.to_string().starts_with('\'') => {
            return Err(cursor.said().syntax(cursor.place(), apostrophe(left)));
        }
        Some(TokenTree::Ident(ident)) => {
            let text = ident.to_string();
            if words::is_keyword(&text) || text == "in" || pictured && words::is_of_picture(&text) {
                return Ok(());
            }
            if let Some(entry) = next_entry(cursor, compared) {
                cursor.said().poison(&text);
                let message = format!("a comma is missing before `{entry}`");
                return Err(cursor.said().syntax(cursor.place(), message));
            }
            match cursor.peek_at(1) {
                // A name with a block behind it was meant to begin a statement.
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                    return Ok(());
                }
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => {
                    format!("{text}(...)")
                }
                _ => {
                    let near = closest(&text, words::STATEMENTS);
                    if let Some(message) = words::unknown_statement(&text, near) {
                        if let Some(statement) = near {
                            expect_name_of(statement, cursor, 1);
                        }
                        return Err(cursor.said().syntax(cursor.place(), message));
                    }
                    text
                }
            }
        }
        Some(TokenTree::Literal(literal)) => literal.to_string(),
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis => {
            "(...)".to_owned()
        }
        _ => return Ok(()),
    };
    let message = juxtaposed(cursor, left, &right, list);
    Err(cursor.said().syntax(cursor.place(), message))
}
