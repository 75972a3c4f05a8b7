//! Sparse programs put together from functions of the model: what collocation and the time-freezing system are both written in.

mod haste;
pub(crate) mod joint_rows;
pub(crate) mod kernel;
pub(crate) mod laws;
pub(crate) mod parts;
pub(crate) mod powers;
pub(crate) mod sparse_program;
mod terms;
