//! What is recorded and drawn of a motion.

use super::builder::Builder;
use super::declared::{inferred, unit};
use crate::declaration::{Picture, Shape, VariableDeclaration, list, text};
use crate::derive::simplify;
use crate::graph::{Compose, Sym};
use crate::scene::{self, Form, Output};

/// Quantities that are recorded, and their kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Name, unit and documentation of each.
    pub quantities: &'static [VariableDeclaration],
    /// Kernel of their values, of `(q, v, u, t)`, the time always among them; the normal and then the tangential forces
    /// of all contacts are the weights, and behind them the same of the impulses so far.
    pub kernel: usize,
}

pub(super) fn outputs(builder: &mut Builder<'_>) -> Option<Outputs> {
    let declared = &builder.scene.outputs;
    let quantities = list(declared.iter().map(|output| VariableDeclaration {
        name: text(&output.name.text),
        unit: output_unit(output),
        documentation: text(&output.documentation),
    }));
    if quantities.is_empty() {
        return None;
    }
    let values = values(declared);
    Some(Outputs {
        quantities,
        kernel: builder.kernel("outputs", &values),
    })
}

/// What is recorded, in its units.
pub(super) fn values(outputs: &[Output]) -> Vec<Sym> {
    let value = |output: &Output| {
        output
            .value
            .scaled(1.0 / scene::scale(output.unit.as_ref()))
    };
    outputs.iter().map(value).map(simplify).collect()
}

/// The declared unit of what is recorded, or that of its value.
pub(super) fn output_unit(output: &Output) -> &'static str {
    match &output.unit {
        Some(_) => unit(output.unit.as_ref()),
        None => inferred(output.inferred),
    }
}

/// A picture, and the kernel of the values of all shapes, one after the other, of `(q, v, u, t)`, the time always among them; the
/// number that runs along a curve is the weight.
pub(super) fn picture(builder: &mut Builder<'_>) -> Option<(Picture, usize)> {
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
                let name = text(name);
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
                    None => Shape::Curve(text(name)),
                    Some(_) => Shape::Arc(text(name)),
                }
            }
        });
    }
    let [across, up] = &declared.axes;
    let picture = Picture {
        unit: text(&declared.unit.0),
        axes: (text(across), text(up)),
        ground: declared.ground.map(|[across, up]| (across, up)),
        shapes: list(shapes),
    };
    Some((picture, builder.kernel("picture", &values)))
}
