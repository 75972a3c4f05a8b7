//! Units of outputs and of what is drawn.

use super::walk::{Units, Walk};
use crate::ast::{Expr, Form, Kind, Name, Quantity, Shape};
use crate::check::values::is_bare;
use crate::diagnostics::{Checked, Reported};
use crate::dimension::Dimension;
use hangtime_units::Unit;

/// Units of outputs, each of which may be used by those below.
pub(super) fn outputs(walk: &mut Walk<'_>, quantities: &[Quantity]) -> Checked<()> {
    for quantity in quantities {
        let own = output(walk, quantity);
        walk.shown.outputs.push(own);
    }
    Ok(())
}

/// Units of all shapes.
pub(super) fn picture(walk: &mut Walk<'_>, shapes: &[Shape]) -> Checked<()> {
    for known in shapes {
        // Reported where it fails; the next one is checked all the same.
        let _: Checked<()> = shape(walk, known);
    }
    Ok(())
}

/// The unit of an output, which is then known by its name.
fn output(walk: &mut Walk<'_>, quantity: &Quantity) -> Dimension {
    let name = &quantity.name.text;
    let declared = quantity.unit.as_ref();
    let declared = declared.map(|written| Dimension::of(written.unit));
    let own = match (&quantity.value, &declared) {
        // A bare number is meant in the declared unit.
        (Some(expr), Some(_)) if is_bare(expr) => Err(Reported),
        (Some(expr), _) => walk.scalar(expr),
        (None, _) => Err(Reported),
    };
    if let (Ok(own), Some(wanted), Some(expr)) = (&own, &declared, &quantity.value) {
        let reason = format!("output `{name}` is declared so");
        let _: Checked<()> = walk.expect(expr, own, wanted, &reason);
    }
    let unit = declared.or(own.ok());
    let unit = unit.unwrap_or_else(|| walk.unifier.unknown(name));
    walk.values
        .insert(name.clone(), Units::Scalar(unit.clone()));
    unit
}

/// Places and sizes are lengths, angles pure numbers.
fn shape(walk: &mut Walk<'_>, shape: &Shape) -> Checked<()> {
    match shape {
        Shape::Body {
            name,
            at,
            angle,
            form,
        } => {
            let placed = lengths(walk, at, "it is a place in the picture");
            let turned = angle.as_ref().map_or(Ok(()), |angle| {
                walk.pure(angle, "the angle of a body").map(|_| ())
            });
            let reason = format!("it is the size of `{}`", name.text);
            let sizes: Vec<&Expr> = match form {
                Form::Point => Vec::new(),
                Form::Circle { radius: size } | Form::Rectangle { size } => vec![size],
                Form::Polygon { corners } => corners.iter().collect(),
            };
            let mut result = placed.and(turned);
            for size in sizes {
                result = result.and(lengths(walk, size, &reason));
            }
            walk.shown.bodies.push(name.text.clone());
            result
        }
        Shape::Line { ends, .. } => {
            for end in ends.iter() {
                let is_body =
                    matches!(&end.kind, Kind::Name(name) if walk.shown.bodies.contains(&name.text));
                if !is_body {
                    lengths(walk, end, "it is a place in the picture")?;
                }
            }
            Ok(())
        }
        Shape::Curve {
            points,
            over,
            range,
            ..
        } => curve(walk, points, over, range.as_ref()),
    }
}

fn curve(
    walk: &mut Walk<'_>,
    points: &Expr,
    over: &Name,
    range: Option<&(Expr, Expr)>,
) -> Checked<()> {
    let along = match range {
        None => metre(),
        Some((lower, upper)) => {
            let (own, its) = (walk.scalar(lower)?, walk.scalar(upper)?);
            let place = lower.place.to(upper.place);
            let what = format!("both ends of `{}`", over.text);
            walk.same(place, (lower, &own), (upper, &its), &what)?;
            own
        }
    };
    walk.frames
        .push(vec![(over.text.clone(), Units::Scalar(along))]);
    let result = lengths(walk, points, "it is a place in the picture");
    walk.frames.pop();
    result
}

fn metre() -> Dimension {
    Dimension::of(Unit::mechanical(1, 0, 0))
}

fn lengths(walk: &mut Walk<'_>, expr: &Expr, reason: &str) -> Checked<()> {
    let items = match &expr.kind {
        Kind::Vector(items) => &items[..],
        _ => std::slice::from_ref(expr),
    };
    let mut result = Ok(());
    for item in items {
        for component in walk.units(item)?.components() {
            result = result.and(walk.expect(item, component, &metre(), reason));
        }
    }
    result
}
