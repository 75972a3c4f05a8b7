//! Expressions of the syntax tree to nodes of the graph.

mod algebra;
mod functions;
mod matrix;
mod scope;
mod value;

pub(crate) use functions::velocity_direction;
pub(crate) use scope::{BUDGET, Meaning, Role, Scope, TOO_LARGE, UserFunction, unrepresentable};
pub(crate) use value::Value;
