//! Expressions while they are read: a graph whose nodes are simplified as they are made.

use super::operation::{Function, Operation};

/// Index of a node; operands come before what uses them.
pub(super) type NodeId = u32;

/// A node before the graph is complete.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Node {
    Constant(f64),
    Variable,
    /// `constant + sum coefficient node`; the terms are `sums[index]`.
    Sum {
        constant: f64,
        index: usize,
    },
    Operation {
        operation: Operation,
        a: NodeId,
        b: NodeId,
        condition: NodeId,
    },
}

/// A term of a sum.
pub(super) type Term = (NodeId, f64);

/// Sums longer than this are not multiplied out into the sum around them; a chain of them would cost its square.
const LONGEST_SCALED: usize = 1000;

/// The expressions of a file.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
    pub(super) sums: Vec<Vec<Term>>,
    /// Nodes that several expressions name; they are never taken apart.
    is_shared: Vec<bool>,
}

impl Graph {
    /// A graph whose first nodes are the variables.
    pub(super) fn new(variables: usize) -> Self {
        Self {
            nodes: vec![Node::Variable; variables],
            sums: Vec::new(),
            is_shared: vec![true; variables],
        }
    }

    fn push(&mut self, node: Node) -> NodeId {
        self.nodes.push(node);
        self.is_shared.push(false);
        (self.nodes.len() - 1) as NodeId
    }

    pub(super) fn share(&mut self, node: NodeId) {
        self.is_shared[node as usize] = true;
    }

    pub(super) fn constant(&mut self, value: f64) -> NodeId {
        self.push(Node::Constant(value))
    }

    fn value_of(&self, node: NodeId) -> Option<f64> {
        match self.nodes[node as usize] {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// `constant + sum coefficient node`, with sums among the terms multiplied out.
    pub(super) fn sum(&mut self, mut constant: f64, terms: &[Term]) -> NodeId {
        let mut all: Vec<Term> = Vec::new();
        for &(node, coefficient) in terms {
            match self.nodes[node as usize] {
                Node::Constant(value) => constant += coefficient * value,
                Node::Sum {
                    constant: inner,
                    index,
                } if !self.is_shared[node as usize]
                    && (coefficient == 1.0 || self.sums[index].len() <= LONGEST_SCALED) =>
                {
                    constant += coefficient * inner;
                    // nothing else names the node, so its terms may be moved
                    let mut taken = std::mem::take(&mut self.sums[index]);
                    if coefficient != 1.0 {
                        taken.iter_mut().for_each(|term| term.1 *= coefficient);
                    }
                    if taken.len() > all.len() {
                        std::mem::swap(&mut taken, &mut all);
                    }
                    all.append(&mut taken);
                }
                _ if coefficient == 0.0 => {}
                _ => all.push((node, coefficient)),
            }
        }
        if all.is_empty() {
            return self.constant(constant);
        }
        if constant == 0.0
            && let [(node, 1.0)] = all[..]
        {
            return node;
        }
        self.sums.push(all);
        let index = self.sums.len() - 1;
        self.push(Node::Sum { constant, index })
    }

    pub(super) fn product(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.value_of(a), self.value_of(b)) {
            (Some(factor), _) => self.sum(0.0, &[(b, factor)]),
            (_, Some(factor)) => self.sum(0.0, &[(a, factor)]),
            _ if a == b => self.operation(Operation::Power(2.0), [a, a, a]),
            _ => self.operation(Operation::Product, [a, b, a]),
        }
    }

    pub(super) fn quotient(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.value_of(a), self.value_of(b)) {
            (None, Some(divisor)) if divisor != 0.0 => self.sum(0.0, &[(a, 1.0 / divisor)]),
            (Some(factor), None) => {
                let inverse = self.operation(Operation::Power(-1.0), [b, b, b]);
                self.sum(0.0, &[(inverse, factor)])
            }
            _ => self.operation(Operation::Quotient, [a, b, a]),
        }
    }

    pub(super) fn power(&mut self, a: NodeId, b: NodeId) -> NodeId {
        match (self.value_of(a), self.value_of(b)) {
            (None, Some(0.0)) => self.constant(1.0),
            (None, Some(1.0)) => a,
            (None, Some(exponent)) => self.operation(Operation::Power(exponent), [a, a, a]),
            (Some(base), None) if base > 0.0 => {
                let exponent = self.sum(0.0, &[(b, base.ln())]);
                self.function(Function::Exp, exponent)
            }
            _ => self.operation(Operation::GeneralPower, [a, b, a]),
        }
    }

    pub(super) fn function(&mut self, function: Function, a: NodeId) -> NodeId {
        self.operation(Operation::Function(function), [a, a, a])
    }

    /// An operation on `[a, b, condition]`; what has fewer operands repeats one of them.
    pub(super) fn operation(&mut self, operation: Operation, operands: [NodeId; 3]) -> NodeId {
        if let [Some(a), Some(b), Some(condition)] = operands.map(|node| self.value_of(node)) {
            return self.constant(operation.value(a, b, condition));
        }
        let [a, b, condition] = operands;
        self.push(Node::Operation {
            operation,
            a,
            b,
            condition,
        })
    }
}
