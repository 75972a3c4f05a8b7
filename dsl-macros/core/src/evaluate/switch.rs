//! `sign`, `step`, `if`, `max`, `min` and `|x|` in what acts: switches, which a variable stands for until it is known what they
//! act on.

use super::scope::{Role, Scope};
use super::value::Value;
use crate::ast::Expr;
use crate::diagnostics::{Checked, Diagnostics, Place};
use crate::graph::{self, Compose, Sym, Variable};
use crate::words;

/// A function of the motion whose sign switches what acts.
#[derive(Clone)]
pub(crate) struct Switch {
    /// What stands for the sign of `function`, or for its size where it is a kink.
    pub(crate) variable: Variable,
    pub(crate) function: Sym,
    /// Whether only the derivative of what acts jumps.
    pub(crate) kink: bool,
    /// As written.
    pub(crate) shown: String,
    pub(crate) place: Place,
}

/// Whether switches may stand here: in forces and rates, and in what is given a name for them.
pub(super) fn admitted(scope: &Scope) -> bool {
    scope.role == Role::Motion && (scope.acts || scope.defers)
}

/// Whether a value contains a switch.
pub(super) fn has_switch(components: &[Sym]) -> bool {
    let mut variables = graph::variables(components).into_iter();
    variables.any(|variable| matches!(variable, Variable::Switch(_)))
}

/// Whether a function is a switch where those may stand.
pub(super) fn is_switch(text: &str) -> bool {
    words::EDGES.contains(&text) || words::JUMPS.contains(&text) || text == words::IF
}

/// The value of a switch of these arguments.
pub(super) fn call(
    scope: &mut Scope,
    whole: &Expr,
    (text, arguments): (&str, &[Expr]),
    parts: &[Sym],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let wanted = match text {
        "max" | "min" => 2,
        words::IF => 4,
        _ => 1,
    };
    if parts.len() != wanted {
        let message = if wanted == 2 && parts.len() > 2 {
            format!(
                "`{text}` of {} in what acts would switch where other switches do; write it of two smooth functions, and \
                 `if c {{ a }} else {{ b }}` for more cases",
                parts.len()
            )
        } else {
            let plural = if wanted == 1 { "" } else { "s" };
            format!("`{text}` takes {wanted} argument{plural}, found {}", parts.len())
        };
        return Err(diagnostics.report("E02", whole.place, message));
    }
    let half = |value: Sym| value.scaled(0.5);
    let value = match (text, parts) {
        ("abs", &[part]) => switch(scope, whole, (part, true), diagnostics)?,
        ("max" | "min", &[a, b]) => {
            let apart = switch(scope, whole, (a - b, true), diagnostics)?;
            let sign = if text == "min" { -1.0 } else { 1.0 };
            half(a + b + apart.scaled(sign))
        }
        (words::IF, &[left, right, yes, no]) => {
            let sign = switch(scope, &arguments[0], (left - right, false), diagnostics)?;
            half(yes + no + (yes - no) * sign)
        }
        ("sign" | "signum", &[part]) => switch(scope, whole, (part, false), diagnostics)?,
        (_, &[part]) => {
            let sign = switch(scope, whole, (part, false), diagnostics)?;
            half(sign + Sym::ONE)
        }
        _ => Sym::ZERO,
    };
    Ok(Value::Scalar(value))
}

/// The size of a number in what acts.
pub(super) fn size(
    scope: &mut Scope,
    whole: &Expr,
    part: Sym,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    switch(scope, whole, (part, true), diagnostics).map(Value::Scalar)
}

/// What stands for the sign of a function, or for its size; the same for the same function.
fn switch(
    scope: &mut Scope,
    whole: &Expr,
    (function, kink): (Sym, bool),
    diagnostics: &mut Diagnostics,
) -> Checked<Sym> {
    if let Some(value) = function.as_number() {
        let sign = if value == 0.0 { 0.0 } else { value.signum() };
        return Ok(Sym::number(if kink { value.abs() } else { sign }));
    }
    let known = scope.switches.iter();
    let mut known = known.filter(|known| known.function == function && known.kink == kink);
    if let Some(known) = known.next() {
        return Ok(Sym::variable(known.variable));
    }
    let variables = graph::variables(&[function]);
    let wrong = variables.iter().find_map(|variable| match variable {
        Variable::Switch(_) => Some((
            "E12",
            "switches itself, so that it has no rate where it would vanish; switch by a smooth function, and \
             put one `if` inside of the braces of another",
        )),
        Variable::Control(_) => Some((
            "E07",
            "depends on a control, which may jump; switch by what moves, and let the control act in its place",
        )),
        _ => None,
    });
    let moves = variables.iter().any(|variable| {
        matches!(
            variable,
            Variable::Coordinate(_) | Variable::Velocity(_) | Variable::Time
        )
    });
    let still = "depends on nothing that changes, so that it never switches; write a parameter of 1 or -1 in its place";
    if let Some((code, why)) = wrong.or((!moves).then_some(("E07", still))) {
        let message = format!("what `{whole}` switches by {why}");
        return Err(diagnostics.report(code, whole.place, message));
    }
    let variable = Variable::Switch(scope.switches.len() as u16);
    scope.switches.push(Switch {
        variable,
        function,
        kink,
        shown: whole.to_string(),
        place: whole.place,
    });
    Ok(Sym::variable(variable))
}
