//! Assembly of sparse values that are added in a fixed order.

use std::collections::HashMap;

/// Positions of a sparse matrix, each once, and which of them each addition goes to.
///
/// ```
/// use hangtime_solver::nlp::Pattern;
///
/// // Two additions share the entry (1, 1).
/// let pattern = Pattern::new(&[(0, 0), (1, 1), (1, 1), (2, 2)]);
/// assert_eq!(pattern.entries, [(0, 0), (1, 1), (2, 2)]);
/// assert_eq!(pattern.places, [0, 1, 1, 2]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    /// (row, column) of each nonzero, in the order of its first addition.
    pub entries: Vec<(usize, usize)>,
    /// Place in `entries` of each addition, in order.
    pub places: Vec<usize>,
}

impl Pattern {
    /// The pattern of additions at these positions, in this order.
    #[must_use]
    pub fn new(additions: &[(usize, usize)]) -> Self {
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
