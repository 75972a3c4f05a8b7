//! Straight-line code: operations in order of evaluation.

use crate::graph::{Compose, Function, Function2, Sym, Variable};

/// One operation on the results of earlier ones, which are named by their positions; what is `Given` is computed nowhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation<G> {
    /// An input or a constant.
    Given(G),
    /// Sum.
    Add(u32, u32),
    /// Difference.
    Subtract(u32, u32),
    /// Product.
    Multiply(u32, u32),
    /// Quotient.
    Divide(u32, u32),
    /// The negative.
    Negate(u32),
    /// Square root.
    Root(u32),
    /// A function of one number.
    Call(Function, u32),
    /// A function of two numbers.
    Call2(Function2, u32, u32),
}

/// What a tape is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Leaf {
    Variable(Variable),
    /// A constant, by its bits.
    Constant(u64),
}

/// An operation of a tape.
pub(crate) type Op = Operation<Leaf>;

impl<G> Operation<G> {
    /// Whether nothing is computed.
    #[must_use]
    pub const fn is_given(&self) -> bool {
        matches!(self, Self::Given(_))
    }

    /// Positions of the operands.
    pub fn operands(&self) -> impl Iterator<Item = u32> + use<G> {
        let (first, second) = match *self {
            Self::Given(_) => (None, None),
            Self::Negate(a) | Self::Root(a) | Self::Call(_, a) => (Some(a), None),
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Call2(_, a, b) => (Some(a), Some(b)),
        };
        first.into_iter().chain(second)
    }

    /// Its value as a number, of what is given and of the results of earlier operations.
    pub fn value(self, given: impl FnOnce(G) -> f64, at: impl Fn(u32) -> f64) -> f64 {
        match self {
            Self::Given(known) => given(known),
            Self::Add(a, b) => at(a) + at(b),
            Self::Subtract(a, b) => at(a) - at(b),
            Self::Multiply(a, b) => at(a) * at(b),
            Self::Divide(a, b) => at(a) / at(b),
            Self::Negate(a) => -at(a),
            Self::Root(a) => at(a).sqrt(),
            Self::Call(function, a) => function.value(at(a)),
            Self::Call2(function, a, b) => function.value(at(a), at(b)),
        }
    }

    /// This operation on other operands.
    #[must_use]
    pub fn with_operands(self, to: impl Fn(u32) -> u32) -> Self {
        self.mapped(|given| given, to)
    }

    /// This operation on what else is given.
    pub(crate) fn with_given<H>(self, given: impl FnOnce(G) -> H) -> Operation<H> {
        self.mapped(given, |part| part)
    }

    fn mapped<H>(self, given: impl FnOnce(G) -> H, to: impl Fn(u32) -> u32) -> Operation<H> {
        match self {
            Self::Given(known) => Operation::Given(given(known)),
            Self::Add(a, b) => Operation::Add(to(a), to(b)),
            Self::Subtract(a, b) => Operation::Subtract(to(a), to(b)),
            Self::Multiply(a, b) => Operation::Multiply(to(a), to(b)),
            Self::Divide(a, b) => Operation::Divide(to(a), to(b)),
            Self::Negate(a) => Operation::Negate(to(a)),
            Self::Root(a) => Operation::Root(to(a)),
            Self::Call(function, a) => Operation::Call(function, to(a)),
            Self::Call2(function, a, b) => Operation::Call2(function, to(a), to(b)),
        }
    }
}

/// Operations in order of evaluation, and which of them are the outputs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tape {
    pub(crate) ops: Vec<Op>,
    pub(crate) outputs: Vec<u32>,
}

impl Tape {
    /// These operations with the calls of functions, and what those need, before all others: a call
    /// leaves no value in a register, so whatever is computed before one and used behind it takes
    /// the way through memory.
    pub(super) fn calls_first(self) -> Self {
        let mut early = vec![false; self.ops.len()];
        for (i, op) in self.ops.iter().enumerate().rev() {
            if early[i] || matches!(op, Op::Call(..) | Op::Call2(..)) {
                early[i] = true;
                for part in op.operands() {
                    early[part as usize] = true;
                }
            }
        }
        let (mut order, late): (Vec<usize>, Vec<usize>) =
            (0..self.ops.len()).partition(|&i| early[i]);
        order.extend(late);
        let mut place = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            place[old] = new as u32;
        }
        Self {
            ops: order
                .iter()
                .map(|&old| self.ops[old].with_operands(|part| place[part as usize]))
                .collect(),
            outputs: self.outputs.iter().map(|&i| place[i as usize]).collect(),
        }
    }

    /// The outputs as expressions again, each operation one quantity: what is differentiated then is the
    /// evaluation with all that it shares.
    pub(crate) fn stepwise(&self) -> Vec<Sym> {
        self.evaluated(Sym::kept)
    }

    /// The outputs as expressions again, with `keep` applied to each operation.
    pub(crate) fn evaluated(&self, keep: fn(Sym) -> Sym) -> Vec<Sym> {
        let mut values: Vec<Sym> = Vec::with_capacity(self.ops.len());
        for &op in &self.ops {
            let at = |i: u32| values[i as usize];
            let value = match op {
                Op::Given(Leaf::Variable(variable)) => Sym::variable(variable),
                Op::Given(Leaf::Constant(bits)) => Sym::number(f64::from_bits(bits)),
                Op::Add(a, b) => at(a) + at(b),
                Op::Subtract(a, b) => at(a) - at(b),
                Op::Multiply(a, b) => at(a) * at(b),
                Op::Divide(a, b) => at(a) / at(b),
                Op::Negate(a) => -at(a),
                Op::Root(a) => at(a).power(1),
                Op::Call(function, a) => at(a).call(function),
                Op::Call2(function, a, b) => at(a).call2(function, at(b)),
            };
            values.push(keep(value));
        }
        self.outputs.iter().map(|&i| values[i as usize]).collect()
    }

    /// Number of arithmetic operations and function calls.
    pub(crate) fn operations(&self) -> usize {
        self.ops.iter().filter(|op| !op.is_given()).count()
    }
}
