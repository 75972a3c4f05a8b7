//! Nonlinear programming: minimize `f(x)` subject to `c_l <= c(x) <= c_u`, `x_l <= x <= x_u`.
//!
//! Knows nothing of time, contacts or complementarity.

mod barrier;
mod barrier_problem;
mod derivative_check;
mod driver;
mod error;
mod filter;
mod formulation;
mod inertia_correction;
mod info;
mod iterate;
pub mod iteration_log;
mod kkt_system;
mod line_search;
mod problem;
mod rescue;
mod residuals;
mod restoration;
mod scaling;
mod second_order_correction;
mod settings;
mod solution;
mod solver;
mod status;
mod step;

pub use derivative_check::{DerivativeEntry, DerivativeReport, check_derivatives};
pub use driver::{WarmStart, solve, solve_from};
pub use error::InputError;
pub use info::IterationInfo;
pub use problem::NlpProblem;
pub use settings::{LinearSolver, Settings};
pub use solution::{Counts, Residuals, Solution, Violation};
pub use solver::Observer;
pub use status::Status;

pub(crate) use barrier::{BarrierPath, Level, Monotone, PathStep, next_barrier_parameter};
pub(crate) use driver::{Products, run, run_from_point};
