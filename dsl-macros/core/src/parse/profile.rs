//! Functions given by points: `profile name(argument: unit): unit { (0, 0), (1, 0.2), ... }`.

use super::cursor::Cursor;
use super::expression::expression;
use super::pieces::{entries, name, said_of};
use super::unit;
use crate::ast::{Expr, Kind, Name, Statement, WrittenUnit};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::graph::Profile;
use proc_macro2::{Delimiter, TokenTree};

/// Fewest and most points of a profile.
const FEWEST: usize = 3;
const MOST: usize = 5_000;

/// What a profile looks like, for messages.
const EXAMPLE: &str = "profile track(s: m): m { (0, 0), (0.5, 0.1), (1, 0.3) }";

/// Parses what stands behind the word `profile`. It is a function whose body knows the points.
pub(super) fn profile(cursor: &mut Cursor) -> Checked<Statement> {
    let name = name(cursor, "the name of the profile")?;
    let (arguments, body) = said_of(&name, cursor, |cursor| after_name(cursor, &name))?;
    Ok(Statement::Function {
        name,
        arguments,
        body,
    })
}

fn after_name(cursor: &mut Cursor, function: &Name) -> Checked<(Vec<Name>, Expr)> {
    let Some(group) = cursor.eat_group(Delimiter::Parenthesis) else {
        let wanted = format!("`(` and the argument, as in `{EXAMPLE}`");
        return Err(cursor.unexpected(&wanted));
    };
    let mut inner = cursor.inside(&group);
    let argument = name(&mut inner, "the name of the argument")?;
    let argument_unit = colon_and_unit(&mut inner)?;
    if !inner.is_empty() {
        return Err(inner.unexpected("one argument"));
    }
    let value_unit = colon_and_unit(cursor)?;
    let place = cursor.place();
    if let Some(TokenTree::Literal(file)) = cursor.peek() {
        let file = file.to_string();
        let message = format!(
            "a profile holds its points itself; `hangtime profile {}` prints the statement with the points of that table",
            file.trim_matches('"')
        );
        return Err(cursor.said().syntax(place, message));
    }
    let Some(group) = cursor.eat_group(Delimiter::Brace) else {
        let wanted = format!("`{{` and the points, as in `{EXAMPLE}`");
        return Err(cursor.unexpected(&wanted));
    };
    let before = cursor.said().mistakes();
    let points = entries(cursor.inside(&group), |cursor| {
        let pair = expression(cursor)?;
        point(&pair)
            .map(|point| (point, pair.place))
            .ok_or_else(|| {
                let message = format!(
                    "`{pair}` is no point; write two numbers without units, as in `(0.5, 0.1)`"
                );
                cursor.said().syntax(pair.place, message)
            })
    });
    if cursor.said().mistakes() > before {
        return Err(Reported);
    }
    in_order(function, place, &points, &mut cursor.said())?;
    let points = points.into_iter().map(|(point, _)| point).collect();
    let body = Expr {
        kind: Kind::Profile {
            profile: Profile::new(&function.text, points),
            argument: argument.clone(),
            argument_unit,
            value_unit,
        },
        place,
        depth: 1,
        parenthesized: false,
    };
    Ok((vec![argument], body))
}

fn colon_and_unit(cursor: &mut Cursor) -> Checked<Option<WrittenUnit>> {
    if cursor.eat_symbol(":") {
        unit::declared(cursor)
    } else {
        Ok(None)
    }
}

/// A pair of numbers, possibly with signs.
fn point(pair: &Expr) -> Option<(f64, f64)> {
    fn number(expr: &Expr) -> Option<f64> {
        match &expr.kind {
            Kind::Number {
                value, unit: None, ..
            } => Some(*value),
            Kind::Negate(inner) => Some(-number(inner)?),
            _ => None,
        }
    }
    match &pair.kind {
        Kind::Vector(items) => match &items[..] {
            [x, y] => Some((number(x)?, number(y)?)),
            _ => None,
        },
        _ => None,
    }
}

/// Whether the points make a function: enough of them, from left to right, and near enough in size.
fn in_order(
    name: &Name,
    block: Place,
    points: &[((f64, f64), Place)],
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    if !(FEWEST..=MOST).contains(&points.len()) {
        let message = format!(
            "profile `{}` needs from {FEWEST} to {MOST} points, and has {}",
            name.text,
            points.len()
        );
        return Err(diagnostics.syntax(block, message));
    }
    for pair in points.windows(2) {
        let [((before, _), _), ((x, _), place)] = pair else {
            continue;
        };
        if x <= before {
            let message = format!(
                "the points of profile `{}` must go from left to right: {x} follows {before}",
                name.text
            );
            return Err(diagnostics.syntax(*place, message));
        }
    }
    let points: Vec<(f64, f64)> = points.iter().map(|(point, _)| *point).collect();
    let pieces = Profile::new(&name.text, points).pieces();
    let finite = |piece: &(f64, [f64; 6])| piece.1.iter().all(|value| value.is_finite());
    if pieces.iter().all(finite) {
        return Ok(());
    }
    let message = format!(
        "the points of profile `{}` are too close or too far apart for the curve through them; choose units in \
         which their numbers are closer to 1, and leave out points that nearly coincide",
        name.text
    );
    Err(diagnostics.report("E21", block, message))
}
