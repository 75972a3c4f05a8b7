//! Names: what is declared, what may not be, what is taken.

use super::checker::{Checker, Of};
use super::{states, values};
use crate::ast::{Condition, Documentation, Expr, Name, Quantity, Statement, WrittenUnit};
use crate::diagnostics::{Checked, Reported};
use crate::evaluate::{Meaning, Number, Value};
use crate::graph::{Compose, Sym, Variable};
use crate::scene::{self, Coordinate, FreeParameter, Parameter};

/// Most coordinates, and most parameters or controls, of one scene.
const MOST: usize = 500;

/// Declares parameters, coordinates and controls, wherever they stand; notes the names of
/// abbreviations and functions that come later.
pub(super) fn declare_all(checker: &mut Checker<'_>, statements: &[Statement]) {
    checker.scope.units.begin(declares_units(statements));
    for statement in statements {
        if let Statement::Parameters(quantities) = statement {
            let names = quantities.iter().map(|quantity| quantity.name.text.clone());
            checker.scope.later.extend(names);
        }
    }
    for statement in statements {
        match statement {
            Statement::Parameters(quantities) => declare(checker, quantities, parameter),
            Statement::Coordinates(quantities) => {
                declare(checker, quantities, |checker, quantity| {
                    listed(checker, quantity, Of::Coordinates)
                });
            }
            Statement::Controls(quantities) => {
                declare(checker, quantities, |checker, quantity| {
                    listed(checker, quantity, Of::Controls)
                });
            }
            Statement::Let { name, .. } | Statement::Function { name, .. } => {
                checker.scope.later.insert(name.text.clone());
            }
            Statement::Outputs(quantities) => {
                for quantity in quantities {
                    checker.scope.later.insert(quantity.name.text.clone());
                }
            }
            _ => {}
        }
    }
    // Behind all coordinates.
    checker.scope.first_state = checker.coordinates.len() as u16;
    for statement in statements {
        if let Statement::States(quantities) = statement {
            declare(checker, quantities, |checker, quantity| {
                listed(checker, quantity, Of::States)
            });
        }
    }
    declare_recorded(checker, statements);
    checker.scope.state_size = (checker.coordinates.len() + checker.states.len()) as u16;
    checker.tell_units();
}

fn declares_units(statements: &[Statement]) -> bool {
    statements.iter().any(|statement| match statement {
        Statement::Parameters(list)
        | Statement::Coordinates(list)
        | Statement::Controls(list)
        | Statement::States(list) => list.iter().any(|quantity| {
            let mut value = quantity.value.iter();
            quantity.unit.is_some() || value.any(|value| value.any(&|part| part.unit().is_some()))
        }),
        _ => false,
    })
}

