//! Scalar products, of two vectors and of many rows with many columns, of which most vanish; and sizes of vectors.

use super::banded::Entry;

/// Scalar product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Largest size of a component, whatever those are that are not numbers.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// The products of all rows of one row-major matrix of `n` columns with all of another one, but for those that vanish, row by row. Their
/// terms are added in the order of the columns, without those that are zero.
pub(crate) fn products(rows: &[f64], others: &[f64], n: usize) -> Vec<Entry> {
    let mut by_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    let nonzero = |(_, value): &(usize, &f64)| **value != 0.0;
    for (other, components) in others.chunks_exact(n).enumerate() {
        for (k, &value) in components.iter().enumerate().filter(nonzero) {
            by_column[k].push((other, value));
        }
    }
    let mut sums = vec![0.0; others.len() / n];
    let mut met = Vec::new();
    let mut entries = Vec::new();
    for (row, components) in rows.chunks_exact(n).enumerate() {
        for (k, &component) in components.iter().enumerate().filter(nonzero) {
            for &(other, value) in &by_column[k] {
                sums[other] += component * value;
                met.push(other);
            }
        }
        met.sort_unstable();
        met.dedup();
        let kept = met
            .drain(..)
            .map(|other| (row, other, std::mem::take(&mut sums[other])));
        entries.extend(kept.filter(|(.., value)| *value != 0.0));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::products;

    #[test]
    fn products_are_those_of_all_rows_without_the_zeros() {
        let rows = [1.0, 0.0, 2.0, 0.0, 3.0, 0.0];
        let others = [0.0, 5.0, 0.0, 4.0, 1.0, -2.0, 1.0, 0.0, 0.5];
        let expected = vec![(0, 2, 2.0), (1, 0, 15.0), (1, 1, 3.0)];
        assert_eq!(products(&rows, &others, 3), expected);
    }
}
