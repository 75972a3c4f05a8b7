//! What is recorded and drawn of a motion.

use super::builder::Builder;
use super::declared::{inferred, text, unit};
use crate::derive::simplify;
use crate::graph::{Compose, Sym};
use crate::scene::{self, Form};

/// Quantities that are recorded, and their kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Name, unit and documentation of each.
    pub quantities: Vec<super::Variable>,
    /// Kernel of their values, of `(q, v, u, t)`, the time always among them; the normal and then the tangential forces
    /// of all contacts are the weights, and behind them the same of the impulses so far.
    pub kernel: usize,
}

/// A picture, and its kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Unit of all lengths, as written; empty in a scene without units.
    pub unit: String,
    /// Names of the axes, the horizontal one first.
    pub axes: [String; 2],
    /// The coordinates of a point, if surfaces may be drawn as places of that.
    pub ground: Option<[usize; 2]>,
    /// The shapes in order of declaration.
    pub shapes: Vec<Shape>,
    /// Kernel of the values of all shapes, one after the other, of `(q, v, u, t)`, the time always among them; the
    /// number that runs along a curve is the weight.
    pub kernel: usize,
}

/// One shape of a picture, with the values that the kernel gives of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// A body without extent: place and angle.
    Point(String),
    /// A body: place, angle and radius.
    Circle(String),
    /// A body: place, angle, width and height.
    Rectangle(String),
    /// A body: place, angle and as many corners, where place and angle are zero.
    Polygon(String, usize),
    /// The places of both ends.
    Link,
    /// The places of both ends.
    Spring,
    /// A curve over all that is shown: a place.
    Curve(String),
    /// A curve over a range: both ends of the range, and a place.
    Arc(String),
}

pub(super) fn outputs(builder: &mut Builder<'_>) -> Option<Outputs> {
    let declared = &builder.scene.outputs;
    let quantities: Vec<super::Variable> = declared
        .iter()
        .map(|output| super::Variable {
            name: output.name.text.clone(),
            unit: match &output.unit {
                Some(_) => unit(output.unit.as_ref()),
                None => inferred(output.inferred),
            },
            documentation: text(&output.documentation),
        })
        .collect();
    if quantities.is_empty() {
        return None;
    }
    let values: Vec<Sym> = declared
        .iter()
        .map(|output| {
            simplify(
                output
                    .value
                    .scaled(1.0 / scene::scale(output.unit.as_ref())),
            )
        })
        .collect();
    Some(Outputs {
        quantities,
        kernel: builder.kernel("outputs", &values),
    })
}

pub(super) fn picture(builder: &mut Builder<'_>) -> Option<Picture> {
    let declared = builder.scene.picture.as_ref()?;
    let scale = 1.0 / declared.unit.1;
    let mut values: Vec<Sym> = Vec::new();
    let lengths = |values: &mut Vec<Sym>, point: &[Sym]| {
        values.extend(point.iter().map(|&length| simplify(length.scaled(scale))));
    };
    let mut shapes = Vec::with_capacity(declared.shapes.len());
    for shape in &declared.shapes {
        shapes.push(match shape {
            scene::Shape::Body {
                name,
                at,
                angle,
                form,
            } => {
                lengths(&mut values, at);
                values.push(simplify(*angle));
                let name = name.clone();
                match form {
                    Form::Point => Shape::Point(name),
                    Form::Circle { radius } => {
                        lengths(&mut values, &[*radius]);
                        Shape::Circle(name)
                    }
                    Form::Rectangle { size } => {
                        lengths(&mut values, size);
                        Shape::Rectangle(name)
                    }
                    Form::Polygon { corners } => {
                        lengths(&mut values, corners.as_flattened());
                        Shape::Polygon(name, corners.len())
                    }
                }
            }
            scene::Shape::Line { spring, ends } => {
                lengths(&mut values, ends.as_flattened());
                if *spring { Shape::Spring } else { Shape::Link }
            }
            scene::Shape::Curve { name, point, range } => {
                values.extend(range.iter().flatten().copied().map(simplify));
                lengths(&mut values, point);
                match range {
                    None => Shape::Curve(name.clone()),
                    Some(_) => Shape::Arc(name.clone()),
                }
            }
        });
    }
    Some(Picture {
        unit: declared.unit.0.clone(),
        axes: declared.axes.clone(),
        ground: declared.ground,
        shapes,
        kernel: builder.kernel("picture", &values),
    })
}
