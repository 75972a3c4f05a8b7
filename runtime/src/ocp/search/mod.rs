//! The search over contact sequences: which are attempted, in which order, and what is proved about the best.
//!
//! Uses [`global`](super::global) for motions to start from and [`collocation`](super::collocation) for the programs of
//! sequences.

mod adjoining;
pub(in crate::ocp) mod attempt;
mod basins;
pub(in crate::ocp) mod nearest;
mod neighbour;
mod passing;
mod policy;
mod pressing;
pub(in crate::ocp) mod proof;
pub(in crate::ocp) mod readings;
mod released;
pub(in crate::ocp) mod replay;
pub(in crate::ocp) mod sampled;
mod sliding;
pub(in crate::ocp) mod throw;
