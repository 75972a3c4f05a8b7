//! Small dense systems and complementarity problems, and large ones of a narrow band, in the caller's memory.

pub(crate) mod banded;
pub(crate) mod dense;
pub(crate) mod lcp;
pub(crate) mod least_norm;
pub(crate) mod products;
pub(crate) mod small_system;
