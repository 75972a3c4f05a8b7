//! Nodes, their arena and the handle of one.

use super::elementary::{Function, Function2};
use super::limits;
use super::table::Table;
use std::cell::RefCell;
use std::marker::PhantomData;
use std::rc::Rc;

/// Handle of an expression. Equality is structural equality. Valid on its own thread only; zero by default.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Sym {
    index: u32,
    not_send: PhantomData<*const ()>,
}

/// An input of the emitted functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Variable {
    /// Parameter, in its declared unit.
    Parameter(u16),
    /// Coordinate, in its declared unit.
    Coordinate(u16),
    /// Velocity: time derivative of a coordinate.
    Velocity(u16),
    /// Control, in its declared unit.
    Control(u16),
    /// Physical time, in seconds.
    Time,
    /// Multiplier of an output in a Hessian.
    Multiplier(u16),
    /// Component of a vector that is solved for at run time (implicit form).
    Unknown(u16),
    /// Normal force of a contact, in SI units.
    ContactForce(u16),
    /// Tangential force of a contact, in SI units.
    FrictionForce(u16),
    /// Normal impulse of all impacts of a contact so far, in SI units.
    ContactImpulse(u16),
    /// Tangential impulse of all impacts of a contact so far, in SI units.
    FrictionImpulse(u16),
    /// Normal acceleration that a contact provides, or normal velocity that it does in an impact: what its force or its
    /// impulse is to the solvers.
    Provided(u16),
    /// Tangential acceleration that a contact provides, or tangential velocity that it does in an impact.
    ProvidedSliding(u16),
    /// One of the sums over all impacts.
    Sum(u16),
    /// Force of one equation of a joint, in SI units.
    JointForce(u16),
    /// 1 for an equation of a joint that is held, 0 for one that follows from others.
    JointHeld(u16),
    /// Component of the start `(q, v)` of the motion, in declared units; none is left in what is derived.
    Start(u16),
    /// An unknown that the language makes for the largest of some values, in SI units; none is left in what is derived.
    Epigraph(u16),
    /// Sign of a function that switches what acts, or its size; none is left in what is derived.
    Switch(u16),
    /// Stands for the argument of a function while it is differentiated.
    Argument(u16),
}

impl Variable {
    /// Those of the first `n` coordinates.
    pub(crate) fn coordinates(n: usize) -> Vec<Self> {
        (0..n).map(|i| Self::Coordinate(i as u16)).collect()
    }

    /// Those of the velocities of the first `n` coordinates.
    pub(crate) fn velocities(n: usize) -> Vec<Self> {
        (0..n).map(|i| Self::Velocity(i as u16)).collect()
    }

    pub(crate) fn is_coordinate(self) -> bool {
        matches!(self, Self::Coordinate(_))
    }

    /// Whether it is a velocity, or a state.
    pub(crate) fn is_velocity(self) -> bool {
        matches!(self, Self::Velocity(_))
    }

    pub(crate) fn is_control(self) -> bool {
        matches!(self, Self::Control(_))
    }

    /// Whether it is anything else than a parameter.
    pub(crate) fn moves(self) -> bool {
        !matches!(self, Self::Parameter(_))
    }

    /// Whether it is the force of a contact, which acts over a time.
    pub(crate) fn is_force(self) -> bool {
        matches!(
            self,
            Self::ContactForce(_) | Self::FrictionForce(_) | Self::JointForce(_)
        )
    }

    /// Whether it is the impulse of a contact, which acts at an instant.
    pub(crate) fn is_impulse(self) -> bool {
        matches!(self, Self::ContactImpulse(_) | Self::FrictionImpulse(_))
    }

    /// Whether it follows from the contacts of a motion: no part of the dynamics knows it.
    pub(crate) fn is_of_contact(self) -> bool {
        self.is_force() || self.is_impulse() || matches!(self, Self::Sum(_))
    }
}

/// An expression whose parts are expressions.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    /// A constant, by its bits.
    Number(u64),
    Variable(Variable),
    /// Coefficients (by their bits) times terms; the constant is the coefficient of the number 1.
    Sum(Rc<[(Sym, u64)]>),
    /// Factors to powers counted in halves: exponent 2 is the factor itself, 1 its square root, -2
    /// its reciprocal.
    Product(Rc<[(Sym, i32)]>),
    Call(Function, Sym),
    Call2(Function2, Sym, Sym),
    /// The value of an expression as one quantity: it is no list of terms or factors to what it is part
    /// of. Formulas that use a long expression many times stay short by it.
    Kept(Sym),
}

