//! The elementary functions by name, and the direction of time.

use crate::graph::{Compose, Function, Sym, Variable};

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
