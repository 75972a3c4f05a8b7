//! `picture { ... }`: what is drawn, one shape an entry.

use super::cursor::Cursor;
use super::expression::{expression, expression_in_picture};
use super::pieces;
use super::pieces::{block, entries, name, range};
use crate::ast::{Expr, Form, Kind, Name, Shape, Statement};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest, list};
use crate::words;
use proc_macro2::Delimiter;

/// `picture { shape, ... }`.
pub(super) fn picture(cursor: &mut Cursor, word: &Name) -> Checked<Statement> {
    let inner = block(cursor, word)?;
    Ok(Statement::Picture {
        keyword: word.place(),
        shapes: entries(inner, shape),
    })
}

fn shape(cursor: &mut Cursor) -> Checked<Shape> {
    let Some(kind) = cursor.eat_name() else {
        let shapes = list(words::SHAPES);
        return Err(cursor.unexpected(&format!("one of {shapes}")));
    };
    match kind.text.as_str() {
        "point" | "circle" | "rectangle" | "polygon" => body(cursor, &kind),
        "link" | "spring" => {
            let from = end(cursor)?;
            if !cursor.eat_word("to") {
                let expected = format!("`to`, as in `{} a to b`", kind.text);
                return Err(cursor.unexpected(&expected));
            }
            let to = end(cursor)?;
            Ok(Shape::Line {
                spring: kind.text == "spring",
                ends: Box::new([from, to]),
            })
        }
        "curve" => curve(cursor),
        other => {
            let message = match closest(other, words::SHAPES) {
                Some(near) => format!("unknown shape `{other}`; did you mean `{near}`?"),
                None => format!(
                    "unknown shape `{other}`; a picture is made of {}",
                    list(words::SHAPES)
                ),
            };
            Err(cursor.said().syntax(kind.place(), message))
        }
    }
}

fn end(cursor: &mut Cursor) -> Checked<Expr> {
    expression_in_picture(cursor)
}

/// A body, with its properties in any order.
fn body(cursor: &mut Cursor, kind: &Name) -> Checked<Shape> {
    let name = name(cursor, "the name of the body")?;
    let wanted = match kind.text.as_str() {
        "circle" => Some("radius"),
        "rectangle" => Some("size"),
        "polygon" => Some("corners"),
        _ => None,
    };
    let (mut at, mut angle, mut measure, mut corners) = (None, None, None, None);
    while let Some(word) = cursor.ident().map(ToString::to_string) {
        let place = cursor.place();
        let is_own = wanted == Some(word.as_str());
        let known = is_own || matches!(word.as_str(), "at" | "angle");
        if !known && words::PROPERTIES.contains(&word.as_str()) {
            let own = ["at", "angle"].into_iter().chain(wanted);
            let message = format!("a {} has {}, no `{word}`", kind.text, list(own));
            return Err(cursor.said().syntax(place, message));
        }
        if !known {
            break;
        }
        cursor.advance();
        if word == "corners" {
            corners = Some(corner_list(cursor)?);
            continue;
        }
        let value = expression_in_picture(cursor)?;
        let slot = match word.as_str() {
            "at" => &mut at,
            "angle" => &mut angle,
            _ => &mut measure,
        };
        if slot.replace(value).is_some() {
            let message = format!("`{word}` is given twice for `{}`; keep one", name.text);
            return Err(cursor.said().syntax(place, message));
        }
    }
    let form = match (kind.text.as_str(), measure, corners) {
        ("point", ..) => Form::Point,
        ("circle", Some(radius), _) => Form::Circle { radius },
        ("rectangle", Some(size), _) => Form::Rectangle { size },
        ("polygon", _, Some(corners)) => Form::Polygon { corners },
        _ => return Err(incomplete(kind, &name, &mut cursor.said())),
    };
    Ok(Shape::Body {
        at: at.unwrap_or_else(|| named(&name)),
        name,
        angle,
        form,
    })
}

fn incomplete(kind: &Name, name: &Name, diagnostics: &mut Diagnostics) -> Reported {
    let (what, example) = match kind.text.as_str() {
        "circle" => ("a radius", "radius 0.1 [m]"),
        "rectangle" => ("a size", "size (0.2 [m], 0.1 [m])"),
        _ => ("its corners", "corners ((0, 0), (l, 0), (0, l))"),
    };
    // Lines to it give no second message.
    diagnostics.poison(&name.text);
    let (kind, text) = (&kind.text, &name.text);
    let message =
        format!("{kind} `{text}` needs {what}, as in `{kind} {text} at (y, z) {example}`");
    diagnostics.syntax(name.place(), message)
}

/// The vector that has the name of the body.
fn named(name: &Name) -> Expr {
    Expr {
        kind: Kind::Name(name.clone()),
        place: name.place(),
        depth: 0,
        parenthesized: false,
    }
}

/// `((a, b), (c, d), ...)`.
fn corner_list(cursor: &mut Cursor) -> Checked<Vec<Expr>> {
    let place = cursor.place();
    let Some(group) = cursor.eat_group(Delimiter::Parenthesis) else {
        let expected = "the corners in parentheses, as in `((0, 0), (l, 0), (0, l))`";
        return Err(cursor.unexpected(expected));
    };
    let before = cursor.said().mistakes();
    let corners = entries(cursor.inside(&group), expression);
    if cursor.said().mistakes() > before {
        return Err(Reported);
    }
    if corners.len() < 3 {
        let whole = place.to(Place::at(group.span_close()));
        let message = "a polygon has three corners or more, as in `((0, 0), (l, 0), (0, l))`";
        return Err(cursor.said().syntax(whole, message));
    }
    Ok(corners)
}

/// `curve name: points over w in lower..=upper`.
fn curve(cursor: &mut Cursor) -> Checked<Shape> {
    let name = name(cursor, "the name of the curve")?;
    if !cursor.eat_symbol(":") {
        let expected = "`:` after the curve's name, as in `curve track: (w, h(w)) over w`";
        return Err(cursor.unexpected(expected));
    }
    let points = expression_in_picture(cursor)?;
    if !cursor.eat_word("over") {
        let expected = "`over` and the number that runs along the curve, as in `(w, h(w)) over w`";
        return Err(cursor.unexpected(expected));
    }
    let over = pieces::name(cursor, "the number that runs along the curve")?;
    let range = range(cursor)?;
    Ok(Shape::Curve {
        name,
        points,
        over,
        range,
    })
}
