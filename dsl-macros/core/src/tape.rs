//! Graph to straight-line code: a list of operations, each on earlier results, equal ones once.

use crate::graph::{self, Function, Function2, Node, Sym, Variable};
use std::collections::HashMap;

/// One operation; operands are positions in the tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    Load(Variable),
    /// A constant, by its bits.
    Constant(u64),
    Add(u32, u32),
    Subtract(u32, u32),
    Multiply(u32, u32),
    Divide(u32, u32),
    Negate(u32),
    Root(u32),
    Call(Function, u32),
    Call2(Function2, u32, u32),
}

/// Operations in order of evaluation, and which of them are the outputs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tape {
    pub(crate) ops: Vec<Op>,
    pub(crate) outputs: Vec<u32>,
}

impl Tape {
    /// The shortest of several ways to evaluate `outputs`.
    pub(crate) fn of(outputs: &[Sym]) -> Self {
        let plain = Lowering::run(outputs, false);
        let factored = Lowering::run(outputs, true);
        if factored.operations() < plain.operations() {
            factored
        } else {
            plain
        }
    }

    /// Number of arithmetic operations and function calls.
    pub(crate) fn operations(&self) -> usize {
        self.ops
            .iter()
            .filter(|op| !matches!(op, Op::Load(_) | Op::Constant(_)))
            .count()
    }
}

/// Number of operations that a set of expressions takes.
pub(crate) fn operations(outputs: &[Sym]) -> usize {
    Tape::of(outputs).operations()
}

struct Lowering {
    tape: Tape,
    table: HashMap<Op, u32>,
    done: HashMap<Sym, u32>,
    /// How many products divide by an expression.
    divisions: HashMap<Sym, usize>,
    factor: bool,
}

impl Lowering {
    fn run(outputs: &[Sym], factor: bool) -> Tape {
        let mut lowering = Self {
            tape: Tape::default(),
            table: HashMap::new(),
            done: HashMap::new(),
            divisions: HashMap::new(),
            factor,
        };
        let order = graph::reachable(outputs);
        for sym in &order {
            if let Node::Product(factors) = sym.node() {
                for &(base, halves) in factors.iter() {
                    if halves < 0 {
                        *lowering.divisions.entry(base).or_default() += 1;
                    }
                }
            }
        }
        let outputs = outputs.iter().map(|&sym| lowering.lower(sym)).collect();
        lowering.tape.outputs = outputs;
        lowering.tape
    }

    fn push(&mut self, op: Op) -> u32 {
        let op = match op {
            Op::Add(a, b) => Op::Add(a.min(b), a.max(b)),
            Op::Multiply(a, b) => Op::Multiply(a.min(b), a.max(b)),
            op => op,
        };
        if let Some(&known) = self.table.get(&op) {
            return known;
        }
        let position = self.tape.ops.len() as u32;
        self.tape.ops.push(op);
        self.table.insert(op, position);
        position
    }

    fn constant(&mut self, value: f64) -> u32 {
        self.push(Op::Constant(value.to_bits()))
    }

    fn lower(&mut self, sym: Sym) -> u32 {
        if let Some(&known) = self.done.get(&sym) {
            return known;
        }
        let position = match sym.node() {
            Node::Number(bits) => self.push(Op::Constant(bits)),
            Node::Variable(variable) => self.push(Op::Load(variable)),
            Node::Sum(terms) => {
                let terms: Vec<(Sym, f64)> = terms
                    .iter()
                    .map(|&(term, bits)| (term, f64::from_bits(bits)))
                    .collect();
                self.lower_sum(sym, &terms)
            }
            Node::Product(factors) => self.lower_product(&factors),
            Node::Call(function, argument) => {
                let argument = self.lower(argument);
                self.push(Op::Call(function, argument))
            }
            Node::Call2(function, first, second) => {
                let (first, second) = (self.lower(first), self.lower(second));
                self.push(Op::Call2(function, first, second))
            }
        };
        self.done.insert(sym, position);
        position
    }

    fn lower_sum(&mut self, whole: Sym, terms: &[(Sym, f64)]) -> u32 {
        if terms.len() > 1
            && let Some(&opposite) = self.done.get(&-whole)
        {
            return self.push(Op::Negate(opposite));
        }
        let items = self.items(terms);
        self.add_up(items)
    }

    /// A sum as signed positions: equal coefficients are taken out, then common factors.
    fn items(&mut self, terms: &[(Sym, f64)]) -> Vec<(u32, bool)> {
        let mut groups: Vec<(f64, Vec<(Sym, bool)>)> = Vec::new();
        for &(term, coefficient) in terms {
            let (magnitude, negative) = (coefficient.abs(), coefficient < 0.0);
            let constant = term == Sym::ONE;
            match groups
                .iter_mut()
                .find(|(known, _)| *known == magnitude && !constant)
            {
                Some((_, group)) if group.iter().all(|&(term, _)| term != Sym::ONE) => {
                    group.push((term, negative));
                }
                _ => groups.push((magnitude, vec![(term, negative)])),
            }
        }
        let mut items = Vec::new();
        for (magnitude, group) in groups {
            if magnitude == 1.0 {
                if self.factor {
                    items.extend(self.factored(group));
                } else {
                    for (term, negative) in group {
                        items.push((self.lower(term), negative));
                    }
                }
                continue;
            }
            match group.as_slice() {
                [(Sym::ONE, negative)] => items.push((self.constant(magnitude), *negative)),
                [(term, negative)] => {
                    let term = self.lower(*term);
                    let factor = self.constant(magnitude);
                    items.push((self.push(Op::Multiply(factor, term)), *negative));
                }
                _ => {
                    let negative = group.iter().all(|&(_, negative)| negative);
                    let group: Vec<(Sym, bool)> = group
                        .into_iter()
                        .map(|(term, own)| (term, own != negative))
                        .collect();
                    let inner = if self.factor {
                        self.factored(group)
                    } else {
                        group
                            .into_iter()
                            .map(|(term, negative)| (self.lower(term), negative))
                            .collect()
                    };
                    let inner = self.add_up(inner);
                    let factor = self.constant(magnitude);
                    items.push((self.push(Op::Multiply(factor, inner)), negative));
                }
            }
        }
        items
    }

