//! Expressions of the syntax tree to nodes of the graph.

mod algebra;
mod edges;
pub(crate) mod expression;
mod functions;
mod kink;
mod matrix;
mod named;
mod number;
mod recorded;
mod remembered;
mod scope;
mod switch;
mod units;
mod value;

pub(crate) use edges::has_edge;
pub(crate) use functions::velocity_direction;
pub(crate) use kink::{Kink, Peak, Switch};
pub(crate) use number::unrepresentable;
pub(crate) use recorded::{FIRST_DRY, at_impacts};
pub(crate) use scope::{Contents, Evaluation, Meaning, Role, Scope, UserFunction};
pub(crate) use units::rounded;
pub(crate) use value::{Number, Value};
