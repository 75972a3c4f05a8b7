//! The memory of many rows of contacts, of which most are not coupled.

use crate::linalg::banded::{Banded, Entry};

/// The couplings of many rows that do not vanish.
#[derive(Debug, Clone, Default)]
pub(super) struct Sparse {
    /// Whether the last solution was by them.
    pub(super) holds: bool,
    pub(super) entries: Vec<Entry>,
    /// Where the entries of each row begin.
    pub(super) starts: Vec<usize>,
    pub(super) factors: Banded,
    /// For each coordinate the columns that move it.
    pub(super) columns: Vec<Vec<(usize, f64)>>,
    pub(super) sums: Vec<f64>,
    pub(super) touched: Vec<usize>,
}
