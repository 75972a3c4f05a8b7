//! Graph to sums and products of any number of parts: coefficients and common factors taken out.

use super::code::{Leaf, Op};
use super::nary::Nary;
use crate::graph::{self, Node, Sym, Table};
use std::collections::hash_map::Entry;

/// Deepest expressions whose parts are lowered as they are met. In deeper ones what is one quantity comes
/// first, in the order in which it was made, so that no recursion runs through all of it.
const SHALLOW: usize = 600;
/// Most brackets inside each other before each of which a common factor stands: formulas have a handful.
const BRACKETS: usize = 100;

/// Factors of a term that stand in it as wholes; none of the number 1.
fn whole_factors(term: Sym) -> Vec<Sym> {
    let factors = graph::factors_of(term).into_iter();
    factors
        .filter(|&(_, halves)| halves >= 2)
        .map(|(factor, _)| factor)
        .collect()
}

/// Lowers a set of expressions.
pub(super) struct Lowering {
    nodes: Vec<Nary>,
    table: Table<Nary, u32>,
    done: Table<Sym, u32>,
    /// How many products divide by an expression.
    divisions: Table<Sym, usize>,
    factor: bool,
    /// Brackets that are open, each with a common factor before it.
    brackets: usize,
}

impl Lowering {
    /// Nodes in order of evaluation, and the positions of the outputs.
    pub(super) fn run(outputs: &[Sym], factor: bool) -> (Vec<Nary>, Vec<u32>) {
        let mut lowering = Self {
            nodes: Vec::new(),
            table: Table::default(),
            done: Table::default(),
            divisions: Table::default(),
            factor,
            brackets: 0,
        };
        let order = graph::reachable(outputs);
        let depth = outputs.iter().map(|output| output.depth()).max();
        let deep = depth.unwrap_or_default() > SHALLOW;
        for sym in &order {
            if let Node::Product(factors) = sym.node() {
                for &(base, halves) in factors.iter() {
                    if halves < 0 {
                        *lowering.divisions.entry(base).or_default() += 1;
                    }
                }
            }
        }
        if deep {
            for &sym in &order {
                if let Node::Kept(_) = sym.node() {
                    lowering.lower(sym);
                }
            }
        }
        let outputs = outputs.iter().map(|&sym| lowering.lower(sym)).collect();
        (lowering.nodes, outputs)
    }

    fn push(&mut self, node: Nary) -> u32 {
        if let Some(&known) = self.table.get(&node) {
            return known;
        }
        let position = self.nodes.len() as u32;
        self.nodes.push(node.clone());
        self.table.insert(node, position);
        position
    }

    fn one(&mut self, op: Op) -> u32 {
        self.push(Nary::One(op))
    }

    fn multiply(&mut self, mut factors: Vec<u32>) -> u32 {
        match factors.as_slice() {
            [] => self.constant(1.0),
            [only] => *only,
            _ => {
                factors.sort_unstable();
                self.push(Nary::Product(factors))
            }
        }
    }

    fn constant(&mut self, value: f64) -> u32 {
        self.one(Op::Given(Leaf::Constant(value.to_bits())))
    }

    fn lower(&mut self, sym: Sym) -> u32 {
        if let Some(&known) = self.done.get(&sym) {
            return known;
        }
        if graph::is_exhausted() {
            return self.constant(0.0);
        }
        let position = match sym.node() {
            Node::Number(bits) => self.one(Op::Given(Leaf::Constant(bits))),
            Node::Variable(variable) => self.one(Op::Given(Leaf::Variable(variable))),
            Node::Sum(terms) => {
                let terms: Vec<(Sym, f64)> = terms
                    .iter()
                    .map(|&(term, bits)| (term, f64::from_bits(bits)))
                    .collect();
                self.lower_sum(sym, &terms)
            }
            Node::Product(factors) => self.lower_product(&factors),
            Node::Kept(inner) => self.lower(inner),
            Node::Call(function, argument) => {
                let argument = self.lower(argument);
                self.one(Op::Call(function, argument))
            }
            Node::Call2(function, first, second) => {
                let (first, second) = (self.lower(first), self.lower(second));
                self.one(Op::Call2(function, first, second))
            }
        };
        self.done.insert(sym, position);
        position
    }

    fn lower_sum(&mut self, whole: Sym, terms: &[(Sym, f64)]) -> u32 {
        if terms.len() > 1
            && let Some(&opposite) = self.done.get(&-whole)
        {
            return self.one(Op::Negate(opposite));
        }
        let items = self.items(terms);
        self.add_up(items)
    }

