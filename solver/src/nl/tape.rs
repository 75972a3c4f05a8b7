//! The nodes that count, in order of evaluation, and the bodies of objective and rows over them.

use super::graph::{Graph, Node, NodeId, Term};
use super::operation::{Operation, Partials};
use super::statement::Body;

/// A node of the finished graph.
#[derive(Debug, Clone, Copy)]
enum Step {
    Constant(f64),
    Variable,
    Sum {
        constant: f64,
        first: u32,
        end: u32,
    },
    Operation {
        operation: Operation,
        a: NodeId,
        b: NodeId,
        condition: NodeId,
    },
}

/// How a node depends on an operand.
#[derive(Debug, Clone, Copy)]
pub(super) enum Factor {
    Coefficient(f64),
    /// The derivative with respect to the first or the second operand.
    First,
    Second,
}

impl Factor {
    /// The derivative.
    pub(super) fn value(self, partials: &Partials) -> f64 {
        match self {
            Self::Coefficient(value) => value,
            Self::First => partials.a,
            Self::Second => partials.b,
        }
    }
}

/// `constant + sum coefficient x + sum coefficient node`.
#[derive(Debug, Clone, Default)]
pub(super) struct Function {
    pub(super) constant: f64,
    /// (variable, coefficient), by variable.
    pub(super) linear: Vec<(usize, f64)>,
    /// Nodes that are neither constants, variables nor sums used once.
    pub(super) nodes: Vec<Term>,
}

impl Function {
    /// The value where the variables are `x` and the nodes are `values`.
    pub(super) fn value(&self, x: &[f64], values: &[f64]) -> f64 {
        let linear: f64 = self.linear.iter().map(|&(j, a)| a * x[j]).sum();
        let nodes: f64 = self
            .nodes
            .iter()
            .map(|&(k, a)| a * values[k as usize])
            .sum();
        self.constant + linear + nodes
    }
}

/// Expressions ready for evaluation. The first nodes are the variables.
#[derive(Debug)]
pub(super) struct Tape {
    pub(super) variables: usize,
    steps: Vec<Step>,
    terms: Vec<Term>,
    /// Nodes that depend on variables in a way that is differentiated.
    is_active: Vec<bool>,
}

impl Tape {
    /// The tape of a graph, with the bodies as functions of its nodes.
    pub(super) fn new(graph: &Graph, variables: usize, bodies: &[&Body]) -> (Self, Vec<Function>) {
        let mut functions: Vec<Function> =
            bodies.iter().map(|body| function(graph, body)).collect();
        let mut is_used = vec![false; graph.nodes.len()];
        is_used[..variables].fill(true);
        for &(node, _) in functions.iter().flat_map(|function| &function.nodes) {
            is_used[node as usize] = true;
        }
        for node in (variables..graph.nodes.len()).rev() {
            if !is_used[node] {
                continue;
            }
            match graph.nodes[node] {
                Node::Constant(_) | Node::Variable => {}
                Node::Sum { index, .. } => {
                    for &(term, _) in &graph.sums[index] {
                        is_used[term as usize] = true;
                    }
                }
                Node::Operation {
                    a, b, condition, ..
                } => [a, b, condition]
                    .into_iter()
                    .for_each(|operand| is_used[operand as usize] = true),
            }
        }
        let mut place = vec![NodeId::MAX; graph.nodes.len()];
        let mut tape = Self {
            variables,
            steps: Vec::new(),
            terms: Vec::new(),
            is_active: Vec::new(),
        };
        for (node, _) in is_used.iter().enumerate().filter(|(_, is_used)| **is_used) {
            place[node] = tape.steps.len() as NodeId;
            tape.push(graph, graph.nodes[node], &place);
        }
        for (node, _) in functions
            .iter_mut()
            .flat_map(|function| &mut function.nodes)
        {
            *node = place[*node as usize];
        }
        tape.forget_conditions(&functions);
        (tape, functions)
    }

    fn push(&mut self, graph: &Graph, node: Node, place: &[NodeId]) {
        let at = |node: NodeId| place[node as usize];
        let (step, is_active) = match node {
            Node::Constant(value) => (Step::Constant(value), false),
            Node::Variable => (Step::Variable, true),
            Node::Sum { constant, index } => {
                let first = self.terms.len();
                let mut terms: Vec<Term> = graph.sums[index]
                    .iter()
                    .map(|&(node, coefficient)| (at(node), coefficient))
                    .collect();
                terms.sort_unstable_by_key(|term| term.0);
                merge(&mut terms);
                let is_active = terms.iter().any(|term| self.is_active[term.0 as usize]);
                self.terms.append(&mut terms);
                let end = self.terms.len();
                let (first, end) = (first as u32, end as u32);
                let sum = Step::Sum {
                    constant,
                    first,
                    end,
                };
                (sum, is_active)
            }
            Node::Operation {
                operation,
                a,
                b,
                condition,
            } => {
                let [a, b, condition] = [a, b, condition].map(at);
                let operands = [a, b].into_iter().take(operation.arity());
                let is_active = operands
                    .into_iter()
                    .any(|operand| self.is_active[operand as usize]);
                let step = Step::Operation {
                    operation,
                    a,
                    b,
                    condition,
                };
                (step, is_active)
            }
        };
        self.steps.push(step);
        self.is_active.push(is_active);
    }

