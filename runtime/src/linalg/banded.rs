//! LU factorization of a large matrix most of whose entries vanish, as a band around its diagonal.
//!
//! Bodies that do not touch each other are not coupled. In the order of Cuthill and McKee, in which unknowns that share an equation
//! stand close to each other, what couples neighbours is a band; partial pivoting inside of it is that of the whole matrix, since what
//! is below the band vanishes. Of `n` unknowns in a band of width `b` a factorization takes `O(n b^2)` operations.
//!
//! Sources: Cuthill, McKee, *Reducing the bandwidth of sparse symmetric matrices* (1969); Gibbs, Poole, Stockmeyer, *An algorithm for
//! reducing the bandwidth and profile of a sparse matrix* (1976), for where to begin; Golub, Van Loan, *Matrix Computations*, section 4.3.

/// A band whose rows have room for more than this share of the order is no less work than the whole matrix: `2 n b^2` of `n^3 / 3` operations.
const WIDE: f64 = 0.6;

/// An entry of a sparse matrix: row, column and value.
pub(crate) type Entry = (usize, usize, f64);

/// Why there are no factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unfactorized {
    /// The band is as wide as the matrix.
    Wide,
    /// The matrix is singular.
    Singular,
}

/// Factors of a matrix in an order of its own.
#[derive(Debug, Clone, Default)]
pub(crate) struct Banded {
    /// Places of the entries that the order is for.
    pattern: Vec<(usize, usize)>,
    /// The unknown at each place, and the place of each unknown.
    order: Vec<usize>,
    place: Vec<usize>,
    /// Number of diagonals below the main one, and entries that a row has room for.
    lower: usize,
    width: usize,
    /// Rows, each from `lower` places before its diagonal on.
    entries: Vec<f64>,
    /// Behind the last entry of each row of `U`.
    ends: Vec<usize>,
    pivots: Vec<usize>,
    /// Largest entry of each column.
    scales: Vec<f64>,
    right: Vec<f64>,
    /// Sign of the determinant.
    pub(crate) sign: f64,
}

impl Banded {
    /// Factorizes the matrix of order `n` with these `entries`, none twice. A pivot of at most `zero` times the largest entry of its
    /// column counts as none.
    ///
    /// # Errors
    /// The band is wide, or the matrix singular.
    pub(crate) fn factorize(
        &mut self,
        n: usize,
        entries: &[Entry],
        zero: f64,
    ) -> Result<(), Unfactorized> {
        let known = self.pattern.iter().copied();
        if self.order.len() != n || !known.eq(entries.iter().map(|&(i, j, _)| (i, j))) {
            self.take_order(n, entries);
        }
        if self.width as f64 > WIDE * n as f64 {
            return Err(Unfactorized::Wide);
        }
        self.entries.clear();
        self.entries.resize(n * self.width, 0.0);
        self.ends.clear();
        self.ends.extend(1..=n);
        self.scales.clear();
        self.scales.resize(n, 0.0);
        for &(row, column, value) in entries {
            let (row, column) = (self.place[row], self.place[column]);
            let at = self.at(row, column);
            self.entries[at] = value;
            self.scales[column] = self.scales[column].max(value.abs());
            self.ends[row] = self.ends[row].max(column + 1);
        }
        self.pivots.clear();
        self.sign = 1.0;
        (0..n).try_for_each(|k| self.eliminate(k, zero))
    }

    /// Finds the order for a pattern.
    fn take_order(&mut self, n: usize, entries: &[Entry]) {
        self.pattern.clear();
        self.pattern.extend(entries.iter().map(|&(i, j, _)| (i, j)));
        let neighbours = neighbours(n, &self.pattern);
        self.order = cuthill_mckee(&neighbours);
        self.place.clear();
        self.place.resize(n, 0);
        for (new, &old) in self.order.iter().enumerate() {
            self.place[old] = new;
        }
        let places = self.pattern.iter();
        let far = places.map(|&(i, j)| self.place[i].abs_diff(self.place[j]));
        self.lower = far.max().unwrap_or_default();
        // Rows that are swapped reach farther by what is below the diagonal.
        self.width = 3 * self.lower + 1;
    }

