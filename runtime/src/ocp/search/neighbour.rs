//! A neighbour of a plan, and what makes neighbours.

use super::pressing::Pressing;
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::tuning::neighbours::APART;

/// A sequence that differs from that of a plan by one edit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Neighbour {
    pub(super) sequence: Sequence,
    /// Whether the plan is a limit of motions with this sequence, so that a claim about it needs an answer of it. None is needed of a
    /// sequence without a contact, a flight or a slip that lasts.
    pub(super) adjoins: bool,
}

impl Neighbour {
    pub(super) fn adjoining(sequence: Sequence) -> Self {
        let adjoins = true;
        Self { sequence, adjoins }
    }

    /// A sequence without what lasts that many intervals.
    pub(super) fn without(lasts: f64, sequence: Sequence) -> Self {
        let adjoins = lasts < APART;
        Self { sequence, adjoins }
    }
}

/// What an edit makes of a plan.
pub(super) type Edit = fn(&Pressing) -> Vec<Neighbour>;
