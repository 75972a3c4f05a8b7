//! Nonlinear programming: minimize `f(x)` subject to `c_l <= c(x) <= c_u`, `x_l <= x <= x_u`.
//!
//! Knows nothing of time, contacts or complementarity.

mod problem;

pub use problem::NlpProblem;
