//! Linear algebra kernels: small dense systems and complementarity problems, and sparse symmetric
//! indefinite systems.
//!
//! The sparse part works on one fixed sparsity: the analysis runs once, factorizations and solves
//! reuse its memory. Nothing here knows of optimization; the names `primal` and `dual` only say which
//! rows of a saddle point matrix receive which shift.
//!
//! # Which factorization
//! [`MultifrontalLdl`] pivots: its inertia is exact and it needs no shifts. [`SimplicialLdl`] does neither, which is
//! cheaper an operation; but static shifts stand for the pivots, refinement has to remove them, and columns are
//! eliminated one by one. Measured on the programs of `benches/solver` (BENCHMARKS.md; same machine, CPU time):
//!
//! | programs | without pivoting / with pivoting |
//! |---|---|
//! | chains of control problems, same path (van_der_pol, brachistochrone, cart_pole) | 0.8 to 0.95 of the time |
//! | the same where the shifts change the path (goddard_rocket, pendulum_swing_up) | 1.4 to 1.8 times the iterations |
//! | grids (obstacle_surface, elliptic_control) | 1.0 to 1.7 times the time |
//! | much fill (random_quadratic) | 8 times the time |
//!
//! Neither loses a problem of these, but only the pivoting one has no bad case: it is the default of
//! the interior point method, and takes over where refinement of the other fails. It also serves block
//! tridiagonal systems, whose fronts are the dense blocks along the chain, so there is no third back end for them: on
//! ill-conditioned chains without any shift one step of refinement leaves a backward error of 2e-16, where the static
//! shifts still leave 1e-8 after three (`tests/solvers/linalg_chain.rs`).

pub mod dense;
mod factorization;
pub mod lcp;
mod multifrontal;
pub(crate) mod norms;
mod refined;
mod simplicial;
mod symmetric;

pub use factorization::{FactorizationError, Inertia, KktFactorization};
pub use multifrontal::MultifrontalLdl;
pub use refined::{RefinedSolver, SolveQuality};
pub use simplicial::SimplicialLdl;
pub use symmetric::SymmetricPattern;
