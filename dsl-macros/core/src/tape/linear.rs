//! Sums and products of many parts to operations on two.

use super::{Nary, Op, Tape};
use std::collections::HashMap;

/// The operations that evaluate `roots`, parts first.
pub(super) fn tape(nodes: &[Nary], roots: &[u32]) -> Tape {
    let mut order = Linear {
        nodes,
        tape: Tape::default(),
        table: HashMap::new(),
        done: vec![None; nodes.len()],
    };
    let outputs = roots.iter().map(|&root| order.visit(root)).collect();
    order.tape.outputs = outputs;
    order.tape
}

struct Linear<'a> {
    nodes: &'a [Nary],
    tape: Tape,
    table: HashMap<Op, u32>,
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

    fn visit(&mut self, node: u32) -> u32 {
        if let Some(known) = self.done[node as usize] {
            return known;
        }
        let nodes = self.nodes;
        let position = match &nodes[node as usize] {
            Nary::Load(variable) => self.push(Op::Load(*variable)),
            Nary::Constant(bits) => self.push(Op::Constant(*bits)),
            Nary::Sum(items) => self.add_up(items),
            Nary::Product(factors) => {
                let mut product = self.visit(factors[0]);
                for &factor in &factors[1..] {
                    let factor = self.visit(factor);
                    product = self.push(Op::Multiply(product, factor));
                }
                product
            }
            Nary::Divide(above, below) => {
                let (above, below) = (self.visit(*above), self.visit(*below));
                self.push(Op::Divide(above, below))
            }
            Nary::Negate(inner) => {
                let inner = self.visit(*inner);
                self.push(Op::Negate(inner))
            }
            Nary::Root(inner) => {
                let inner = self.visit(*inner);
                self.push(Op::Root(inner))
            }
            Nary::Call(function, argument) => {
                let argument = self.visit(*argument);
                self.push(Op::Call(*function, argument))
            }
            Nary::Call2(function, first, second) => {
                let (first, second) = (self.visit(*first), self.visit(*second));
                self.push(Op::Call2(*function, first, second))
            }
        };
        self.done[node as usize] = Some(position);
        position
    }

    fn add_up(&mut self, items: &[(u32, bool)]) -> u32 {
        // The sharing of pairs may leave a sum without a positive term.
        let first = items.iter().position(|&(_, negative)| !negative);
        let start = first.unwrap_or(0);
        let mut total = self.visit(items[start].0);
        for (i, &(item, negative)) in items.iter().enumerate() {
            if i == start {
                continue;
            }
            let item = self.visit(item);
            total = self.push(if negative && first.is_some() {
                Op::Subtract(total, item)
            } else {
                Op::Add(total, item)
            });
        }
        if first.is_none() {
            self.push(Op::Negate(total))
        } else {
            total
        }
    }
}
