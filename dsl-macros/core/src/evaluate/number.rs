//! What numbers have to be: finite, held by double precision, and no vectors.

use super::value::{Number, Value};
use crate::ast::Expr;
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::graph::Fault;

/// E21: a constant that double precision does not hold.
pub(crate) fn unrepresentable(
    fault: Fault,
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Reported {
    let message = match fault {
        Fault::Overflow => format!(
            "with `{expr}` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller"
        ),
        Fault::Cancellation => format!(
            "with `{expr}` constants cancel up to their rounding, so that no digit of the difference is right; write the difference itself, or leave the terms out if they cancel"
        ),
        Fault::Absorption => format!(
            "with `{expr}` constants are added of which one is lost, as it is more than 1e16 times smaller; leave it out, or write the sum otherwise"
        ),
    };
    diagnostics.report("E21", expr.place, message)
}

/// A value that must be a number.
pub(super) fn number(expr: &Expr, value: &Value, diagnostics: &mut Diagnostics) -> Checked<Number> {
    match value {
        Value::Scalar(number) => {
            if number.sym.as_number().is_some_and(|value| !value.is_finite()) {
                return Err(unrepresentable(Fault::Overflow, expr, diagnostics));
            }
            Ok(number.clone())
        }
        Value::Vector(_) => Err(diagnostics.report(
            "E02",
            expr.place,
            format!(
                "`{expr}` is {} where a number is needed; take a component, `|...|^2` or `dot(a, b)`",
                value.describe()
            ),
        )),
        Value::Matrix(_) => Err(diagnostics.report(
            "E02",
            expr.place,
            format!(
                "`{expr}` is {} where a number is needed; take an entry, as in `[0][1]`, or write \
                 `dot(v, m*v)`",
                value.describe()
            ),
        )),
    }
}
