//! Rows and places of the fronts.

use std::ops::Range;

use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};

use super::assembly_tree::{AssemblyTree, Supernode};
use crate::linalg::{FactorizationError, SymmetricPattern};

/// A node of the assembly tree. Everything about its front is known in advance as long as no column was postponed to
/// it; then the front's rows are its columns followed by the rows below, increasing.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// Number of its columns.
    pub(crate) columns: usize,
    /// Range of the front's rows in [`Symbolic::rows`].
    pub(crate) rows: Range<usize>,
    /// Range of its entries in [`Symbolic::entries`].
    pub(crate) entries: Range<usize>,
    /// Start in [`Symbolic::parent_places`] of the places of the rows below in the parent's front.
    pub(crate) parent_places: usize,
    /// Number of children; in postorder they are the last that many open nodes.
    pub(crate) children: usize,
    pub(crate) is_root: bool,
}

/// An entry of the pattern in the permuted matrix, row >= column. Half the width of `usize` keeps the scans over all
/// entries short.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// Position in the value array of the pattern.
    pub(crate) position: u32,
    pub(crate) row: u32,
    pub(crate) column: u32,
    /// Place in the panel of its node's front.
    pub(crate) place: u32,
}

/// Everything that depends on the pattern alone.
#[derive(Debug, Clone)]
pub(crate) struct Symbolic {
    /// `permutation[new] = old`.
    pub(crate) permutation: Vec<u32>,
    pub(crate) nodes: Vec<Node>,
    /// Rows of all fronts, node after node.
    pub(crate) rows: Vec<u32>,
    pub(crate) parent_places: Vec<u32>,
    /// Entries of the pattern by the node that eliminates them.
    pub(crate) entries: Vec<Entry>,
    /// Index in `entries` of each diagonal entry, by old row.
    pub(crate) diagonal: Vec<u32>,
}

impl Symbolic {
    pub(crate) fn new(pattern: &SymmetricPattern) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        if u32::try_from(pattern.stored().max(n)).is_err() {
            return Err(FactorizationError::Analysis(n));
        }
        let lower = SymbolicSparseColMatRef::new_checked(
            n,
            n,
            pattern.column_pointers(),
            None,
            pattern.row_indices(),
        );
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(lower, Side::Lower, SymmetricOrdering::Amd, parameters)
                .map_err(|_| FactorizationError::Analysis(n))?;
        let SymbolicCholeskyRaw::Simplicial(factor) = symbolic.raw() else {
            return Err(FactorizationError::Analysis(n));
        };
        let order: Vec<usize> = match symbolic.perm() {
            Some(permutation) => permutation.arrays().0.to_vec(),
            None => (0..n).collect(),
        };
        // the diagonal comes first in a column of the factor, then the parent in the elimination tree
        let below = |j: usize| {
            let column = factor.col_ptr()[j]..factor.col_ptr()[j + 1];
            factor.row_idx()[column].get(1..).unwrap_or_default()
        };
        let tree = AssemblyTree::new(n, below);
        let permutation: Vec<u32> = tree
            .columns
            .iter()
            .map(|&j| order[j as usize] as u32)
            .collect();
        let (supernodes, rows) = tree.supernodes(below);

