//! Graph to straight-line code: a list of operations, each on earlier results, equal ones once.

mod code;
mod linear;
mod lower;
mod nary;
mod share;

pub(crate) use code::{Leaf, Op, Operation, Tape};

use crate::graph::Sym;
use lower::Lowering;

/// Operations from which on sums are not factored: those of chains of 40 to 100 links become half as long again by it, in twice the time.
const LONG: usize = 10_000;

/// The shortest of several ways to evaluate `outputs`.
pub(crate) fn shortest(outputs: &[Sym]) -> Tape {
    let mut best = shorter(outputs, false);
    if best.operations() <= LONG {
        let factored = shorter(outputs, true);
        if factored.operations() < best.operations() {
            best = factored;
        }
    }
    best.calls_first()
}

/// The shorter one of the evaluations with pairs that are looked for in all sums and products, and without, where common factors are taken
/// out or not.
fn shorter(outputs: &[Sym], factor: bool) -> Tape {
    let (nodes, roots) = Lowering::run(outputs, factor);
    let plain = linear::tape(&nodes, &roots);
    let shared = linear::tape(&share::pairs(nodes), &roots);
    if shared.operations() < plain.operations() {
        shared
    } else {
        plain
    }
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
