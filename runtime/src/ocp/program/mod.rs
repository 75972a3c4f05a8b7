//! Sparse programs put together from functions of the model, the units that they are measured in, and the one door to
//! the solvers.
//!
//! Uses [`motion`](super::motion) for guesses. What is in a program, and why, is the business of the layers above.

pub(in crate::ocp) mod frame;
mod given;
mod haste;
pub(in crate::ocp) mod joint_rows;
pub(in crate::ocp) mod kernel;
mod laws;
pub(in crate::ocp) mod purposes;
pub(in crate::ocp) mod runner;
pub(in crate::ocp) mod sparse_program;
pub(in crate::ocp) mod units;
