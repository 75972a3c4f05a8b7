//! The search over contact sequences: which are attempted, in which order, and what is proved about the best.
//!
//! Uses [`global`](super::global) for motions to start from and [`collocation`](super::collocation) for the programs of
//! sequences.

mod at_nodes;
pub(in crate::ocp) mod attempt;
pub(in crate::ocp) mod candidates;
mod edge_neighbours;
mod free_lengths;
pub(in crate::ocp) mod friction_neighbours;
pub(in crate::ocp) mod nearest;
pub(in crate::ocp) mod neighbours;
pub(in crate::ocp) mod pressure;
pub(in crate::ocp) mod reach;
pub(in crate::ocp) mod repair;
pub(in crate::ocp) mod replay;
mod resting;
pub(in crate::ocp) mod ride;
pub(in crate::ocp) mod sampled;
mod settling;
mod simultaneous;
pub(in crate::ocp) mod stationary;
pub(in crate::ocp) mod stepping;
mod together;
