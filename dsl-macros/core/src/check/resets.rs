//! `when condition { ... }`: states and velocities that are set where a condition comes true.
//!
//! The condition is a switch that nothing acts by, so that whatever locates switches locates it.

use super::checker::{Checker, Reset};
use super::rules::smooth;
use super::states;
use super::values::{self, of_an_instant};
use crate::ast::{Assignment, Condition, Expr, Name, Relation};
use crate::diagnostics::{Checked, Reported};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, Action, Contact};

pub(super) fn when(
    checker: &mut Checker<'_>,
    condition: &Condition,
    assignments: &[Assignment],
) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    let mut side = |expr: &Expr| {
        let value = of_an_instant(checker, expr)?;
        smooth(value, expr, checker)?;
        Ok(value)
    };
    let (left, right) = (side(&condition.left), side(&condition.right));
    let values: Vec<Checked<(usize, Sym)>> = assignments
        .iter()
        .map(|assignment| set(checker, assignment))
        .collect();
    let (left, right) = (left?, right?);
    let function = match condition.relation {
        Relation::AtMost => right - left,
        _ => left - right,
    };
    let place = condition.left.place.to(condition.right.place);
    let moves = |variable| {
        matches!(
            variable,
            Variable::Coordinate(_) | Variable::Velocity(_) | Variable::Time
        )
    };
    let shown = condition.to_string();
    if !graph::depends_on(function, moves) {
        let message = format!(
            "`{shown}` depends on nothing that changes, so that it never comes true; use coordinates, velocities, states or the time"
        );
        checker.diagnostics.report("E07", place, message);
    }
    if assignments.is_empty() {
        let message =
            format!("`when {shown}` sets nothing; write what it sets, as in `{{ on = 1 }}`");
        checker.diagnostics.syntax(place, message);
    }
    let values: Vec<(usize, Sym)> = values.into_iter().flatten().collect();
    for (k, (index, _)) in values.iter().enumerate() {
        if values[..k].iter().any(|(other, _)| other == index) {
            let target = &assignments[k].target;
            let message = format!("`{}` is set twice at once; keep one", target.text);
            checker.diagnostics.syntax(target.place(), message);
        }
    }
    if checker.diagnostics.mistakes() > before {
        return Err(Reported);
    }
    checker.laws.resets.push(Reset {
        documentation: condition.documentation.clone(),
        name: Name {
            text: shown,
            ident: proc_macro2::Ident::new("when", place.start),
        },
        function,
        values,
    });
    Ok(())
}

/// The velocity or state that is set, by its place among all velocities, and its value in its declared unit.
pub(super) fn set(checker: &mut Checker<'_>, assignment: &Assignment) -> Checked<(usize, Sym)> {
    let name = &assignment.target;
    let value = of_an_instant(checker, &assignment.value);
    let (index, unit) = match states::index(checker, name) {
        Some(state) if !assignment.velocity => {
            let unit = checker.states[state].unit.clone();
            (checker.coordinates.len() + state, unit)
        }
        _ => {
            let index = checker.coordinate_index(name)?;
            if !assignment.velocity {
                let message = format!(
                    "`{0}` is a coordinate, and bodies do not jump; set its velocity, `dot({0}) = ...`, or a state",
                    name.text
                );
                return Err(checker.diagnostics.report("E04", name.place(), message));
            }
            (index, checker.coordinates[index].unit.clone())
        }
    };
    let value = value?;
    if values::is_bare(&assignment.value) {
        // A bare number is meant in the declared unit.
        return Ok((index, value));
    }
    let scale = scene::scale(unit.as_ref());
    Ok((index, value.scaled(1.0 / scale)))
}

/// Puts a contact for each condition behind the others; states have their coordinates.
pub(super) fn append(checker: &mut Checker<'_>, contacts: &mut Vec<Contact>) {
    let n = checker.coordinates.len();
    for reset in std::mem::take(&mut checker.laws.resets) {
        let nothing = || vec![Sym::ZERO; n];
        contacts.push(Contact {
            switch: Some(Action {
                force: nothing(),
                usual: nothing(),
                kink: false,
            }),
            reset: reset.values,
            ..Contact::dry(reset.name, reset.documentation, (-reset.function, Sym::ONE))
        });
    }
}
