//! `max`, `min` and `|x|`, which may stand in a surface, and in what is recorded and drawn.

use super::kink::{Kink, has_switch};
use super::scope::{Evaluation, Role, Scope};
use crate::ast::{Expr, Kind};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::graph::{self, Compose, Function, Node, Sym, Variable};
use crate::words;

/// Whether `max`, `min` and `|x|` may stand there.
pub(super) fn admitted(scope: &Scope) -> bool {
    scope.takes_apart || matches!(scope.role, Role::Surface | Role::Record | Role::Draw)
}

/// Whether a function with a kink or a jump may stand here, with so many arguments; E12 otherwise.
pub(super) fn admit(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    (text, arguments): (&str, usize),
) -> Checked<()> {
    let known = words::EDGES.contains(&text);
    if !known || !admitted(eval.scope) {
        let message = format!(
            "`{text}` has a kink or a jump, {}",
            remedy(eval.scope.role, known)
        );
        return Err(eval.diagnostics.report("E12", whole.place, message));
    }
    let (wanted, fits) = match text {
        "abs" => ("1 argument", arguments == 1),
        "clamp" => ("3 arguments", arguments == 3),
        _ => ("2 arguments or more", arguments >= 2),
    };
    if fits {
        return Ok(());
    }
    let message = format!("`{text}` takes {wanted}, found {arguments}");
    Err(eval.diagnostics.report("E02", whole.place, message))
}

/// Why there must be no kink or jump, and what to write instead of one, or of one that a surface may have.
fn remedy(role: Role, surface: bool) -> &'static str {
    match role {
        Role::Running | Role::Impact => {
            "which an objective must not have; for the size of a control declare two that are at least 0, and add up \
             their sum, or square it"
        }
        Role::Constraint | Role::End => {
            "which objectives, constraints and goals must not have; write a condition for each side, as `x <= c` and \
             `x >= -c`, or square it"
        }
        Role::Motion | Role::Bound if surface => {
            "which energies and laws must not have; write what acts in `forces`, which may switch, or declare a `surface`, \
             which may contain it, where the motion strikes"
        }
        Role::Motion | Role::Bound => {
            "which energies and laws must not have; write what acts in `forces`, which may switch, or declare a `surface` \
             where the motion strikes"
        }
        _ if surface => {
            "which smooth dynamics must not have; declare a `surface`, which may contain it, where the motion switches"
        }
        _ => "which smooth dynamics must not have; declare a `surface` where the motion switches",
    }
}

/// E12: a bar around a number that is neither in a surface nor in what is shown.
pub(super) fn refuse_size(eval: &mut Evaluation<'_>, inner: &Expr, part: Sym) -> Reported {
    let why = match eval.scope.role {
        Role::Motion | Role::Bound if is_velocity(part) => format!(
            "a kink at 0; for a drag write `sqrt({}^2 + v_0^2)` in its place, with a small speed `v_0`, and for dry \
             friction `dry friction name: bound f, sliding {inner}`",
            match &inner.kind {
                Kind::Name(_) | Kind::Call { .. } | Kind::Component { .. } => inner.to_string(),
                _ => format!("({inner})"),
            }
        ),
        Role::Running | Role::Impact | Role::Constraint | Role::End => {
            format!("a kink at 0, {}", remedy(eval.scope.role, false))
        }
        _ => format!("a kink at 0, {}", remedy(eval.scope.role, true)),
    };
    let message = format!("`|{inner}|` of a number has {why}");
    eval.diagnostics.report("E12", inner.place, message)
}

/// Whether a value moves with velocities.
fn is_velocity(part: Sym) -> bool {
    graph::depends_on(part, Variable::is_velocity)
}

/// E12: the sign of a velocity, which is dry friction.
pub(super) fn refuse_sign(
    whole: &Expr,
    argument: &Expr,
    part: Sym,
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    if !is_velocity(part) {
        return Ok(());
    }
    let message = format!(
        "`{whole}` jumps where a motion comes to rest, which is dry friction; write the statement `dry friction name: bound f, \
         sliding {argument}`, with the size `f` of the force"
    );
    Err(diagnostics.report("E12", whole.place, message))
}

/// What `max`, `min`, `clamp` or `abs` of some parts is: in a surface or a condition a variable, the same one for the same parts.
pub(super) fn call(scope: &mut Scope, text: &str, mut parts: Vec<Sym>) -> Sym {
    if let ("clamp", &[part, low, high]) = (text, &parts[..]) {
        let below = call(scope, "min", vec![part, high]);
        return call(scope, "max", vec![below, low]);
    }
    if scope.role != Role::Surface && !scope.takes_apart {
        return computed(text, &parts);
    }
    if let ("abs", [part]) = (text, &parts[..]) {
        parts.push(-*part);
    }
    let largest = text != "min";
    let known = scope.kinks.iter();
    let mut known = known.filter(|kink| kink.largest == largest && kink.parts == parts);
    let variable = known.next().map(|kink| kink.variable);
    let variable = variable.unwrap_or_else(|| {
        scope.arguments += 1;
        let variable = Variable::Argument(scope.arguments);
        scope.kinks.push(Kink {
            variable,
            largest,
            parts,
        });
        variable
    });
    Sym::variable(variable)
}

/// A maximum or minimum as a number: `max(a, b) = (a + b + |a - b|)/2`.
fn computed(text: &str, parts: &[Sym]) -> Sym {
    let sign = if text == "min" { -1.0 } else { 1.0 };
    let mut parts = parts.iter().copied();
    let first = parts.next().unwrap_or(Sym::ZERO);
    if text == "abs" {
        return first.call(Function::Abs);
    }
    parts.fold(first, |largest, part| {
        let apart = (largest - part).call(Function::Abs).scaled(sign);
        (largest + part + apart).scaled(0.5)
    })
}

/// Whether an expression that is computed contains an edge.
pub(crate) fn has_edge(components: &[Sym]) -> bool {
    let mut parts = graph::reachable(components).into_iter();
    parts.any(|part| matches!(part.node(), Node::Call(Function::Abs, _)))
}

/// E12: what has an edge has no derivative there.
pub(super) fn differentiable(
    eval: &mut Evaluation<'_>,
    components: &[Sym],
    (shown, place): (&str, Place),
) -> Checked<()> {
    let edge = |variable| {
        eval.scope
            .kinks
            .iter()
            .any(|kink| kink.variable == variable)
    };
    let switches = has_switch(components);
    if !switches && !graph::variables(components).into_iter().any(edge) && !has_edge(components) {
        return Ok(());
    }
    let message = format!(
        "`{shown}` contains `max`, `min` or `|x|`, which have no derivative at the edge; differentiate the pieces"
    );
    Err(eval.diagnostics.report("E12", place, message))
}
