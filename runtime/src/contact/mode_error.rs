//! Why a contact mode could not be determined.

use crate::linalg::lcp;

/// Why a contact mode could not be determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ModeError {
    /// The complementarity problem of impulses or accelerations has no solution: jamming.
    Jammed,
    /// It has several, with different motions, as friction may push this contact into the ground: Painleve's paradox.
    Several(usize),
    /// The normals of the active contacts are dependent.
    Dependent,
    /// A model value is infinite or not a number.
    NotFinite,
    /// The bound of this dry friction is negative.
    NegativeBound(usize),
    /// Both sides of this switch push away from the zero of its function, on which the motion is.
    NotUnique(usize),
    /// The motion stays where the function of this switch and its rate vanish, while something else moves.
    SecondOrder(usize),
    /// This condition sets at one instant what another one sets to a different value.
    SetTwice(usize),
}

impl ModeError {
    /// The contact that is to blame, where it is known.
    pub(crate) fn contact(self) -> Option<usize> {
        match self {
            Self::Several(contact)
            | Self::NegativeBound(contact)
            | Self::NotUnique(contact)
            | Self::SecondOrder(contact)
            | Self::SetTwice(contact) => Some(contact),
            Self::Jammed | Self::Dependent | Self::NotFinite => None,
        }
    }
}

impl From<lcp::LcpError> for ModeError {
    fn from(error: lcp::LcpError) -> Self {
        match error {
            lcp::LcpError::Ray => Self::Jammed,
            lcp::LcpError::NotFinite => Self::NotFinite,
        }
    }
}