#[derive(Default)]
struct Arena {
    nodes: Vec<Node>,
    /// Longest path from each node to a leaf.
    depths: Vec<u32>,
    /// Whether each node, as a factor to a whole power, is split at once into all that it will ever be.
    split: Vec<bool>,
    table: Table<Node, Sym>,
    /// How often it was emptied.
    generation: u64,
}

thread_local! {
    static ARENA: RefCell<Arena> = RefCell::default();
}

/// Empties the arena of this thread; handles from before are void.
pub(crate) fn reset() {
    ARENA.with_borrow_mut(|arena| {
        arena.nodes.clear();
        arena.depths.clear();
        arena.split.clear();
        arena.table.clear();
        arena.generation += 1;
    });
    limits::reset();
    // Fixed places of the two constants that `Sym::ZERO` and `Sym::ONE` name.
    intern(Node::Number(0.0_f64.to_bits()));
    intern(Node::Number(1.0_f64.to_bits()));
}

/// Which derivation of this thread goes on: handles of another one are void.
pub(crate) fn generation() -> u64 {
    ARENA.with_borrow(|arena| arena.generation)
}

/// The handle of a node that is in normal form already.
pub(super) fn intern(node: Node) -> Sym {
    ARENA.with_borrow_mut(|arena| {
        if let Some(&known) = arena.table.get(&node) {
            return known;
        }
        let sym = Sym::at(arena.nodes.len());
        let below = children(&node).into_iter();
        let below = below.filter_map(|part| arena.depths.get(part.index()));
        let depth = below.max().map_or(0, |depth| depth + 1);
        arena.depths.push(depth);
        let split = arena.splits_at_once(&node);
        arena.split.push(split);
        arena.nodes.push(node.clone());
        arena.table.insert(node, sym);
        sym
    })
}

impl Arena {
    /// One quantity is split no further, nor is a product of such and of whole powers of sums, which were split when it was made.
    fn splits_at_once(&self, node: &Node) -> bool {
        let is_split = |&(part, halves): &(Sym, i32)| match self.nodes.get(part.index()) {
            Some(Node::Sum(_)) => halves % 2 == 0,
            Some(Node::Number(_) | Node::Product(_) | Node::Call(Function::Root, _)) | None => {
                false
            }
            Some(_) => true,
        };
        match node {
            Node::Sum(_) | Node::Call(Function::Root, _) => false,
            Node::Product(factors) => factors.iter().all(is_split),
            _ => true,
        }
    }
}

impl Sym {
    /// Whether it is split, as a factor to a whole power, at once into all that it will ever be.
    pub(super) fn splits_at_once(self) -> bool {
        ARENA.with_borrow(|arena| arena.split.get(self.index()).copied().unwrap_or(false))
    }

    pub(crate) const ZERO: Self = Self::at_const(0);
    pub(crate) const ONE: Self = Self::at_const(1);

    const fn at_const(index: u32) -> Self {
        Self {
            index,
            not_send: PhantomData,
        }
    }

    /// Nodes never reach 2^32: an expansion is refused long before.
    fn at(index: usize) -> Self {
        Self::at_const(u32::try_from(index).unwrap_or(u32::MAX))
    }

    pub(crate) fn index(self) -> usize {
        self.index as usize
    }

    pub(crate) fn node(self) -> Node {
        ARENA.with_borrow(|arena| match arena.nodes.get(self.index()) {
            Some(node) => node.clone(),
            // Before the first `reset` of a thread only the two constants are named.
            None => Node::Number(f64::from(self.index).to_bits()),
        })
    }

    /// Length of the longest path to a leaf.
    pub(crate) fn depth(self) -> usize {
        ARENA.with_borrow(|arena| arena.depths.get(self.index()).map_or(0, |&d| d as usize))
    }

    pub(crate) fn number(value: f64) -> Self {
        // One zero only: -0.0 would be a second one.
        let value = if value == 0.0 { 0.0 } else { value };
        intern(Node::Number(value.to_bits()))
    }

    pub(crate) fn variable(variable: Variable) -> Self {
        intern(Node::Variable(variable))
    }

    /// The constant that this is, if it is one.
    pub(crate) fn as_number(self) -> Option<f64> {
        match self.node() {
            Node::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn is_structural_zero(self) -> bool {
        self == Self::ZERO
    }
}

/// Parts of a node.
pub(crate) fn children(node: &Node) -> Vec<Sym> {
    match node {
        Node::Number(_) | Node::Variable(_) => Vec::new(),
        Node::Sum(terms) => terms.iter().map(|&(term, _)| term).collect(),
        Node::Product(factors) => factors.iter().map(|&(factor, _)| factor).collect(),
        Node::Call(_, inner) | Node::Kept(inner) => vec![*inner],
        Node::Call2(_, first, second) => vec![*first, *second],
    }
}
