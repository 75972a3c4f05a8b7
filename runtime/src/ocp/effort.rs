//! How thoroughly contact sequences are searched.

/// How much is asked of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::ocp) enum Effort {
    /// A motion: programs that fail are left.
    Quick,
    /// A proof of a motion that may be the result: every neighbour is decided, as far as the programs go, and it is polished.
    Conclude,
}

impl Effort {
    /// Whether every neighbour is decided.
    pub(in crate::ocp) fn proves(self) -> bool {
        self == Self::Conclude
    }
}
