//! How large the gap and the velocities of a contact are, which says what is zero of them.
//!
//! A gap `g(q)` sums up terms of about the sizes `|dg/dq_k q_k|`, and rounding leaves an error relative to
//! them, whatever the other coordinates are, the unit of the gap, and a factor in it. Velocities likewise.
//! The largest coordinates so far count, since all terms may vanish together.

use crate::yardstick;

/// What cannot be told from zero, relative to its size: the rounding errors of a run.
const COLLECTED: f64 = 1024.0 * f64::EPSILON;
/// Sizes of gap and velocities of a contact.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactSize {
    /// Of the gap [unit of the gap].
    pub(super) gap: f64,
    /// Of the normal velocity [unit of the gap / s].
    pub(super) velocity: f64,
    /// Of the sliding velocity.
    pub(super) sliding: f64,
    /// What accelerations have added to the normal velocity, and taken from it again.
    pub(super) gained: f64,
    /// What accelerations have added to the sliding velocity, and taken from it again.
    pub(super) gained_sliding: f64,
    /// What accelerations change of the normal velocity in the shortest time that a run tells apart.
    pub(super) unresolved: f64,
}

impl ContactSize {
    /// Takes the sizes of another place, but for those without a value.
    pub(super) fn take(&mut self, other: Self) {
        let pairs = [
            (&mut self.gap, other.gap),
            (&mut self.velocity, other.velocity),
            (&mut self.sliding, other.sliding),
        ];
        for (size, other) in pairs.into_iter().filter(|(_, other)| other.is_finite()) {
            *size = other;
        }
    }

    /// The sizes at `time`, whose own rounding error moves the gap as well, under accelerations of the given
    /// sizes, for a run that tells times apart down to the `shortest`.
    pub(super) fn at(self, (time, shortest): (f64, f64), normal: f64, tangential: f64) -> Self {
        Self {
            gap: self.gap + self.velocity * time,
            gained: normal * time,
            unresolved: normal * shortest,
            gained_sliding: tangential * time,
            ..self
        }
    }

    /// The sizes where rounding of the coordinates leaves this error of the gap, which may have no terms of its own left: that of a
    /// coordinate which is itself the gap.
    pub(crate) fn with_error(self, error: f64) -> Self {
        Self {
            gap: self.gap + error / f64::EPSILON,
            ..self
        }
    }

    /// The sizes where the gap is a difference from another one.
    pub(crate) fn as_difference_from(self, other: Self) -> Self {
        Self {
            gap: self.gap.max(other.gap),
            ..self
        }
    }

    /// Rounding error of the gap.
    pub(crate) fn gap_rounding(self) -> f64 {
        yardstick::DIGITS * self.gap
    }

    /// Gap up to which the contact touches.
    pub(crate) fn touching_gap(self) -> f64 {
        COLLECTED * self.gap
    }

    /// Gap that rounding leaves in a run of this `length` \[s\]: that of its terms, and of accelerations that balance.
    pub(crate) fn collected_gap(self, length: f64) -> f64 {
        COLLECTED * (self.gap + self.gained * length)
    }

    /// Size of the normal velocity.
    pub(crate) fn speed(self) -> f64 {
        self.velocity
    }

    /// Size of the sliding velocity.
    pub(crate) fn sliding(self) -> f64 {
        self.sliding
    }

    /// Rounding error of the normal velocity.
    pub(crate) fn velocity_rounding(self) -> f64 {
        yardstick::DIGITS * (self.velocity + self.gained)
    }

    /// Normal velocity up to which the contact touches; a flight that begins with less is over in less time than
    /// a run tells apart.
    pub(crate) fn touching_velocity(self) -> f64 {
        let zero = (yardstick::NOTHING * self.velocity).max(COLLECTED * self.gained);
        zero.max(self.unresolved)
    }

    /// Size of the sliding velocity, or of the function of a switch.
    pub(crate) fn sliding_speed(self) -> f64 {
        self.sliding
    }

    /// Rounding error of the sliding velocity.
    pub(crate) fn sliding_rounding(self) -> f64 {
        yardstick::DIGITS * (self.sliding + self.gained_sliding)
    }

    /// Sliding velocity beyond rest that another switch explains; larger ones are switches of their own.
    pub(crate) fn crossed_rest(self) -> f64 {
        (yardstick::NOTHING * self.sliding).max(COLLECTED * self.gained_sliding)
    }

    /// Sliding velocity that counts as rest.
    pub(crate) fn at_rest(self) -> f64 {
        (yardstick::ROUNDING * self.sliding).max(COLLECTED * self.gained_sliding)
    }
}
