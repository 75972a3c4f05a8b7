//! What a contact does between two switches.

use super::model_input::drive;
use crate::model::{Model, tangent_point};

/// Sliding velocities below this share of the largest velocity are zero: a simulation projects them to rounding error.
const AT_REST: f64 = 1e-9;

/// Sign of a sliding velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::ocp) enum Direction {
    Forward,
    Backward,
}

impl Direction {
    /// Both.
    pub(in crate::ocp) const BOTH: [Self; 2] = [Self::Forward, Self::Backward];

    pub(in crate::ocp) fn of(velocity: f64) -> Self {
        if velocity < 0.0 {
            Self::Backward
        } else {
            Self::Forward
        }
    }

    pub(in crate::ocp) fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    pub(in crate::ocp) fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// What a contact does between two switches, or during an impact. A contact without friction is open or
/// frictionless, one with friction is never frictionless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::ocp) enum Mode {
    /// No force.
    Open,
    /// `r >= 0`, and no friction.
    Frictionless,
    /// `v_t = 0` by a force `|s| <= mu r`.
    Stick,
    /// `s = -mu r` forward and `+mu r` backward.
    Slip(Direction),
}

impl Mode {
    pub(in crate::ocp) fn is_open(self) -> bool {
        self == Self::Open
    }

    /// In a word or two.
    pub(in crate::ocp) fn state(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Frictionless => "closed",
            Self::Stick => "sticking",
            Self::Slip(Direction::Forward) => "slipping forward",
            Self::Slip(Direction::Backward) => "slipping backward",
        }
    }

    /// The mode of a closed contact without friction, or of one that slides at `velocity`.
    pub(in crate::ocp) fn closed(frictional: bool, velocity: f64, zero: f64) -> Self {
        if !frictional {
            Self::Frictionless
        } else if velocity.abs() <= zero {
            Self::Stick
        } else {
            Self::Slip(Direction::of(velocity))
        }
    }
}

/// Whether friction acts on a contact.
pub(in crate::ocp) fn is_frictional(model: &dyn Model, contact: usize) -> bool {
    let declared = model.declaration().contacts[contact].friction;
    declared.is_some() && model.friction(contact) > 0.0
}

/// Sliding velocity of a contact with friction at a time and `x`, which starts with `(q, v)`.
pub(in crate::ocp) fn sliding_velocity(
    model: &dyn Model,
    contact: usize,
    x: &[f64],
    time: f64,
) -> f64 {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut point = vec![0.0; tangent_point::length(n)];
    let mut input = x[..2 * n].to_vec();
    let controls = vec![0.0; declaration.controls.len()];
    input.extend(drive(model, &controls, time));
    model.tangent(contact, &input, &mut point);
    point[tangent_point::SLIDING_VELOCITY]
}

/// Sliding velocities of a state `(q, v)` below this are zero.
pub(in crate::ocp) fn zero_velocity(v: &[f64]) -> f64 {
    AT_REST * v.iter().fold(1.0, |largest: f64, v| largest.max(v.abs()))
}
