//! The refusal of an input.

use std::fmt;

/// Why an input was refused before the first step or iteration: the message names what and where, its value and unit,
/// the bound, and what to do instead.
///
/// `Debug` shows the message as well: it is what a program prints whose `main` returns the error.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: 1 [m] }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let refused = simulate(&Ball::default()).horizon(-1.0).run().unwrap_err();
/// assert_eq!(refused.to_string(), "horizon = -1 s: must be above 0");
/// assert!(!refused.is_unsupported());
/// ```
#[derive(Clone, PartialEq, Eq)]
pub struct InputError {
    message: String,
    unsupported: bool,
}

impl InputError {
    /// Whether the input makes sense, but not to this method: another one may take it.
    #[must_use]
    pub fn is_unsupported(&self) -> bool {
        self.unsupported
    }

    /// A refusal in words of its own.
    pub(crate) fn new(message: String) -> Self {
        Self {
            message,
            unsupported: false,
        }
    }

    /// A number that must be finite is not.
    pub(crate) fn not_finite(what: impl fmt::Display, value: f64) -> Self {
        Self::new(format!("{what} is {value}; give a finite number"))
    }

    /// A number lies outside the values that make sense; its unit may be empty, the bound is in words.
    pub(crate) fn out_of_range(
        what: impl fmt::Display,
        value: f64,
        unit: &str,
        bound: impl fmt::Display,
    ) -> Self {
        let number = format!("{value} {unit}");
        Self::new(format!("{what} = {}: must be {bound}", number.trim_end()))
    }

    /// A vector has the wrong length.
    pub(crate) fn wrong_length(what: impl fmt::Display, found: usize, expected: usize) -> Self {
        Self::new(format!(
            "{what} has {found} components, expected {expected}"
        ))
    }

    /// The method cannot treat something that is meaningful otherwise.
    pub(crate) fn unsupported(what: impl fmt::Display, remedy: impl fmt::Display) -> Self {
        Self {
            message: format!("{what} is not supported; {remedy}"),
            unsupported: true,
        }
    }

    /// The method cannot treat the impact law of a contact.
    pub(crate) fn unsupported_law(method: &str, contact: &str) -> Self {
        Self {
            message: format!("method {method} cannot treat the impact law of `{contact}`"),
            unsupported: true,
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl fmt::Debug for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for InputError {}
