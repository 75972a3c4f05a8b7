//! The velocities that contacts hold, one a force.

use super::active_contact::ActiveContact;

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
    /// The sign with which the velocity counts.
    pub(super) fn sense(self) -> f64 {
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

/// Tangents of the contacts that stick.
pub(super) fn tangents(active: &[ActiveContact]) -> impl Iterator<Item = Line> {
    let sticking = active.iter().filter(|held| held.sticks());
    sticking.flat_map(|held| {
        let contact = held.contact;
        let along = Line::Tangent {
            contact,
            sense: 1.0,
        };
        let across = (held.stuck() > 1).then_some(Line::Across { contact });
        std::iter::once(along).chain(across)
    })
}

/// The lines that the `active` contacts hold, for forces along the contact directions themselves.
pub(super) fn unbiased_lines(active: &[ActiveContact]) -> Vec<Line> {
    let normals = active.iter().map(|held| Line::Normal {
        contact: held.contact,
        slope: 0.0,
    });
    normals.chain(tangents(active)).collect()
}