    /// Where an entry stands.
    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width + column + self.lower - row
    }

    /// Takes column `k` out of the rows below it.
    fn eliminate(&mut self, k: usize, zero: f64) -> Result<(), Unfactorized> {
        let n = self.order.len();
        let below = k + 1..(k + self.lower + 1).min(n);
        let (mut pivot, mut largest) = (k, self.entries[self.at(k, k)].abs());
        for row in below.clone() {
            let size = self.entries[self.at(row, k)].abs();
            if size > largest || size.is_nan() {
                (pivot, largest) = (row, size);
            }
        }
        if !largest.is_finite() || largest <= zero * self.scales[k] {
            return Err(Unfactorized::Singular);
        }
        self.pivots.push(pivot);
        self.sign *= self.entries[self.at(pivot, k)].signum();
        if pivot != k {
            self.sign = -self.sign;
            for column in k..self.ends[k].max(self.ends[pivot]) {
                let (one, other) = (self.at(k, column), self.at(pivot, column));
                self.entries.swap(one, other);
            }
            self.ends.swap(k, pivot);
        }
        let end = self.ends[k];
        let (from, length) = (self.at(k, k), end - k);
        for row in below {
            let to = self.at(row, k);
            let (above, rest) = self.entries.split_at_mut(to);
            let own = &above[from..from + length];
            let row_of = &mut rest[..length];
            let factor = row_of[0] / own[0];
            row_of[0] = factor;
            if factor == 0.0 {
                continue;
            }
            for (entry, above) in row_of[1..].iter_mut().zip(&own[1..]) {
                *entry -= factor * above;
            }
            self.ends[row] = self.ends[row].max(end);
        }
        Ok(())
    }

    /// Solves `A x = b` with the factors; `b` is overwritten by `x`.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let n = self.order.len();
        let mut x = std::mem::take(&mut self.right);
        x.clear();
        x.extend(self.order.iter().map(|&old| b[old]));
        for (k, &pivot) in self.pivots.iter().enumerate() {
            x.swap(k, pivot);
            let value = x[k];
            if value == 0.0 {
                continue;
            }
            let below = x[..(k + self.lower + 1).min(n)].iter_mut().enumerate();
            for (row, x) in below.skip(k + 1) {
                *x -= self.entries[self.at(row, k)] * value;
            }
        }
        for k in (0..n).rev() {
            let first = self.at(k, k);
            let own = &self.entries[first..first + self.ends[k] - k];
            let known = own[1..].iter().zip(&x[k + 1..]);
            let sum: f64 = known.map(|(u, x)| u * x).sum();
            x[k] = (x[k] - sum) / own[0];
        }
        for (&old, value) in self.order.iter().zip(&x) {
            b[old] = *value;
        }
        self.right = x;
    }
}

/// For each unknown the others with which it shares an entry.
fn neighbours(n: usize, pattern: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); n];
    for &(i, j) in pattern.iter().filter(|(i, j)| i != j) {
        neighbours[i].push(j);
        neighbours[j].push(i);
    }
    for others in &mut neighbours {
        others.sort_unstable();
        others.dedup();
    }
    neighbours
}

/// Unknowns in the order in which a search in breadth meets them, those with few neighbours first, from ends of the graph.
fn cuthill_mckee(neighbours: &[Vec<usize>]) -> Vec<usize> {
    let n = neighbours.len();
    let mut order = Vec::with_capacity(n);
    let mut done = vec![false; n];
    let mut by_degree: Vec<usize> = (0..n).collect();
    by_degree.sort_by_key(|&i| neighbours[i].len());
    for &start in &by_degree {
        if done[start] {
            continue;
        }
        // What is met last lies at an end.
        let mut end = start;
        for _ in 0..2 {
            let met = in_breadth(neighbours, end, &mut done.clone());
            end = met.last().copied().unwrap_or(end);
        }
        order.extend(in_breadth(neighbours, end, &mut done));
    }
    order
}

