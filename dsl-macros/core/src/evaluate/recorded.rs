//! Forces and impulses of contacts in what is recorded.

use super::scope::{Role, Scope};
use super::value::Value;
use crate::ast::{Expr, Kind};
use crate::diagnostics::{Checked, Diagnostics, Reported, closest, list};
use crate::graph::{Sym, Variable};

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

/// `force(surface)`, `friction_force(surface)`, `impulse(surface)` or `friction_impulse(surface)`.
pub(super) fn of_contact(
    scope: &mut Scope,
    whole: &Expr,
    text: &str,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    if scope.role != Role::Record {
        let message = format!(
            "`{text}` of a contact follows from the motion; it can be used in `outputs` only"
        );
        return Err(diagnostics.report("E24", whole.place, message));
    }
    let surface = match arguments {
        [
            Expr {
                kind: Kind::Name(surface),
                ..
            },
        ] => surface,
        _ => {
            let message = format!("`{text}` takes the name of a surface, as in `{text}(ground)`");
            return Err(diagnostics.report("E02", whole.place, message));
        }
    };
    let (variable, normal) = quantity(text);
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
        let force = Variable::FrictionForce(FIRST_DRY + index as u16);
        return Ok(Value::Scalar(Sym::variable(force)));
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
                format!("no surface `{name}` stands above `outputs`; declare it there")
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
    Ok(Value::Scalar(parts.sum()))
}
