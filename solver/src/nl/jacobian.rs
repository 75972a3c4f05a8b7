//! Gradients of objective and rows by sweeps backwards, each node once.
//!
//! A node that one function alone uses belongs to the *piece* of that function. A node that several pieces use is the
//! head of a piece of its own: its gradient is found once and added to theirs. So the work is that of the
//! graph and of the gradients, however much the rows share.

use super::operation::Partials;
use super::tape::{Function, Tape};

/// Most entries that gradients of shared nodes may add to others.
const MOST: usize = 100_000_000;

/// A node that ends a piece below.
#[derive(Debug, Clone, Copy)]
enum Leaf {
    /// A variable, and its place in the gradient.
    Variable { variable: u32, place: u32 },
    /// The head of another piece, and where the places of its gradient begin.
    Head { node: u32, piece: u32, places: u32 },
}

/// A function or a shared node.
#[derive(Debug, Default)]
struct Piece {
    /// Nodes with their weights from which the sweep begins.
    seeds: Vec<(u32, f64)>,
    /// Nodes inside, operands last.
    nodes: Vec<u32>,
    leaves: Vec<Leaf>,
    /// Where its gradient begins among all, and the variables of its entries.
    first: usize,
    columns: Vec<u32>,
}

/// Who uses a node.
#[derive(Debug, Clone, Copy, PartialEq)]
enum User {
    Nobody,
    One(u32),
    Several,
}

/// The gradients of some functions, nonlinear parts only.
#[derive(Debug)]
pub(super) struct Gradients {
    /// The functions in their order, then the shared nodes from last to first.
    pieces: Vec<Piece>,
    functions: usize,
    /// Places of the gradients of heads in those of the pieces that use them.
    places: Vec<u32>,
    adjoints: Vec<f64>,
    values: Vec<f64>,
}

impl Gradients {
    /// Finds pieces and patterns; `None` if the gradients have too many entries.
    pub(super) fn new(tape: &Tape, functions: &[Function]) -> Option<Self> {
        let mut gradients = Self {
            pieces: functions.iter().map(piece).collect(),
            functions: functions.len(),
            places: Vec::new(),
            adjoints: vec![0.0; tape.len()],
            values: Vec::new(),
        };
        let heads = gradients.divide(tape);
        let order = gradients.order();
        for piece in order {
            gradients.join(piece, &heads)?;
        }
        Some(gradients)
    }

    /// Shared nodes from the first on, then the functions: each after what it uses.
    fn order(&self) -> impl Iterator<Item = usize> + use<> {
        let heads = self.functions..self.pieces.len();
        heads.rev().chain(0..self.functions)
    }

    /// Gives each node to a piece; returns the piece that each node is the head of. Leaves are not placed yet.
    fn divide(&mut self, tape: &Tape) -> Vec<Option<u32>> {
        let mut users = vec![User::Nobody; tape.len()];
        let mut heads = vec![None; tape.len()];
        let mut met: Vec<(u32, u32)> = Vec::new();
        fn meet(users: &mut [User], node: u32, piece: u32) {
            let user = &mut users[node as usize];
            *user = match *user {
                User::Nobody => User::One(piece),
                User::One(known) if known == piece => User::One(piece),
                _ => User::Several,
            };
        }
        for (index, piece) in self.pieces.iter().enumerate() {
            for &(node, _) in &piece.seeds {
                meet(&mut users, node, index as u32);
                met.push((node, index as u32));
            }
        }
        for node in (tape.variables..tape.len()).rev() {
            let piece = match users[node] {
                User::Nobody => continue,
                User::One(piece) => piece,
                User::Several => {
                    let piece = self.pieces.len() as u32;
                    heads[node] = Some(piece);
                    self.pieces.push(Piece {
                        seeds: vec![(node as u32, 1.0)],
                        ..Piece::default()
                    });
                    piece
                }
            };
            self.pieces[piece as usize].nodes.push(node as u32);
            tape.visit(node, |operand, _| {
                meet(&mut users, operand, piece);
                met.push((operand, piece));
            });
        }
        met.sort_unstable();
        met.dedup();
        for (node, piece) in met {
            let leaves = &mut self.pieces[piece as usize].leaves;
            if (node as usize) < tape.variables {
                leaves.push(Leaf::Variable {
                    variable: node,
                    place: 0,
                });
            } else if let Some(head) = heads[node as usize] {
                leaves.push(Leaf::Head {
                    node,
                    piece: head,
                    places: 0,
                });
            }
        }
        heads
    }

