//! Straight-line functions of a scene: operations on parameters, inputs and weights.

use crate::declaration::{self, text};
use crate::graph::{Function, Function2, Variable};
use crate::scene::CheckedScene;
use crate::tape::{Op, Tape};

/// One function of a scene, as operations in order of evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    /// Its name, which other kernels may have as well.
    pub name: String,
    /// Whether it is evaluated again and again, so that its cost is of interest. The others read parameters only.
    pub listed: bool,
    /// The operations; their operands are earlier ones, by position.
    pub operations: Vec<Operation>,
    /// Positions of the operations that are the outputs.
    pub outputs: Vec<u32>,
}

/// One operation of a kernel on the results of earlier ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Operation {
    /// The value of a parameter, in its declared unit.
    Parameter(u32),
    /// A component of the input vector.
    Input(u32),
    /// A component of the second vector: multipliers, or the unknowns of a linear system.
    Weight(u32),
    /// A number.
    Constant(f64),
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

impl Operation {
    /// Whether nothing is computed: an input or a constant.
    #[must_use]
    pub fn is_given(self) -> bool {
        matches!(
            self,
            Self::Parameter(_) | Self::Input(_) | Self::Weight(_) | Self::Constant(_)
        )
    }

    /// Positions of the operands.
    pub fn operands(self) -> impl Iterator<Item = u32> {
        let (first, second) = match self {
            Self::Parameter(_) | Self::Input(_) | Self::Weight(_) | Self::Constant(_) => {
                (None, None)
            }
            Self::Negate(a) | Self::Root(a) | Self::Call(_, a) => (Some(a), None),
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Call2(_, a, b) => (Some(a), Some(b)),
        };
        first.into_iter().chain(second)
    }

    /// This operation on other operands.
    #[must_use]
    pub fn with_operands(self, to: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Parameter(_) | Self::Input(_) | Self::Weight(_) | Self::Constant(_) => self,
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

impl Kernel {
    /// The kernel of these outputs in this order of operations. With `at_the_end` it reads `(q, v, T)` with the final time `T`, and sums behind it,
    /// instead of the input vector; what contacts provide stands behind either.
    pub(super) fn new(
        scene: &CheckedScene,
        name: &str,
        tape: Tape,
        (listed, at_the_end): (bool, bool),
    ) -> Self {
        let operations = tape.ops.iter().map(|&op| match op {
            Op::Load(variable) => place(scene, variable, at_the_end),
            Op::Constant(bits) => Operation::Constant(f64::from_bits(bits)),
            Op::Add(a, b) => Operation::Add(a, b),
            Op::Subtract(a, b) => Operation::Subtract(a, b),
            Op::Multiply(a, b) => Operation::Multiply(a, b),
            Op::Divide(a, b) => Operation::Divide(a, b),
            Op::Negate(a) => Operation::Negate(a),
            Op::Root(a) => Operation::Root(a),
            Op::Call(function, a) => Operation::Call(function, a),
            Op::Call2(function, a, b) => Operation::Call2(function, a, b),
        });
        Self {
            name: name.to_owned(),
            listed,
            operations: operations.collect(),
            outputs: tape.outputs,
        }
    }

    /// The code of some of its `outputs` only, with the operations that these need.
    pub(super) fn part(&self, outputs: impl IntoIterator<Item = usize>) -> Self {
        let outputs: Vec<u32> = outputs.into_iter().map(|k| self.outputs[k]).collect();
        let mut needed = vec![false; self.operations.len()];
        for &output in &outputs {
            needed[output as usize] = true;
        }
        for (i, operation) in self.operations.iter().enumerate().rev() {
            if needed[i] {
                for operand in operation.operands() {
                    needed[operand as usize] = true;
                }
            }
        }
        let mut place = vec![0_u32; self.operations.len()];
        let mut operations = Vec::new();
        for (i, operation) in self.operations.iter().enumerate() {
            if needed[i] {
                place[i] = operations.len() as u32;
                operations.push(operation.with_operands(|part| place[part as usize]));
            }
        }
        Self {
            name: self.name.clone(),
            listed: self.listed,
            operations,
            outputs: outputs.iter().map(|&k| place[k as usize]).collect(),
        }
    }

    /// What is declared of it.
    pub(super) fn declared(&self) -> declaration::Kernel {
        declaration::Kernel {
            name: text(&self.name),
            operations: self.cost(),
            outputs: self.outputs.len(),
        }
    }

    /// Number of arithmetic operations and function calls.
    #[must_use]
    pub fn cost(&self) -> usize {
        let computed = self.operations.iter().filter(|known| !known.is_given());
        computed.count()
    }

    /// Whether all constants are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.operations
            .iter()
            .all(|known| !matches!(known, Operation::Constant(value) if !value.is_finite()))
    }
}

/// Where a kernel finds a variable.
fn place(scene: &CheckedScene, variable: Variable, at_the_end: bool) -> Operation {
    let (n, m) = (scene.coordinates.len(), scene.controls.len());
    let input = |i: usize| Operation::Input(i as u32);
    let sums = scene
        .optimal_control
        .as_ref()
        .map_or(0, |task| task.sums.len());
    let plain = if at_the_end {
        2 * n + 1 + sums
    } else {
        2 * n + m + usize::from(scene.explicit_time)
    };
    let of_contact = |group: usize, i: u16| {
        Operation::Weight((group * scene.contacts.len() + usize::from(i)) as u32)
    };
    match variable {
        Variable::Parameter(i) => Operation::Parameter(u32::from(i)),
        Variable::Coordinate(i) => input(usize::from(i)),
        Variable::Velocity(i) => input(n + usize::from(i)),
        Variable::Control(i) => input(2 * n + usize::from(i)),
        Variable::Time if at_the_end => input(2 * n),
        Variable::Time => input(2 * n + m),
        Variable::ContactForce(i) => of_contact(0, i),
        Variable::FrictionForce(i) => of_contact(1, i),
        Variable::ContactImpulse(i) => of_contact(2, i),
        Variable::FrictionImpulse(i) => of_contact(3, i),
        Variable::Sum(i) => input(2 * n + 1 + usize::from(i)),
        Variable::Provided(i) => input(plain + usize::from(i)),
        Variable::ProvidedSliding(i) => input(plain + scene.contacts.len() + usize::from(i)),
        // Behind the parameters.
        Variable::JointHeld(i) => {
            Operation::Parameter(u32::from(i) + scene.parameters.len() as u32)
        }
        Variable::JointForce(i) => of_contact(4, i),
        Variable::Multiplier(i)
        | Variable::Unknown(i)
        | Variable::Argument(i)
        | Variable::Switch(i)
        | Variable::Epigraph(i)
        | Variable::Start(i) => Operation::Weight(u32::from(i)),
    }
}
