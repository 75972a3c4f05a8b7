//! Passes over the graph: rates forward, adjoints backward, substitution, dependence.

use super::function::{Compose, derivative, derivatives};
use super::table::{Set, Table};
use super::{Node, Sym, Variable, children, product, spend, sum};
use std::collections::BTreeSet;

/// All expressions that `roots` consist of, parts before wholes.
pub(crate) fn reachable(roots: &[Sym]) -> Vec<Sym> {
    let mut seen: Set<Sym> = Set::default();
    let mut order = Vec::new();
    let mut stack: Vec<Sym> = roots.to_vec();
    while let Some(sym) = stack.pop() {
        if seen.insert(sym) {
            order.push(sym);
            let parts = children(&sym.node());
            if !spend(1 + parts.len()) {
                return Vec::new();
            }
            stack.extend(parts);
        }
    }
    // A node is created after its parts, so the order of creation is an order of evaluation.
    order.sort_unstable();
    order
}

/// Whether an expression has more than `limit` parts that are sums, products or calls; looks no further.
pub(crate) fn is_longer_than(root: Sym, limit: usize) -> bool {
    let mut seen: Set<Sym> = Set::default();
    let mut stack = vec![root];
    while let Some(sym) = stack.pop() {
        let parts = children(&sym.node());
        if !parts.is_empty() && seen.insert(sym) {
            if seen.len() > limit {
                return true;
            }
            stack.extend(parts);
        }
    }
    false
}

/// All variables that `roots` depend on.
pub(crate) fn variables(roots: &[Sym]) -> BTreeSet<Variable> {
    reachable(roots)
        .into_iter()
        .filter_map(|sym| match sym.node() {
            Node::Variable(variable) => Some(variable),
            _ => None,
        })
        .collect()
}

/// Whether an expression contains a variable for which `test` holds.
pub(crate) fn depends_on(root: Sym, test: impl Fn(Variable) -> bool) -> bool {
    variables(&[root]).into_iter().any(test)
}

/// Whether an expression contains variables for which `test` holds, and is 0 where all of these are.
pub(crate) fn vanishes_with(root: Sym, test: impl Fn(Variable) -> bool) -> bool {
    let zero = |variable| test(variable).then_some(Sym::ZERO);
    depends_on(root, &test) && substitute(&[root], zero)[0].is_structural_zero()
}

/// Whether an expression contains a variable for which `test` holds; looks no further than the first one.
pub(crate) fn contains(root: Sym, test: impl Fn(Variable) -> bool) -> bool {
    let mut seen: Set<Sym> = Set::default();
    let mut stack = vec![root];
    while let Some(sym) = stack.pop() {
        let node = sym.node();
        if matches!(node, Node::Variable(variable) if test(variable)) {
            return true;
        }
        if seen.insert(sym) {
            let parts = children(&node);
            if !spend(1 + parts.len()) {
                return false;
            }
            stack.extend(parts);
        }
    }
    false
}

/// Degree of an expression in the variables for which `test` holds, as it is written: what cancels counts. `None` where it is no
/// polynomial in them.
pub(crate) fn degree(root: Sym, test: impl Fn(Variable) -> bool) -> Option<u32> {
    let mut degrees: Table<Sym, u32> = Table::default();
    for sym in reachable(&[root]) {
        let of = |part: &Sym| degrees.get(part).copied().unwrap_or(0);
        let node = sym.node();
        let degree = match &node {
            Node::Number(_) => 0,
            Node::Variable(variable) => u32::from(test(*variable)),
            Node::Sum(terms) => terms.iter().map(|(term, _)| of(term)).max()?,
            Node::Product(factors) => {
                let mut all = 0_u32;
                for (factor, halves) in factors.iter() {
                    let own = of(factor);
                    let power = u32::try_from(*halves).ok().filter(|halves| halves % 2 == 0);
                    all = match (own, power) {
                        (0, _) => all,
                        (_, Some(halves)) => all.saturating_add(own.saturating_mul(halves / 2)),
                        (_, None) => return None,
                    };
                }
                all
            }
            Node::Kept(inner) => of(inner),
            Node::Call(..) | Node::Call2(..) => {
                let varies = children(&node).iter().any(|part| of(part) > 0);
                if varies {
                    return None;
                }
                0
            }
        };
        degrees.insert(sym, degree);
    }
    degrees.get(&root).copied()
}

