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
    let number = format!("{} {unit}", shown(value));
    InputError::new(format!("{what} = {}: must be {bound}", number.trim_end()))
}

/// A number with an exponent where there would be dozens of digits.
fn shown(value: f64) -> String {
    let size = value.abs();
    if size.is_finite() && size != 0.0 && !(1e-6..1e16).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// A vector has the wrong length.
pub(crate) fn wrong_length(what: impl fmt::Display, found: usize, expected: usize) -> InputError {
    InputError::new(format!(
        "{what} has {found} components, expected {expected}"
    ))
}

/// There is nothing of that name.
pub(crate) fn no_such(what: &str, name: &str, names: &[&str]) -> InputError {
    InputError::new(format!(
        "`{name}` is no {what}; there are {}",
        names.join(", ")
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

#[cfg(test)]
mod tests {
    use super::out_of_range;

    #[test]
    fn numbers_far_from_one_are_refused_in_few_digits() {
        for (value, words) in [
            (1e300, "x = 1e300 s: must be less"),
            (-2.5e-300, "x = -2.5e-300 s: must be less"),
            (0.25, "x = 0.25 s: must be less"),
            (0.0, "x = 0 s: must be less"),
        ] {
            assert_eq!(out_of_range("x", value, "s", "less").to_string(), words);
        }
    }
}
