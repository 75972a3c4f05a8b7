//! Quantities that are recorded along every motion.

use super::checker::Checker;
use crate::ast::{Expr, Quantity};
use crate::diagnostics::Checked;
use crate::evaluate::{Contents, Meaning, Number, Role, Value, has_edge};
use crate::graph::{self, Compose, Variable};
use crate::scene::{self, Contact};

/// Most outputs of one scene.
const MOST: usize = 500;

/// `outputs { name: unit = expression, ... }`; what follows may use them by name.
pub(super) fn outputs(checker: &mut Checker<'_>, quantities: &[Quantity]) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    for quantity in quantities {
        // Each reports its own mistakes; the next one is checked all the same.
        if output(checker, quantity).is_err() {
            checker.diagnostics.poison(&quantity.name.text);
        }
    }
    checker.diagnostics.none_since(before)
}

fn output(checker: &mut Checker<'_>, quantity: &Quantity) -> Checked<()> {
    let name = &quantity.name;
    let free = checker.new_name(name, "output");
    let declared = quantity.unit.as_ref();
    checker.scope.later.remove(&name.text);
    if let Some((lower, _)) = &quantity.bounds {
        let message = format!(
            "output `{0}` has no bounds; limit it by `constraint limit: {0} <= ...`",
            name.text
        );
        checker.diagnostics.syntax(lower.place, message);
    }
    let Some(expr) = &quantity.value else {
        let unit = declared.map(|unit| format!(": {}", unit.text));
        let message = format!(
            "output `{0}` needs an expression, as in `{0}{1} = ...`",
            name.text,
            unit.unwrap_or_default()
        );
        return Err(checker.diagnostics.syntax(name.place(), message));
    };
    let value = recorded(checker, expr, quantity);
    free?;
    let own = value?;
    let value = own.sym;
    if checker.shown.outputs.len() >= MOST {
        let message = format!("a scene has at most {MOST} outputs");
        return Err(checker.diagnostics.syntax(name.place(), message));
    }
    let contents = Contents {
        contacts: graph::depends_on(value, Variable::is_of_contact),
        edges: has_edge(&[value]),
    };
    checker.scope.recorded.insert(name.text.clone(), contents);
    let mut unit = own.unit.clone();
    if let Some(written) = declared {
        let units = &mut checker.scope.units;
        unit = units.of(written.unit);
        let reason = format!("output `{}` is declared so", name.text);
        checker.given(expr, &own, &unit, &reason);
    }
    let meaning = Meaning::Value(Value::Scalar(own.in_unit(unit)));
    checker.scope.names.insert(name.text.clone(), meaning);
    checker.shown.outputs.push(scene::Output {
        name: name.clone(),
        unit: quantity.unit.clone(),
        inferred: None,
        documentation: quantity.documentation.clone(),
        value,
    });
    Ok(())
}

/// The value of an output, of which a bare number is meant in the declared unit.
fn recorded(checker: &mut Checker<'_>, expr: &Expr, quantity: &Quantity) -> Checked<Number> {
    checker.scope.role = Role::Record;
    let value = checker.value(expr);
    let value = value.and_then(|value| match value {
        Value::Vector(components) => {
            let message = format!(
                "`{expr}` is a vector with {} components, and an output is a number; record its components one by \
                 one, as in `{}_y = ({expr}).y`",
                components.len(),
                quantity.name.text
            );
            Err(checker.diagnostics.report("E02", expr.place, message))
        }
        _ => checker.number(expr),
    });
    checker.scope.role = Role::Motion;
    let scale = scene::scale(quantity.unit.as_ref());
    value.map(|value| match expr.is_bare() {
        true => value.with(value.sym.scaled(scale)),
        false => value,
    })
}

/// Units that follow from the expressions, and whether the contacts have the friction that is recorded.
pub(super) fn finish(checker: &mut Checker<'_>, contacts: &[Contact]) {
    for i in 0..checker.shown.outputs.len() {
        let name = checker.shown.outputs[i].name.text.clone();
        let unit = checker.unit_of(&name);
        checker.shown.outputs[i].inferred = checker.scope.units.known(&unit);
    }
    for (index, function, place) in std::mem::take(&mut checker.scope.rubbing) {
        if let Some(contact) = contacts.get(index)
            && contact.friction.is_none()
        {
            let name = &contact.name.text;
            let message = format!(
                "contact `{name}` has no friction; declare it by `impact {name}: ..., friction mu`, or leave \
                 `{function}({name})` out"
            );
            checker.diagnostics.report("E24", place, message);
        }
    }
}
