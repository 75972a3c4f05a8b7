//! What a search starts from.

use super::sequence::Sequence;
use super::trajectory::Trajectory;

/// A motion that may be near an optimum, and its contact sequence.
#[derive(Clone)]
pub(in crate::ocp) struct Candidate {
    pub(in crate::ocp) objective: f64,
    pub(in crate::ocp) trajectory: Trajectory,
    pub(in crate::ocp) sequence: Sequence,
}
