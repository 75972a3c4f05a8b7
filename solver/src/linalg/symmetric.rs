//! A fixed symmetric sparsity with scatter maps.

/// Lower triangle of a symmetric matrix in compressed column form, without duplicates.
///
/// Every diagonal position is present, so that a shift of the diagonal never changes the pattern. Row
/// indices of a column are increasing, hence the diagonal entry comes first.
#[derive(Debug, Clone)]
pub(crate) struct SymmetricPattern {
    column_pointers: Vec<u32>,
    row_indices: Vec<u32>,
}

impl SymmetricPattern {
    /// As [`SymmetricPattern::with_map`], from entries that are held.
    #[cfg(test)]
    pub(crate) fn new(dimension: usize, entries: &[(usize, usize)]) -> Option<(Self, Vec<usize>)> {
        let (pattern, map) = Self::with_map(dimension, entries.iter().copied())?;
        Some((pattern, map.into_iter().map(|k| k as usize).collect()))
    }

    /// Pattern of dimension `dimension` that holds the diagonal and all `entries` (row, column).
    ///
    /// Entries may repeat and may lie in either triangle; (i, j) and (j, i) are the same position.
    /// The second value is the scatter map: position of entry `k` in the value array, so that
    /// `values[map[k]] += a_k` assembles the matrix. Entries outside the dimension are not accepted:
    /// `None` is returned if there is one, and if dimension and entries exceed the range of `u32` together.
    /// The entries are visited twice.
    pub(crate) fn with_map(
        dimension: usize,
        entries: impl Iterator<Item = (usize, usize)> + Clone,
    ) -> Option<(Self, Vec<u32>)> {
        // counting sort by rows: starts[i] is where row i goes
        let mut starts = vec![0_u32; dimension + 1];
        let mut count = 0;
        for (i, j) in entries.clone() {
            *starts.get_mut(i.max(j).checked_add(1)?)? += 1;
            count += 1;
        }
        u32::try_from(dimension.checked_add(count)?).ok()?;
        let mut column_pointers = vec![0_u32; dimension + 1];
        for row in 0..dimension {
            starts[row + 1] += starts[row];
        }
        let mut by_row = vec![(0_u32, 0_u32); count];
        for (k, (i, j)) in entries.enumerate() {
            let next = &mut starts[i.max(j)];
            by_row[*next as usize] = (i.min(j) as u32, k as u32);
            *next += 1;
        }
        // what is sorted by rows stays so within each column; repeated positions are counted once
        let mut last = vec![u32::MAX; dimension];
        let rows = |starts: &[u32], row: usize| {
            let first = if row == 0 { 0 } else { starts[row - 1] };
            first as usize..starts[row] as usize
        };
        for row in 0..dimension {
            for &(column, _) in &by_row[rows(&starts, row)] {
                if last[column as usize] != row as u32 && column as usize != row {
                    last[column as usize] = row as u32;
                    column_pointers[column as usize + 1] += 1;
                }
            }
        }
        for column in 0..dimension {
            // the diagonal comes first
            column_pointers[column + 1] += column_pointers[column] + 1;
        }
        let mut row_indices = vec![0_u32; column_pointers[dimension] as usize];
        let mut map = vec![0_u32; count];
        // from here on the last position taken in each column
        last.copy_from_slice(&column_pointers[..dimension]);
        for row in 0..dimension {
            row_indices[column_pointers[row] as usize] = row as u32;
        }
        for row in 0..dimension {
            for &(column, k) in &by_row[rows(&starts, row)] {
                let last = &mut last[column as usize];
                if row_indices[*last as usize] != row as u32 && column as usize != row {
                    *last += 1;
                    row_indices[*last as usize] = row as u32;
                }
                map[k as usize] = if column as usize == row {
                    column_pointers[row]
                } else {
                    *last
                };
            }
        }
        let pattern = Self {
            column_pointers,
            row_indices,
        };
        Some((pattern, map))
    }

    /// Dimension of the matrix.
    pub(crate) fn dimension(&self) -> usize {
        self.column_pointers.len() - 1
    }

    /// Number of stored positions, the length of a value array.
    pub(crate) fn stored(&self) -> usize {
        self.row_indices.len()
    }

    /// Start of each column in the value array, length `dimension + 1`.
    pub(crate) fn column_pointers(&self) -> &[u32] {
        &self.column_pointers
    }

    /// Row of each stored position.
    pub(crate) fn row_indices(&self) -> &[u32] {
        &self.row_indices
    }

    /// Position of the diagonal entry of `column` in the value array.
    pub(crate) fn diagonal(&self, column: usize) -> usize {
        self.column_pointers[column] as usize
    }

    /// Adds `A x` to `y`, where `A` has the given values.
    pub(crate) fn multiply_add(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for (j, ends) in self.column_pointers.windows(2).enumerate() {
            let (start, end) = (ends[0] as usize, ends[1] as usize);
            let x_j = x[j];
            let mut sum = values[start] * x_j;
            for (&i, &a) in self.row_indices[start + 1..end]
                .iter()
                .zip(&values[start + 1..end])
            {
                y[i as usize] += a * x_j;
                sum += a * x[i as usize];
            }
            y[j] += sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_repeated_and_mirrored_entries_share_one_position() {
        let entries = [(2, 0), (0, 2), (1, 1), (2, 1), (2, 0)];
        let (pattern, map) = SymmetricPattern::new(3, &entries).unwrap();
        assert_eq!(pattern.column_pointers(), [0, 2, 4, 5]);
        assert_eq!(pattern.row_indices(), [0, 2, 1, 2, 2]);
        assert_eq!(map, [1, 1, 2, 3, 1]);
    }

    #[test]
    fn new_entry_outside_the_dimension_is_refused() {
        assert!(SymmetricPattern::new(2, &[(2, 0)]).is_none());
    }

    #[test]
    fn multiply_add_uses_both_triangles() {
        // A = [2 1 0; 1 3 4; 0 4 5]
        let (pattern, map) =
            SymmetricPattern::new(3, &[(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)]).unwrap();
        let mut values = vec![0.0; pattern.stored()];
        for (position, a) in map.iter().zip([2.0, 1.0, 3.0, 4.0, 5.0]) {
            values[*position] += a;
        }
        let mut y = vec![1.0; 3];
        pattern.multiply_add(&values, &[1.0, 2.0, 3.0], &mut y);
        assert_eq!(y, [5.0, 20.0, 24.0]);
    }
}
