//! How thoroughly contact sequences are searched.

/// How much is asked of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::ocp) enum Effort {
    /// A good motion from nothing: sequences in other basins are tried, programs that fail are left.
    Explore,
    /// The motion on this grid that one on a coarser grid leads to: programs that fail are left.
    Carry,
    /// A proof: every neighbour is decided, as far as the programs go.
    Certify,
    /// The same of a motion that may be the result: it is polished.
    Conclude,
}

impl Effort {
    /// Whether every neighbour is decided.
    pub(in crate::ocp) fn proves(self) -> bool {
        matches!(self, Self::Certify | Self::Conclude)
    }
}
