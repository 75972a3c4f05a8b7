//! The interface of the factorizations.

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
    /// A pivot vanished; the matrix is singular, or needs pivoting.
    #[cfg(test)]
    ZeroPivot,
    /// An entry or a pivot is not a finite number.
    NotFinite,
    /// The time was over, or the run was asked to end.
    Stopped,
    /// The analysis ran out of memory or index range.
    Analysis,
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
pub(crate) trait KktFactorization {
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
}
