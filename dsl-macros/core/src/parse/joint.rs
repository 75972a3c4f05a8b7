//! Joints: equations between positions, or between velocities.

use super::control::relation_follows;
use super::cursor::Cursor;
use super::expression::{compared, expression};
use super::pieces::{named, said_of};
use crate::ast::{Documentation, Expr, Name, Statement};
use crate::diagnostics::Checked;

/// `joint name: left == right`.
pub(super) fn joint(cursor: &mut Cursor, documentation: Documentation) -> Checked<Statement> {
    let message = "a joint has a name, as in `joint loop: left == right`";
    let name = named(cursor, message)?;
    let [left, right] = said_of(&name, cursor, |cursor| sides(cursor, &name))?;
    Ok(Statement::Joint {
        documentation,
        name,
        left,
        right,
    })
}

/// Both sides of the equation.
fn sides(cursor: &mut Cursor, name: &Name) -> Checked<[Expr; 2]> {
    let left = expression(cursor)?;
    let place = cursor.place();
    if !cursor.eat_symbol("==") {
        if cursor.at_symbol(">=") || cursor.at_symbol("<=") {
            let message = format!(
                "a joint holds both ways, so that it is an equation `==`; what holds one way is a \
                 `surface {0}: ...` with its law, `impact {0}: inelastic`",
                name.text
            );
            return Err(cursor.said().syntax(place, message));
        }
        if cursor.at_symbol("=") {
            let message = "the two sides of a joint are joined by `==`";
            return Err(cursor.said().syntax(place, message));
        }
        let wanted = "`==` and the other side, as in `joint loop: left == right`";
        return Err(cursor.unexpected(wanted));
    }
    let right = compared(cursor)?;
    if relation_follows(cursor) {
        let message = format!(
            "a joint is one equation; declare two joints, the second one with `{right}` on its left"
        );
        return Err(cursor.said().syntax(cursor.place(), message));
    }
    Ok([left, right])
}
