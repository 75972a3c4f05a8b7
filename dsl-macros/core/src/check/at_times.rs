//! `at time { condition, ... }`: what holds at a time inside of the motion.
//!
//! Each condition is recorded at that time by a state that nothing else changes: it is set where `t >= time` comes true, as by `when`, and
//! has to be what the condition asks for at the end of the motion. A motion that ends before does not keep to it, as the state begins where no
//! condition holds.

use super::checker::{Asked, Checker, Moment, Reset};
use super::names::{self, recorded};
use super::values::condition_at_an_instant;
use super::{resets, states};
use crate::ast::{Assignment, Condition, Documentation, Expr, Name, Relation};
use crate::diagnostics::{Checked, Reported, all};
use crate::dimension::Dimension;
use crate::graph::{self, Sym, Variable};
use crate::scene;

/// What a recorded condition is before its time: it holds neither as an equation nor as an inequality.
const NOT_YET: f64 = -1.0;

pub(super) fn at(
    checker: &mut Checker<'_>,
    time: &Expr,
    conditions: &[Condition],
    recorded: &[Assignment],
) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    let moment = moment(checker, time);
    let mut values = Vec::new();
    for condition in conditions {
        if let Ok(value) = one(checker, condition, time) {
            values.push(value);
        }
    }
    let recorded = all(recorded.iter().map(|value| resets::set(checker, value)));
    checker.diagnostics.none_since(before)?;
    let (mut moment, recorded) = (moment?, recorded?);
    if conditions.is_empty() && recorded.is_empty() {
        let message = format!(
            "`at {time}` asks for nothing; write what holds then, as in `at {time} {{ x == 1 }}`"
        );
        return Err(checker.diagnostics.syntax(time.place, message));
    }
    if conditions.is_empty() {
        values.push(reached(checker, time)?);
    }
    let first = usize::from(checker.scope.first_state);
    moment.states = values.iter().map(|known| known.0).collect();
    moment.values = recorded.iter().map(|known| known.0 - first).collect();
    let read = values.iter().chain(&recorded).map(|known| known.1);
    moment.read = graph::variables(&read.collect::<Vec<Sym>>())
        .into_iter()
        .filter_map(|variable| match variable {
            Variable::Velocity(i) => usize::from(i).checked_sub(first),
            _ => None,
        })
        .collect();
    checker.laws.resets.push(Reset {
        documentation: Default::default(),
        name: Name::at(time.place, moment.shown.clone()),
        function: Sym::variable(Variable::Time) - moment.time,
        values: values
            .into_iter()
            .map(|(state, value)| (first + state, value))
            .chain(recorded)
            .collect(),
    });
    checker.moments.push(moment);
    Ok(())
}

/// The time of the conditions, which depends on parameters alone.
fn moment(checker: &mut Checker<'_>, time: &Expr) -> Checked<Moment> {
    let own = checker.number(time)?;
    let second = checker.scope.units.second();
    checker.given(time, &own, &second, "conditions hold at a time");
    let value = own.sym;
    checker.free_of(&[value], Variable::moves, (Some("E15"), time.place), |moving| {
        format!(
            "`at {time}` depends on {moving}; a time is a number or follows from parameters, and one that is to be found is written \
             `at gate in 0.5..=2 [s] {{ ... }}`"
        )
    })?;
    if let Some(value) = checker.at_default(value).filter(|value| *value <= 0.0) {
        let message = format!(
            "`at {time}` is at {value} s, where the motion has not begun; what holds at the start is written in `start`"
        );
        return Err(checker.diagnostics.report("E17", time.place, message));
    }
    Ok(Moment {
        time: value,
        place: time.place,
        shown: format!("at {time}"),
        states: Vec::new(),
        values: Vec::new(),
        read: Vec::new(),
    })
}

