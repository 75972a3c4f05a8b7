//! Graph to straight-line code: a list of operations, each on earlier results, equal ones once.

mod code;
mod linear;
mod lower;
mod nary;
mod share;

pub(crate) use code::{Leaf, Op, Operation, Tape};

use crate::graph::Sym;
use lower::Lowering;

/// The shortest of several ways to evaluate `outputs`.
pub(crate) fn shortest(outputs: &[Sym]) -> Tape {
    let mut best: Option<Tape> = None;
    for factor in [false, true] {
        let (nodes, roots) = Lowering::run(outputs, factor);
        let shared = share::pairs(nodes.clone());
        for candidate in [linear::tape(&nodes, &roots), linear::tape(&shared, &roots)] {
            if best
                .as_ref()
                .is_none_or(|best| candidate.operations() < best.operations())
            {
                best = Some(candidate);
            }
        }
    }
    best.unwrap_or_default().calls_first()
}

/// What a set of expressions costs, in multiplications, about: a division or a root takes as long as
/// several of them, a function as long as many.
pub(crate) fn cost(outputs: &[Sym]) -> usize {
    let weight = |op: &Op| match op {
        Op::Given(_) => 0,
        Op::Add(..) | Op::Subtract(..) | Op::Multiply(..) | Op::Negate(_) => 1,
        Op::Divide(..) | Op::Root(_) => 5,
        Op::Call(..) => 25,
        Op::Call2(..) => 50,
    };
    let (nodes, roots) = Lowering::run(outputs, true);
    let shared = share::pairs(nodes);
    linear::tape(&shared, &roots).ops.iter().map(weight).sum()
}

/// Number of operations that a set of expressions takes, about: without the search for shared pairs.
pub(crate) fn operations(outputs: &[Sym]) -> usize {
    let count = |factor| {
        let (nodes, roots) = Lowering::run(outputs, factor);
        linear::tape(&nodes, &roots).operations()
    };
    count(false).min(count(true))
}
