//! Mathematical programs with complementarity constraints, in vertical form.
//!
//! ```text
//!     min f(x)  s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u,  0 <= x_i  _|_  x_j >= 0  for all pairs
//! ```
//!
//! One warm interior point run relaxes every pair to `x_i x_j <= sigma` (Scholtes) and drives `sigma`
//! to zero together with the barrier parameter; a crossover fixes one side of each pair and solves the
//! remaining smooth program exactly; a certificate then says what kind of stationary point it is.

mod branch;
mod certificate;
mod crossover;
mod driver;
mod linear_program;
mod problem;
mod relaxation;
mod settings;
mod solution;

pub use certificate::{Certificate, StationarityType};
pub use driver::{solve, solve_observed, solve_parallel};
pub use problem::Mpcc;
pub use settings::{RelaxationRule, Settings};
pub use solution::{Residuals, Solution, Status};