    /// A sum as signed positions: equal coefficients are taken out, then common factors.
    fn items(&mut self, terms: &[(Sym, f64)]) -> Vec<(u32, bool)> {
        if !graph::spend(terms.len()) {
            return Vec::new();
        }
        let mut groups: Vec<(f64, Vec<(Sym, bool)>)> = Vec::new();
        let mut of_magnitude: Table<u64, Option<usize>> = Table::default();
        for &(term, coefficient) in terms {
            let (magnitude, negative) = (coefficient.abs(), coefficient < 0.0);
            // A constant, which comes first, is a group of its own; so are terms with its magnitude.
            let group = (term != Sym::ONE).then_some(groups.len());
            match of_magnitude.entry(magnitude.to_bits()) {
                Entry::Occupied(known) => match *known.get() {
                    Some(known) => groups[known].1.push((term, negative)),
                    None => groups.push((magnitude, vec![(term, negative)])),
                },
                Entry::Vacant(place) => {
                    place.insert(group);
                    groups.push((magnitude, vec![(term, negative)]));
                }
            }
        }
        let mut items = Vec::new();
        for (magnitude, group) in groups {
            if magnitude == 1.0 {
                items.extend(self.factored(group));
                continue;
            }
            match group.as_slice() {
                [(Sym::ONE, negative)] => items.push((self.constant(magnitude), *negative)),
                [(term, negative)] => {
                    let term = self.lower(*term);
                    let factor = self.constant(magnitude);
                    items.push((self.multiply(vec![factor, term]), *negative));
                }
                _ => {
                    let negative = group.iter().all(|&(_, negative)| negative);
                    let group: Vec<(Sym, bool)> = group
                        .into_iter()
                        .map(|(term, own)| (term, own != negative))
                        .collect();
                    let inner = self.factored(group);
                    let inner = self.add_up(inner);
                    let factor = self.constant(magnitude);
                    items.push((self.multiply(vec![factor, inner]), negative));
                }
            }
        }
        items
    }

    /// Terms with the factor that most of them share taken out, again and again, where factors are taken out.
    fn factored(&mut self, terms: Vec<(Sym, bool)>) -> Vec<(u32, bool)> {
        if !self.factor || self.brackets >= BRACKETS {
            let terms = terms.into_iter();
            return terms.map(|(term, own)| (self.lower(term), own)).collect();
        }
        let mut items = Vec::new();
        let with_factors = |(term, negative)| (term, negative, whole_factors(term));
        let mut terms: Vec<(Sym, bool, Vec<Sym>)> = terms.into_iter().map(with_factors).collect();
        let mut counts: Table<Sym, usize> = Table::default();
        loop {
            if !graph::spend(terms.len()) {
                return Vec::new();
            }
            counts.clear();
            for &factor in terms.iter().flat_map(|(_, _, factors)| factors) {
                *counts.entry(factor).or_default() += 1;
            }
            let best = counts
                .iter()
                .filter(|&(_, &count)| count >= 2)
                .max_by_key(|&(&factor, &count)| (count, std::cmp::Reverse(factor)));
            let Some((&factor, _)) = best else {
                break;
            };
            let (inside, outside): (Vec<_>, Vec<_>) = terms
                .into_iter()
                .partition(|(_, _, factors)| factors.contains(&factor));
            let negative = inside.iter().all(|&(_, negative, _)| negative);
            let reduced: Vec<(Sym, f64)> = inside
                .into_iter()
                .map(|(term, own, _)| (term / factor, if own == negative { 1.0 } else { -1.0 }))
                .collect();
            // Recursion ends: each level removes a factor, and a high power has no more levels than others.
            self.brackets += 1;
            let inner = self.items(&reduced);
            self.brackets -= 1;
            let inner = self.add_up(inner);
            let factor = self.lower(factor);
            items.push((self.multiply(vec![factor, inner]), negative));
            terms = outside;
        }
        for (term, negative, _) in terms {
            items.push((self.lower(term), negative));
        }
        items
    }

    fn add_up(&mut self, mut items: Vec<(u32, bool)>) -> u32 {
        if items.iter().all(|&(_, negative)| negative) {
            // All negative: the sum, then one sign.
            if items.is_empty() {
                return self.constant(0.0);
            }
            for item in &mut items {
                item.1 = false;
            }
            let inner = self.add_up(items);
            return self.one(Op::Negate(inner));
        }
        if let [(only, false)] = items.as_slice() {
            return *only;
        }
        self.push(Nary::Sum(items))
    }

    fn lower_product(&mut self, factors: &[(Sym, i32)]) -> u32 {
        let mut above = Vec::new();
        let mut below = Vec::new();
        for &(base, halves) in factors {
            if halves > 0 {
                self.power(base, halves, &mut above);
            } else if self.divisions.get(&base).is_some_and(|&count| count > 1) {
                // One division, then products: a division costs as much as several of them.
                let whole = halves.unsigned_abs() / 2;
                if whole > 0 {
                    let inverse = self.inverse(base);
                    above.push(self.repeated(inverse, whole));
                }
                if halves % 2 != 0 {
                    let root = self.lower(base);
                    let root = self.one(Op::Root(root));
                    let one = self.constant(1.0);
                    above.push(self.one(Op::Divide(one, root)));
                }
            } else {
                self.power(base, -halves, &mut below);
            }
        }
        let above = self.multiply(above);
        if below.is_empty() {
            return above;
        }
        let below = self.multiply(below);
        self.one(Op::Divide(above, below))
    }

    fn inverse(&mut self, base: Sym) -> u32 {
        let base = self.lower(base);
        let one = self.constant(1.0);
        self.one(Op::Divide(one, base))
    }

    /// Factors of `base` to a positive power counted in halves.
    fn power(&mut self, base: Sym, halves: i32, factors: &mut Vec<u32>) {
        let value = self.lower(base);
        let whole = halves.unsigned_abs() / 2;
        if whole > 0 {
            factors.push(self.repeated(value, whole));
        }
        if halves % 2 != 0 {
            factors.push(self.one(Op::Root(value)));
        }
    }

    /// Power by squaring.
    fn repeated(&mut self, value: u32, exponent: u32) -> u32 {
        if exponent <= 1 {
            return value;
        }
        let half = self.repeated(value, exponent / 2);
        let square = self.multiply(vec![half, half]);
        if exponent.is_multiple_of(2) {
            square
        } else {
            self.multiply(vec![square, value])
        }
    }
}
