//! Linear algebra kernels. Knows nothing of optimization.

pub mod dense;
pub mod lcp;
