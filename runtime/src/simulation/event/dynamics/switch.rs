//! Switching functions: what they can be.

use crate::contact::Direction;

/// A function of time whose zero ends the contact mode; all are positive within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simulation) enum Switch {
    /// The gap of an open contact.
    Gap(usize),
    /// The normal contact acceleration `r` of an active contact.
    NormalForce(usize),
    /// What a sticking contact has left before it slips in a direction, `mu r + s` or `mu r - s`.
    FrictionLimit(usize, Direction),
    /// The sliding velocity, in its direction, of a contact that slips.
    SlidingVelocity(usize, Direction),
    /// How far the sliding velocity of a contact that others hold is from counting as sliding.
    HeldVelocity(usize),
    /// None: a constant.
    Constant(usize),
}

impl Switch {
    pub(in crate::simulation) fn contact(self) -> usize {
        match self {
            Self::Gap(i)
            | Self::NormalForce(i)
            | Self::FrictionLimit(i, _)
            | Self::SlidingVelocity(i, _)
            | Self::HeldVelocity(i)
            | Self::Constant(i) => i,
        }
    }

    /// What it is, in words.
    pub(in crate::simulation) fn words(self) -> &'static str {
        match self {
            Self::Gap(_) => "the gap",
            Self::NormalForce(_) => "the normal force",
            Self::FrictionLimit(..) => "the reserve of friction",
            Self::SlidingVelocity(..) | Self::HeldVelocity(_) => "the sliding velocity",
            Self::Constant(_) => "nothing",
        }
    }

    pub(in crate::simulation) fn is_force(self) -> bool {
        matches!(self, Self::NormalForce(_) | Self::FrictionLimit(..))
    }
}
