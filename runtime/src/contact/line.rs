//! The velocities that contacts hold, one a force.

use super::state::{ActiveContact, ContactState};

/// One velocity that is held, and the direction of the force that holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Line {
    /// The normal velocity, by a force along `d + slope e`.
    Normal { contact: usize, slope: f64 },
    /// The sliding velocity times `sense`, by a force along `sense e`.
    Tangent { contact: usize, sense: f64 },
    /// The second sliding velocity of a contact in space.
    Across { contact: usize },
}

impl Line {
    /// The normal velocity, by a force along the contact direction itself.
    pub(crate) fn normal(contact: usize) -> Self {
        Self::Normal {
            contact,
            slope: 0.0,
        }
    }

    /// The sliding velocity.
    pub(crate) fn tangent(contact: usize) -> Self {
        Self::Tangent {
            contact,
            sense: 1.0,
        }
    }

    /// The sign with which the velocity counts.
    pub(crate) fn sense(self) -> f64 {
        match self {
            Self::Normal { .. } | Self::Across { .. } => 1.0,
            Self::Tangent { sense, .. } => sense,
        }
    }

    pub(crate) fn contact(self) -> usize {
        match self {
            Self::Normal { contact, .. }
            | Self::Tangent { contact, .. }
            | Self::Across { contact } => contact,
        }
    }
}

/// The sliding velocities that a contact holds in a state.
pub(crate) fn stuck(contact: usize, state: ContactState) -> impl Iterator<Item = Line> {
    let lines = [Line::tangent(contact), Line::Across { contact }];
    lines.into_iter().take(state.stuck())
}

/// Tangents of the contacts that stick.
pub(crate) fn tangents(active: &[ActiveContact]) -> impl Iterator<Item = Line> {
    active
        .iter()
        .flat_map(|held| stuck(held.contact, held.state))
}

/// The lines that the `active` contacts hold, for forces along the contact directions themselves.
pub(crate) fn unbiased_lines(active: &[ActiveContact]) -> Vec<Line> {
    let normals = active.iter().map(|held| Line::normal(held.contact));
    normals.chain(tangents(active)).collect()
}
