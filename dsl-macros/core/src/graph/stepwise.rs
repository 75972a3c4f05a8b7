//! Derivatives of long expressions whose sums are one quantity each ([`Node::Kept`]).
//!
//! No sum is flattened into another on the way: the rate of what is one quantity is one as well. So the derivatives of an
//! evaluation with `m` operations take a small multiple of `m` operations for each direction, as with numbers, however often
//! its parts are used. Products stay open, and so do the results, so that what cancels in those still does.

use super::passes::{Sweeps, gradient_by};
use super::{Compose, Node, Sym, Variable};

/// Derivatives of the evaluation of `roots`.
pub(crate) fn sweeps(roots: &[Sym]) -> Sweeps {
    Sweeps::keeping(roots, kept_sum)
}

/// Gradient of `root` with respect to `by`.
pub(crate) fn gradient(root: Sym, by: &[Variable]) -> Vec<Sym> {
    gradient_by(root, by, kept_sum)
}

/// A sum as one quantity; anything else as it is.
pub(crate) fn kept_sum(sym: Sym) -> Sym {
    match sym.node() {
        Node::Sum(terms) if terms.len() > 1 => sym.kept(),
        _ => sym,
    }
}
