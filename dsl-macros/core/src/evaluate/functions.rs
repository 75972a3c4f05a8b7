//! The elementary functions by name, and the direction of time.

use crate::ast::{Expr, Kind};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::graph::{Compose, Function, Sym, Variable};
use crate::words;

/// The direction in which time moves the variables, velocities held.
pub(crate) fn velocity_direction(variable: Variable) -> Sym {
    match variable {
        Variable::Coordinate(i) => Sym::variable(Variable::Velocity(i)),
        Variable::Time => Sym::ONE,
        _ => Sym::ZERO,
    }
}

/// The elementary function with this name.
pub(super) fn elementary(name: &str) -> Option<Box<dyn Fn(Sym) -> Sym>> {
    if name == "sqrt" {
        return Some(Box::new(|x| x.power(1)));
    }
    Function::named(name)
        .map(|function| -> Box<dyn Fn(Sym) -> Sym> { Box::new(move |x| x.call(function)) })
}

/// E02: a function has as many arguments as it takes.
pub(super) fn takes(
    (text, wanted): (&str, usize),
    found: usize,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<()> {
    if found == wanted {
        return Ok(());
    }
    let plural = if wanted == 1 { "" } else { "s" };
    let message = format!("`{text}` takes {wanted} argument{plural}, found {found}");
    Err(diagnostics.report("E02", place, message))
}

/// The only argument of a function.
pub(super) fn one<'e>(
    text: &str,
    whole: &Expr,
    arguments: &'e [Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<&'e Expr> {
    takes((text, 1), arguments.len(), whole.place, diagnostics)?;
    arguments.first().ok_or(Reported)
}

/// Whether an exponential may make a constant of an expression small: itself, or in a function that the scene declares.
pub(super) fn fades(expr: &Expr) -> bool {
    expr.any(&|part| match &part.kind {
        Kind::Call { function, .. } => {
            function.text == "exp" || !words::is_function(&function.text)
        }
        _ => false,
    })
}

/// Whether an expression is a derivative.
pub(super) fn is_derivative(expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Derivative { .. } => true,
        Kind::Call {
            function,
            arguments,
        } => function.text == "dot" && arguments.len() == 1,
        _ => false,
    }
}
