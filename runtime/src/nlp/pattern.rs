//! Assembly of sparse values that are added in a fixed order.

use std::collections::HashMap;

/// Positions of a sparse matrix, each once, and which of them each addition goes to.
#[derive(Clone, Default)]
pub(crate) struct Pattern {
    /// (row, column) of each nonzero, in the order of its first addition.
    pub(crate) entries: Vec<(usize, usize)>,
    /// Place in `entries` of each addition, in order.
    pub(crate) places: Vec<usize>,
}

impl Pattern {
    /// The pattern of additions at these positions, in this order.
    pub(crate) fn new(additions: &[(usize, usize)]) -> Self {
        let mut index = HashMap::new();
        let mut pattern = Self::default();
        for &position in additions {
            let place = *index.entry(position).or_insert_with(|| {
                pattern.entries.push(position);
                pattern.entries.len() - 1
            });
            pattern.places.push(place);
        }
        pattern
    }
}
