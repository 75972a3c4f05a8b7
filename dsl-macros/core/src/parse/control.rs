//! Statements of optimal control: objective, constraints, terminal conditions, free initial values.

use super::cursor::Cursor;
use super::documentation::documentation;
use super::expression::{compared, expression};
use super::pieces::{assignment, block, entries, named, range, target};
use crate::ast::{
    Condition, Documentation, Expr, FreeStart, Kind, Name, Quantity, Relation, Statement,
    WrittenUnit,
};
use crate::diagnostics::{Checked, Reported};
use hangtime_units::Unit;

/// `finally { condition, ... }`.
pub(super) fn finally(cursor: &mut Cursor, word: &Name) -> Checked<Statement> {
    let inner = block(cursor, word)?;
    Ok(Statement::Finally(conditions(inner)))
}

fn conditions(inner: Cursor) -> Vec<Condition> {
    entries(inner, |cursor| {
        let documentation = documentation(cursor);
        condition(cursor, documentation)
    })
}

/// `constraint name: condition`.
pub(super) fn constraint(cursor: &mut Cursor, documentation: Documentation) -> Checked<Statement> {
    let message = "a constraint has a name, as in `constraint speed: dot(y) <= 3 [m/s]`";
    let name = named(cursor, message)?;
    let condition = condition(cursor, documentation)?;
    Ok(Statement::Constraint { name, condition })
}

/// `when condition { state = value, dot(q) = value }`.
pub(super) fn when(
    cursor: &mut Cursor,
    word: &Name,
    documentation: Documentation,
) -> Checked<Statement> {
    let place = cursor.place();
    let condition = condition(cursor, documentation)?;
    if condition.relation == Relation::Equal {
        let message = format!(
            "`when` waits for a side to be passed; write `when {0} >= {1} {{ ... }}`, or `<=`",
            condition.left, condition.right
        );
        return Err(cursor.said().syntax(place, message));
    }
    let inner = block(cursor, word)?;
    let before = cursor.said().mistakes();
    let assignments = entries(inner, |cursor| assignment(cursor, "="));
    if assignments.is_empty() && cursor.said().mistakes() > before {
        return Err(Reported);
    }
    Ok(Statement::When {
        condition,
        assignments,
    })
}

/// `at time { condition, ... }`, or `at name in lower..=upper { condition, ... }` at a time that is to be found.
pub(super) fn at(cursor: &mut Cursor, word: &Name) -> Checked<Statement> {
    let time = expression(cursor)?;
    let gate = match range(cursor)? {
        Some(bounds) => Some(Box::new(gate(cursor, &time, bounds)?)),
        None => None,
    };
    let inner = block(cursor, word)?;
    let before = cursor.said().mistakes();
    let conditions = conditions(inner);
    if conditions.is_empty() && cursor.said().mistakes() > before {
        return Err(Reported);
    }
    Ok(Statement::At {
        time,
        gate,
        conditions,
        values: Vec::new(),
    })
}

/// The time of conditions as a parameter that is to be found; it begins in the middle of its range unless it has a value.
fn gate(cursor: &mut Cursor, time: &Expr, (lower, upper): (Expr, Expr)) -> Checked<Quantity> {
    let Kind::Name(name) = &time.kind else {
        let message = format!(
            "a time that is to be found has a name, as in `at gate in {lower}..={upper} {{ ... }}`"
        );
        return Err(cursor.said().syntax(time.place, message));
    };
    let middle = match (&lower.kind, &upper.kind) {
        (
            Kind::Number { value: low, .. },
            Kind::Number {
                value: high, unit, ..
            },
        ) => Some(Expr {
            kind: Kind::Number {
                value: 0.5 * (low + high),
                text: format!("{}", 0.5 * (low + high)),
                unit: unit.clone(),
            },
            ..upper.clone()
        }),
        _ => None,
    };
    let value = match cursor.eat_symbol("=") {
        true => Some(expression(cursor)?),
        false => middle,
    };
    if value.is_none() {
        let message = format!(
            "the time `{0}` needs a value to begin with, as in `at {0} in {lower}..={upper} = {upper} {{ ... }}`",
            name.text
        );
        return Err(cursor.said().syntax(name.place(), message));
    }
    let second = WrittenUnit {
        text: "s".to_owned(),
        unit: Unit::mechanical(0, 0, 1),
    };
    Ok(Quantity {
        documentation: Documentation::default(),
        name: name.clone(),
        unit: Some(second),
        bounds: Some((lower, upper)),
        value,
        free: true,
    })
}

