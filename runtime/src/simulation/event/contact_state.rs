//! What a single contact does between two events.

pub(in crate::simulation) use crate::simulation::Direction;
use crate::simulation::{ContactMode, EventKind};

/// State of a contact in a contact mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simulation) enum ContactState {
    /// Carries no force.
    Open,
    /// Carries a normal force, and has no friction.
    Frictionless,
    /// Carries a normal force and the tangential force that keeps its sliding velocity zero.
    Stick,
    /// Slides, and carries the tangential force `s = -mu r` or `+mu r` against it.
    Slip(Direction),
    /// Other contacts keep its sliding velocity zero; it carries the tangential force of sliding in a direction, or none:
    /// how they share the load is not determined, and does not matter for the motion. With none the others may take it
    /// either way, with that of sliding they are helped up to the sum of what all of them can carry.
    Held(Option<Direction>),
}

impl From<ContactState> for ContactMode {
    fn from(state: ContactState) -> Self {
        match state {
            ContactState::Open => Self::Open,
            ContactState::Frictionless => Self::Frictionless,
            ContactState::Stick | ContactState::Held(_) => Self::Stick,
            ContactState::Slip(direction) => Self::Slip(direction),
        }
    }
}

impl ContactState {
    pub(in crate::simulation) fn is_open(self) -> bool {
        self == Self::Open
    }

    /// Whether the sliding velocity is zero throughout.
    pub(in crate::simulation) fn is_stuck(self) -> bool {
        matches!(self, Self::Stick | Self::Held(_))
    }

    /// The event that the change to another state is, without an impact; `None` where nothing changes.
    pub(in crate::simulation) fn event(self, now: Self) -> Option<EventKind> {
        if self == now || self.is_stuck() && now.is_stuck() {
            return None;
        }
        Some(match (self, now) {
            (Self::Open, _) => EventKind::Contact,
            (_, Self::Open) => EventKind::LiftOff,
            (_, now) if now.is_stuck() => EventKind::Stick,
            _ => EventKind::Slip,
        })
    }

    /// `s / r` of a contact whose tangential force follows from the normal one, by the coefficients of rest and of sliding; 0 for
    /// the others.
    pub(in crate::simulation) fn force_ratio(self, (rest, sliding): (f64, f64)) -> f64 {
        match self {
            Self::Slip(direction) => -direction.sign() * sliding,
            Self::Held(Some(direction)) => -direction.sign() * rest,
            Self::Open | Self::Frictionless | Self::Stick | Self::Held(None) => 0.0,
        }
    }
}
