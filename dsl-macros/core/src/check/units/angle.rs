//! E23: numbers that are angles in radians by the letter, and in degrees by their size.

use super::walk::{Walk, constant};
use crate::ast::{Expr, Kind};
use crate::check::values::is_bare;
use std::f64::consts::TAU;

/// Both sides of a comparison.
pub(super) fn compared(walk: &mut Walk<'_>, left: &Expr, right: &Expr) {
    for (angle, number) in [(left, right), (right, left)] {
        if is_angle(walk, angle) {
            likely_degrees(walk, &format!("`{angle}`"), number);
        }
    }
}

/// A number that belongs to the declaration of a name.
pub(super) fn of_name(walk: &mut Walk<'_>, name: &str, number: &Expr) {
    if walk.radians.contains(name) {
        likely_degrees(walk, &format!("`{name}`"), number);
    }
}

/// Numbers of which the sine, the cosine or the tangent is taken.
pub(super) fn arguments(walk: &mut Walk<'_>) {
    for (function, number) in std::mem::take(&mut walk.angles) {
        likely_degrees(walk, &format!("the argument of `{function}`"), &number);
    }
}

/// Whether a name is declared in rad.
pub(super) fn is_declared(walk: &Walk<'_>, name: &str) -> bool {
    walk.radians.contains(name)
}

/// Whether an expression is a name declared in rad, or a sum with one and nothing else but numbers.
fn is_angle(walk: &Walk<'_>, expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Name(name) => walk.radians.contains(&name.text),
        Kind::Negate(inner) | Kind::Norm(inner) => is_angle(walk, inner),
        Kind::Chain(first, rest) if rest[0].operator.is_additive() => {
            let terms = || std::iter::once(&**first).chain(rest.iter().map(|link| &link.operand));
            terms().any(|term| is_angle(walk, term))
                && terms().all(|term| is_bare(term) || is_angle(walk, term))
        }
        _ => false,
    }
}

fn likely_degrees(walk: &mut Walk<'_>, angle: &str, number: &Expr) {
    let Some(value) = constant(number).filter(|value| is_bare(number) && value.abs() > TAU) else {
        return;
    };
    let turns = (value.abs() / TAU * 10.0).round() / 10.0;
    let message = format!(
        "{angle} is in rad, and {value} rad are {turns} turns; write `{value} [deg]` if degrees are meant, \
         `{value} [rad]` if not"
    );
    walk.diagnostics.warn("E23", number.place, message);
}