/// `left >= right`, `left <= right` or `left == right`.
fn condition(cursor: &mut Cursor, documentation: Documentation) -> Checked<Condition> {
    let left = expression(cursor)?;
    let place = cursor.place();
    let Some(relation) = relation(cursor) else {
        if cursor.at_symbol(">") || cursor.at_symbol("<") || cursor.at_symbol("=") {
            return Err(cursor.said().syntax(
                place,
                "a condition is written with `==`, `>=` or `<=`; one of them is meant here",
            ));
        }
        return Err(cursor.unexpected("`==`, `>=` or `<=`"));
    };
    let right = compared(cursor)?;
    let place = cursor.place();
    if relation_follows(cursor) {
        return Err(cursor.said().syntax(
            place,
            format!(
                "a condition compares two sides; write two conditions, the second one with `{right}` \
                 on its left; bounds of a control stand where it is declared, as in `u in -1..=1`"
            ),
        ));
    }
    Ok(Condition {
        documentation,
        left,
        relation,
        right,
    })
}

fn relation(cursor: &mut Cursor) -> Option<Relation> {
    [
        ("==", Relation::Equal),
        (">=", Relation::AtLeast),
        ("<=", Relation::AtMost),
    ]
    .into_iter()
    .find_map(|(symbol, relation)| cursor.eat_symbol(symbol).then_some(relation))
}

pub(super) fn relation_follows(cursor: &Cursor) -> bool {
    relation(&mut cursor.clone()).is_some()
}

/// `free { q in lower..=upper, dot(q), ... }`.
pub(super) fn free(cursor: &mut Cursor, word: &Name) -> Checked<Statement> {
    let inner = block(cursor, word)?;
    let values = entries(inner, |cursor| {
        let (target, velocity) = target(cursor)?;
        let bounds = range(cursor)?;
        if cursor.at_symbol(":") || cursor.at_symbol("=") {
            return Err(cursor.said().syntax(
                cursor.place(),
                format!(
                    "`free` says which initial values are to be found; the guess belongs to `start {{ {}: \
                     ... }}`",
                    if velocity {
                        format!("dot({})", target.text)
                    } else {
                        target.text.clone()
                    }
                ),
            ));
        }
        Ok(FreeStart {
            target,
            velocity,
            bounds,
        })
    });
    Ok(Statement::Free(values))
}

/// Whether a parameter that is to be found stands behind `free`, and no block of initial values.
pub(super) fn is_parameter(cursor: &Cursor) -> bool {
    cursor.ident().is_some()
}

/// `free name: unit in lower..=upper = value`, a parameter that is to be found.
pub(super) fn free_parameter(
    cursor: &Cursor,
    quantity: Quantity,
    documentation: Documentation,
) -> Checked<Statement> {
    let Quantity { name, unit, .. } = &quantity;
    let unit = unit
        .as_ref()
        .map_or(String::new(), |unit| format!(": {}", unit.text));
    if quantity.bounds.is_none() {
        cursor.said().poison(&name.text);
        let message = format!(
            "free parameter `{0}` needs the range in which it is looked for, as in `free {0}{unit} in 1..=10 = 2`; a \
             free initial value stands in braces, `free {{ {0} }}`",
            name.text
        );
        return Err(cursor.said().syntax(name.place(), message));
    }
    if quantity.value.is_none() {
        cursor.said().poison(&name.text);
        let message = format!(
            "free parameter `{0}` needs a value to begin with, as in `free {0}{unit} in 1..=10 = 2`; a free initial \
             value stands in braces, `free {{ {0} in ... }}`",
            name.text
        );
        return Err(cursor.said().syntax(name.place(), message));
    }
    Ok(Statement::Parameters(vec![Quantity {
        documentation,
        free: true,
        ..quantity
    }]))
}
