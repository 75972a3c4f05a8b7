//! Explicit functions of a scene from a text, for ranges of their inputs.

use crate::model::tape::{Function, Operation};
use crate::model::{Explicit, Tape};
use hangtime_dsl::description::{
    Description, ExplicitFunction, Function as Called, Function2, Kernel, Operation as Described,
};

/// Explicit functions of a contact: gap, normal side, tangential side, second tangential side.
const OF_CONTACT: usize = 4;

/// The explicit functions of a scene.
#[derive(Debug)]
pub(super) struct Tapes {
    motion: Option<Stored>,
    /// Of each contact one after the other.
    contacts: Vec<Option<Stored>>,
}

#[derive(Debug)]
struct Stored {
    operations: Vec<Operation>,
    outputs: Vec<u32>,
}

impl Tapes {
    pub(super) fn of(description: &Description) -> Self {
        let places = OF_CONTACT * description.structure.contacts.len();
        let mut tapes = Self {
            motion: None,
            contacts: (0..places).map(|_| None).collect(),
        };
        for (function, kernel) in description.explicit_functions() {
            let (contact, kind) = match function {
                ExplicitFunction::Motion => {
                    tapes.motion = Some(Stored::of(kernel));
                    continue;
                }
                ExplicitFunction::Gap(i) => (i, 0),
                ExplicitFunction::Normal(i) => (i, 1),
                ExplicitFunction::Tangent(i) => (i, 2),
                ExplicitFunction::Across(i) => (i, 3),
            };
            tapes.contacts[OF_CONTACT * contact + kind] = Some(Stored::of(kernel));
        }
        tapes
    }

    pub(super) fn get(&self, function: Explicit) -> Option<Tape<'_>> {
        let of = |contact: usize, kind: usize| {
            let stored = self.contacts.get(OF_CONTACT * contact + kind)?;
            stored.as_ref()
        };
        let stored = match function {
            Explicit::Motion => self.motion.as_ref(),
            Explicit::Gap(i) => of(i, 0),
            Explicit::Normal(i) => of(i, 1),
            Explicit::Tangent(i) => of(i, 2),
            Explicit::Across(i) => of(i, 3),
        }?;
        Some(Tape {
            operations: &stored.operations,
            outputs: &stored.outputs,
        })
    }
}

impl Stored {
    fn of(kernel: Kernel) -> Self {
        Self {
            operations: kernel.operations.into_iter().map(operation).collect(),
            outputs: kernel.outputs,
        }
    }
}

fn operation(described: Described) -> Operation {
    match described {
        Described::Parameter(i) => Operation::Parameter(i),
        Described::Input(i) => Operation::Input(i),
        Described::Weight(_) => Operation::Unknown,
        Described::Constant(value) => Operation::Constant(value),
        Described::Add(a, b) => Operation::Add(a, b),
        Described::Subtract(a, b) => Operation::Subtract(a, b),
        Described::Multiply(a, b) => Operation::Multiply(a, b),
        Described::Divide(a, b) => Operation::Divide(a, b),
        Described::Negate(a) => Operation::Negate(a),
        Described::Root(a) => Operation::Root(a),
        Described::Call(function, a) => Operation::Call(called(function), a),
        Described::Call2(Function2::Atan2, a, b) => Operation::Atan2(a, b),
        Described::Call2(Function2::Power, a, b) => Operation::Power(a, b),
    }
}

fn called(function: Called) -> Function {
    match function {
        Called::Sin => Function::Sin,
        Called::Cos => Function::Cos,
        Called::Tan => Function::Tan,
        Called::Asin => Function::Asin,
        Called::Acos => Function::Acos,
        Called::Atan => Function::Atan,
        Called::Sinh => Function::Sinh,
        Called::Cosh => Function::Cosh,
        Called::Tanh => Function::Tanh,
        Called::Exp => Function::Exp,
        Called::Ln => Function::Ln,
        Called::Cbrt => Function::Cbrt,
        Called::Root => Function::Root,
        Called::InverseRoot => Function::InverseRoot,
        Called::Abs => Function::Abs,
        Called::Sign => Function::Sign,
        Called::Profile(profile) => Function::Profile(profile.pieces(), profile.order()),
    }
}
