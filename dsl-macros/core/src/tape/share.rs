//! Sharing of parts: a pair of terms or factors that occurs in several sums or products is computed
//! once. The most frequent pair first, until none occurs twice.

use super::nary::Nary;
use crate::graph::Table;
use std::collections::BinaryHeap;

/// Most pairs that are counted; longer sums than fit are left as they are, as the search would take
/// longer than it saves.
const MOST: usize = 150_000;

/// Two parts of a product, or two terms of a sum and whether their signs differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Pair {
    sum: bool,
    first: u32,
    second: u32,
    opposite: bool,
}

impl Pair {
    fn product(a: u32, b: u32) -> Self {
        Self {
            sum: false,
            first: a.min(b),
            second: a.max(b),
            opposite: false,
        }
    }

    fn sum(a: (u32, bool), b: (u32, bool)) -> Self {
        Self {
            sum: true,
            first: a.0.min(b.0),
            second: a.0.max(b.0),
            opposite: a.1 != b.1,
        }
    }
}

/// Nodes in which shared pairs are nodes of their own; positions stay valid.
pub(super) fn pairs(mut nodes: Vec<Nary>) -> Vec<Nary> {
    let mut places = places(&nodes);
    let mut heap: BinaryHeap<(usize, std::cmp::Reverse<Pair>)> = places
        .iter()
        .filter(|(_, list)| list.len() > 1)
        .map(|(&pair, list)| (list.len(), std::cmp::Reverse(pair)))
        .collect();
    while let Some((count, std::cmp::Reverse(pair))) = heap.pop() {
        let Some(list) = places.get_mut(&pair) else {
            continue;
        };
        list.retain(|&i| contains(&nodes[i], pair));
        if list.len() < 2 {
            places.remove(&pair);
            continue;
        }
        if list.len() < count {
            heap.push((list.len(), std::cmp::Reverse(pair)));
            continue;
        }
        let list = places.remove(&pair).unwrap_or_default();
        // A node that is the pair already serves; else a new one.
        let shared = match list.iter().find(|&&i| length(&nodes[i]) == 2) {
            Some(&whole) => whole,
            None => {
                nodes.push(if pair.sum {
                    Nary::Sum(vec![(pair.first, false), (pair.second, pair.opposite)])
                } else {
                    Nary::Product(vec![pair.first, pair.second])
                });
                nodes.len() - 1
            }
        };
        // A sum that is the pair may have it with both signs turned.
        let turned = match &nodes[shared] {
            Nary::Sum(items) => items
                .iter()
                .any(|&(item, negative)| item == pair.first && negative),
            _ => false,
        };
        for i in list {
            if i == shared {
                continue;
            }
            replace(&mut nodes[i], pair, shared as u32, turned);
            for new in pairs_of(&nodes[i]) {
                if new.first != shared as u32 && new.second != shared as u32 {
                    continue;
                }
                let list = places.entry(new).or_default();
                if !list.contains(&i) {
                    list.push(i);
                }
                if list.len() > 1 {
                    heap.push((list.len(), std::cmp::Reverse(new)));
                }
            }
        }
    }
    nodes
}

/// Number of terms or factors.
fn length(node: &Nary) -> usize {
    match node {
        Nary::Sum(items) => items.len(),
        Nary::Product(factors) => factors.len(),
        _ => 0,
    }
}

/// The lists in which each pair occurs, short lists first.
fn places(nodes: &[Nary]) -> Table<Pair, Vec<usize>> {
    let mut lists: Vec<usize> = (0..nodes.len())
        .filter(|&i| match &nodes[i] {
            Nary::Sum(items) => items.len() > 1,
            Nary::Product(factors) => factors.len() > 1,
            _ => false,
        })
        .collect();
    lists.sort_by_key(|&i| length(&nodes[i]));
    let mut places: Table<Pair, Vec<usize>> = Table::default();
    let mut counted = 0;
    for &i in &lists {
        let parts = length(&nodes[i]);
        counted += parts * (parts - 1) / 2;
        if counted > MOST {
            break;
        }
        for pair in pairs_of(&nodes[i]) {
            let list = places.entry(pair).or_default();
            if list.last() != Some(&i) {
                list.push(i);
            }
        }
    }
    places
}

fn pairs_of(node: &Nary) -> Vec<Pair> {
    let mut pairs = Vec::new();
    match node {
        Nary::Sum(items) => {
            for (i, &a) in items.iter().enumerate() {
                pairs.extend(items[i + 1..].iter().map(|&b| Pair::sum(a, b)));
            }
        }
        Nary::Product(factors) => {
            for (i, &a) in factors.iter().enumerate() {
                pairs.extend(factors[i + 1..].iter().map(|&b| Pair::product(a, b)));
            }
        }
        _ => {}
    }
    pairs
}

fn contains(node: &Nary, pair: Pair) -> bool {
    match node {
        Nary::Sum(items) if pair.sum => {
            let sign = |wanted: u32| {
                items
                    .iter()
                    .find(|&&(item, _)| item == wanted)
                    .map(|&(_, negative)| negative)
            };
            match (sign(pair.first), sign(pair.second)) {
                (Some(a), Some(b)) => pair.first != pair.second && (a != b) == pair.opposite,
                _ => false,
            }
        }
        Nary::Product(factors) if !pair.sum => {
            let count = |wanted: u32| factors.iter().filter(|&&factor| factor == wanted).count();
            if pair.first == pair.second {
                count(pair.first) > 1
            } else {
                count(pair.first) > 0 && count(pair.second) > 0
            }
        }
        _ => false,
    }
}

/// Puts the shared node in the place of the pair.
fn replace(node: &mut Nary, pair: Pair, shared: u32, turned: bool) {
    match node {
        Nary::Sum(items) => {
            let mut negative = false;
            if let Some(at) = items.iter().position(|&(item, _)| item == pair.first) {
                negative = items.remove(at).1;
            }
            if let Some(at) = items.iter().position(|&(item, _)| item == pair.second) {
                items.remove(at);
            }
            items.push((shared, negative != turned));
        }
        Nary::Product(factors) => {
            for part in [pair.first, pair.second] {
                if let Some(at) = factors.iter().position(|&factor| factor == part) {
                    factors.remove(at);
                }
            }
            factors.push(shared);
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::code::{Leaf, Op};
    use super::*;

    #[test]
    fn pairs_are_computed_once() {
        // a*b*c, b*c*d, and a - b + c, b - a + d: (b c) and (a - b) are shared.
        let coordinate = |i| Leaf::Variable(crate::graph::Variable::Coordinate(i));
        let load = |i| Nary::One(Op::Given(coordinate(i)));
        let nodes = vec![
            load(0),
            load(1),
            load(2),
            load(3),
            Nary::Product(vec![0, 1, 2]),
            Nary::Product(vec![1, 2, 3]),
            Nary::Sum(vec![(0, false), (1, true), (2, false)]),
            Nary::Sum(vec![(1, false), (0, true), (3, false)]),
        ];
        let before = super::super::linear::tape(&nodes, &[4, 5, 6, 7]).operations();
        let after = super::super::linear::tape(&pairs(nodes), &[4, 5, 6, 7]).operations();
        assert_eq!((before, after), (8, 6));
    }
}