    /// Terms with the factor that most of them share taken out, again and again.
    fn factored(&mut self, mut terms: Vec<(Sym, bool)>) -> Vec<(u32, bool)> {
        let mut items = Vec::new();
        loop {
            let mut counts: HashMap<Sym, usize> = HashMap::new();
            for &(term, _) in &terms {
                if term == Sym::ONE {
                    continue;
                }
                for (factor, halves) in graph::factors_of(term) {
                    if halves >= 2 {
                        *counts.entry(factor).or_default() += 1;
                    }
                }
            }
            let best = counts
                .into_iter()
                .filter(|&(_, count)| count >= 2)
                .max_by_key(|&(factor, count)| (count, std::cmp::Reverse(factor)));
            let Some((factor, _)) = best else {
                break;
            };
            let (inside, outside): (Vec<_>, Vec<_>) = terms.into_iter().partition(|&(term, _)| {
                term != Sym::ONE
                    && graph::factors_of(term)
                        .iter()
                        .any(|&(base, halves)| base == factor && halves >= 2)
            });
            let negative = inside.iter().all(|&(_, negative)| negative);
            let reduced: Vec<(Sym, f64)> = inside
                .into_iter()
                .map(|(term, own)| (term / factor, if own == negative { 1.0 } else { -1.0 }))
                .collect();
            // Recursion ends: each level removes a factor.
            let inner = self.items(&reduced);
            let inner = self.add_up(inner);
            let factor = self.lower(factor);
            items.push((self.push(Op::Multiply(factor, inner)), negative));
            terms = outside;
        }
        for (term, negative) in terms {
            items.push((self.lower(term), negative));
        }
        items
    }

    fn add_up(&mut self, items: Vec<(u32, bool)>) -> u32 {
        let Some(first) = items.iter().position(|&(_, negative)| !negative) else {
            // All negative: the sum, then one sign.
            let positive = items
                .into_iter()
                .map(|(item, _)| (item, false))
                .collect::<Vec<_>>();
            if positive.is_empty() {
                return self.constant(0.0);
            }
            let inner = self.add_up(positive);
            return self.push(Op::Negate(inner));
        };
        let mut total = items[first].0;
        for (i, &(item, negative)) in items.iter().enumerate() {
            if i == first {
                continue;
            }
            total = self.push(if negative {
                Op::Subtract(total, item)
            } else {
                Op::Add(total, item)
            });
        }
        total
    }

    fn lower_product(&mut self, factors: &[(Sym, i32)]) -> u32 {
        let mut above = None;
        let mut below = None;
        for &(base, halves) in factors {
            if halves > 0 {
                let power = self.power(base, halves);
                above = Some(self.times(above, power));
            } else if self.divisions.get(&base).is_some_and(|&count| count > 1) && halves % 2 == 0 {
                let inverse = self.inverse(base);
                let power = self.repeated(inverse, halves.unsigned_abs() / 2);
                above = Some(self.times(above, power));
            } else {
                let power = self.power(base, -halves);
                below = Some(self.times(below, power));
            }
        }
        match (above, below) {
            (Some(above), None) => above,
            (Some(above), Some(below)) => self.push(Op::Divide(above, below)),
            (None, Some(below)) => {
                let one = self.constant(1.0);
                self.push(Op::Divide(one, below))
            }
            (None, None) => self.constant(1.0),
        }
    }

    fn times(&mut self, product: Option<u32>, factor: u32) -> u32 {
        match product {
            None => factor,
            Some(product) => self.push(Op::Multiply(product, factor)),
        }
    }

    fn inverse(&mut self, base: Sym) -> u32 {
        let base = self.lower(base);
        let one = self.constant(1.0);
        self.push(Op::Divide(one, base))
    }

    /// `base` to a positive power counted in halves.
    fn power(&mut self, base: Sym, halves: i32) -> u32 {
        let value = self.lower(base);
        let whole = halves.unsigned_abs() / 2;
        if halves % 2 == 0 {
            return self.repeated(value, whole);
        }
        let root = self.push(Op::Root(value));
        if whole == 0 {
            return root;
        }
        let power = self.repeated(value, whole);
        self.push(Op::Multiply(power, root))
    }

    /// Power by squaring.
    fn repeated(&mut self, value: u32, exponent: u32) -> u32 {
        if exponent <= 1 {
            return value;
        }
        let half = self.repeated(value, exponent / 2);
        let square = self.push(Op::Multiply(half, half));
        if exponent.is_multiple_of(2) {
            square
        } else {
            self.push(Op::Multiply(square, value))
        }
    }
}
