//! What is drawn: places of two components, bodies and curves whose form depends on parameters only.

use super::checker::Checker;
use crate::ast::{self, Expr, Kind, Name};
use crate::diagnostics::{Checked, Place, Reported};
use crate::dimension::Dimension;
use crate::evaluate::{Meaning, Number, Role, Value};
use crate::graph::{Compose, Sym, Variable};
use crate::scene::{self, Form, Picture, Point, Shape};
use hangtime_units::Unit;

/// Most shapes of one picture.
const MOST: usize = 500;

/// The unit of what is drawn.
const METRE: Unit = Unit::mechanical(1, 0, 0);

/// What has it.
const PLACE: &str = "it is a place in the picture";

/// The number that runs along a curve.
const ALONG: Variable = Variable::Argument(0);

/// `picture { shape, ... }`.
pub(super) fn picture(
    checker: &mut Checker<'_>,
    keyword: Place,
    shapes: &[ast::Shape],
) -> Checked<()> {
    if checker.shown.picture.is_some() {
        let message = "a scene has one `picture`; put all shapes into it";
        return Err(checker.diagnostics.syntax(keyword, message));
    }
    if shapes.len() > MOST {
        let message = format!("a picture has at most {MOST} shapes");
        return Err(checker.diagnostics.syntax(keyword, message));
    }
    let before = checker.diagnostics.mistakes();
    let mut picture = Picture {
        unit: unit_of_length(checker),
        ..Picture::default()
    };
    checker.scope.role = Role::Draw;
    for shape in shapes {
        // Each reports its own mistakes; the next one is checked all the same.
        match (checked(checker, &picture, shape), shape) {
            (Ok(shape), _) => picture.shapes.push(shape),
            (Err(Reported), ast::Shape::Body { name, .. }) => {
                checker.diagnostics.poison(&name.text);
            }
            (Err(Reported), _) => {}
        }
    }
    checker.scope.role = Role::Motion;
    checker.diagnostics.none_since(before)?;
    set_axes(checker, &mut picture);
    checker.shown.picture = Some(picture);
    Ok(())
}

/// The unit of the first coordinate that is a length; metres if there is none, and nothing in a scene without units.
fn unit_of_length(checker: &Checker<'_>) -> (String, f64) {
    let quantities = checker.coordinates.iter().chain(&checker.controls);
    let coordinates = quantities.filter_map(|known| known.unit.as_ref());
    let parameters = checker.parameters.iter();
    let units = coordinates.chain(parameters.filter_map(|known| known.unit.as_ref()));
    let mut units = units.peekable();
    if units.peek().is_none() {
        return (String::new(), 1.0);
    }
    let coordinates = checker.coordinates.iter();
    let mut declared = coordinates.filter_map(|known| known.unit.as_ref());
    match declared.find(|written| written.unit.same_dimension(METRE)) {
        Some(written) => (written.text.clone(), written.unit.scale),
        None => ("m".to_owned(), 1.0),
    }
}

/// Where a body is at a pair of coordinates, these name the axes, and surfaces may be drawn as places of that body,
/// unless something drawn is larger than a point or the ground is drawn by curves.
fn set_axes(checker: &Checker<'_>, picture: &mut Picture) {
    let coordinates = (0_u16..).zip(&checker.coordinates);
    let values: Vec<Sym> = coordinates
        .map(|(index, known)| {
            Sym::variable(Variable::Coordinate(index)).scaled(scene::scale(known.unit.as_ref()))
        })
        .collect();
    let index = |sym: Sym| values.iter().position(|known| *known == sym);
    let mut places = picture.shapes.iter().filter_map(|shape| match shape {
        Shape::Body { at, .. } => Some([index(at[0])?, index(at[1])?]),
        _ => None,
    });
    let place = places.next();
    let only_points = picture.shapes.iter().all(|shape| {
        let form = match shape {
            Shape::Body { form, .. } => form,
            Shape::Line { .. } => return true,
            Shape::Curve { .. } => return false,
        };
        matches!(form, Form::Point)
    });
    let names = place.map(|place| place.map(|index| checker.coordinates[index].name.text.clone()));
    picture.axes = names.unwrap_or_else(|| ["y", "z"].map(str::to_owned));
    picture.ground = place.filter(|_| only_points);
}

fn checked(checker: &mut Checker<'_>, picture: &Picture, shape: &ast::Shape) -> Checked<Shape> {
    match shape {
        ast::Shape::Body {
            name,
            at,
            angle,
            form,
        } => {
            let free = new_shape(checker, picture, name);
            let at = place(checker, at, PLACE);
            let angle = match angle {
                Some(angle) => checker.number(angle).map(|own| {
                    checker.scope.units.pure("the angle of a body", angle, &own);
                    own.sym
                }),
                None => Ok(Sym::ZERO),
            };
            let form = checked_form(checker, name, form);
            free?;
            Ok(Shape::Body {
                name: name.text.clone(),
                at: at?,
                angle: angle?,
                form: form?,
            })
        }
        ast::Shape::Line { spring, ends } => {
            let [from, to] = [0, 1].map(|i| end(checker, picture, &ends[i]));
            Ok(Shape::Line {
                spring: *spring,
                ends: [from?, to?],
            })
        }
        ast::Shape::Curve {
            name,
            points,
            over,
            range,
        } => {
            let free = new_shape(checker, picture, name);
            let range = range.as_ref().map(|(lower, upper)| {
                let [low, high] = [lower, upper].map(|bound| {
                    let value = checker.number(bound)?;
                    fixed(checker, value.sym, bound, &name.text)?;
                    Ok(value)
                });
                let (low, high) = (low?, high?);
                let units = &mut checker.scope.units;
                let what = format!("both ends of `{}`", over.text);
                let place = lower.place.to(upper.place);
                units.same(place, (lower, &low.unit), (upper, &high.unit), &what);
                Ok((low, high))
            });
            let range = range.transpose();
            // Over all that is shown it is a length as the axis shows it.
            let (scale, unit) = match &range {
                Ok(None) => (picture.unit.1, checker.scope.units.of(METRE)),
                Ok(Some((low, _))) => (1.0, low.unit.clone()),
                Err(Reported) => (1.0, Dimension::default()),
            };
            let sym = Sym::variable(ALONG).scaled(scale);
            let along = (over.text.as_str(), Number { sym, unit });
            let value = checker.value_over(along, points);
            let point = value.and_then(|value| two(checker, points, &value, PLACE));
            free?;
            let point = point?;
            for component in point {
                fixed(checker, component, points, &name.text)?;
            }
            Ok(Shape::Curve {
                name: name.text.clone(),
                point,
                range: range?.map(|(low, high)| [low.sym, high.sym]),
            })
        }
    }
}