/// Declares that a motion lasts until a time of which values are asked for: the state that tells it, which is 1 from then on.
fn reached(checker: &mut Checker<'_>, time: &Expr) -> Checked<(usize, Sym)> {
    let name = names::reached(time).text;
    let mut states = checker.states.iter();
    let state = states
        .position(|state| state.name.text == name)
        .ok_or(Reported)?;
    // That the time has come.
    let unit = checker.scope.units.one();
    ask(
        checker,
        (name, Documentation::default()),
        (state, false),
        unit,
    );
    Ok((state, Sym::ONE))
}

/// Asks for the value of a state at the end: 0 as an equation, and no less than that otherwise.
fn ask(
    checker: &mut Checker<'_>,
    (name, documentation): (String, Documentation),
    (state, equality): (usize, bool),
    unit: Dimension,
) {
    let condition = scene::Condition {
        name,
        documentation,
        function: Sym::variable(states::variable(checker, state)),
        equality,
        unit: None,
    };
    let pieces = vec![condition];
    checker.task.goals.push(Asked { pieces, unit });
}

/// Evaluates a condition and declares what it asks for; the state that records it, and the value that is recorded.
fn one(checker: &mut Checker<'_>, condition: &Condition, time: &Expr) -> Checked<(usize, Sym)> {
    let value = condition_at_an_instant(checker, condition);
    let name = recorded(condition, time).text;
    let taken = |state: &usize| {
        let moments = checker.moments.iter();
        !moments
            .flat_map(|known| &known.states)
            .any(|other| other == state)
    };
    let mut all = (0..checker.states.len()).filter(taken);
    let state = all.find(|&state| checker.states[state].name.text == name);
    let (value, state) = (value?, state.ok_or(Reported)?);
    let moves = |variable| !matches!(variable, Variable::Parameter(_) | Variable::Time);
    if !graph::depends_on(value.sym, moves) {
        let message = format!(
            "`{condition}` is the same for every motion, so it is no condition; use coordinates, velocities or states"
        );
        let place = condition.left.place.to(condition.right.place);
        return Err(checker.diagnostics.report("E15", place, message));
    }
    let said = (name, condition.documentation.clone());
    let equality = condition.relation == Relation::Equal;
    ask(checker, said, (state, equality), value.unit);
    Ok((state, value.sym))
}

/// E17: the times lie inside of a motion whose length is given, and what is recorded begins where nothing holds.
pub(super) fn finish(checker: &mut Checker<'_>, velocities: &mut [Sym]) {
    let first = usize::from(checker.scope.first_state);
    let free_time = checker.scope.used.contains(crate::words::FINAL_TIME);
    let horizon = checker.horizon.filter(|_| !free_time);
    let horizon = horizon.and_then(|horizon| checker.at_default(horizon));
    let moments = std::mem::take(&mut checker.moments);
    for moment in &moments {
        order(checker, moment, &moments);
    }
    for moment in moments {
        for state in moment.states {
            velocities[first + state] = Sym::number(NOT_YET);
        }
        let Some((time, horizon)) = checker.at_default(moment.time).zip(horizon) else {
            continue;
        };
        if time >= horizon {
            let message = format!(
                "`{}` is at {time} s, and the motion ends at {horizon} s; what holds at its end is written in `finally`",
                moment.shown
            );
            checker.diagnostics.report("E17", moment.place, message);
        }
    }
}

/// E17: what is read at a time of values at others is known then.
fn order(checker: &mut Checker<'_>, moment: &Moment, all: &[Moment]) {
    for &state in &moment.read {
        let mut others = all.iter();
        let Some(other) = others.find(|other| other.values.contains(&state)) else {
            continue;
        };
        let times = checker.at_default(moment.time);
        let Some((time, its)) = times.zip(checker.at_default(other.time)) else {
            continue;
        };
        if its >= time {
            let message = format!(
                "`{}` is not known at {time} s, where `{}` reads it; a condition between times is written in `finally`, as in \
                 `finally {{ at(2 [s], x) == 2*at(1 [s], x) }}`",
                checker.states[state].name.text, moment.shown
            );
            checker.diagnostics.report("E17", moment.place, message);
        }
    }
}
