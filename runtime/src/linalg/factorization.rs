//! The interface of the factorizations.

/// Numbers of positive, negative and zero eigenvalues of a symmetric matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inertia {
    /// Positive eigenvalues.
    pub positive: usize,
    /// Negative eigenvalues.
    pub negative: usize,
    /// Eigenvalues that the factorization found to be zero. A factorization without pivoting stops
    /// at the first zero pivot; then this counts the rows it did not reach.
    pub zero: usize,
}

/// Why a matrix has no usable factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FactorizationError {
    /// A pivot vanished at this row; the matrix is singular, or needs pivoting.
    #[error("zero pivot at row {0}; shift the diagonal or use a pivoting factorization")]
    ZeroPivot(usize),
    /// An entry or a pivot is not a finite number.
    #[error("a matrix entry or pivot at row {0} is not finite")]
    NotFinite(usize),
    /// The analysis ran out of memory or index range.
    #[error("the symbolic analysis failed for dimension {0}: out of memory or index range")]
    Analysis(usize),
}

/// Factorization `P (K + D) P' = L B L'` of a saddle point matrix on a fixed pattern, with
///
/// ```text
///     K + D = [ W + delta_w I        A'      ]   primal rows
///             [       A        -(C + delta_c I)]   dual rows
/// ```
///
/// The analysis happens in the constructor of each implementation; afterwards neither `factor` nor
/// `solve` allocates, unless a pivoting implementation has to postpone more pivots than ever before.
pub trait KktFactorization {
    /// Factorizes the matrix with the given values (order of the pattern) and shifts, both of them
    /// `>= 0`, and returns the inertia of what was factorized.
    ///
    /// # Errors
    /// [`FactorizationError`] when there are no factors to solve with.
    fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError>;

    /// Solves with the factors of the last successful [`KktFactorization::factor`], in place.
    fn solve(&mut self, right_hand_side: &mut [f64]);

    /// Entries of the factor, a measure of fill.
    fn factor_entries(&self) -> usize;
}
