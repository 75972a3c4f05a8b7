//! What a factorization tells of a matrix.

/// Numbers of positive, negative and zero eigenvalues of a symmetric matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Inertia {
    /// Positive eigenvalues.
    pub(crate) positive: usize,
    /// Negative eigenvalues.
    pub(crate) negative: usize,
    /// Eigenvalues that the factorization found to be zero.
    pub(crate) zero: usize,
}

/// Why a matrix has no usable factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FactorizationError {
    /// An entry or a pivot is not a finite number.
    NotFinite,
    /// The time was over, or the run was asked to end.
    Stopped,
    /// The analysis ran out of memory or index range.
    Analysis,
}
