//! Small dense systems and complementarity problems, in the caller's memory.

pub(crate) mod dense;
pub(crate) mod lcp;
pub(crate) mod small_system;
