//! States of first order: what they are, what they change by, and where they may not stand.
//!
//! A state is the velocity of a coordinate behind the declared ones that nothing reads ([`append`]). So all that knows
//! velocities knows states, and nothing else is solved for.

use super::checker::Checker;
use crate::ast::{Assignment, Name, WrittenUnit};
use crate::diagnostics::{Checked, Place, Reported, closest, list};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, Condition, Coordinate};
use hangtime_units::Unit;

/// The variable of a state.
pub(super) fn variable(checker: &Checker<'_>, state: usize) -> Variable {
    Variable::Velocity(checker.scope.first_state + state as u16)
}

/// Index of the state with this name.
pub(super) fn index(checker: &Checker<'_>, name: &Name) -> Option<usize> {
    let mut states = checker.states.iter();
    states.position(|known| known.name.text == name.text)
}

/// What states change by.
pub(super) fn rates(checker: &mut Checker<'_>, assignments: &[Assignment]) -> Checked<()> {
    for assignment in assignments {
        checker.scope.acts = true;
        let value = checker.number(&assignment.value);
        checker.scope.acts = false;
        let (Ok(state), Ok(value)) = (of_rate(checker, assignment), value) else {
            continue;
        };
        let name = &assignment.target;
        let of_state = checker.unit_of(&name.text);
        let units = &mut checker.scope.units;
        let wanted = of_state.over(&units.second());
        let reason = format!(
            "the rate of `{}` is the unit of the state over s",
            name.text
        );
        units.expect(&assignment.value, &value.unit, &wanted, &reason);
        if checker.rates.iter().any(|&(known, _)| known == state) {
            let message = format!("`{}` has two rates; add them up in one", name.text);
            checker.diagnostics.syntax(name.place(), message);
            continue;
        }
        checker.rates.push((state, value.sym));
    }
    Ok(())
}

/// The state that an entry of `rates` is of.
fn of_rate(checker: &mut Checker<'_>, assignment: &Assignment) -> Checked<usize> {
    let name = &assignment.target;
    let text = &name.text;
    if let Some(state) = index(checker, name) {
        if assignment.velocity {
            let message = format!("the rate of `{text}` is written `{text}: ...`, without `dot`");
            return Err(checker.diagnostics.syntax(name.place(), message));
        }
        return Ok(state);
    }
    if checker.diagnostics.is_poisoned(text) {
        return Err(Reported);
    }
    let names: Vec<&str> = checker
        .states
        .iter()
        .map(|known| known.name.text.as_str())
        .collect();
    let mut coordinates = checker.coordinates.iter();
    let message = if coordinates.any(|known| known.name.text == *text) {
        format!(
            "`{text}` is a coordinate, whose acceleration follows from the `lagrangian`; what acts on it stands in \
             `forces {{ {text}: ... }}`"
        )
    } else if let Some(near) = closest(text, names.iter().copied()) {
        format!("`{text}` is no state; did you mean `{near}`?")
    } else if names.is_empty() {
        format!(
            "`{text}` is no state; declare it by `states {{ {text} }}`, with its unit behind a colon"
        )
    } else {
        format!("`{text}` is no state (states: {})", list(names))
    };
    Err(checker.diagnostics.report("E01", name.place(), message))
}

/// E04: each state has a rate.
pub(super) fn without_rate(checker: &mut Checker<'_>) {
    for state in 0..checker.states.len() {
        let name = checker.states[state].name.clone();
        let known = checker.rates.iter().any(|&(known, _)| known == state);
        if known || checker.is_set(state) || checker.diagnostics.mistakes() > 0 {
            continue;
        }
        let message = format!(
            "state `{0}` has no rate; write `rates {{ {0}: ... }}`, with 0 for one that stays",
            name.text
        );
        checker.diagnostics.report("E04", name.place(), message);
    }
}

/// E04: no momentum depends on a state: what a body loses with its mass is not said by a kinetic energy.
pub(super) fn momenta(checker: &mut Checker<'_>, lagrangian: Sym, place: Place) -> Checked<()> {
    if checker.states.is_empty() {
        return Ok(());
    }
    let n = checker.coordinates.len();
    let velocities = Variable::velocities(n);
    let momenta = graph::gradient(lagrangian, &velocities);
    let first = checker.scope.first_state;
    let is_state = |variable| matches!(variable, Variable::Velocity(i) if i >= first);
    let momenta: Vec<Sym> = momenta.into_iter().map(crate::derive::simplify).collect();
    checker.free_of(&momenta, is_state, (Some("E04"), place), |state| {
        format!(
            "the kinetic energy depends on {state}, and does not say what becomes of the momentum when that changes; of a body whose \
             mass changes write the energies of a mass of 1, as in `dot(x)^2/2 - g*x`, and divide what acts by the mass, as in \
             `forces {{ x: thrust/m }}`"
        )
    })
}

/// The place of a state in `(q, v)`.
pub(super) fn place(checker: &Checker<'_>, state: usize) -> usize {
    let n = checker.coordinates.len();
    n + checker.states.len() + n + state
}

/// The bounds of states as constraints of optimal control.
pub(super) fn constraints(checker: &Checker<'_>) -> Vec<Condition> {
    let mut conditions = Vec::new();
    for (index, state) in checker.states.iter().enumerate() {
        let Some((lower, upper)) = state.bounds else {
            continue;
        };
        let value = Sym::variable(variable(checker, index));
        let scale = scene::scale(state.unit.as_ref());
        for (suffix, function) in [("least", value - lower), ("most", upper - value)] {
            conditions.push(Condition {
                name: format!("{}.{suffix}", state.name.text),
                documentation: state.documentation.clone(),
                function: function.scaled(scale),
                equality: false,
                unit: state.unit.as_ref().map(|written| written.unit.si()),
            });
        }
    }
    conditions
}

/// Puts a coordinate behind the declared ones for each state, whose velocity the state is, and its rate in place of the force.
pub(super) fn append(checker: &mut Checker<'_>, forces: &mut Vec<Sym>) {
    let first = forces.len();
    for state in &checker.states {
        let mut name = state.name.clone();
        name.text = format!("integral({})", name.text);
        checker.coordinates.push(Coordinate {
            name,
            unit: state.unit.as_ref().map(times_second),
            documentation: state.documentation.clone(),
            bounds: None,
        });
        forces.push(Sym::ZERO);
    }
    for &(state, rate) in &checker.rates {
        let scale = scene::scale(checker.states[state].unit.as_ref());
        forces[first + state] = rate.scaled(1.0 / scale);
    }
}

/// The unit of the integral of what has this one over the time.
fn times_second(unit: &WrittenUnit) -> WrittenUnit {
    WrittenUnit {
        text: format!("{} s", unit.text),
        unit: unit.unit * Unit::mechanical(0, 0, 1),
    }
}

/// The start values of the coordinates of a mechanism and of their velocities, among the declared ones `(q, v)`.
pub(super) fn of_coordinates(
    declared: &[Option<(Sym, Place)>],
    coordinates: usize,
) -> [Vec<Sym>; 2] {
    let value = |value: &Option<(Sym, Place)>| value.map_or(Sym::ZERO, |(value, _)| value);
    [0, declared.len() / 2].map(|begin| {
        let values = declared[begin..begin + coordinates].iter();
        values.map(value).collect()
    })
}
