//! The factors: the eliminated columns of all fronts, one after the other.

/// A front of the factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrontRecord {
    pub(super) pivots: u32,
    pub(super) rows: u32,
}

/// `L` by fronts and `B^-1`.
#[derive(Debug, Default)]
pub(super) struct Factors {
    /// Columns of the fronts, padded.
    pub(super) values: Vec<f64>,
    /// Names of their rows.
    pub(super) rows: Vec<u32>,
    pub(super) fronts: Vec<FrontRecord>,
    /// Diagonal and coupling to the next row of `B^-1`, which is tridiagonal.
    pub(super) inverse: Vec<[f64; 2]>,
}
