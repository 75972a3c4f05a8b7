//! Product constraints.

/// Product constraints `x_i x_j <= sigma` that a run carries along, and what became of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Products {
    pub(crate) pairs: Vec<(usize, usize)>,
    /// Multiplier of each product, in the order of the pairs; 0 where a variable is fixed. On entry of
    /// a warm start those to begin with.
    pub(crate) multipliers: Vec<f64>,
    /// `sigma` at the end.
    pub(crate) sigma: f64,
}
