//! Straight-line code: operations in order of evaluation.

use crate::graph::{Compose, Function, Function2, Sym, Variable};

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

impl Op {
    /// Positions of the operands.
    pub(crate) fn operands(self) -> impl Iterator<Item = u32> {
        let (first, second) = match self {
            Self::Load(_) | Self::Constant(_) => (None, None),
            Self::Negate(a) | Self::Root(a) | Self::Call(_, a) => (Some(a), None),
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Call2(_, a, b) => (Some(a), Some(b)),
        };
        first.into_iter().chain(second)
    }

    fn with_operands(self, to: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Load(_) | Self::Constant(_) => self,
            Self::Negate(a) => Self::Negate(to(a)),
            Self::Root(a) => Self::Root(to(a)),
            Self::Call(function, a) => Self::Call(function, to(a)),
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Subtract(a, b) => Self::Subtract(to(a), to(b)),
            Self::Multiply(a, b) => Self::Multiply(to(a), to(b)),
            Self::Divide(a, b) => Self::Divide(to(a), to(b)),
            Self::Call2(function, a, b) => Self::Call2(function, to(a), to(b)),
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
                Op::Load(variable) => Sym::variable(variable),
                Op::Constant(bits) => Sym::number(f64::from_bits(bits)),
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
        self.ops
            .iter()
            .filter(|op| !matches!(op, Op::Load(_) | Op::Constant(_)))
            .count()
    }
}
