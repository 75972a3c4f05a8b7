//! `sign`, `step`, `if`, `max`, `min`, `clamp` and `|x|` in what acts: switches, which a variable stands for until it is known what they
//! act on.

use super::functions::takes;
use super::kink::Switch;
use super::scope::{Evaluation, Role, Scope};
use crate::ast::Expr;
use crate::diagnostics::{Checked, Place};
use crate::graph::{self, Compose, Function, Sym, Variable};
use crate::words;

/// Whether a jump may stand here: where switches may, and in what is recorded.
pub(super) fn may_jump(scope: &Scope, text: &str) -> bool {
    let jumps = words::JUMPS.contains(&text) || text == words::IF;
    scope.role == Role::Record && jumps
}

/// Whether a function is a switch where those may stand.
pub(super) fn is_switch(text: &str) -> bool {
    words::EDGES.contains(&text) || words::JUMPS.contains(&text) || text == words::IF
}

/// The value of a switch of these arguments.
pub(super) fn call(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    (text, arguments): (&str, &[Expr]),
    parts: &[Sym],
) -> Checked<Sym> {
    let wanted = match text {
        "max" | "min" => 2,
        "clamp" => 3,
        words::IF => 4,
        _ => 1,
    };
    if wanted == 2 && parts.len() > 2 {
        let message = format!(
            "`{text}` of {} in what acts would switch where other switches do; write it of two smooth functions, and \
             `if c {{ a }} else {{ b }}` for more cases",
            parts.len()
        );
        return Err(eval.diagnostics.report("E02", whole.place, message));
    }
    takes((text, wanted), parts.len(), whole.place, eval.diagnostics)?;
    let half = |value: Sym| value.scaled(0.5);
    Ok(match (text, parts) {
        ("abs", &[part]) => switch(eval, shown(whole), (part, true))?,
        ("max" | "min", &[a, b]) => {
            let apart = switch(eval, shown(whole), (a - b, true))?;
            let sign = if text == "min" { -1.0 } else { 1.0 };
            half(a + b + apart.scaled(sign))
        }
        ("clamp", &[part, low, high]) => {
            let mut side = |sign: &str, bound: usize, apart: Sym| {
                let shown = format!("{} {sign} {}", arguments[0], arguments[bound]);
                switch(eval, (shown, whole.place), (apart, true))
            };
            let above = side(">=", 1, part - low)?;
            let beyond = side("<=", 2, part - high)?;
            half(low + high + above - beyond)
        }
        (words::IF, &[left, right, yes, no]) => {
            let shown = format!("{} >= {}", arguments[0], arguments[1]);
            let place = arguments[0].place.to(arguments[1].place);
            let sign = switch(eval, (shown, place), (left - right, false))?;
            half(yes + no + (yes - no) * sign)
        }
        ("sign" | "signum", &[part]) => switch(eval, shown(whole), (part, false))?,
        (_, &[part]) => {
            let sign = switch(eval, shown(whole), (part, false))?;
            half(sign + Sym::ONE)
        }
        _ => Sym::ZERO,
    })
}

/// The size of a number in what acts.
pub(super) fn size(eval: &mut Evaluation<'_>, whole: &Expr, part: Sym) -> Checked<Sym> {
    switch(eval, shown(whole), (part, true))
}

/// An expression as written, and its place.
fn shown(expr: &Expr) -> (String, Place) {
    (expr.to_string(), expr.place)
}

/// What stands for the sign of a function, or for its size; the same for the same function.
fn switch(
    eval: &mut Evaluation<'_>,
    (shown, place): (String, Place),
    (function, kink): (Sym, bool),
) -> Checked<Sym> {
    if let Some(value) = function.as_number() {
        let sign = if value == 0.0 { 0.0 } else { value.signum() };
        return Ok(Sym::number(if kink { value.abs() } else { sign }));
    }
    for known in eval
        .scope
        .switches
        .iter()
        .filter(|known| known.kink == kink)
    {
        let variable = Sym::variable(known.variable);
        if known.function == function {
            return Ok(variable);
        }
        if known.function == -function {
            return Ok(if kink { variable } else { -variable });
        }
    }
    let variables = graph::variables(&[function]);
    let moving = |variable: &Variable| {
        matches!(
            variable,
            Variable::Coordinate(_)
                | Variable::Velocity(_)
                | Variable::Time
                | Variable::Parameter(_)
        )
    };
    if eval.scope.role == Role::Record && !variables.iter().all(moving) {
        return Ok(function.call(Function::Sign));
    }
    let wrong = variables.iter().find_map(|variable| match variable {
        Variable::Switch(_) => Some((
            "E12",
            "switches itself, so that it has no rate where it would vanish; write `clamp(x, low, high)` for what saturates on both \
             sides, or switch by a smooth function",
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
    let still = (!moves && eval.scope.role != Role::Record).then_some(("E07", still));
    if let Some((code, why)) = wrong.or(still) {
        let message = format!("what `{shown}` switches by {why}");
        return Err(eval.diagnostics.report(code, place, message));
    }
    let variable = Variable::Switch(eval.scope.switches.len() as u16);
    eval.scope.switches.push(Switch {
        variable,
        function,
        kink,
        shown,
        place,
    });
    Ok(Sym::variable(variable))
}