/// An evaluation that is differentiated in several directions.
pub(crate) struct Sweeps {
    nodes: Vec<Node>,
    /// Places of the parts of each node.
    parts: Vec<Vec<usize>>,
    place: Table<Sym, usize>,
    /// Places of the roots; `None` where there was too much to look at.
    roots: Vec<Option<usize>>,
    /// What becomes of the rate of what is one quantity.
    keep: fn(Sym) -> Sym,
}

impl Sweeps {
    /// Of the evaluation of `roots`, with `keep` applied to the rate of each part that is one quantity.
    pub(super) fn keeping(roots: &[Sym], keep: fn(Sym) -> Sym) -> Self {
        let order = reachable(roots);
        let place: Table<Sym, usize> = order.iter().enumerate().map(|(i, &sym)| (sym, i)).collect();
        let nodes: Vec<Node> = order.iter().map(|sym| sym.node()).collect();
        let parts = nodes.iter().map(|node| {
            let parts = children(node).into_iter();
            parts.filter_map(|part| place.get(&part).copied()).collect()
        });
        Self {
            parts: parts.collect(),
            roots: roots.iter().map(|root| place.get(root).copied()).collect(),
            nodes,
            place,
            keep,
        }
    }

    /// Of the evaluation of `roots`.
    pub(crate) fn over(roots: &[Sym]) -> Self {
        Self::keeping(roots, |rate| rate)
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
                    let slopes = slopes(node, of).into_iter();
                    let own = sum(slopes.map(|(_, value, factor)| (value, factor)));
                    match node {
                        Node::Kept(_) => (self.keep)(own),
                        _ => own,
                    }
                }
            };
            rates[i] = own;
        }
        let roots = self.roots.iter();
        roots
            .map(|root| root.map_or(Sym::ZERO, |at| rates[at]))
            .collect()
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

/// Derivatives of `roots` in the direction in which each variable moves by `direction`.
pub(crate) fn directional(roots: &[Sym], direction: impl Fn(Variable) -> Sym) -> Vec<Sym> {
    Sweeps::over(roots).directional(direction)
}

/// Partial derivatives of `roots` with respect to one variable.
pub(crate) fn partial(roots: &[Sym], variable: Variable) -> Vec<Sym> {
    Sweeps::over(roots).partial(variable)
}

/// Each part of a node with the derivative of the node by it times the weight of the part, and a number.
pub(super) fn slopes(node: &Node, weight: impl Fn(Sym) -> Sym) -> Vec<(Sym, Sym, f64)> {
    let times = |part: Sym, partial: Sym| match weight(part) {
        Sym::ZERO => (part, Sym::ZERO, 1.0),
        weight => (part, weight * partial, 1.0),
    };
    match node {
        Node::Number(_) | Node::Variable(_) => Vec::new(),
        Node::Sum(terms) => terms
            .iter()
            .map(|&(term, bits)| (term, weight(term), f64::from_bits(bits)))
            .collect(),
        Node::Product(factors) => {
            // Over the powers of the factors, the product rule of the dual numbers.
            let own = |(i, &(factor, halves)): (usize, &(Sym, i32))| {
                let weight = weight(factor);
                let mut rest: Vec<(Sym, i32)> = factors.to_vec();
                rest[i].1 = halves - 2;
                rest.push((weight, 2));
                let is_there = !weight.is_structural_zero();
                is_there.then(|| (factor, product(rest), f64::from(halves) / 2.0))
            };
            factors.iter().enumerate().filter_map(own).collect()
        }
        Node::Kept(inner) => vec![(*inner, weight(*inner), 1.0)],
        Node::Call(function, argument) => {
            vec![times(*argument, derivative(*function, *argument))]
        }
        Node::Call2(function, first, second) => {
            let (by_first, by_second) = derivatives(*function, *first, *second);
            vec![times(*first, by_first), times(*second, by_second)]
        }
    }
}

