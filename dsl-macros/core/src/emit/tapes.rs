//! Explicit functions as data, for ranges of their inputs.

use super::kernel::{literal, profiles};
use crate::description::{Description, ExplicitFunction, Function, Function2, Kernel, Operation};
use std::fmt::Write;

const TAPE: &str = "::hangtime::model::tape";

/// The method of the model trait that gives them, with their operations as static data.
pub(super) fn method(description: &Description) -> String {
    let mut arms = String::new();
    for (function, kernel) in description.explicit_functions() {
        let function = match function {
            ExplicitFunction::Gap(i) => format!("Gap({i})"),
            ExplicitFunction::Normal(i) => format!("Normal({i})"),
            ExplicitFunction::Tangent(i) => format!("Tangent({i})"),
            ExplicitFunction::Across(i) => format!("Across({i})"),
            ExplicitFunction::Motion => "Motion".to_owned(),
        };
        let _ = write!(
            arms,
            "{TAPE}::Explicit::{function} => {{ static O: &[__Operation] = &[{}]; static V: &[::core::primitive::u32] = &{:?}; (O, V) }}",
            operations(description, &kernel),
            kernel.outputs
        );
    }
    format!(
        "fn tape(&self, function: {TAPE}::Explicit) -> ::core::option::Option<{TAPE}::Tape<'_>> {{
            use {TAPE}::{{Function as __Function, Operation as __Operation}};
            let (operations, outputs) = match function {{ {arms} _ => return ::core::option::Option::None }};
            ::core::option::Option::Some({TAPE}::Tape {{ operations, outputs }})
        }}"
    )
}

fn operations(description: &Description, kernel: &Kernel) -> String {
    let mut code = String::new();
    for &operation in &kernel.operations {
        let written = match operation {
            Operation::Weight(_) => "Unknown".to_owned(),
            Operation::Constant(value) => format!("Constant({})", literal(value)),
            Operation::Call(function, a) => {
                format!("Call(__Function::{}, {a})", called(description, function))
            }
            Operation::Call2(Function2::Atan2, a, b) => format!("Atan2({a}, {b})"),
            Operation::Call2(Function2::Power, a, b) => format!("Power({a}, {b})"),
            // The others have the same names.
            plain => format!("{plain:?}"),
        };
        let _ = write!(code, "__Operation::{written},");
    }
    code
}

fn called(description: &Description, function: Function) -> String {
    match function {
        Function::Profile(profile) => {
            let mut known = profiles(description).into_iter();
            let place = known.position(|known| known.name() == profile.name());
            let place = place.unwrap_or_default();
            format!("Profile(__PROFILES[{place}], {})", profile.order())
        }
        plain => format!("{plain:?}"),
    }
}
