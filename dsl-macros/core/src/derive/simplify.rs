//! Simplification by trying: the form with the fewest operations wins.

use crate::graph::{self, Function, Sym, Table};
use crate::tape;
use std::cell::RefCell;

/// Most terms of an expanded form that is tried.
const TERMS: usize = 200;

/// Most operations of an expression for which other forms are tried. Larger ones share more when they
/// are left alone (measured: 150 saves a quarter of the Hessian of a bicycle on two wheels against 400).
const SIZE: usize = 150;

/// Most operations of an equation of motion, from which all derivatives come; a form of more than [`SIZE`]
/// operations is left for one of half of them only.
const EQUATION: usize = 2000;

/// What is known of the expressions of one derivation, by the longest that was allowed.
#[derive(Default)]
struct Known {
    generation: u64,
    simplified: Table<(Sym, usize), Sym>,
    /// Operations of an expression by itself.
    operations: Table<Sym, usize>,
}

thread_local! {
    static KNOWN: RefCell<Known> = RefCell::default();
}

/// The cheapest of: the expression as it is, multiplied out, and multiplied out with squares of
/// cosines or of sines removed.
pub(crate) fn simplify(sym: Sym) -> Sym {
    simplify_up_to(sym, SIZE)
}

/// The cheapest of these forms of an equation of motion, which may be longer.
pub(crate) fn simplify_equation(sym: Sym) -> Sym {
    simplify_up_to(sym, EQUATION)
}

fn simplify_up_to(sym: Sym, longest: usize) -> Sym {
    let generation = graph::generation();
    let known = KNOWN.with_borrow_mut(|known| {
        if known.generation != generation {
            known.simplified.clear();
            known.operations.clear();
            known.generation = generation;
        }
        known.simplified.get(&(sym, longest)).copied()
    });
    known.unwrap_or_else(|| {
        let simple = tried(sym, longest);
        KNOWN.with_borrow_mut(|known| known.simplified.insert((sym, longest), simple));
        simple
    })
}

/// Number of operations that an expression takes by itself, counted once a derivation.
fn operations(sym: Sym) -> usize {
    let known = KNOWN.with_borrow(|known| known.operations.get(&sym).copied());
    known.unwrap_or_else(|| {
        let count = tape::operations(&[sym]);
        KNOWN.with_borrow_mut(|known| known.operations.insert(sym, count));
        count
    })
}

fn tried(sym: Sym, longest: usize) -> Sym {
    // Counting operations takes much longer than counting parts, of which each is one or more.
    if graph::is_longer_than(sym, longest) {
        return sym;
    }
    let mut best = sym;
    let mut cost = operations(sym);
    if cost <= 1 || cost > longest {
        return sym;
    }
    if cost > SIZE {
        cost /= 2;
    }
    let Some(expanded) = graph::expand(sym, TERMS) else {
        return sym;
    };
    let candidates = [
        Some(expanded),
        graph::pythagoras(expanded, Function::Cos, TERMS),
        graph::pythagoras(expanded, Function::Sin, TERMS),
    ];
    let mut known = vec![sym];
    for candidate in candidates.into_iter().flatten() {
        if !known.contains(&candidate) {
            known.push(candidate);
            let own = operations(candidate);
            if own < cost {
                (best, cost) = (candidate, own);
            }
        }
    }
    best
}

/// Several expressions that are evaluated together. Each by itself may become simpler while they share
/// less, so the two ways are compared as a whole; what simplifies to zero is zero in both.
pub(crate) fn simplify_all(values: &[Sym]) -> Vec<Sym> {
    let simplified: Vec<Sym> = values.iter().map(|&value| simplify(value)).collect();
    if simplified == values {
        return simplified;
    }
    let plain: Vec<Sym> = values
        .iter()
        .zip(&simplified)
        .map(|(&value, &simple)| {
            if simple.as_number().is_some() {
                simple
            } else {
                value
            }
        })
        .collect();
    if tape::operations(&plain) < tape::operations(&simplified) {
        plain
    } else {
        simplified
    }
}
