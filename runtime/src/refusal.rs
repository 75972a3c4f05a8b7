//! The messages in which inputs are refused.

use std::fmt;

use hangtime_solver::InputError;

/// A number that must be finite is not.
pub(crate) fn not_finite(what: impl fmt::Display, value: f64) -> InputError {
    InputError::new(format!("{what} is {value}; give a finite number"))
}

/// A number lies outside the values that make sense; its unit may be empty, the bound is in words.
pub(crate) fn out_of_range(
    what: impl fmt::Display,
    value: f64,
    unit: &str,
    bound: impl fmt::Display,
) -> InputError {
    let number = format!("{value} {unit}");
    InputError::new(format!("{what} = {}: must be {bound}", number.trim_end()))
}

/// A vector has the wrong length.
pub(crate) fn wrong_length(what: impl fmt::Display, found: usize, expected: usize) -> InputError {
    InputError::new(format!(
        "{what} has {found} components, expected {expected}"
    ))
}

/// The method cannot treat something that is meaningful otherwise.
pub(crate) fn unsupported(what: impl fmt::Display, remedy: impl fmt::Display) -> InputError {
    InputError::unsupported(format!("{what} is not supported; {remedy}"))
}

/// The method cannot treat the impact law of a contact.
pub(crate) fn unsupported_law(method: &str, contact: &str) -> InputError {
    InputError::unsupported(format!(
        "method {method} cannot treat the impact law of `{contact}`"
    ))
}
