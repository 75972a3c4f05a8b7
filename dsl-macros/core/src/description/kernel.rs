//! Straight-line functions of a scene: operations on parameters, inputs and weights.

use crate::declaration::{self, text};
use crate::derive::Names;
use crate::graph::Variable;
use crate::scene::CheckedScene;
use crate::tape::{self, Leaf, Tape};

/// One function of a scene, as operations in order of evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    /// Its name, which other kernels may have as well.
    pub name: String,
    /// An earlier kernel, by its index, with the same operations and outputs on other components of inputs and weights.
    pub like: Option<usize>,
    /// Whether it is evaluated again and again, so that its cost is of interest. The others read parameters only.
    pub listed: bool,
    /// The operations; their operands are earlier ones, by position.
    pub operations: Vec<Operation>,
    /// Positions of the operations that are the outputs.
    pub outputs: Vec<u32>,
}

/// An operation of a kernel.
pub type Operation = tape::Operation<Source>;

/// What the operations of a kernel are given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// The value of a parameter, in its declared unit; behind all parameters, 1 for each equation of a joint that is held and 0
    /// for others.
    Parameter(u32),
    /// A component of the input vector.
    Input(u32),
    /// A component of the second vector: multipliers, or the unknowns of a linear system.
    Weight(u32),
    /// A number.
    Constant(f64),
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
        let given = |leaf| match leaf {
            Leaf::Variable(variable) => place(scene, variable, at_the_end),
            Leaf::Constant(bits) => Source::Constant(f64::from_bits(bits)),
        };
        let operations = tape.ops.iter().map(|op| op.with_given(given));
        Self {
            name: name.to_owned(),
            like: None,
            listed,
            operations: operations.collect(),
            outputs: tape.outputs,
        }
    }

    /// The kernel of the Lagrangian of a scene, and behind it of the generalized forces.
    pub(crate) fn acting(scene: &CheckedScene) -> Self {
        let mut values = vec![scene.lagrangian];
        values.extend(&scene.forces);
        Self::new(scene, "acting", tape::shortest(&values), (false, false))
    }

    /// This kernel, which has that index, under another name and with other names of coordinates: those of inputs, and of weights
    /// behind the first `rows`.
    pub(super) fn renamed(&self, index: usize, name: &str, (names, rows): (&Names, usize)) -> Self {
        let given = |source| match source {
            Source::Input(i) => Source::Input(names.input(i as usize) as u32),
            Source::Weight(i) => Source::Weight(names.row(i as usize, rows) as u32),
            other => other,
        };
        let operations = self.operations.iter().map(|known| known.with_given(given));
        Self {
            name: name.to_owned(),
            like: Some(self.like.unwrap_or(index)),
            listed: self.listed,
            operations: operations.collect(),
            outputs: self.outputs.clone(),
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
            like: None,
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
            .all(|known| !matches!(known, Operation::Given(Source::Constant(value)) if !value.is_finite()))
    }
}

/// Where a kernel finds a variable.
fn place(scene: &CheckedScene, variable: Variable, at_the_end: bool) -> Source {
    let (n, m) = (scene.coordinates.len(), scene.controls.len());
    let input = |i: usize| Source::Input(i as u32);
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
        Source::Weight((group * scene.contacts.len() + usize::from(i)) as u32)
    };
    match variable {
        Variable::Parameter(i) => Source::Parameter(u32::from(i)),
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
        Variable::JointHeld(i) => Source::Parameter(u32::from(i) + scene.parameters.len() as u32),
        Variable::JointForce(i) => of_contact(4, i),
        Variable::Multiplier(i)
        | Variable::Unknown(i)
        | Variable::Argument(i)
        | Variable::Switch(i)
        | Variable::Epigraph(i)
        | Variable::Start(i) => Source::Weight(u32::from(i)),
    }
}
