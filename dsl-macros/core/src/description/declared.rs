//! What is declared: names, units, documentation.

use crate::ast::WrittenUnit;
use crate::declaration::{ParameterDeclaration, VariableDeclaration, list, text};
use crate::scene;
use hangtime_units::Unit;

pub(super) fn parameter(parameter: &scene::Parameter) -> ParameterDeclaration {
    ParameterDeclaration {
        name: text(&parameter.name.text),
        unit: unit(parameter.unit.as_ref()),
        default: parameter.default,
        positive: is_inertia(parameter.unit.as_ref()),
        documentation: text(&parameter.documentation),
    }
}

/// Coordinates, controls or states.
pub(super) fn variables(variables: &[scene::Coordinate]) -> &'static [VariableDeclaration] {
    list(variables.iter().map(|variable| VariableDeclaration {
        name: text(&variable.name.text),
        unit: unit(variable.unit.as_ref()),
        documentation: text(&variable.documentation),
    }))
}

pub(super) fn unit(written: Option<&WrittenUnit>) -> &'static str {
    written.map_or("", |unit| text(&unit.text))
}

/// A unit that follows from others; empty for pure numbers, as where none is declared.
pub(super) fn inferred(unit: Option<Unit>) -> &'static str {
    unit.filter(|unit| !unit.same_dimension(Unit::ONE))
        .map_or("", |unit| text(&unit.to_string()))
}

/// Masses and moments of inertia, which must be positive.
fn is_inertia(written: Option<&WrittenUnit>) -> bool {
    written.is_some_and(|written| {
        written.unit.same_dimension(Unit::mechanical(0, 1, 0))
            || written.unit.same_dimension(Unit::mechanical(2, 1, 0))
    })
}
