//! What a contact that carries a force does along its tangent.

/// State of a sustained contact along its tangent.
///
/// Where several contacts hold the same sliding velocity only one of them sticks; the forces of the others
/// follow from their states, since the laws do not determine how the contacts share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tangential {
    /// No tangential force: the contact has no friction, or needs none beside other contacts.
    Idle,
    /// The sliding velocity is held at zero by a force inside the friction cone.
    Sticking,
    /// Both sliding velocities of a contact in space are.
    StickingInSpace,
    /// At rest with full friction `s = -mu r`, beside other contacts that stick.
    BoundForward,
    /// At rest with full friction `s = mu r`, beside other contacts that stick.
    BoundBackward,
    /// Slides with `v_t > 0`, or is about to: `s = -mu r`.
    Forward,
    /// Slides with `v_t < 0`, or is about to: `s = mu r`.
    Backward,
}

impl Tangential {
    /// Slip in the direction of the sign of `value`.
    pub(crate) fn slip(value: f64) -> Self {
        if value >= 0.0 {
            Self::Forward
        } else {
            Self::Backward
        }
    }

    /// Rest with full friction against sliding in the direction of the sign of `value`.
    pub(crate) fn bound(value: f64) -> Self {
        if value >= 0.0 {
            Self::BoundForward
        } else {
            Self::BoundBackward
        }
    }

    /// Sign of the sliding velocity: 1, -1, or 0 where there is none.
    pub(crate) fn sense(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            _ => 0.0,
        }
    }

    /// Ratio `s / (mu r)`, 0 where it is not fixed.
    pub(crate) fn share(self) -> f64 {
        match self {
            Self::Forward | Self::BoundForward => -1.0,
            Self::Backward | Self::BoundBackward => 1.0,
            Self::Idle | Self::Sticking | Self::StickingInSpace => 0.0,
        }
    }
}

/// A contact that carries a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ActiveContact {
    pub(crate) contact: usize,
    pub(crate) tangential: Tangential,
}

impl ActiveContact {
    /// Whether the contact sticks.
    pub(crate) fn sticks(self) -> bool {
        self.stuck() > 0
    }

    /// Number of sliding velocities that it holds.
    pub(crate) fn stuck(self) -> usize {
        match self.tangential {
            Tangential::Sticking => 1,
            Tangential::StickingInSpace => 2,
            _ => 0,
        }
    }
}

/// Number of force unknowns: one a contact, and one more for each sliding velocity that sticks.
pub(crate) fn force_count(active: &[ActiveContact]) -> usize {
    active.len() + active.iter().map(|contact| contact.stuck()).sum::<usize>()
}

/// The state of `contact` in `active`, if it carries a force.
pub(crate) fn find(active: &[ActiveContact], contact: usize) -> Option<Tangential> {
    active
        .iter()
        .find(|held| held.contact == contact)
        .map(|held| held.tangential)
}