    /// What only conditions read is not differentiated.
    fn forget_conditions(&mut self, functions: &[Function]) {
        let mut counts = vec![false; self.len()];
        counts[..self.variables].fill(true);
        for &(node, _) in functions.iter().flat_map(|function| &function.nodes) {
            counts[node as usize] = true;
        }
        for node in (self.variables..self.len()).rev() {
            if counts[node] {
                self.visit(node, |operand, _| counts[operand as usize] = true);
            }
        }
        for (is_active, counts) in self.is_active.iter_mut().zip(counts) {
            *is_active &= counts;
        }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// Values of all nodes; those of the variables are there already.
    pub(super) fn evaluate(&self, values: &mut [f64]) {
        for node in self.variables..self.steps.len() {
            values[node] = match self.steps[node] {
                Step::Variable => continue,
                Step::Constant(value) => value,
                Step::Sum {
                    constant,
                    first,
                    end,
                } => self.terms[first as usize..end as usize]
                    .iter()
                    .fold(constant, |sum, &(term, coefficient)| {
                        sum + coefficient * values[term as usize]
                    }),
                Step::Operation {
                    operation,
                    a,
                    b,
                    condition,
                } => {
                    let [a, b, condition] = [a, b, condition].map(|node| values[node as usize]);
                    operation.value(a, b, condition)
                }
            };
        }
    }

    /// Partial derivatives of all nodes with respect to their operands.
    pub(super) fn differentiate(&self, values: &[f64], partials: &mut [Partials]) {
        for (node, step) in self.steps.iter().enumerate() {
            if let Step::Operation {
                operation,
                a,
                b,
                condition,
            } = *step
                && self.is_active[node]
            {
                let [a, b, condition] = [a, b, condition].map(|node| values[node as usize]);
                partials[node] = operation.partials(a, b, condition, values[node]);
            }
        }
    }

    /// Visits the active operands of a node in a fixed order. An operand may come twice.
    pub(super) fn visit(&self, node: usize, mut see: impl FnMut(NodeId, Factor)) {
        match self.steps[node] {
            _ if !self.is_active[node] => {}
            Step::Constant(_) | Step::Variable => {}
            Step::Sum { first, end, .. } => {
                for &(term, coefficient) in &self.terms[first as usize..end as usize] {
                    if self.is_active[term as usize] {
                        see(term, Factor::Coefficient(coefficient));
                    }
                }
            }
            Step::Operation {
                operation, a, b, ..
            } => {
                let arity = operation.arity();
                if arity > 0 && self.is_active[a as usize] {
                    see(a, Factor::First);
                }
                if arity > 1 && self.is_active[b as usize] {
                    see(b, Factor::Second);
                }
            }
        }
    }

    /// Visits the pairs of active operands with a second derivative, as places 0 to 2 of `aa`, `ab`, `bb`.
    pub(super) fn visit_curvature(&self, node: usize, mut see: impl FnMut(usize, NodeId, NodeId)) {
        if let Step::Operation {
            operation, a, b, ..
        } = self.steps[node]
            && self.is_active[node]
        {
            let curvature = operation.curvature();
            for (place, (i, j)) in [(a, a), (a, b), (b, b)].into_iter().enumerate() {
                let is_active = self.is_active[i as usize] && self.is_active[j as usize];
                if curvature[place] && is_active {
                    see(place, i, j);
                }
            }
        }
    }
}

/// Adds up neighbours of the same node.
fn merge(terms: &mut Vec<Term>) {
    terms.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}

/// A body with constants and linear terms taken out of its expression.
fn function(graph: &Graph, body: &Body) -> Function {
    let mut function = Function {
        linear: body.linear.clone(),
        ..Function::default()
    };
    let mut add = |node: NodeId, coefficient: f64| match graph.nodes[node as usize] {
        Node::Constant(value) => function.constant += coefficient * value,
        Node::Variable => function.linear.push((node as usize, coefficient)),
        _ => function.nodes.push((node, coefficient)),
    };
    if let Some(root) = body.expression {
        match graph.nodes[root as usize] {
            Node::Sum { constant, index } => {
                for &(node, coefficient) in &graph.sums[index] {
                    add(node, coefficient);
                }
                function.constant += constant;
            }
            _ => add(root, 1.0),
        }
    }
    function.linear.sort_unstable_by_key(|term| term.0);
    function.linear.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    function.linear.retain(|term| term.1 != 0.0);
    function.nodes.sort_unstable_by_key(|term| term.0);
    merge(&mut function.nodes);
    function
}
