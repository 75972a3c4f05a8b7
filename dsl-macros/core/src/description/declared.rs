//! What is declared: names, units, documentation.

use crate::ast::{Documentation, WrittenUnit};
use crate::scene;
use hangtime_units::Unit;

/// A number that can be changed at run time.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name, as written.
    pub name: String,
    /// Unit, as written; empty if none is declared.
    pub unit: String,
    /// Default value in that unit.
    pub default: f64,
    /// Whether it is a mass or a moment of inertia.
    pub positive: bool,
    /// Documentation, as written.
    pub documentation: String,
}

/// A coordinate, a control or a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name, as written.
    pub name: String,
    /// Unit, as written; empty if none is declared.
    pub unit: String,
    /// Documentation, as written.
    pub documentation: String,
}

impl Parameter {
    pub(super) fn of(parameter: &scene::Parameter) -> Self {
        Self {
            name: parameter.name.text.clone(),
            unit: unit(parameter.unit.as_ref()),
            default: parameter.default,
            positive: is_inertia(parameter.unit.as_ref()),
            documentation: text(&parameter.documentation),
        }
    }
}

impl Variable {
    pub(super) fn of(variable: &scene::Coordinate) -> Self {
        Self {
            name: variable.name.text.clone(),
            unit: unit(variable.unit.as_ref()),
            documentation: text(&variable.documentation),
        }
    }
}

pub(super) fn unit(written: Option<&WrittenUnit>) -> String {
    written.map_or_else(String::new, |unit| unit.text.clone())
}

/// A unit that follows from others; empty for pure numbers, as where none is declared.
pub(super) fn inferred(unit: Option<Unit>) -> String {
    unit.filter(|unit| !unit.same_dimension(Unit::ONE))
        .map_or_else(String::new, |unit| unit.to_string())
}

/// Masses and moments of inertia, which must be positive.
fn is_inertia(written: Option<&WrittenUnit>) -> bool {
    written.is_some_and(|written| {
        written.unit.same_dimension(Unit::mechanical(0, 1, 0))
            || written.unit.same_dimension(Unit::mechanical(2, 1, 0))
    })
}

/// Doc comments as plain text.
pub(crate) fn text(documentation: &Documentation) -> String {
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
