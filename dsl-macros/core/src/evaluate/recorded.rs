//! Forces and impulses of contacts, in what is recorded and in optimal control.

use super::functions::one;
use super::scope::{Evaluation, Role};
use super::value::{Number, Value};
use crate::ast::{Expr, Kind};
use crate::diagnostics::{Checked, Diagnostics, Reported, closest, list};
use crate::dimension::Dimension;
use crate::graph::{self, Sym, Variable};
use std::ops::Range;

/// Number of the first dry friction in forces, until the number of contacts before it is known.
pub(crate) const FIRST_DRY: u16 = 1 << 15;

/// What a name of [`CONTACT_FUNCTIONS`](crate::words::CONTACT_FUNCTIONS) is of a contact.
fn quantity(text: &str) -> (fn(u16) -> Variable, bool) {
    match text {
        "force" => (Variable::ContactForce, true),
        "friction_force" => (Variable::FrictionForce, false),
        "impulse" => (Variable::ContactImpulse, true),
        _ => (Variable::FrictionImpulse, false),
    }
}

/// E24: where the force or the impulse of a contact has no meaning, what to write instead.
fn admit(role: Role, whole: &Expr, text: &str, diagnostics: &mut Diagnostics) -> Checked<()> {
    let is_force = matches!(text, "force" | "friction_force");
    let message = match (role, is_force) {
        (Role::Bound, _) if text == "force" => return Ok(()),
        (Role::Bound, _) => format!(
            "the bound of a dry friction may follow normal forces of surfaces and forces of joints, as in `bound mu*r*force(pad)`, and not `{whole}`"
        ),
        (Role::Record | Role::Constraint, _)
        | (Role::Running | Role::End, true)
        | (Role::Impact, false) => return Ok(()),
        (Role::Running, false) => format!(
            "`{whole}` acts at the instant of an impact, so that it has no integral; write \
             `sum({whole}^2)` in `minimize`, which adds up over all impacts"
        ),
        (Role::End, false) => format!(
            "`{whole}` is that of one impact, and there may be several; write `sum({whole})`, which adds up \
             over all of them, or limit each by `constraint limit: {whole} <= ...`"
        ),
        (Role::Impact, true) => format!(
            "`{whole}` acts over a time, and `sum` adds up over impacts; write `integral({whole}^2)` in \
             `minimize`, or an impulse"
        ),
        (Role::Motion | Role::Surface | Role::Draw, _) => format!(
            "`{text}` of a contact follows from the motion; it can be used in `outputs`, `minimize`, \
             `constraint` and `finally` only"
        ),
    };
    Err(diagnostics.report("E24", whole.place, message))
}

/// What `sum(expression)` adds up over all impacts, where that has a meaning.
pub(super) fn summand<'e>(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    arguments: &'e [Expr],
) -> Checked<&'e Expr> {
    if eval.scope.role != Role::End {
        let message = "`sum` adds a function of impulses up over all impacts; it stands in `minimize` and \
                       `finally` only, and not within `integral` or another `sum`";
        return Err(eval.diagnostics.report("E24", whole.place, message));
    }
    one("sum", whole, arguments, eval.diagnostics)
}

/// The sum of a value over all impacts.
pub(super) fn sum(eval: &mut Evaluation<'_>, argument: &Expr, value: Number) -> Checked<Value> {
    let sum = value.sym;
    if !graph::depends_on(sum, Variable::is_impulse) {
        let message = format!(
            "`{argument}` contains no impulse, and `sum` adds up over impacts; use `impulse(...)` of a surface in it"
        );
        return Err(eval.diagnostics.report("E24", argument.place, message));
    }
    at_impacts(sum, argument, eval.diagnostics)?;
    let known = eval.scope.sums.iter().position(|known| *known == sum);
    let index = known.unwrap_or_else(|| {
        eval.scope.sums.push(sum);
        eval.scope.sums.len() - 1
    });
    let sum = Sym::variable(Variable::Sum(index as u16));
    Ok(Value::Scalar(value.with(sum)))
}

/// E24: what holds at an impact knows no velocities, which jump there, and no controls.
pub(crate) fn at_impacts(value: Sym, expr: &Expr, diagnostics: &mut Diagnostics) -> Checked<()> {
    let what = graph::variables(&[value])
        .into_iter()
        .find_map(|variable| match variable {
            Variable::Velocity(_) => Some("a velocity, which jumps there"),
            Variable::Control(_) => Some("a control, which has no part in it"),
            known if known.is_force() => Some("a force, which has no part in it"),
            _ => None,
        });
    let Some(what) = what else { return Ok(()) };
    let message = format!(
        "`{expr}` stands where impulses act, at impacts, and contains {what}; use coordinates, the time and impulses"
    );
    Err(diagnostics.report("E24", expr.place, message))
}

