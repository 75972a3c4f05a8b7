//! Hessians by one sweep from the root down, which carries the second derivatives along with the
//! adjoints.
//!
//! When a vertex is passed, its interactions with others are handed to its parts, and its own second
//! derivatives, weighted by its adjoint, become interactions of its parts. What remains between
//! variables is the Hessian; it costs each product once, symmetry included (Gower and Mello, A new
//! framework for the computation of Hessians, Optimization Methods and Software 27, 2012).

use super::function::{Compose, derivative, derivatives};
use super::table::Table;
use super::{Function, Function2, Node, Sym, Variable, passes, product, reachable, sum};
use std::collections::BTreeMap;

/// Second derivatives of `root` with respect to `inputs`, lower triangle, where they are not zero.
/// Every result that is used again is one quantity.
pub(crate) fn hessian(root: Sym, inputs: &[Variable]) -> BTreeMap<(usize, usize), Sym> {
    let place: Table<Variable, usize> = inputs.iter().enumerate().map(|(i, &v)| (v, i)).collect();
    let order = reachable(&[root]);
    let mut active: Table<Sym, bool> = Table::default();
    for &sym in &order {
        let node = sym.node();
        let own = match node {
            Node::Variable(variable) => place.contains_key(&variable),
            _ => super::children(&node).iter().any(|part| active[part]),
        };
        active.insert(sym, own);
    }
    let mut adjoints: Table<Sym, Sym> = std::iter::once((root, Sym::ONE)).collect();
    let mut interactions = Interactions::default();
    let mut result = BTreeMap::new();
    for &sym in order.iter().rev() {
        if !active[&sym] {
            continue;
        }
        let node = sym.node();
        let own = interactions.take(sym);
        if let Node::Variable(variable) = node {
            for (other, value) in own {
                if let Node::Variable(its) = other.node() {
                    let (i, j) = (place[&variable], place[&its]);
                    result.insert((i.max(j), i.min(j)), value);
                }
                if other != sym {
                    interactions.put_back(sym, other, value);
                }
            }
            continue;
        }
        let mut parts = partials(&node);
        parts.retain(|(part, _)| active[part]);
        for (_, partial) in &mut parts {
            *partial = partial.kept();
        }
        for (other, value) in own {
            let value = value.kept();
            if other == sym {
                for (i, &(a, by_a)) in parts.iter().enumerate() {
                    let pushed = (by_a * value).kept();
                    interactions.add(a, a, pushed * by_a);
                    for &(b, by_b) in &parts[..i] {
                        interactions.add(a, b, pushed * by_b);
                    }
                }
            } else {
                for &(part, by_part) in &parts {
                    let pushed = by_part * value;
                    let pushed = if part == other {
                        pushed.scaled(2.0)
                    } else {
                        pushed
                    };
                    interactions.add(part, other, pushed);
                }
            }
        }
        let Some(adjoint) = adjoints.remove(&sym).map(Sym::kept) else {
            continue;
        };
        for (a, b, second) in second_partials(&node) {
            if active[&a] && active[&b] {
                interactions.add(a, b, adjoint * second.kept());
            }
        }
        for (part, partial) in parts {
            *adjoints.entry(part).or_insert(Sym::ZERO) += adjoint * partial;
        }
    }
    result.retain(|_, value| !value.is_structural_zero());
    result
}

/// Second derivatives between the vertices that the sweep has not passed yet.
#[derive(Default)]
struct Interactions {
    of: Table<Sym, BTreeMap<Sym, Sym>>,
}

impl Interactions {
    fn add(&mut self, a: Sym, b: Sym, value: Sym) {
        for (a, b) in [(a, b), (b, a)] {
            *self.of.entry(a).or_default().entry(b).or_insert(Sym::ZERO) += value;
            if a == b {
                break;
            }
        }
    }

    /// All interactions of a vertex, which are forgotten.
    fn take(&mut self, sym: Sym) -> BTreeMap<Sym, Sym> {
        let own = self.of.remove(&sym).unwrap_or_default();
        for other in own.keys() {
            if let Some(its) = self.of.get_mut(other) {
                its.remove(&sym);
            }
        }
        own
    }

    /// Variables are never passed: what they have in common with others stays with those.
    fn put_back(&mut self, sym: Sym, other: Sym, value: Sym) {
        self.of.entry(other).or_default().insert(sym, value);
    }
}

/// Nonzero second derivatives of a node with respect to its parts, each pair once.
fn second_partials(node: &Node) -> Vec<(Sym, Sym, Sym)> {
    match node {
        Node::Number(_) | Node::Variable(_) | Node::Sum(_) | Node::Kept(_) => Vec::new(),
        Node::Product(factors) => {
            let mut all = Vec::new();
            for (i, &(a, own)) in factors.iter().enumerate() {
                let mut rest = factors.to_vec();
                rest[i].1 = own - 4;
                let factor = f64::from(own) / 2.0 * (f64::from(own) / 2.0 - 1.0);
                all.push((a, a, sum([(product(rest), factor)])));
                for (j, &(b, its)) in factors[..i].iter().enumerate() {
                    let mut rest = factors.to_vec();
                    rest[i].1 = own - 2;
                    rest[j].1 = its - 2;
                    let factor = f64::from(own) * f64::from(its) / 4.0;
                    all.push((a, b, sum([(product(rest), factor)])));
                }
            }
            all.retain(|(_, _, value)| !value.is_structural_zero());
            all
        }
        Node::Call(function, argument) => {
            vec![(
                *argument,
                *argument,
                second_derivative(*function, *argument),
            )]
        }
        Node::Call2(function, first, second) => second_derivatives(*function, *first, *second),
    }
}

