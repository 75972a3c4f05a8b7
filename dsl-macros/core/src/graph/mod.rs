//! The expression graph: hash-consed nodes in normal form, behind a small `Copy` handle.
//!
//! Sums are flat lists of (term, coefficient), products flat lists of (factor, exponent), both
//! sorted and merged, so that structural zeros and equal subexpressions show by themselves. The
//! handle [`Sym`] is a number, and its derivatives are expressions again.
//!
//! Nodes live in an arena of the thread. It outlives one expansion, as one compiler process runs
//! many; [`reset`] empties it at the start of each.

mod elementary;
mod expand;
mod function;
mod limits;
mod node;
mod normal;
mod number;
mod passes;
mod profile;
mod second_order;
pub(crate) mod stepwise;
mod table;

pub use elementary::{Function, Function2, inverse_root, root};
pub(crate) use expand::{expand, pythagoras};
pub(crate) use function::Compose;
pub(crate) use limits::{Fault, Stage, allowed, begin, is_exhausted, spend, stage, take_fault};
pub(crate) use node::{Node, Sym, Variable, children, generation, reset};
pub(crate) use normal::{factors_of, product, sum};
pub(crate) use passes::{
    Sweeps, contains, degree, depends_on, directional, gradient, is_longer_than, partial,
    reachable, substitute, vanishes_with, variables, with_roots,
};
pub use profile::{Profile, Spline, piecewise};
pub(crate) use second_order::hessian;
pub(crate) use table::Table;
