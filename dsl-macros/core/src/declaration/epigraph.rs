//! Largest values as unknowns: `t >= a`, `t >= b` where as little as possible of `max(a, b)` is asked for.

/// A largest value that optimal control has as an unknown, see `Model::epigraphs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epigraph {
    /// What it stands for, or the term that it stands in, as written.
    pub name: &'static str,
    /// When the values are of which it is the largest.
    pub over: Over,
    /// How many conditions say what it is at least, at each place where it is stated.
    pub rows: usize,
}

/// When the values are of which an unknown is the largest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Each instant, under an integral: one unknown at each stage.
    Instants,
    /// The end of the motion.
    End,
    /// All of the motion.
    Motion,
}
