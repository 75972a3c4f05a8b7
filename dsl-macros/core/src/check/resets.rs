//! `when condition { ... }`: states and velocities that are set where a condition comes true.
//!
//! The condition is a switch that nothing acts by, so that whatever locates switches locates it.

use super::checker::{Checker, Reset};
use super::values::{Target, condition_at_an_instant, converted, of_an_instant};
use crate::ast::{Assignment, Condition, Name};
use crate::derive::simplify;
use crate::diagnostics::Checked;
use crate::graph::{self, Sym, Variable};
use crate::scene::{Action, Contact};

pub(super) fn when(
    checker: &mut Checker<'_>,
    condition: &Condition,
    assignments: &[Assignment],
) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    let function = condition_at_an_instant(checker, condition);
    let values: Vec<Checked<(usize, Sym)>> = assignments
        .iter()
        .map(|assignment| set(checker, assignment))
        .collect();
    let function = function?.sym;
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
    let mut others = checker.laws.resets.iter();
    if let Some(other) = others.find(|other| simplify(other.function + function) == Sym::ZERO) {
        let message = format!(
            "`{shown}` is true where `{0}` is not, and at the threshold both are: a motion that turns back there comes to neither; write a \
             switch, `if {0} {{ .. }} else {{ .. }}`, for what follows at once, or move one threshold",
            other.name.text
        );
        checker.diagnostics.warn("E18", place, message);
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
    checker.diagnostics.none_since(before)?;
    checker.laws.resets.push(Reset {
        documentation: condition.documentation.clone(),
        name: Name::at(place, shown),
        function,
        values,
    });
    Ok(())
}

/// The velocity or state that is set, by its place among all velocities, and its value in its declared unit.
pub(super) fn set(checker: &mut Checker<'_>, assignment: &Assignment) -> Checked<(usize, Sym)> {
    let name = &assignment.target;
    let value = of_an_instant(checker, &assignment.value);
    let (place, target) = Target::of(checker, name, assignment.velocity)?;
    let Some(index) = place.checked_sub(checker.coordinates.len() + checker.states.len()) else {
        let message = format!(
            "`{0}` is a coordinate, and bodies do not jump; set its velocity, `dot({0}) = ...`, or a state",
            name.text
        );
        return Err(checker.diagnostics.report("E04", name.place(), message));
    };
    let value = (&assignment.value, &value?);
    let value = converted(checker, value, &target, ["", " is set to it"])?;
    Ok((index, value))
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
