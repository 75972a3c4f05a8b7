//! The search over contact sequences: which are attempted, in which order, and what is proved about the best.
//!
//! Uses [`global`](super::global) for motions to start from and [`collocation`](super::collocation) for the programs of
//! sequences.

mod at_nodes;
pub(in crate::ocp) mod attempt;
mod edge_neighbours;
pub(in crate::ocp) mod friction_neighbours;
pub(in crate::ocp) mod nearest;
pub(in crate::ocp) mod neighbours;
mod policy;
pub(in crate::ocp) mod pressure;
pub(in crate::ocp) mod readings;
pub(in crate::ocp) mod repair;
pub(in crate::ocp) mod replay;
mod resting;
pub(in crate::ocp) mod sampled;
pub(in crate::ocp) mod stationary;
pub(in crate::ocp) mod throw;
mod together;
