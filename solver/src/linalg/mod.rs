//! Sparse symmetric indefinite systems, and norms of long vectors.
//!
//! A system has one fixed sparsity: the analysis runs once, factorizations and solves
//! reuse its memory. Nothing here knows of optimization; the names `primal` and `dual` only say which
//! rows of a saddle point matrix receive which shift.
//!
//! [`MultifrontalLdl`] pivots: its inertia is exact and it needs no shifts. It also serves block tridiagonal systems, whose
//! fronts are the dense blocks along the chain. A simplicial factorization without pivoting, which needs static shifts,
//! gained nothing as a setting of the solver (`docs/experiments/solver.md`).

#[cfg(test)]
pub(crate) mod conformance;
mod factorization;
mod multifrontal;
pub(crate) mod norms;
mod refined;
mod symmetric;

pub(crate) use factorization::{FactorizationError, Inertia};
pub(crate) use multifrontal::MultifrontalLdl;
pub(crate) use refined::RefinedSolver;
pub(crate) use symmetric::SymmetricPattern;