fn declare(
    checker: &mut Checker<'_>,
    quantities: &[Quantity],
    one: impl Fn(&mut Checker<'_>, &Quantity) -> Checked<()>,
) {
    for quantity in quantities {
        // Reported where it fails; the others are declared all the same.
        if one(checker, quantity).is_err() {
            checker.diagnostics.poison(&quantity.name.text);
        }
    }
}

/// E19: where a scene is compiled, no two parameters are one field, as `m[1]` and `m_1` would be.
fn field(checker: &mut Checker<'_>, name: &Name) -> Checked<()> {
    if checker.diagnostics.is_data {
        return Ok(());
    }
    let field = name.rust();
    let mut known = checker.parameters.iter().map(|known| &known.name);
    let Some(known) = known.find(|known| known.rust() == field) else {
        return Ok(());
    };
    let message = format!(
        "`{}` and `{}` are both the field `{field}` in Rust; rename one",
        known.text, name.text
    );
    Err(checker.diagnostics.report("E19", name.place(), message))
}

fn parameter(checker: &mut Checker<'_>, quantity: &Quantity) -> Checked<()> {
    let name = &quantity.name;
    checker.scope.later.remove(&name.text);
    checker.new_name(name, "parameter")?;
    field(checker, name)?;
    room(checker, name, checker.parameters.len())?;
    // Declared even if its value is missing or wrong, so that its uses give no second message.
    let index = checker.parameters.len() as u16;
    let unit = quantity.unit.clone();
    let sym = Sym::variable(Variable::Parameter(index)).scaled(scene::scale(unit.as_ref()));
    declare_value(checker, name, sym, unit.as_ref());
    let default = match &quantity.value {
        Some(value) => values::default_value(checker, quantity, value),
        None => {
            let shown = unit.as_ref().map_or("", |unit| unit.text.as_str());
            let colon = if shown.is_empty() { "" } else { ": " };
            Err(checker.diagnostics.syntax(
                name.place(),
                format!(
                    "parameter `{0}` needs a default value, as in `{0}{colon}{shown} = 1`",
                    name.text
                ),
            ))
        }
    };
    if let Some((lower, _)) = quantity.bounds.as_ref().filter(|_| !quantity.free) {
        checker.diagnostics.syntax(
            lower.place,
            format!(
                "bounds belong to coordinates, controls and free parameters; parameter `{0}` has none: leave them out, or \
                 write `free {0}...` outside of `parameters` if `solve` is to find it",
                name.text
            ),
        );
    }
    if quantity.free {
        checker.free_parameters.push(FreeParameter {
            index,
            bounds: (Sym::ZERO, Sym::ZERO),
        });
    }
    checker.parameters.push(Parameter {
        name: name.clone(),
        unit,
        documentation: quantity.documentation.clone(),
        default: default.unwrap_or(f64::NAN),
    });
    Ok(())
}

/// A coordinate, a control or a state.
fn listed(checker: &mut Checker<'_>, quantity: &Quantity, of: Of) -> Checked<()> {
    let name = &quantity.name;
    let what = match of {
        Of::Coordinates => "coordinate",
        Of::Controls => "control",
        Of::States => "state",
    };
    checker.new_name(name, what)?;
    let index = checker.list(of).len();
    room(checker, name, index)?;
    if let Some(value) = &quantity.value {
        let text = &name.text;
        let message = match of {
            Of::Controls => {
                format!("control `{text}` has no value of its own; leave `= ...` out")
            }
            Of::Coordinates | Of::States => {
                format!("initial values belong to `start {{ {text}: ... }}`; leave `= ...` out")
            }
        };
        checker.diagnostics.syntax(value.place, message);
    }
    let variable = match of {
        Of::Coordinates => Variable::Coordinate(index as u16),
        Of::Controls => Variable::Control(index as u16),
        Of::States => states::variable(checker, index),
    };
    let scale = scene::scale(quantity.unit.as_ref());
    let sym = Sym::variable(variable).scaled(scale);
    declare_value(checker, name, sym, quantity.unit.as_ref());
    checker.list(of).push(Coordinate {
        name: name.clone(),
        unit: quantity.unit.clone(),
        documentation: quantity.documentation.clone(),
        bounds: None,
    });
    Ok(())
}

/// Declares the states that record conditions, behind all others.
fn declare_recorded(checker: &mut Checker<'_>, statements: &[Statement]) {
    for statement in statements {
        let Statement::At {
            time,
            conditions,
            values,
            ..
        } = statement
        else {
            continue;
        };
        let mut names: Vec<(Name, Documentation)> = conditions
            .iter()
            .map(|condition| (recorded(condition, time), condition.documentation.clone()))
            .collect();
        if conditions.is_empty() && !values.is_empty() {
            names.push((reached(time), Documentation::default()));
        }
        for value in values {
            let name = value.target.clone();
            let state = Sym::variable(states::variable(
                checker,
                checker.states.len() + names.len(),
            ));
            declare_value(checker, &name, state, None);
            names.push((name, Documentation::default()));
        }
        for (name, documentation) in names {
            if room(checker, &name, checker.states.len()).is_err() {
                return;
            }
            checker.states.push(Coordinate {
                name,
                unit: None,
                documentation,
                bounds: None,
            });
        }
    }
}

/// The name of the state that tells whether a time has come.
pub(super) fn reached(time: &Expr) -> Name {
    Name::at(time.place, format!("t >= {time}"))
}

/// The name of the state that records a condition.
pub(super) fn recorded(condition: &Condition, time: &Expr) -> Name {
    Name::at(condition.left.place, format!("{condition} at {time}"))
}

fn room(checker: &mut Checker<'_>, name: &Name, taken: usize) -> Checked<()> {
    if taken < MOST {
        return Ok(());
    }
    let error: Reported = checker.diagnostics.syntax(
        name.place(),
        format!("a scene has at most {MOST} quantities of one kind"),
    );
    Err(error)
}

fn declare_value(checker: &mut Checker<'_>, name: &Name, sym: Sym, unit: Option<&WrittenUnit>) {
    let unit = checker.scope.units.declared(&name.text, unit);
    let meaning = Meaning::Value(Value::Scalar(Number { sym, unit }));
    checker.scope.names.insert(name.text.clone(), meaning);
}
