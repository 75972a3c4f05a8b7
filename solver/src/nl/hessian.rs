//! The Hessian of a weighted sum of functions by pushing edges backwards (Gower and Mello, Optimization Methods and
//! Software 27, 2012).
//!
//! Nodes are eliminated from last to first. An *edge* `(i, p)` holds the second derivative of the sum with respect to
//! nodes `i` and `p`. Eliminating `i` with operands `j`, `k` turns its edges into edges of the operands,
//!
//! ```text
//!     W_jp += phi_j W_ip,        W_jk += phi_j phi_k W_ii,        W_jk += adjoint_i phi_jk,
//! ```
//!
//! an edge that meets itself counting twice, until only variables are left. Which edges there are does not depend on the
//! point, so every edge has a fixed place, found once.

use super::operation::Partials;
use super::tape::Tape;

/// Most updates of edges; each takes four bytes and a few operations an evaluation.
const MOST: usize = 50_000_000;

/// The Hessian of `sum weight function`.
#[derive(Debug)]
pub(super) struct Hessian {
    /// Edges of each node with those before it and itself: `firsts[node]..firsts[node] + counts[node]`.
    firsts: Vec<u32>,
    counts: Vec<u32>,
    /// The other end of each edge.
    others: Vec<u32>,
    /// Which edge each update goes to, in the order of the updates.
    targets: Vec<u32>,
    edges: Vec<f64>,
    adjoints: Vec<f64>,
    /// (row, column) of the entries of the lower triangle, and their edges.
    entries: Vec<(usize, usize, u32)>,
}

/// Edges that are still to be placed: for each node the other end, not later than the node, and the update.
struct Pending(Vec<Vec<(u32, u32)>>);

impl Pending {
    fn add(&mut self, i: u32, j: u32, targets: &mut Vec<u32>) {
        let update = targets.len() as u32;
        targets.push(0);
        self.0[i.max(j) as usize].push((i.min(j), update));
    }
}

impl Hessian {
    /// Finds all edges; `None` if there are too many.
    pub(super) fn new(tape: &Tape) -> Option<Self> {
        let length = tape.len();
        let mut hessian = Self {
            firsts: vec![0; length],
            counts: vec![0; length],
            others: Vec::new(),
            targets: Vec::new(),
            edges: Vec::new(),
            adjoints: vec![0.0; length],
            entries: Vec::new(),
        };
        let mut pending = Pending(vec![Vec::new(); length]);
        let mut operands = Vec::new();
        for node in (0..length).rev() {
            hessian.place(node, std::mem::take(&mut pending.0[node]));
            operands.clear();
            tape.visit(node, |operand, _| operands.push(operand));
            let targets = &mut hessian.targets;
            let first = hessian.firsts[node] as usize;
            let end = first + hessian.counts[node] as usize;
            for &other in &hessian.others[first..end] {
                // checked before the updates of one edge, which may be the square of a long sum
                let updates = operands.len().saturating_mul(operands.len());
                if node >= tape.variables && targets.len().saturating_add(updates) > MOST {
                    return None;
                }
                for (k, &i) in operands.iter().enumerate() {
                    if other as usize != node {
                        pending.add(i, other, targets);
                    } else {
                        for &j in &operands[..=k] {
                            pending.add(i, j, targets);
                        }
                    }
                }
            }
            tape.visit_curvature(node, |_, i, j| pending.add(i, j, targets));
        }
        hessian.edges = vec![0.0; hessian.others.len()];
        for row in 0..tape.variables {
            let first = hessian.firsts[row];
            for edge in first..first + hessian.counts[row] {
                let column = hessian.others[edge as usize] as usize;
                hessian.entries.push((row, column, edge));
            }
        }
        Some(hessian)
    }

    /// Gives each edge of a node a place and tells its updates.
    fn place(&mut self, node: usize, mut edges: Vec<(u32, u32)>) {
        edges.sort_unstable();
        self.firsts[node] = self.others.len() as u32;
        for (other, update) in edges {
            let own = &self.others[self.firsts[node] as usize..];
            if own.last() != Some(&other) {
                self.others.push(other);
            }
            self.targets[update as usize] = (self.others.len() - 1) as u32;
        }
        self.counts[node] = self.others.len() as u32 - self.firsts[node];
    }

    /// (row, column) of the entries of the lower triangle.
    pub(super) fn pattern(&self) -> impl Iterator<Item = (usize, usize)> {
        self.entries.iter().map(|&(row, column, _)| (row, column))
    }

    /// The entries found last, in the order of the pattern.
    pub(super) fn values(&self) -> impl Iterator<Item = f64> {
        let entries = self.entries.iter();
        entries.map(|&(_, _, edge)| self.edges[edge as usize])
    }

    /// Finds the entries where the partial derivatives are `partials`, for weighted nodes.
    pub(super) fn evaluate(
        &mut self,
        tape: &Tape,
        partials: &[Partials],
        seeds: impl Iterator<Item = (u32, f64)>,
    ) {
        self.edges.fill(0.0);
        self.adjoints.fill(0.0);
        for (node, weight) in seeds {
            self.adjoints[node as usize] += weight;
        }
        let mut update = 0;
        let mut operands: Vec<(u32, f64)> = Vec::new();
        for node in (tape.variables..tape.len()).rev() {
            operands.clear();
            tape.visit(node, |operand, factor| {
                operands.push((operand, factor.value(&partials[node])));
            });
            let first = self.firsts[node] as usize;
            for edge in first..first + self.counts[node] as usize {
                let (other, weight) = (self.others[edge], self.edges[edge]);
                for (k, &(i, phi)) in operands.iter().enumerate() {
                    if other as usize != node {
                        let twice = if i == other { 2.0 } else { 1.0 };
                        self.edges[self.targets[update] as usize] += twice * phi * weight;
                        update += 1;
                        continue;
                    }
                    for (l, &(j, psi)) in operands[..=k].iter().enumerate() {
                        let twice = if i == j && l != k { 2.0 } else { 1.0 };
                        self.edges[self.targets[update] as usize] += twice * phi * psi * weight;
                        update += 1;
                    }
                }
            }
            let adjoint = self.adjoints[node];
            let own = &partials[node];
            tape.visit_curvature(node, |place, i, j| {
                let twice = if place == 1 && i == j { 2.0 } else { 1.0 };
                let second = [own.aa, own.ab, own.bb][place];
                self.edges[self.targets[update] as usize] += twice * second * adjoint;
                update += 1;
            });
            for &(operand, phi) in &operands {
                self.adjoints[operand as usize] += adjoint * phi;
            }
        }
    }
}
