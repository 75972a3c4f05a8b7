//! Why a unit or a quantity was refused.

use std::fmt;

/// Why a unit, a quantity or a conversion was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnitError {
    /// A symbol that is no unit.
    Unknown {
        /// The symbol.
        symbol: String,
        /// A unit that looks like it, if any.
        suggestion: Option<&'static str>,
    },
    /// Something other than symbols, powers, products and quotients.
    Malformed {
        /// The whole text.
        text: String,
        /// What is wrong, and the remedy.
        reason: &'static str,
    },
    /// The text does not begin with a number.
    NotANumber {
        /// The whole text.
        text: String,
    },
    /// The text begins with a number that goes on with something that is no unit, such as a decimal comma.
    BrokenNumber {
        /// The whole text.
        text: String,
    },
    /// The two units measure different things.
    Different {
        /// Unit given.
        from: String,
        /// Unit wanted.
        to: String,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown {
                symbol,
                suggestion: Some(suggestion),
            } => write!(
                f,
                "unknown unit `{}`; did you mean `{suggestion}`?",
                shown(symbol)
            ),
            Self::Unknown {
                symbol,
                suggestion: None,
            } => write!(
                f,
                "unknown unit `{}`; write SI units such as m, kg, s, N, J, rad, deg, km/h",
                shown(symbol)
            ),
            Self::Malformed { text, reason } => write!(f, "unit `{}`: {reason}", shown(text)),
            Self::NotANumber { text } => write!(
                f,
                "`{}` does not begin with a number; write a number and an optional unit such as \
                 15km/h",
                shown(text)
            ),
            Self::BrokenNumber { text } => write!(
                f,
                "`{}` is no number; write decimals behind a point and all digits together, such as 1500.5",
                shown(text)
            ),
            Self::Different { from, to } => write!(
                f,
                "`{from}` cannot be converted to `{to}`: they measure different things"
            ),
        }
    }
}

impl std::error::Error for UnitError {}

/// Longest text that a message shows in full, in characters.
const LONGEST: usize = 60;

/// A text on one line, its beginning if it is long.
fn shown(text: &str) -> String {
    let mut characters = text
        .chars()
        .map(|c| if c.is_whitespace() { ' ' } else { c });
    let begin: String = characters.by_ref().take(LONGEST).collect();
    match characters.next() {
        None => begin,
        Some(_) => begin + " ...",
    }
}
