//! What the programs of optimal control have in common, the units that they are measured in, and the one door to the solvers.
//!
//! Uses [`motion`](super::motion) for guesses. What is in a program, and why, is the business of the layers above.

pub(in crate::ocp) mod frame;
mod given;
pub(in crate::ocp) mod ledger;
pub(in crate::ocp) mod runner;
pub(in crate::ocp) mod start_joints;
pub(in crate::ocp) mod units;
