//! Units of matrices: entry by entry, as those of moments of inertia and of rotations differ.

use crate::dimension::Dimension;

/// Units of the entries, row by row.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    pub(super) entries: Vec<Dimension>,
    pub(super) columns: usize,
}

impl Matrix {
    pub(super) fn rows(&self) -> impl Iterator<Item = &[Dimension]> {
        self.entries.chunks(self.columns.max(1))
    }

    pub(super) fn column(&self, j: usize) -> Vec<Dimension> {
        let column = self.entries.iter().skip(j).step_by(self.columns.max(1));
        column.cloned().collect()
    }
}
