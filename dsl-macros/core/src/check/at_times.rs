//! `at time { condition, ... }`: what holds at a time inside of the motion.
//!
//! Each condition is recorded at that time by a state that nothing else changes: it is set where `t >= time` comes true, as by `when`, and
//! has to be what the condition asks for at the end of the motion. A motion that ends before does not keep to it, as the state begins where no
//! condition holds.

use super::checker::{Checker, Moment, Reset};
use super::names::recorded;
use super::rules::smooth;
use super::states;
use super::values::of_an_instant;
use crate::ast::{Condition, Expr, Name, Relation};
use crate::diagnostics::{Checked, Reported};
use crate::evaluate::expression;
use crate::graph::{self, Sym, Variable};
use crate::scene;

/// What a recorded condition is before its time: it holds neither as an equation nor as an inequality.
const NOT_YET: f64 = -1.0;

pub(super) fn at(checker: &mut Checker<'_>, time: &Expr, conditions: &[Condition]) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    let moment = moment(checker, time);
    let mut values = Vec::new();
    for condition in conditions {
        if let Ok(value) = one(checker, condition, time) {
            values.push(value);
        }
    }
    if checker.diagnostics.mistakes() > before {
        return Err(Reported);
    }
    let mut moment = moment?;
    if conditions.is_empty() {
        let message = format!(
            "`at {time}` asks for nothing; write what holds then, as in `at {time} {{ x == 1 }}`"
        );
        return Err(checker.diagnostics.syntax(time.place, message));
    }
    let first = usize::from(checker.scope.first_state);
    moment.states = values.iter().map(|known| known.0).collect();
    checker.laws.resets.push(Reset {
        documentation: Default::default(),
        name: Name {
            text: moment.shown.clone(),
            ident: proc_macro2::Ident::new("at", time.place.start),
        },
        function: Sym::variable(Variable::Time) - moment.time,
        values: values
            .into_iter()
            .map(|(state, value)| (first + state, value))
            .collect(),
    });
    checker.moments.push(moment);
    Ok(())
}

/// The time of the conditions, which depends on parameters alone.
fn moment(checker: &mut Checker<'_>, time: &Expr) -> Checked<Moment> {
    let value = expression::scalar(&mut checker.scope, time, checker.diagnostics)?;
    let mut moving = graph::variables(&[value]).into_iter();
    if let Some(variable) = moving.find(|variable| !matches!(variable, Variable::Parameter(_))) {
        let message = format!(
            "`at {time}` depends on {}; a time is a number or follows from parameters, and one that is to be found is written \
             `at gate in 0.5..=2 [s] {{ ... }}`",
            checker.in_words(variable)
        );
        return Err(checker.diagnostics.report("E15", time.place, message));
    }
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
    })
}

/// Evaluates a condition and declares what it asks for; the state that records it, and the value that is recorded.
fn one(checker: &mut Checker<'_>, condition: &Condition, time: &Expr) -> Checked<(usize, Sym)> {
    let mut side = |expr: &Expr| {
        let value = of_an_instant(checker, expr)?;
        smooth(value, expr, checker)?;
        Ok(value)
    };
    let (left, right) = (side(&condition.left), side(&condition.right));
    let name = recorded(condition, time).text;
    let taken = |state: &usize| {
        let moments = checker.moments.iter();
        !moments
            .flat_map(|known| &known.states)
            .any(|other| other == state)
    };
    let mut all = (0..checker.states.len()).filter(taken);
    let state = all.find(|&state| checker.states[state].name.text == name);
    let (left, right, state) = (left?, right?, state.ok_or(Reported)?);
    let value = match condition.relation {
        Relation::AtMost => right - left,
        Relation::AtLeast | Relation::Equal => left - right,
    };
    let moves = |variable| !matches!(variable, Variable::Parameter(_) | Variable::Time);
    if !graph::depends_on(value, moves) {
        let message = format!(
            "`{condition}` is the same for every motion, so it is no condition; use coordinates, velocities or states"
        );
        let place = condition.left.place.to(condition.right.place);
        return Err(checker.diagnostics.report("E15", place, message));
    }
    let function = Sym::variable(states::variable(checker, state));
    checker.task.goals.push(vec![scene::Condition {
        name,
        documentation: condition.documentation.clone(),
        function,
        equality: condition.relation == Relation::Equal,
        unit: None,
    }]);
    Ok((state, value))
}

/// E17: the times lie inside of a motion whose length is given, and what is recorded begins where nothing holds.
pub(super) fn finish(checker: &mut Checker<'_>, velocities: &mut [Sym]) {
    let first = usize::from(checker.scope.first_state);
    let free_time = checker.scope.used.contains(crate::words::FINAL_TIME);
    let horizon = checker.horizon.filter(|_| !free_time);
    let horizon = horizon.and_then(|horizon| checker.at_default(horizon));
    for moment in std::mem::take(&mut checker.moments) {
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
