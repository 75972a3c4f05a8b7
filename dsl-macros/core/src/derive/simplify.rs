//! Simplification by trying: the form with the fewest operations wins.

use crate::graph::{self, Function, Sym};
use crate::tape;

/// Most terms of an expanded form that is tried.
const TERMS: usize = 200;

/// Most operations of an expression for which other forms are tried.
const SIZE: usize = 400;

/// The cheapest of: the expression as it is, multiplied out, and multiplied out with squares of
/// cosines or of sines removed.
pub(crate) fn simplify(sym: Sym) -> Sym {
    let mut best = sym;
    let mut cost = tape::operations(&[sym]);
    if cost <= 1 || cost > SIZE {
        return sym;
    }
    let Some(expanded) = graph::expand(sym, TERMS) else {
        return sym;
    };
    let candidates = [
        Some(expanded),
        graph::pythagoras(expanded, Function::Cos, TERMS),
        graph::pythagoras(expanded, Function::Sin, TERMS),
    ];
    for candidate in candidates.into_iter().flatten() {
        if candidate != best {
            let own = tape::operations(&[candidate]);
            if own < cost {
                (best, cost) = (candidate, own);
            }
        }
    }
    best
}
