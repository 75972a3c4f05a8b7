//! The refusal of an input.

use std::fmt;

/// Why an input was refused before the first step or iteration: the message names what and where, its value and unit,
/// the bound, and what to do instead.
///
/// `Debug` shows the message as well: it is what a program prints whose `main` returns the error.
///
/// ```
/// use hangtime_solver::InputError;
///
/// let refused = InputError::new("x[0]: lower bound 1, upper bound 0; give bounds with lower <= upper");
/// assert_eq!(format!("{refused:?}"), refused.to_string());
/// assert!(!refused.is_unsupported());
/// ```
#[derive(Clone, PartialEq, Eq)]
pub struct InputError {
    message: String,
    unsupported: bool,
}

impl InputError {
    /// A refusal with this message.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            unsupported: false,
        }
    }

    /// A refusal, with this message, of what makes sense, but not to this method.
    #[must_use]
    pub fn unsupported(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            unsupported: true,
        }
    }

    /// Whether the input makes sense, but not to this method: another one may take it.
    #[must_use]
    pub fn is_unsupported(&self) -> bool {
        self.unsupported
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
