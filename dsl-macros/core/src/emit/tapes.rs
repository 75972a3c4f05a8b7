//! Explicit functions as data, for ranges of their inputs.

use super::kernel::{literal, written};
use crate::description::{Description, Function, Kernel, Operation, Source};
use std::fmt::Write;

const TAPE: &str = "::hangtime::scene::tape";

/// The method of the model trait that gives them, with their operations as static data.
pub(super) fn method(description: &Description) -> String {
    let mut arms = String::new();
    for (function, kernel) in description.explicit_functions() {
        let _ = write!(
            arms,
            "{TAPE}::Explicit::{function:?} => {{ static O: &[__Operation] = &[{}]; static V: &[::core::primitive::u32] = &{:?}; (O, V) }}",
            operations(description, &kernel),
            kernel.outputs
        );
    }
    format!(
        "fn tape(&self, function: {TAPE}::Explicit) -> ::core::option::Option<{TAPE}::Tape<'_>> {{
            use {TAPE}::{{Function as __Function, Function2 as __Function2, Operation as __Operation, Source as __Source}};
            let (operations, outputs) = match function {{ {arms} _ => return ::core::option::Option::None }};
            ::core::option::Option::Some({TAPE}::Tape {{ operations, outputs }})
        }}"
    )
}

fn operations(description: &Description, kernel: &Kernel) -> String {
    let mut code = String::new();
    for &operation in &kernel.operations {
        let text = match operation {
            Operation::Given(Source::Constant(value)) => {
                format!("Given(__Source::Constant({}))", literal(value))
            }
            Operation::Given(source) => format!("Given(__Source::{source:?})"),
            Operation::Call(Function::Profile(profile), a) => {
                let profile = written(description, profile);
                format!("Call(__Function::Profile({profile}), {a})")
            }
            Operation::Call(function, a) => format!("Call(__Function::{function:?}, {a})"),
            Operation::Call2(function, a, b) => {
                format!("Call2(__Function2::{function:?}, {a}, {b})")
            }
            // The others have names alone.
            plain => format!("{plain:?}"),
        };
        let _ = write!(code, "__Operation::{text},");
    }
    code
}
