//! What ends an element, and how a root is found on its dense output.

use crate::fesd::finite_element::MotionSize;
use crate::simulation::near::Near;

/// Relative size of a negative normal contact acceleration that is rounding error.
pub(super) const FORCE_TOLERANCE: f64 = 1e-12;

/// Which sign condition ends the element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SwitchKind {
    /// The gap of an open contact closes.
    Entry,
    /// A contact that was released closes again: `max(g, v_n)` falls below zero.
    Reentry,
    /// The force of an active contact vanishes.
    Exit,
    /// The friction of a sticking contact reaches its bound.
    Slipping,
    /// The sliding velocity of an active contact vanishes.
    Stopping,
}

/// A violated sign condition and where the dense output puts its root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Switch {
    pub(super) kind: SwitchKind,
    pub(super) contact: usize,
    /// Place in the element, `0..=1`.
    pub(super) theta: f64,
    /// Place at which the condition is known to be violated.
    pub(super) violated: f64,
    /// Slope of the switching function with respect to time at the root.
    pub(super) slope: f64,
}

/// What the detector knows of the element's start.
pub(super) struct ElementStart<'a> {
    /// Input vector at the start.
    pub(super) x: &'a [f64],
    /// Which contacts may close.
    pub(super) near: &'a Near,
    /// Gaps of all contacts.
    pub(super) gaps: &'a [f64],
    /// Normal velocities of all contacts.
    pub(super) velocities: &'a [f64],
    /// Sliding velocities of all contacts.
    pub(super) sliding: &'a [f64],
    /// Forces of the active contacts: `r` of each, then `s` of those that stick.
    pub(super) forces: &'a [f64],
    /// Acceleration with contact forces.
    pub(super) acceleration: &'a [f64],
    /// Time [s].
    pub(super) time: f64,
    /// The motion by which the gaps of active contacts are measured, where errors are controlled.
    pub(super) motion: Option<&'a MotionSize>,
}

/// Halves an interval 60 times around the root of a `value` that is positive on its left and not on its right.
pub(super) fn bisect(
    value: &mut dyn FnMut(f64) -> f64,
    mut left: f64,
    mut right: f64,
) -> (f64, f64) {
    for _ in 0..60 {
        let middle = 0.5 * (left + right);
        if value(middle) > 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    (left, right)
}

pub(super) fn keep_first(first: &mut Option<Switch>, candidate: Switch) {
    if first.is_none_or(|switch| candidate.theta < switch.theta) {
        *first = Some(candidate);
    }
}