/// Parts of a node, each once, and the derivative with respect to each.
fn partials(node: &Node) -> Vec<(Sym, Sym)> {
    let mut all: Vec<(Sym, Sym)> = Vec::new();
    for (part, value, factor) in passes::slopes(node, |_| Sym::ONE) {
        let value = value.scaled(factor);
        match all.last_mut() {
            Some((known, sum)) if *known == part => *sum += value,
            _ => all.push((part, value)),
        }
    }
    all
}

/// `f''(x)`, by dual numbers over the rule of the first derivative.
fn second_derivative(function: Function, x: Sym) -> Sym {
    let [hole, _] = holes();
    let slope = derivative(function, Sym::variable(hole));
    let second = passes::partial(&[slope], hole);
    put(second[0], [(hole, x), (hole, x)])
}

/// Nonzero second derivatives with respect to pairs of arguments.
fn second_derivatives(function: Function2, first: Sym, second: Sym) -> Vec<(Sym, Sym, Sym)> {
    let [x, y] = holes();
    let (by_x, by_y) = derivatives(function, Sym::variable(x), Sym::variable(y));
    let slopes = [by_x, by_y];
    let (by_x, by_y) = (passes::partial(&slopes, x), passes::partial(&slopes, y));
    let at = |formula| put(formula, [(x, first), (y, second)]);
    let mut all = vec![(first, first, at(by_x[0])), (second, second, at(by_y[1]))];
    let mixed = at(by_y[0]);
    // With equal arguments both mixed derivatives fall on the same pair.
    all.push(if first == second {
        (first, second, mixed.scaled(2.0))
    } else {
        (first, second, mixed)
    });
    all.retain(|(_, _, value)| !value.is_structural_zero());
    all
}

/// Stand-ins for arguments, which no expression of a scene contains.
fn holes() -> [Variable; 2] {
    [
        Variable::Argument(u16::MAX),
        Variable::Argument(u16::MAX - 1),
    ]
}

fn put(formula: Sym, arguments: [(Variable, Sym); 2]) -> Sym {
    passes::substitute(&[formula], |variable| {
        let found = arguments.iter().find(|(hole, _)| *hole == variable);
        found.map(|&(_, argument)| argument)
    })[0]
}

#[cfg(test)]
mod tests {
    use super::super::{gradient, partial, reset};
    use super::*;

    #[test]
    fn hessian_agrees_with_two_sweeps_at_a_point() {
        reset();
        let inputs: Vec<Variable> = (0..3).map(Variable::Coordinate).collect();
        let [x, y, z] = [0, 1, 2].map(|i| Sym::variable(Variable::Coordinate(i)));
        let shared = (x * y + z.call(Function::Sin)).kept();
        let root = (shared.square() + Sym::ONE).power(-1) * x.call2(Function2::Power, y)
            + shared.call(Function::Exp) * shared
            + y.call2(Function2::Atan2, shared) / z
            + (x + y.square()).call(Function::Ln).power(6)
            + x.call2(Function2::Power, x);
        let found = hessian(root, &inputs);
        let slopes = gradient(root, &inputs);
        let at = |variable| match variable {
            Variable::Coordinate(i) => Some(Sym::number([0.7, 1.9, -0.4][usize::from(i)])),
            _ => None,
        };
        for (i, &slope) in slopes.iter().enumerate() {
            for (j, &input) in inputs.iter().enumerate().take(i + 1) {
                let wanted = partial(&[slope], input);
                let entry = found.get(&(i, j)).copied().unwrap_or(Sym::ZERO);
                let values = passes::substitute(&[entry, wanted[0]], at);
                let values: Vec<f64> = values.into_iter().filter_map(Sym::as_number).collect();
                // Some fifty roundings of numbers up to 100.
                let error = (values[0] - values[1]).abs();
                assert!(
                    error < 1e-12 * values[1].abs().max(1.0),
                    "{i} {j}: {values:?}"
                );
            }
        }
        // What no pair of inputs has in common has no entry.
        let separate = hessian(x.call(Function::Exp) + y * z, &inputs);
        let places: Vec<(usize, usize)> = separate.keys().copied().collect();
        assert_eq!(places, [(0, 0), (2, 1)]);
    }

    #[test]
    fn kept_values_keep_signs_and_hide_terms() {
        reset();
        let [x, y] = [0, 1].map(|i| Sym::variable(Variable::Coordinate(i)));
        let kept = (x + y).kept();
        assert_eq!((-(x * y)).kept(), -((x * y).kept()));
        assert_eq!(x.kept(), x);
        assert_eq!(kept - kept, Sym::ZERO);
        assert_ne!(kept - x, y);
        assert_eq!(partial(&[kept - x], Variable::Coordinate(0)), [Sym::ZERO]);
    }
}
