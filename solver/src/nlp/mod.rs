//! Nonlinear programming: minimize `f(x)` subject to `c_l <= c(x) <= c_u`, `x_l <= x <= x_u`.
//!
//! Knows nothing of time or contacts. Of complementarity it knows products only: a run may carry constraints
//! `x_i x_j <= sigma` whose slacks are eliminated and whose `sigma` moves with `mu` along a path; which pairs these are, how
//! `sigma` falls, and what their solution means is the caller's business.
//!
//! # Method
//! Constraints get slacks `w` where `c_l < c_u`, so that with `v = (x, w)` the problem reads
//! `min f(v)`, `c(v) = 0`, `l <= v <= u`. For a sequence of barrier parameters `mu -> 0` the barrier problem
//!
//! ```text
//!     min  phi(v) = f(v) - mu sum_i [ log(v_i - l_i) + log(u_i - v_i) ]   s.t.  c(v) = 0
//! ```
//!
//! is solved approximately by Newton's method for its primal-dual conditions
//!
//! ```text
//!     grad f + J' y - z_l + z_u = 0,   c(v) = 0,   (v - l) z_l = mu,   (u - v) z_u = mu,
//! ```
//!
//! until `max(|dual|/s_d, |c|, |complementarity|/s_c) <= 10 mu`; then `mu` falls. The Newton matrix is shifted
//! until its inertia promises descent. A filter of pairs (violation, `phi`) accepts steps, with second-order
//! corrections; where no step is acceptable a restoration phase minimizes the violation. `program` holds the barrier
//! problem, `kkt` the Newton system, `method` the iteration, one idea a file. The constants are
//! those of Waechter and Biegler (Mathematical Programming 106, 2006) where nothing else is said. What differs: slacks of inequalities and elastic slacks of the restoration phase are
//! eliminated, so that both phases share one sparsity and one symbolic factorization; slacks of inequalities are
//! reset to the constraint value at trial points while their barrier stays comparable, which halves the
//! iterations on some problems; bounds are not relaxed; objectives that are steep at the start are scaled again where
//! they are not at the end; a solution whose multipliers are huge is called
//! [`Status::Degenerate`], not solved. Runs that would end without a solution go on by other means ([`Settings::persistent`]).

mod cone;
mod derivative_check;
mod error;
mod info;
mod kkt;
mod least_squares;
mod method;
mod objective_unit;
mod pattern;
mod problem;
mod products;
mod program;
mod rescaled;
mod result;
mod run;
mod second_round;
mod settings;
mod solution;
mod solve;
mod status;
mod variant;
mod warm_start;

pub use crate::InputError;
pub use crate::until::Interrupt;
pub use derivative_check::{DerivativeEntry, check_derivatives};
pub(crate) use error::Fault;
pub use info::{IterationInfo, Observer};
pub use pattern::Pattern;
pub use problem::NlpProblem;
pub use settings::Settings;
pub use solution::{Counts, Residuals, Solution, Violation};
pub use solve::{solve, solve_from};
pub use status::Status;
pub use warm_start::WarmStart;

pub(crate) use cone::{Astray, Cone, OFF_CONE};
pub(crate) use least_squares::violation;
pub(crate) use method::barrier::{BarrierPath, Level, Monotone, PathStep, next_barrier_parameter};
pub(crate) use objective_unit::{Slopes, objective_unit};
pub(crate) use products::Products;
pub(crate) use run::{end_of_path, run};
pub(crate) use variant::Variant;
