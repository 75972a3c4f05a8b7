//! What is declared: names, units, documentation.

use crate::ast::{Documentation, WrittenUnit};
use crate::declaration::{ParameterDeclaration, VariableDeclaration, list, text};
use crate::scene;
use hangtime_units::Unit;

pub(super) fn parameter(parameter: &scene::Parameter) -> ParameterDeclaration {
    ParameterDeclaration {
        name: text(&parameter.name.text),
        unit: unit(parameter.unit.as_ref()),
        default: parameter.default,
        positive: is_inertia(parameter.unit.as_ref()),
        documentation: documentation(&parameter.documentation),
    }
}

/// Coordinates, controls or states.
pub(super) fn variables(variables: &[scene::Coordinate]) -> &'static [VariableDeclaration] {
    list(variables.iter().map(|variable| VariableDeclaration {
        name: text(&variable.name.text),
        unit: unit(variable.unit.as_ref()),
        documentation: documentation(&variable.documentation),
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

pub(super) fn documentation(documentation: &Documentation) -> &'static str {
    text(&documentation_text(documentation))
}

/// Doc comments as plain text.
pub(crate) fn documentation_text(documentation: &Documentation) -> String {
    let lines: Vec<String> = documentation
        .lines
        .iter()
        .map(|line| unquote(&line.to_string()).trim().to_owned())
        .collect();
    lines.join("\n").trim().to_owned()
}

/// The content of a string literal.
fn unquote(literal: &str) -> String {
    if let Some(raw) = literal.strip_prefix('r') {
        return raw.trim_matches('#').trim_matches('"').to_owned();
    }
    let inner = literal
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'))
        .unwrap_or(literal);
    let mut text = String::with_capacity(inner.len());
    let mut characters = inner.chars();
    while let Some(character) = characters.next() {
        if character != '\\' {
            text.push(character);
            continue;
        }
        match characters.next() {
            Some('n') => text.push('\n'),
            Some('t') => text.push('\t'),
            Some('r') => text.push('\r'),
            Some('u') => {
                let code: String = characters
                    .by_ref()
                    .skip(1)
                    .take_while(|&c| c != '}')
                    .collect();
                text.extend(u32::from_str_radix(&code, 16).ok().and_then(char::from_u32));
            }
            Some(other) => text.push(other),
            None => {}
        }
    }
    text
}
