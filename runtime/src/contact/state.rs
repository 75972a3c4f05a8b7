//! What a contact does: the one type for it, whichever method asks.

use super::contact_mode::{ContactMode, Direction};

/// State of a contact in a contact mode.
///
/// Where several contacts hold the same sliding velocity only one of them sticks; the forces of the others follow from their
/// states, since the laws do not determine how the contacts share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ContactState {
    /// Carries no force.
    Open,
    /// Carries a normal force, and has no friction.
    Frictionless,
    /// Carries a normal force and the tangential force that keeps its sliding velocity zero.
    Stick,
    /// Sticks in space, with two sliding velocities that vanish; which way such a contact slides is said by its [frame](crate::model::Frame).
    StickInSpace,
    /// Slides, or is about to, and carries the tangential force `s = -mu r` or `+mu r` against it.
    Slip(Direction),
    /// Other contacts keep its sliding velocity zero; it carries the tangential force of sliding in a direction, or none:
    /// how they share the load is not determined, and does not matter for the motion. With none the others may take it
    /// either way, with that of sliding they are helped up to the sum of what all of them can carry.
    Held(Option<Direction>),
}

impl ContactState {
    /// Slip in the direction of the sign of `value`.
    pub(crate) fn slip(value: f64) -> Self {
        Self::Slip(Direction::of(value))
    }

    /// Rest with full friction against sliding in the direction of the sign of `value`.
    pub(crate) fn at_edge(value: f64) -> Self {
        Self::Held(Some(Direction::of(value)))
    }

    /// That of a contact which sticks.
    pub(crate) fn sticking(in_space: bool) -> Self {
        if in_space {
            Self::StickInSpace
        } else {
            Self::Stick
        }
    }

    /// Whether the contact carries no force.
    pub(crate) fn is_open(self) -> bool {
        self == Self::Open
    }

    /// Whether a force of its own keeps its sliding velocity zero.
    pub(crate) fn sticks(self) -> bool {
        self.stuck() > 0
    }

    /// Number of sliding velocities that its own force holds.
    pub(crate) fn stuck(self) -> usize {
        match self {
            Self::Stick => 1,
            Self::StickInSpace => 2,
            _ => 0,
        }
    }

    /// Whether the sliding velocity is zero throughout.
    pub(crate) fn is_stuck(self) -> bool {
        self.sticks() || matches!(self, Self::Held(_))
    }

    /// Whether it slides.
    pub(crate) fn slips(self) -> bool {
        matches!(self, Self::Slip(_))
    }

    /// Whether it carries a tangential force.
    pub(crate) fn rubs(self) -> bool {
        !matches!(self, Self::Open | Self::Frictionless | Self::Held(None))
    }

    /// Sign of the sliding velocity: 1, -1, or 0 where there is none.
    pub(crate) fn sense(self) -> f64 {
        match self {
            Self::Slip(direction) => direction.sign(),
            _ => 0.0,
        }
    }

    /// `s / r` of a contact whose tangential force follows from the normal one, by the coefficients of rest and of sliding; 0 for
    /// the others.
    pub(crate) fn force_ratio(self, (rest, sliding): (f64, f64)) -> f64 {
        match self {
            Self::Slip(direction) => -direction.sign() * sliding,
            Self::Held(Some(direction)) => -direction.sign() * rest,
            _ => 0.0,
        }
    }
}

impl From<ContactState> for ContactMode {
    fn from(state: ContactState) -> Self {
        match state {
            ContactState::Open => Self::Open,
            ContactState::Frictionless => Self::Frictionless,
            ContactState::Stick | ContactState::StickInSpace | ContactState::Held(_) => Self::Stick,
            ContactState::Slip(direction) => Self::Slip(direction),
        }
    }
}

/// A contact that carries a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ActiveContact {
    pub(crate) contact: usize,
    pub(crate) state: ContactState,
}

/// Number of force unknowns: one a contact, and one more for each sliding velocity that sticks.
pub(crate) fn force_count(active: &[ActiveContact]) -> usize {
    active.len() + active.iter().map(|held| held.state.stuck()).sum::<usize>()
}

/// The state of `contact` in `active`, if it carries a force.
pub(crate) fn find(active: &[ActiveContact], contact: usize) -> Option<ContactState> {
    let held = active.iter().find(|held| held.contact == contact);
    held.map(|held| held.state)
}
