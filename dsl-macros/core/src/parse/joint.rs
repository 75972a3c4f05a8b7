//! Joints: equations between positions, or between velocities.

use super::control::relation_follows;
use super::cursor::{Cursor, unexpected};
use super::expression::{compared, expression};
use super::pieces::name;
use crate::ast::{Documentation, Expr, Name, Statement};
use crate::diagnostics::{Checked, Diagnostics, Reported};

/// `joint name: left == right`.
pub(super) fn joint(
    cursor: &mut Cursor,
    documentation: Documentation,
    diagnostics: &mut Diagnostics,
) -> Checked<Statement> {
    let begin = cursor.place();
    let named = match cursor.ident() {
        Some(_) => Some(name(cursor, "the name of the joint", diagnostics)?),
        None => None,
    };
    let Some(name) = named.filter(|_| cursor.eat_symbol(":")) else {
        let message = "a joint has a name, as in `joint loop: left == right`";
        return Err(diagnostics.syntax(begin, message));
    };
    match sides(cursor, &name, diagnostics) {
        Ok([left, right]) => Ok(Statement::Joint {
            documentation,
            name,
            left,
            right,
        }),
        Err(Reported) => {
            diagnostics.poison(&name.text);
            Err(Reported)
        }
    }
}

/// Both sides of the equation.
fn sides(cursor: &mut Cursor, name: &Name, diagnostics: &mut Diagnostics) -> Checked<[Expr; 2]> {
    let left = expression(cursor, diagnostics)?;
    let place = cursor.place();
    if !cursor.eat_symbol("==") {
        if cursor.at_symbol(">=") || cursor.at_symbol("<=") {
            let message = format!(
                "a joint holds both ways, so that it is an equation `==`; what holds one way is a \
                 `surface {0}: ...` with its law, `impact {0}: inelastic`",
                name.text
            );
            return Err(diagnostics.syntax(place, message));
        }
        if cursor.at_symbol("=") {
            let message = "the two sides of a joint are joined by `==`";
            return Err(diagnostics.syntax(place, message));
        }
        let wanted = "`==` and the other side, as in `joint loop: left == right`";
        return Err(unexpected(cursor, diagnostics, wanted));
    }
    let right = compared(cursor, diagnostics)?;
    if relation_follows(cursor) {
        let message = format!(
            "a joint is one equation; declare two joints, the second one with `{right}` on its left"
        );
        return Err(diagnostics.syntax(cursor.place(), message));
    }
    Ok([left, right])
}
