//! What stands in the way of equations of motion.

/// Why no equations could be derived.
pub(crate) enum Failure {
    /// The mass matrix is singular whatever the parameters; this coordinate's pivot vanishes.
    SingularMass { coordinate: usize },
}
