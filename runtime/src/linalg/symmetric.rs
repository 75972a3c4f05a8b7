//! A fixed symmetric sparsity with scatter maps.

/// Lower triangle of a symmetric matrix in compressed column form, without duplicates.
///
/// Every diagonal position is present, so that a shift of the diagonal never changes the pattern. Row
/// indices of a column are increasing, hence the diagonal entry comes first.
///
/// # Examples
/// `A = [2 1; 1 0]` from its entries, the off-diagonal one in two parts, and `A (1, 1)`:
///
/// ```
/// use hangtime::linalg::SymmetricPattern;
///
/// let entries = [(0, 0), (1, 0), (0, 1)];
/// let (pattern, map) = SymmetricPattern::new(2, &entries).ok_or("an entry outside the matrix")?;
/// assert_eq!(pattern.stored(), 3);
/// let mut values = vec![0.0; pattern.stored()];
/// for (&position, a) in map.iter().zip([2.0, 0.25, 0.75]) {
///     values[position] += a;
/// }
/// let mut y = [0.0; 2];
/// pattern.multiply_add(&values, &[1.0, 1.0], &mut y);
/// assert_eq!(y, [3.0, 1.0]);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone)]
pub struct SymmetricPattern {
    dimension: usize,
    column_pointers: Vec<usize>,
    row_indices: Vec<usize>,
}

impl SymmetricPattern {
    /// Pattern of dimension `dimension` that holds the diagonal and all `entries` (row, column).
    ///
    /// Entries may repeat and may lie in either triangle; (i, j) and (j, i) are the same position.
    /// The second value is the scatter map: position of entry `k` in the value array, so that
    /// `values[map[k]] += a_k` assembles the matrix. Entries outside the dimension are not accepted:
    /// `None` is returned if there is one.
    pub fn new(dimension: usize, entries: &[(usize, usize)]) -> Option<(Self, Vec<usize>)> {
        let mut counts = vec![0_usize; dimension + 1];
        for &(i, j) in entries {
            if i.max(j) >= dimension {
                return None;
            }
            counts[i.min(j) + 1] += 1;
        }
        for j in 0..dimension {
            counts[j + 1] += counts[j];
        }
        let mut next = counts.clone();
        let mut by_column = vec![(0_usize, 0_usize); entries.len()];
        for (k, &(i, j)) in entries.iter().enumerate() {
            let column = i.min(j);
            by_column[next[column]] = (i.max(j), k);
            next[column] += 1;
        }
        let mut column_pointers = Vec::with_capacity(dimension + 1);
        let mut row_indices = Vec::with_capacity(dimension + entries.len());
        let mut map = vec![0_usize; entries.len()];
        column_pointers.push(0);
        for j in 0..dimension {
            let column = &mut by_column[counts[j]..counts[j + 1]];
            column.sort_unstable();
            row_indices.push(j);
            for &(row, k) in column.iter() {
                if row_indices.last() != Some(&row) {
                    row_indices.push(row);
                }
                map[k] = row_indices.len() - 1;
            }
            column_pointers.push(row_indices.len());
        }
        let pattern = Self {
            dimension,
            column_pointers,
            row_indices,
        };
        Some((pattern, map))
    }

    /// Dimension of the matrix.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of stored positions, the length of a value array.
    pub fn stored(&self) -> usize {
        self.row_indices.len()
    }

    /// Start of each column in the value array, length `dimension + 1`.
    pub fn column_pointers(&self) -> &[usize] {
        &self.column_pointers
    }

    /// Row of each stored position.
    pub fn row_indices(&self) -> &[usize] {
        &self.row_indices
    }

    /// Position of the diagonal entry of `column` in the value array.
    pub fn diagonal(&self, column: usize) -> usize {
        self.column_pointers[column]
    }

    /// Adds `A x` to `y`, where `A` has the given values.
    pub fn multiply_add(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for j in 0..self.dimension {
            let start = self.column_pointers[j];
            let end = self.column_pointers[j + 1];
            let x_j = x[j];
            let mut sum = values[start] * x_j;
            for (&i, &a) in self.row_indices[start + 1..end]
                .iter()
                .zip(&values[start + 1..end])
            {
                y[i] += a * x_j;
                sum += a * x[i];
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