fn in_breadth(neighbours: &[Vec<usize>], start: usize, done: &mut [bool]) -> Vec<usize> {
    let mut met = vec![start];
    done[start] = true;
    let mut next = 0;
    while let Some(&i) = met.get(next) {
        let first = met.len();
        for &j in &neighbours[i] {
            if !done[j] {
                done[j] = true;
                met.push(j);
            }
        }
        met[first..].sort_by_key(|&j| neighbours[j].len());
        next += 1;
    }
    met
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::small_system;
    use crate::random_cases::same_in_every_run;
    use proptest::prelude::*;

    /// A matrix of blocks of three along a chain whose links are numbered in a scattered order, coupled to the next one; row-major.
    fn scattered_chain(links: usize, entries: &[f64]) -> Vec<f64> {
        let n = 3 * links;
        // Seven has no divisor in common with what it counts.
        let number = |link: usize| (7 * link + 3) % links;
        let mut values = entries.iter().copied().cycle();
        let mut matrix = vec![0.0; n * n];
        for link in 0..links {
            for other in [link, (link + 1).min(links - 1)] {
                for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                    let (row, column) = (3 * number(link) + i, 3 * number(other) + j);
                    matrix[row * n + column] = values.next().unwrap_or(1.0);
                    matrix[column * n + row] = values.next().unwrap_or(1.0);
                }
            }
        }
        matrix
    }

    fn entries(matrix: &[f64], n: usize) -> Vec<Entry> {
        let all = matrix.iter().enumerate();
        let all = all.filter(|(_, value)| **value != 0.0);
        all.map(|(at, value)| (at / n, at % n, *value)).collect()
    }

    proptest! {
        #![proptest_config(same_in_every_run())]
        #[test]
        fn solution_is_that_of_the_whole_matrix(
            values in proptest::collection::vec(-1.0..1.0, 101),
            b in proptest::collection::vec(-1.0..1.0, 90),
        ) {
            let n = 90;
            let matrix = scattered_chain(n / 3, &values);
            let mut whole = matrix.clone();
            let mut right = b.clone();
            let sign = small_system::solve(&mut whole, &mut right);
            let mut banded = Banded::default();
            let regular = banded.factorize(n, &entries(&matrix, n), 1e-12);
            prop_assert_eq!(sign.is_some(), regular.is_ok());
            if let Some(sign) = sign {
                prop_assert_eq!(sign, banded.sign);
                let mut x = b.clone();
                banded.solve(&mut x);
                // Backward stable: the residual is rounding of the terms, whatever the condition; pivots grow the entries a little.
                for i in 0..n {
                    let terms = (0..n).map(|j| matrix[n * i + j] * x[j]);
                    let (sum, size) = terms.fold((-b[i], b[i].abs()), |(sum, size), term| {
                        (sum + term, size + term.abs())
                    });
                    let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    prop_assert!(sum.abs() <= 1e-12 * (size + largest), "{sum:e} of {size:e}");
                }
            }
        }
    }

    #[test]
    fn band_of_a_scattered_chain_is_as_wide_as_its_links() {
        let matrix = scattered_chain(40, &[1.0, 0.3, -0.7, 0.2, 5.0]);
        let mut banded = Banded::default();
        assert_eq!(banded.factorize(120, &entries(&matrix, 120), 1e-12), Ok(()));
        // Three unknowns of a link and three of the next one.
        assert!(banded.lower <= 6, "{}", banded.lower);
    }

    #[test]
    fn matrix_without_zeros_is_left_to_others() {
        let outcome = Banded::default().factorize(20, &entries(&[1.0; 400], 20), 1e-12);
        assert_eq!(outcome, Err(Unfactorized::Wide));
    }

    #[test]
    fn matrix_with_an_empty_column_is_singular() {
        let ones = (0..30).filter(|&i| i != 17).map(|i| (i, i, 1.0));
        let outcome = Banded::default().factorize(30, &ones.collect::<Vec<_>>(), 1e-12);
        assert_eq!(outcome, Err(Unfactorized::Singular));
    }
}
