//! What a balance of forces says of the state of each contact that touches.

use super::contact_mode::Direction;
use super::state::ContactState;
use super::touching::Balance;
use super::view::View;
use crate::model::pair_size;

/// What accelerations say of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Decision {
    /// Its state.
    Is(ContactState),
    /// Friction on the edge of its cone, without sliding acceleration: it sticks, or is about to slip as said.
    Edge(ContactState),
    /// Neither force nor normal acceleration: it is open, or closed.
    Touches,
}

/// What is known of a contact besides: a switching function of the mode before that vanishes now, whatever rounding error has left of
/// it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Vanished {
    /// Its normal force does.
    pub(crate) force: bool,
    /// Friction has come to the edge of its cone, against sliding in this direction.
    pub(crate) reserve: Option<Direction>,
}

impl Balance {
    /// What accelerations say of the `k`-th contact; below `zeros`, a normal and a tangential acceleration, they are none.
    pub(crate) fn decide(
        &self,
        view: &View<'_>,
        k: usize,
        zeros: (f64, f64),
        vanished: Vanished,
    ) -> Decision {
        if self.forces[k] > zeros.0 && !vanished.force {
            self.pressed(view, k, zeros.1, vanished.reserve)
        } else if self.motions[k] > zeros.0 && !vanished.force {
            Decision::Is(ContactState::Open)
        } else {
            Decision::Touches
        }
    }

    /// What the `k`-th contact does along its tangent, which carries a force.
    pub(crate) fn pressed(
        &self,
        view: &View<'_>,
        k: usize,
        zero: f64,
        reserve: Option<Direction>,
    ) -> Decision {
        let contact = self.touching.contacts[k];
        let Some(slip) = self.slip(k) else {
            return Decision::Is(sliding(view, contact));
        };
        // Where sliding has a lower coefficient of its own, a force that is no longer held jumps.
        let breaks = view.kinetic(contact) < view.friction(contact);
        let slips = pair_size(slip) > zero;
        if self.margin(view, k) > zero && reserve.is_none() && !(breaks && slips) {
            return Decision::Is(ContactState::sticking(view.is_in_space(contact)));
        }
        let to = match reserve {
            _ if view.is_in_space(contact) => Direction::Forward,
            Some(direction) if !slips => direction,
            _ => Direction::of(self.heading(k, zero).0),
        };
        let state = ContactState::Slip(to);
        if slips || breaks {
            Decision::Is(state)
        } else {
            Decision::Edge(state)
        }
    }

    /// What the friction of the `k`-th contact has left before it slips, `mu r - |s|`.
    pub(crate) fn margin(&self, view: &View<'_>, k: usize) -> f64 {
        view.friction(self.touching.contacts[k]) * self.forces[k] - pair_size(self.friction(k))
    }

    /// Where the `k`-th contact slides to that begins to: along its acceleration, or against its friction where that is none.
    pub(crate) fn heading(&self, k: usize, zero: f64) -> (f64, f64) {
        let friction = self.friction(k);
        let slip = self.slip(k).filter(|&slip| pair_size(slip) > zero);
        slip.unwrap_or((-friction.0, -friction.1))
    }
}

/// State of a contact that slides or has no friction.
pub(crate) fn sliding(view: &View<'_>, contact: usize) -> ContactState {
    if view.has_friction(contact) {
        ContactState::slip(view.side(contact))
    } else {
        ContactState::Frictionless
    }
}
