//! What a contact does between two switches.

use std::fmt;

/// Sign of a sliding velocity.
///
/// ```
/// use hangtime::prelude::*;
///
/// assert_eq!(Direction::Backward.sign(), -1.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// `v_t > 0`, or about to be.
    Forward,
    /// `v_t < 0`, or about to be.
    Backward,
}

impl Direction {
    /// Both.
    pub(crate) const BOTH: [Self; 2] = [Self::Forward, Self::Backward];

    /// The direction of a sliding velocity; forward for zero.
    pub(crate) fn of(velocity: f64) -> Self {
        if velocity < 0.0 {
            Self::Backward
        } else {
            Self::Forward
        }
    }

    /// `1` forward, `-1` backward.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    pub(crate) fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// What a contact does between two switches. A contact without friction, or with the coefficient 0, is open or
/// frictionless; one with friction is never frictionless.
///
/// ```
/// use hangtime::prelude::*;
///
/// let mode = ContactMode::Slip(Direction::Backward);
/// assert_ne!(mode, ContactMode::Open);
/// assert_eq!(mode.to_string(), "slipping backward");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ContactMode {
    /// No force.
    Open,
    /// Sustained contact with `r >= 0` and no friction.
    Frictionless,
    /// Sustained contact at rest, `v_t = 0` by a force `|s| <= mu r`; how several contacts that hold each other share
    /// their load is not determined and does not matter.
    Stick,
    /// Sustained contact that slides, or begins to: `s = -mu r` forward and `+mu r` backward.
    Slip(Direction),
}

impl ContactMode {
    /// Whether the contact carries no force.
    pub(crate) fn is_open(self) -> bool {
        self == Self::Open
    }

    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Frictionless => "closed",
            Self::Stick => "stick",
            Self::Slip(Direction::Forward) => "slip_forward",
            Self::Slip(Direction::Backward) => "slip_backward",
        }
    }
}

impl fmt::Display for ContactMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Open => "open",
            Self::Frictionless => "closed",
            Self::Stick => "sticking",
            Self::Slip(Direction::Forward) => "slipping forward",
            Self::Slip(Direction::Backward) => "slipping backward",
        })
    }
}
