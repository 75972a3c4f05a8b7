//! Linear algebra of the solvers: sparse symmetric indefinite systems.
//!
//! Everything here works on one fixed sparsity: the analysis runs once, factorizations and solves
//! reuse its memory. Nothing here knows of optimization; the names `primal` and `dual` only say which
//! rows of a saddle point matrix receive which shift.

mod factorization;
mod multifrontal;
mod refined;
mod simplicial;
mod symmetric;

pub use factorization::{FactorizationError, Inertia, KktFactorization};
pub use multifrontal::MultifrontalLdl;
pub use refined::{RefinedSolver, SolveQuality};
pub use simplicial::SimplicialLdl;
pub use symmetric::SymmetricPattern;
