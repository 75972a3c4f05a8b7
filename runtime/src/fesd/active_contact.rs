//! What a contact that carries a force does along its tangent.

/// State of a sustained contact along its tangent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tangential {
    /// The contact has no friction.
    Frictionless,
    /// The sliding velocity is held at zero by a force inside the friction cone.
    Sticking,
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

    /// Sign of the sliding velocity: 1, -1, or 0 where there is none.
    pub(crate) fn sense(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Frictionless | Self::Sticking => 0.0,
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
        self.tangential == Tangential::Sticking
    }
}

/// Number of force unknowns: one a contact, and one more for each that sticks.
pub(crate) fn force_count(active: &[ActiveContact]) -> usize {
    active.len() + active.iter().filter(|contact| contact.sticks()).count()
}

/// The state of `contact` in `active`, if it carries a force.
pub(crate) fn find(active: &[ActiveContact], contact: usize) -> Option<Tangential> {
    active
        .iter()
        .find(|held| held.contact == contact)
        .map(|held| held.tangential)
}