        let mut inverse = vec![0_u32; n];
        for (new, &old) in permutation.iter().enumerate() {
            inverse[old as usize] = new as u32;
        }
        let mut symbolic = Self {
            permutation,
            nodes: Vec::with_capacity(supernodes.len()),
            rows,
            parent_places: Vec::new(),
            entries: Vec::with_capacity(pattern.stored()),
            diagonal: vec![0; n],
        };
        symbolic.add_nodes(n, &supernodes);
        let panel = |node: &Node| node.columns.saturating_mul(node.rows.len());
        if u32::try_from(symbolic.nodes.iter().map(panel).max().unwrap_or(0)).is_err() {
            return Err(FactorizationError::Analysis(n));
        }
        symbolic.add_entries(pattern, &inverse, &supernodes);
        Ok(symbolic)
    }

    /// Most entries that the stack of Schur complements holds while no column is postponed.
    pub(crate) fn stack(&self) -> usize {
        let mut sizes: Vec<usize> = Vec::new();
        let (mut now, mut most) = (0, 0);
        for node in &self.nodes {
            for _ in 0..node.children {
                now -= sizes.pop().unwrap_or(0);
            }
            if !node.is_root {
                let size = (node.rows.len() - node.columns).pow(2);
                sizes.push(size);
                now += size;
                most = most.max(now);
            }
        }
        most
    }

    /// Nodes, with the places of their rows in their parents' fronts.
    fn add_nodes(&mut self, n: usize, supernodes: &[Supernode]) {
        let owner = owners(n, supernodes);
        let mut start = 0;
        for supernode in supernodes {
            let columns = supernode.end - supernode.first;
            let end = start + columns + supernode.below;
            self.nodes.push(Node {
                columns,
                rows: start..end,
                entries: 0..0,
                parent_places: 0,
                children: 0,
                is_root: supernode.below == 0,
            });
            start = end;
        }
        for k in 0..self.nodes.len() {
            self.nodes[k].parent_places = self.parent_places.len();
            let rows = &self.rows[self.nodes[k].rows.clone()];
            let below = &rows[self.nodes[k].columns..];
            let Some(&first) = below.first() else {
                continue;
            };
            let parent = owner[first as usize] as usize;
            self.nodes[parent].children += 1;
            let above = &self.rows[self.nodes[parent].rows.clone()];
            let mut place = 0;
            for &row in below {
                // both lists increase, and the parent's holds every row of the child's
                while above[place] != row {
                    place += 1;
                }
                self.parent_places.push(place as u32);
            }
        }
    }

    /// Entries by node, with their places in the panels.
    fn add_entries(
        &mut self,
        pattern: &SymmetricPattern,
        inverse: &[u32],
        supernodes: &[Supernode],
    ) {
        let n = inverse.len();
        let owner = owners(n, supernodes);
        // counting sort by node, then by column and row within the node
        let mut starts = vec![0_usize; supernodes.len() + 1];
        let place_of = |j: usize, k: usize| {
            let (a, b) = (inverse[pattern.row_indices()[k]], inverse[j]);
            (a.max(b), a.min(b))
        };
        let columns = pattern.column_pointers();
        for j in 0..n {
            for k in columns[j]..columns[j + 1] {
                starts[owner[place_of(j, k).1 as usize] as usize + 1] += 1;
            }
        }
        for node in 0..supernodes.len() {
            starts[node + 1] += starts[node];
            self.nodes[node].entries = starts[node]..starts[node + 1];
        }
        let blank = Entry {
            position: 0,
            row: 0,
            column: 0,
            place: 0,
        };
        self.entries.resize(pattern.stored(), blank);
        for j in 0..n {
            for k in columns[j]..columns[j + 1] {
                let (row, column) = place_of(j, k);
                let next = &mut starts[owner[column as usize] as usize];
                self.entries[*next] = Entry {
                    position: k as u32,
                    row,
                    column,
                    place: 0,
                };
                *next += 1;
            }
        }
        let mut local = vec![0_u32; n];
        for (node, supernode) in self.nodes.iter().zip(supernodes) {
            let rows = &self.rows[node.rows.clone()];
            for (place, &row) in rows.iter().enumerate() {
                local[row as usize] = place as u32;
            }
            let entries = &mut self.entries[node.entries.clone()];
            for entry in entries.iter_mut() {
                let column = entry.column - supernode.first as u32;
                entry.place = column * rows.len() as u32 + local[entry.row as usize];
            }
            entries.sort_unstable_by_key(|entry| entry.place);
        }
        for (index, entry) in self.entries.iter().enumerate() {
            if entry.row == entry.column {
                self.diagonal[self.permutation[entry.row as usize] as usize] = index as u32;
            }
        }
    }
}

/// The node that eliminates each column.
fn owners(n: usize, nodes: &[Supernode]) -> Vec<u32> {
    let mut owner = vec![0; n];
    for (k, node) in nodes.iter().enumerate() {
        owner[node.first..node.end].fill(k as u32);
    }
    owner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_dense_matrix_is_one_supernode() {
        let mut entries = Vec::new();
        for i in 0..6 {
            for j in 0..=i {
                entries.push((i, j));
            }
        }
        let (pattern, _) = SymmetricPattern::new(6, &entries).unwrap();
        let symbolic = Symbolic::new(&pattern).unwrap();
        assert_eq!(symbolic.nodes.len(), 1);
        assert_eq!(symbolic.nodes[0].columns, 6);
        assert_eq!(symbolic.rows, [0, 1, 2, 3, 4, 5]);
    }
}
