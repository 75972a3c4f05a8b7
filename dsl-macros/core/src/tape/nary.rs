//! What stands between the graph and the code.

use super::code::Op;

/// Expressions with sums and products of any number of parts, before those are put in an order.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Nary {
    /// An operation on other expressions, by their positions.
    One(Op),
    /// Terms, and whether they are subtracted; the first one of a sum never is, unless all are.
    Sum(Vec<(u32, bool)>),
    Product(Vec<u32>),
}