/// E19: names of bodies and curves are different.
fn new_shape(checker: &mut Checker<'_>, picture: &Picture, name: &Name) -> Checked<()> {
    if !picture
        .shapes
        .iter()
        .any(|known| known.is_called(&name.text))
    {
        return Ok(());
    }
    let message = format!("`{}` is drawn twice; rename one", name.text);
    Err(checker.diagnostics.report("E19", name.place(), message))
}

fn checked_form(checker: &mut Checker<'_>, name: &Name, form: &ast::Form) -> Checked<Form> {
    Ok(match form {
        ast::Form::Point => Form::Point,
        ast::Form::Circle { radius } => {
            let value = checker.number(radius)?;
            let size = Value::Scalar(value.clone());
            lengths(checker, radius, &size, &size_of(name));
            Form::Circle {
                radius: fixed(checker, value.sym, radius, &name.text)?,
            }
        }
        ast::Form::Rectangle { size } => Form::Rectangle {
            size: fixed_point(checker, name, size)?,
        },
        ast::Form::Polygon { corners } => {
            let corners = corners
                .iter()
                .map(|corner| fixed_point(checker, name, corner));
            Form::Polygon {
                corners: corners.collect::<Checked<_>>()?,
            }
        }
    })
}

fn fixed_point(checker: &mut Checker<'_>, name: &Name, expr: &Expr) -> Checked<Point> {
    let point = place(checker, expr, &size_of(name))?;
    for component in point {
        fixed(checker, component, expr, &name.text)?;
    }
    Ok(point)
}

/// E24: a form depends on parameters only.
fn fixed(checker: &mut Checker<'_>, value: Sym, expr: &Expr, name: &str) -> Checked<Sym> {
    let moving = |variable: Variable| variable.moves() && variable != ALONG;
    checker.free_of(&[value], moving, (Some("E24"), expr.place), |moving| {
        format!(
            "the form of `{name}` depends on {moving}; it may depend on parameters only, what moves is the place and the angle \
             of a body"
        )
    })?;
    Ok(value)
}

/// The end of a line: a body that is drawn, or a place.
fn end(checker: &mut Checker<'_>, picture: &Picture, expr: &Expr) -> Checked<Point> {
    if let Kind::Name(name) = &expr.kind {
        let body = picture.shapes.iter().find_map(|shape| match shape {
            Shape::Body {
                name: known, at, ..
            } => (*known == name.text).then_some(*at),
            _ => None,
        });
        if let Some(at) = body {
            return Ok(at);
        }
        let known = matches!(checker.scope.names.get(&name.text), Some(Meaning::Value(_)));
        if !known && !checker.diagnostics.is_poisoned(&name.text) {
            let message = format!(
                "there is no body `{0}` above; draw it before, as in `point {0} at (y, z)`, or write a place",
                name.text
            );
            return Err(checker.diagnostics.report("E01", name.place(), message));
        }
    }
    place(checker, expr, PLACE)
}

fn place(checker: &mut Checker<'_>, expr: &Expr, reason: &str) -> Checked<Point> {
    let value = checker.value(expr)?;
    two(checker, expr, &value, reason)
}

fn size_of(name: &Name) -> String {
    format!("it is the size of `{}`", name.text)
}

/// E03: what is drawn are lengths.
fn lengths(checker: &mut Checker<'_>, expr: &Expr, value: &Value, reason: &str) {
    let items = match &expr.kind {
        Kind::Vector(items) => &items[..],
        _ => &[],
    };
    let units = &mut checker.scope.units;
    let metre = units.of(METRE);
    for (i, own) in value.components().iter().enumerate() {
        units.expect(items.get(i).unwrap_or(expr), &own.unit, &metre, reason);
    }
}

/// E02: places have two components.
fn two(checker: &mut Checker<'_>, expr: &Expr, value: &Value, reason: &str) -> Checked<Point> {
    lengths(checker, expr, value, reason);
    let message = match value {
        Value::Vector(components) => match &components[..] {
            [across, up] => return Ok([across.sym, up.sym]),
            [_, _, _] => format!(
                "`{expr}` has 3 components, and a picture shows 2; write the two that are to be seen, as in \
                 `(p.x, p.z)`"
            ),
            _ => format!(
                "`{expr}` has {} components, and a picture shows 2, the horizontal one first",
                components.len()
            ),
        },
        _ => format!(
            "`{expr}` is no place in the picture; write a horizontal and a vertical component, as in `(y, z)`"
        ),
    };
    Err(checker.diagnostics.report("E02", expr.place, message))
}
