//! Linear algebra kernels: small dense systems and complementarity problems, and sparse symmetric
//! indefinite systems.
//!
//! The sparse part works on one fixed sparsity: the analysis runs once, factorizations and solves
//! reuse its memory. Nothing here knows of optimization; the names `primal` and `dual` only say which
//! rows of a saddle point matrix receive which shift.

pub mod dense;
mod factorization;
pub mod lcp;
mod multifrontal;
mod refined;
mod simplicial;
mod symmetric;

pub use factorization::{FactorizationError, Inertia, KktFactorization};
pub use multifrontal::MultifrontalLdl;
pub use refined::{RefinedSolver, SolveQuality};
pub use simplicial::SimplicialLdl;
pub use symmetric::SymmetricPattern;
