//! What stands between the graph and the code.

use crate::graph::{Function, Function2, Variable};

/// Expressions with sums and products of any number of parts, before those are put in an order.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Nary {
    Load(Variable),
    Constant(u64),
    /// Terms, and whether they are subtracted; the first one of a sum never is, unless all are.
    Sum(Vec<(u32, bool)>),
    Product(Vec<u32>),
    Divide(u32, u32),
    Negate(u32),
    Root(u32),
    Call(Function, u32),
    Call2(Function2, u32, u32),
}
