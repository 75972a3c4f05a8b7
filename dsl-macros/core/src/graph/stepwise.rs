//! Derivatives of long expressions whose sums are one quantity each ([`Node::Kept`]).
//!
//! No sum is flattened into another on the way: the rate of what is one quantity is one as well. So the derivatives of an
//! evaluation with `m` operations take a small multiple of `m` operations for each direction, as with numbers, however often
//! its parts are used. Products stay open, and so do the results, so that what cancels in those still does.

use super::passes::{gradient_by, rate};
use super::table::Table;
use super::{Compose, Node, Sym, Variable, children, reachable, spend};

/// An evaluation that is differentiated in several directions.
pub(crate) struct Sweeps {
    nodes: Vec<Node>,
    /// Places of the parts of each node.
    parts: Vec<Vec<usize>>,
    place: Table<Sym, usize>,
    roots: Vec<usize>,
}

impl Sweeps {
    /// Of the evaluation of `roots`.
    pub(crate) fn over(roots: &[Sym]) -> Self {
        let order = reachable(roots);
        let place: Table<Sym, usize> = order.iter().enumerate().map(|(i, &sym)| (sym, i)).collect();
        let nodes: Vec<Node> = order.iter().map(|sym| sym.node()).collect();
        let parts = nodes.iter().map(|node| {
            let parts = children(node).into_iter();
            parts.filter_map(|part| place.get(&part).copied()).collect()
        });
        Self {
            parts: parts.collect(),
            roots: roots
                .iter()
                .filter_map(|root| place.get(root).copied())
                .collect(),
            nodes,
            place,
        }
    }

    /// Derivatives of the roots in the direction in which each variable moves by `direction`.
    pub(crate) fn directional(&self, direction: impl Fn(Variable) -> Sym) -> Vec<Sym> {
        let mut rates = vec![Sym::ZERO; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let own = match *node {
                Node::Variable(variable) => direction(variable),
                _ if self.parts[i].iter().all(|&part| rates[part] == Sym::ZERO) => Sym::ZERO,
                _ if !spend(1 + self.parts[i].len()) => return vec![Sym::ZERO; self.roots.len()],
                _ => {
                    let of = |part| self.place.get(&part).map_or(Sym::ZERO, |&at| rates[at]);
                    let own = rate(node, of);
                    match node {
                        Node::Kept(_) => kept_sum(own),
                        _ => own,
                    }
                }
            };
            rates[i] = own;
        }
        self.roots.iter().map(|&root| rates[root]).collect()
    }

    /// Partial derivatives of the roots with respect to one variable.
    pub(crate) fn partial(&self, variable: Variable) -> Vec<Sym> {
        self.directional(|other| {
            if other == variable {
                Sym::ONE
            } else {
                Sym::ZERO
            }
        })
    }
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