/// Gradient of `root` with respect to `by`: adjoints from the root down.
pub(crate) fn gradient(root: Sym, by: &[Variable]) -> Vec<Sym> {
    gradient_by(root, by, |adjoint| adjoint)
}

/// Gradient of `root` with respect to `by`, with `keep` applied to each adjoint that is handed on.
pub(super) fn gradient_by(root: Sym, by: &[Variable], keep: fn(Sym) -> Sym) -> Vec<Sym> {
    let mut adjoints: Table<Sym, Vec<(Sym, f64)>> = Table::default();
    adjoints.insert(root, vec![(Sym::ONE, 1.0)]);
    let mut totals: Table<Variable, Sym> = Table::default();
    for sym in reachable(&[root]).into_iter().rev() {
        let Some(parts) = adjoints.remove(&sym) else {
            continue;
        };
        let adjoint = sum(parts);
        if let Node::Variable(variable) = sym.node() {
            totals.insert(variable, adjoint);
            continue;
        }
        let adjoint = keep(adjoint);
        for (part, value, factor) in slopes(&sym.node(), |_| adjoint) {
            adjoints.entry(part).or_default().push((value, factor));
        }
    }
    by.iter()
        .map(|variable| totals.get(variable).copied().unwrap_or(Sym::ZERO))
        .collect()
}

/// `roots` with some variables replaced.
pub(crate) fn substitute(roots: &[Sym], replace: impl Fn(Variable) -> Option<Sym>) -> Vec<Sym> {
    rebuilt(roots, replace, |_, _| None)
}

/// `root` with some odd powers of roots replaced, which are given by what they are powers of and by their number of halves.
pub(crate) fn with_roots(root: Sym, replace: impl Fn(Sym, i32) -> Option<Sym>) -> Sym {
    let replace = |base, halves: i32| (halves % 2 != 0).then(|| replace(base, halves)).flatten();
    rebuilt(&[root], |_| None, replace)[0]
}

/// `roots` with some variables and some powers, counted in halves, replaced.
fn rebuilt(
    roots: &[Sym],
    variable: impl Fn(Variable) -> Option<Sym>,
    power: impl Fn(Sym, i32) -> Option<Sym>,
) -> Vec<Sym> {
    let mut images: Table<Sym, Sym> = Table::default();
    for sym in reachable(roots) {
        let of = |part: Sym| images.get(&part).copied().unwrap_or(part);
        let image = match sym.node() {
            Node::Number(_) => sym,
            Node::Variable(known) => variable(known).unwrap_or(sym),
            Node::Sum(terms) => sum(terms
                .iter()
                .map(|&(term, bits)| (of(term), f64::from_bits(bits)))),
            Node::Product(factors) => product(factors.iter().map(|&(factor, halves)| match power(
                factor, halves,
            ) {
                Some(replaced) => (replaced, 2),
                None => (of(factor), halves),
            })),
            Node::Kept(inner) => of(inner).kept(),
            Node::Call(function, argument) => of(argument).call(function),
            Node::Call2(function, first, second) => of(first).call2(function, of(second)),
        };
        images.insert(sym, image);
    }
    roots
        .iter()
        .map(|root| images.get(root).copied().unwrap_or(*root))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Function, reset};

    fn is_velocity(variable: Variable) -> bool {
        matches!(variable, Variable::Velocity(_))
    }

    #[test]
    fn degree_counts_powers_of_the_chosen_variables_alone() {
        reset();
        let [q, v, w] = [
            Variable::Coordinate(0),
            Variable::Velocity(0),
            Variable::Velocity(1),
        ]
        .map(Sym::variable);
        let of = |sym| degree(sym, is_velocity);
        assert_eq!(of(q * q * q), Some(0));
        assert_eq!(of(q.call(Function::Sin) * v * w + q * v), Some(2));
        assert_eq!(of((q * v + w) * (v + w) * v), Some(3));
        assert_eq!(of(v.call(Function::Sin)), None);
        assert_eq!(of(Sym::ONE / v), None);
        assert!(contains(q * v + q, is_velocity));
        assert!(!contains(q.call(Function::Sin), is_velocity));
    }
}
