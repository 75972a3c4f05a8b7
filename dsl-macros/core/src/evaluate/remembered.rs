//! `start(...)` and `peak(...)`: what a quantity is at the start of the motion, and at most over all of it, in what is judged of it.

use super::functions::one;
use super::kink::Peak;
use super::scope::{Evaluation, Role, Scope};
use super::value::{Number, Value};
use crate::ast::Expr;
use crate::diagnostics::Checked;
use crate::graph::{self, Sym, Variable};

/// What `start(...)` is asked of, where that has a meaning.
pub(super) fn argument<'e>(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    arguments: &'e [Expr],
) -> Checked<&'e Expr> {
    if !matches!(
        eval.scope.role,
        Role::Running | Role::Constraint | Role::End
    ) {
        let message = format!(
            "`{whole}` is known to `minimize`, `constraint` and `finally` only, which judge a motion as a whole; elsewhere a \
             parameter that `start` names says the same"
        );
        return Err(eval.diagnostics.report("E15", whole.place, message));
    }
    one("start", whole, arguments, eval.diagnostics)
}

/// The value of the argument with the start of the motion in the place of its coordinates and velocities.
pub(super) fn at_start(
    eval: &mut Evaluation<'_>,
    (whole, argument): (&Expr, &Expr),
    known: &Value,
) -> Checked<Value> {
    for variable in graph::variables(&known.syms()) {
        let what = match variable {
            Variable::Coordinate(_) | Variable::Velocity(_) | Variable::Parameter(_) => continue,
            Variable::Start(_) => "a value at the start already",
            Variable::Control(_) => "a control, which acts over a time",
            Variable::Time => "the time, which begins at 0 there",
            _ => "what contacts do, which begins with the motion",
        };
        let message = format!(
            "`{whole}` contains {what}; `start` takes coordinates, velocities, states and what follows from them"
        );
        return Err(eval.diagnostics.report("E15", argument.place, message));
    }
    let size = eval.scope.state_size;
    let place = |variable| match variable {
        Variable::Coordinate(i) => Some(i),
        Variable::Velocity(i) => Some(size + i),
        _ => None,
    };
    let read = graph::variables(&known.syms());
    let read = read.into_iter().filter_map(place);
    let read = read.map(|k| (k, whole.to_string(), whole.place));
    eval.scope.starts.extend(read);
    let components = graph::substitute(&known.syms(), |variable| {
        place(variable).map(|k| Sym::variable(Variable::Start(k)))
    });
    Ok(known.with_syms(components))
}

/// What `peak(...)` is asked of, where that has a meaning.
pub(super) fn over_the_motion<'e>(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    arguments: &'e [Expr],
) -> Checked<&'e Expr> {
    let argument = one("peak", whole, arguments, eval.diagnostics)?;
    let why = match eval.scope.role {
        Role::End => return Ok(argument),
        Role::Constraint => {
            "a `constraint` holds all the time by itself; write what is inside of `peak` in its place"
        }
        Role::Running => {
            "an integral adds up over the motion what is one number of it; leave `peak` in front of it, as a term by itself"
        }
        _ => "it judges a motion as a whole, in `minimize` and `finally`",
    };
    let message = format!("`{whole}` is the largest value over the motion: {why}");
    Err(eval.diagnostics.report("E15", whole.place, message))
}

/// The unknown that is the largest value of this one over the motion.
pub(super) fn peak(scope: &mut Scope, whole: &Expr, value: Number) -> Value {
    let shown = whole.to_string();
    let known = scope.peaks.iter().find(|known| known.shown == shown);
    if let Some(known) = known {
        return Value::Scalar(value.with(Sym::variable(known.variable)));
    }
    let variable = Variable::Epigraph(scope.epigraphs);
    scope.epigraphs += 1;
    scope.peaks.push(Peak {
        variable,
        value: value.sym,
        shown,
    });
    Value::Scalar(value.with(Sym::variable(variable)))
}
