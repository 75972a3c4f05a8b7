//! What a term adds to.

/// What a term is added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// The objective.
    Objective,
    /// The constraint with this index, as returned by [`ElementProblemBuilder::row`](super::ElementProblemBuilder::row).
    Row(usize),
}
