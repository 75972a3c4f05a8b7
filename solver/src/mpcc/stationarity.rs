//! What is proved about a result.

use std::fmt;

use serde::Serialize;

/// What is proved about a feasible point.
///
/// ```
/// use hangtime_solver::mpcc::Stationarity;
///
/// assert_eq!(Stationarity::B.name(), "B");
/// assert_eq!(
///     Stationarity::B.to_string(),
///     "B, no other choice of the sides that vanish is better"
/// );
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stationarity {
    /// Strongly stationary: the optimality conditions of the program with all pairs relaxed hold.
    S,
    /// B-stationary: both sides of some pairs vanish, and no choice of the sides that stay zero is better.
    B,
    /// Nothing.
    None,
}

impl fmt::Display for Stationarity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::S => "S, no pair has another side that could vanish",
            Self::B => "B, no other choice of the sides that vanish is better",
            Self::None => "none, other choices of the sides were not compared",
        })
    }
}

impl Serialize for Stationarity {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Stationarity {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::S => "S",
            Self::B => "B",
            Self::None => "none",
        }
    }
}
