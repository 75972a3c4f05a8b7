//! Sums and products of many parts to operations on two.

use super::code::{Op, Tape};
use super::nary::Nary;
use crate::graph::Table;

/// The operations that evaluate `roots`, parts first.
pub(super) fn tape(nodes: &[Nary], roots: &[u32]) -> Tape {
    let mut order = Linear {
        nodes,
        tape: Tape::default(),
        table: Table::default(),
        done: vec![None; nodes.len()],
    };
    let outputs = roots.iter().map(|&root| order.visit(root)).collect();
    order.tape.outputs = outputs;
    order.tape
}

struct Linear<'a> {
    nodes: &'a [Nary],
    tape: Tape,
    table: Table<Op, u32>,
    done: Vec<Option<u32>>,
}

impl Linear<'_> {
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

    /// Evaluates a node and what it is made of, without recursion: a sum of a thousand terms that are added
    /// one by one is a thousand levels deep.
    fn visit(&mut self, root: u32) -> u32 {
        let mut stack = vec![Visit::new(root)];
        let mut value = None;
        while let Some(visit) = stack.last_mut() {
            let node = visit.node;
            if let Some(known) = self.done[node as usize] {
                value = Some(known);
                stack.pop();
                continue;
            }
            let nodes = self.nodes;
            match self.step(&nodes[node as usize], visit, value.take()) {
                Step::Into(part) => stack.push(Visit::new(part)),
                Step::Is(position) => self.done[node as usize] = Some(position),
            }
        }
        value.unwrap_or_default()
    }

    /// Goes on with a node: `part` is the value of the part that was asked for last.
    fn step(&mut self, node: &Nary, visit: &mut Visit, part: Option<u32>) -> Step {
        match node {
            Nary::One(op) => {
                visit.parts.extend(part);
                let Some(next) = op.operands().nth(visit.parts.len()) else {
                    let own = |part| op.operands().position(|operand| operand == part);
                    let known = |part| own(part).map_or(part, |place| visit.parts[place]);
                    return Step::Is(self.push(op.with_operands(known)));
                };
                Step::Into(next)
            }
            Nary::Sum(items) => self.add_up(items, visit, part),
            Nary::Product(factors) => {
                if let Some(factor) = part {
                    visit.total = Some(match visit.total {
                        Some(product) => self.push(Op::Multiply(product, factor)),
                        None => factor,
                    });
                    visit.next += 1;
                }
                match (factors.get(visit.next), visit.total) {
                    (Some(&factor), _) => Step::Into(factor),
                    (None, total) => Step::Is(total.unwrap_or_default()),
                }
            }
        }
    }

    fn add_up(&mut self, items: &[(u32, bool)], visit: &mut Visit, part: Option<u32>) -> Step {
        // The sharing of pairs may leave a sum without a positive term.
        let first = items.iter().position(|&(_, negative)| !negative);
        let start = first.unwrap_or(0);
        if let Some(item) = part {
            match visit.total {
                None => visit.total = Some(item),
                Some(total) => {
                    let op = if items[visit.next].1 && first.is_some() {
                        Op::Subtract(total, item)
                    } else {
                        Op::Add(total, item)
                    };
                    visit.total = Some(self.push(op));
                    visit.next += 1;
                }
            }
        }
        let Some(total) = visit.total else {
            return Step::Into(items[start].0);
        };
        visit.next += usize::from(visit.next == start);
        match items.get(visit.next) {
            Some(&(item, _)) => Step::Into(item),
            None if first.is_none() => Step::Is(self.push(Op::Negate(total))),
            None => Step::Is(total),
        }
    }
}

/// A node on its way to be evaluated.
struct Visit {
    node: u32,
    /// The part that comes next, of sums and products.
    next: usize,
    /// Sum or product of the parts so far.
    total: Option<u32>,
    /// Values of the operands so far.
    parts: Vec<u32>,
}

impl Visit {
    fn new(node: u32) -> Self {
        Self {
            node,
            next: 0,
            total: None,
            parts: Vec::new(),
        }
    }
}

enum Step {
    /// First this node has to be evaluated.
    Into(u32),
    /// The value stands here.
    Is(u32),
}