    /// Finds the entries of a piece and the places of its leaves in them.
    fn join(&mut self, piece: usize, heads: &[Option<u32>]) -> Option<()> {
        let mut leaves = std::mem::take(&mut self.pieces[piece].leaves);
        // the head of the piece itself is none of its leaves
        leaves.retain(|leaf| match leaf {
            Leaf::Head { node, .. } => heads[*node as usize] != Some(piece as u32),
            Leaf::Variable { .. } => true,
        });
        let mut columns: Vec<u32> = Vec::new();
        for leaf in &leaves {
            match *leaf {
                Leaf::Variable { variable, .. } => columns.push(variable),
                Leaf::Head { piece: head, .. } => {
                    columns.extend_from_slice(&self.pieces[head as usize].columns);
                }
            }
            if columns.len() > MOST {
                return None;
            }
        }
        columns.sort_unstable();
        columns.dedup();
        let place_of = |variable: u32| columns.partition_point(|&column| column < variable) as u32;
        for leaf in &mut leaves {
            match leaf {
                Leaf::Variable { variable, place } => *place = place_of(*variable),
                Leaf::Head {
                    piece: head,
                    places,
                    ..
                } => {
                    *places = self.places.len() as u32;
                    let inner = &self.pieces[*head as usize].columns;
                    self.places.extend(inner.iter().map(|&v| place_of(v)));
                }
            }
        }
        let first = self.values.len();
        self.values.resize(first + columns.len(), 0.0);
        if self.values.len() + self.places.len() > MOST {
            return None;
        }
        let piece = &mut self.pieces[piece];
        (piece.leaves, piece.first, piece.columns) = (leaves, first, columns);
        Some(())
    }

    /// Variables of the gradient of a function, ascending.
    pub(super) fn columns(&self, function: usize) -> &[u32] {
        &self.pieces[function].columns
    }

    /// The gradient of a function at the point of the last [`evaluate`](Self::evaluate).
    pub(super) fn values(&self, function: usize) -> &[f64] {
        let piece = &self.pieces[function];
        &self.values[piece.first..piece.first + piece.columns.len()]
    }

    /// Finds all gradients where the partial derivatives are `partials`.
    pub(super) fn evaluate(&mut self, tape: &Tape, partials: &[Partials]) {
        self.values.fill(0.0);
        for index in self.order() {
            let piece = &self.pieces[index];
            let adjoints = &mut self.adjoints;
            for &(node, weight) in &piece.seeds {
                adjoints[node as usize] += weight;
            }
            for &node in &piece.nodes {
                let node = node as usize;
                let adjoint = std::mem::take(&mut adjoints[node]);
                tape.visit(node, |operand, factor| {
                    adjoints[operand as usize] += adjoint * factor.value(&partials[node]);
                });
            }
            for leaf in &piece.leaves {
                match *leaf {
                    Leaf::Variable { variable, place } => {
                        let adjoint = std::mem::take(&mut adjoints[variable as usize]);
                        self.values[piece.first + place as usize] += adjoint;
                    }
                    Leaf::Head {
                        node,
                        piece: head,
                        places,
                    } => {
                        let adjoint = std::mem::take(&mut adjoints[node as usize]);
                        let head = &self.pieces[head as usize];
                        let places = &self.places[places as usize..];
                        for (k, &place) in places[..head.columns.len()].iter().enumerate() {
                            let add = adjoint * self.values[head.first + k];
                            self.values[piece.first + place as usize] += add;
                        }
                    }
                }
            }
        }
    }
}

fn piece(function: &Function) -> Piece {
    Piece {
        seeds: function.nodes.clone(),
        ..Piece::default()
    }
}
