//! Mathematical programs with complementarity constraints, in vertical form.

mod problem;

pub use problem::Mpcc;
