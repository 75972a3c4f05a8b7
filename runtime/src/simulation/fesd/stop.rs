//! Why a segment could not be completed.

use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::ElementError;

/// Why a segment could not be completed.
pub(super) enum Stop {
    /// An element has no solution; shorter elements may have.
    Element(ElementError),
    /// The contact mode could not be determined.
    Mode(ModeError),
    /// A switch could not be located; shorter elements may help.
    Location,
    /// The gap of this contact changes its sign at this time \[s\] without passing zero: through infinity or by a jump.
    Leap(usize, f64),
    /// A gap varies too fast for the samples of an element; shorter elements help.
    Unresolved,
}

impl From<ElementError> for Stop {
    fn from(error: ElementError) -> Self {
        Self::Element(error)
    }
}

impl From<ModeError> for Stop {
    fn from(error: ModeError) -> Self {
        Self::Mode(error)
    }
}
