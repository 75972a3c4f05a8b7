//! What a contact does between two switches.

use super::path::drive;
use crate::model::{Model, tangent_point};
use crate::simulation::Simulation;

/// Sliding velocities below this share of the largest velocity are zero: a simulation projects them to rounding error.
const AT_REST: f64 = 1e-9;
/// Share of `mu r` that a tangential force must reach to be one of sliding: of rounding error in `s / r`.
const EDGE: f64 = 1.0 - 1e-9;

/// Sign of a sliding velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Direction {
    Forward,
    Backward,
}

impl Direction {
    /// Both.
    pub(super) const BOTH: [Self; 2] = [Self::Forward, Self::Backward];

    pub(super) fn of(velocity: f64) -> Self {
        if velocity < 0.0 {
            Self::Backward
        } else {
            Self::Forward
        }
    }

    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    pub(super) fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// What a contact does between two switches, or during an impact. A contact without friction is open or
/// frictionless, one with friction is never frictionless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Mode {
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
    pub(super) fn is_open(self) -> bool {
        self == Self::Open
    }

    /// In a word or two.
    pub(super) fn state(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Frictionless => "closed",
            Self::Stick => "sticking",
            Self::Slip(Direction::Forward) => "slipping forward",
            Self::Slip(Direction::Backward) => "slipping backward",
        }
    }

    /// The mode of a closed contact without friction, or of one that slides at `velocity`.
    pub(super) fn closed(rough: bool, velocity: f64, zero: f64) -> Self {
        if !rough {
            Self::Frictionless
        } else if velocity.abs() <= zero {
            Self::Stick
        } else {
            Self::Slip(Direction::of(velocity))
        }
    }
}

/// Whether friction acts on a contact.
pub(super) fn is_rough(model: &dyn Model, contact: usize) -> bool {
    let declared = model.declaration().contacts[contact].friction;
    declared.is_some() && model.friction(contact) > 0.0
}

/// Sliding velocity of a contact with friction at a time and `x`, which starts with `(q, v)`.
pub(super) fn sliding_velocity(model: &dyn Model, contact: usize, x: &[f64], time: f64) -> f64 {
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
pub(super) fn zero_velocity(v: &[f64]) -> f64 {
    AT_REST * v.iter().fold(1.0, |largest: f64, v| largest.max(v.abs()))
}

/// The mode of a closed contact right after entry `index` of a simulation. At rest a contact with friction may
/// begin to slip, in the direction against which its force acts. `slips` says whether it does; if that is not known,
/// it does if its force lies on the edge of the friction cone and it moves before its next event.
pub(super) fn after(
    model: &dyn Model,
    simulation: &Simulation,
    (contact, index): (usize, usize),
    slips: Option<bool>,
) -> Mode {
    if !is_rough(model, contact) {
        return Mode::Frictionless;
    }
    let trajectory = &simulation.trajectory;
    let velocity = |index: usize| {
        let state = [&trajectory.q[index][..], &trajectory.v[index]].concat();
        sliding_velocity(model, contact, &state, trajectory.time[index])
    };
    let zero = zero_velocity(&trajectory.v[index]);
    let now = velocity(index);
    let resting = Mode::closed(true, now, zero);
    if resting != Mode::Stick {
        return resting;
    }
    let force = trajectory.friction_force[index][contact];
    if let Some(slips) = slips {
        return match slips {
            true => Mode::Slip(Direction::of(-force)),
            false => Mode::Stick,
        };
    }
    let limit = model.friction(contact) * trajectory.contact_force[index][contact];
    let time = trajectory.time[index];
    let mut events = simulation.events.iter();
    let next = events.find(|event| event.contact == contact && event.time > time);
    let until = next.map_or(f64::INFINITY, |next| next.time);
    let mut later = index + 1..trajectory.time.len();
    let moves = later.any(|next| {
        trajectory.time[next] <= until && velocity(next).abs() > zero_velocity(&trajectory.v[next])
    });
    if force.abs() >= EDGE * limit && moves {
        Mode::Slip(Direction::of(-force))
    } else {
        Mode::Stick
    }
}