/// `force(joint)`, a vector if the joint is several equations.
fn of_joint(
    role: Role,
    whole: &Expr,
    (text, name): (&str, &str),
    (rows, unit): (Range<usize>, &Dimension),
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let message = if text != "force" {
        format!("joint `{name}` has no `{text}`; what it carries is `force({name})`")
    } else if role == Role::End {
        format!(
            "`{whole}` acts over a time, by controls that have no value at the final instant; write `integral({whole}^2)` in `minimize`, or \
             a `constraint`"
        )
    } else if !matches!(
        role,
        Role::Record | Role::Running | Role::Constraint | Role::Bound
    ) {
        format!(
            "`{whole}` is the force of a joint, which follows from the motion; it can be used in `outputs`, in integrals of `minimize`, in \
             `constraint` and in bounds of dry friction only"
        )
    } else {
        let forces = rows.map(|row| Number {
            sym: Sym::variable(Variable::JointForce(row as u16)),
            unit: unit.clone(),
        });
        let mut forces: Vec<Number> = forces.collect();
        return Ok(match forces.len() {
            1 => Value::Scalar(forces.remove(0)),
            _ => Value::Vector(forces.into()),
        });
    };
    Err(diagnostics.report("E24", whole.place, message))
}

/// `force(surface)`, `friction_force(surface)`, `impulse(surface)` or `friction_impulse(surface)`.
pub(super) fn of_contact(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    text: &str,
    arguments: &[Expr],
) -> Checked<Value> {
    let Evaluation { scope, diagnostics } = eval;
    let [
        Expr {
            kind: Kind::Name(surface),
            ..
        },
    ] = arguments
    else {
        let message = format!("`{text}` takes the name of a surface, as in `{text}(ground)`");
        return Err(diagnostics.report("E02", whole.place, message));
    };
    let (variable, normal) = quantity(text);
    let unit = scope.units.of_contact(text, &surface.text);
    let joint = scope.joints.iter().find(|(name, _)| *name == surface.text);
    if let Some((name, rows)) = joint.cloned() {
        let force = of_joint(scope.role, whole, (text, &name), (rows, &unit), diagnostics)?;
        if !matches!(scope.role, Role::Record | Role::Bound) {
            scope.planned.get_or_insert(whole.place);
        }
        return Ok(force);
    }
    admit(scope.role, whole, text, diagnostics)?;
    if let Some(index) = scope.dry.iter().position(|name| *name == surface.text) {
        if text != "friction_force" {
            let message = format!(
                "dry friction `{0}` has no {1}; its own is `friction_force({0})`",
                surface.text,
                if text == "force" {
                    "normal force"
                } else {
                    "impulse, as its force is bounded"
                }
            );
            return Err(diagnostics.report("E24", whole.place, message));
        }
        let sym = Sym::variable(Variable::FrictionForce(FIRST_DRY + index as u16));
        return Ok(Value::Scalar(Number { sym, unit }));
    }
    let known = scope
        .surfaces
        .iter()
        .find(|(name, _)| *name == surface.text);
    let Some((_, contacts)) = known.cloned() else {
        if diagnostics.is_poisoned(&surface.text) {
            return Err(Reported);
        }
        let known = || scope.surfaces.iter().map(|(name, _)| name.as_str());
        let name = &surface.text;
        let message = match closest(name, known()) {
            _ if scope.surfaces.is_empty() => {
                format!("no surface `{name}` stands above this statement; declare it there")
            }
            Some(near) => format!("there is no surface `{name}` above; did you mean `{near}`?"),
            None => format!(
                "there is no surface `{name}` above (declared: {})",
                list(known())
            ),
        };
        return Err(diagnostics.report("E01", surface.place(), message));
    };
    if !normal {
        scope
            .rubbing
            .push((contacts.start, text.to_owned(), whole.place));
    }
    // That of all pieces.
    let parts = contacts.map(|index| Sym::variable(variable(index as u16)));
    let sym = parts.sum();
    Ok(Value::Scalar(Number { sym, unit }))
}
