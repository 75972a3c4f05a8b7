//! Rows and places of the fronts.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};

use super::assembly_tree::{AssemblyTree, Supernode};
use super::kernels::padded;
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

/// An entry of the pattern below the diagonal of the permuted matrix, row > column. Half the width of `usize` keeps the
/// scans over all entries short.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// Position in the value array of the pattern.
    pub(crate) position: u32,
    pub(crate) row: u32,
    pub(crate) column: u32,
    /// Place in the square of its node's front.
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
    /// Entries of the pattern outside the diagonal by the node that eliminates them.
    pub(crate) entries: Vec<Entry>,
    /// Position in the value array of the diagonal entry of each permuted row.
    pub(crate) diagonal: Vec<u32>,
}

impl Symbolic {
    pub(crate) fn new(pattern: &SymmetricPattern) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        let failed = FactorizationError::Analysis;
        let (order, place) = minimum_degree(pattern).ok_or(failed)?;
        let upper = upper_triangle(pattern, &place);
        let (parents, below) = elimination_tree(n, &upper).ok_or(failed)?;
        let tree = AssemblyTree::new(&below, |j| usize::try_from(parents[j]).ok());
        let supernodes = tree.supernodes(&below);
        let permutation: Vec<u32> = tree.columns.iter().map(|&j| order[j as usize]).collect();
        let mut inverse = place;
        for (new, &old) in permutation.iter().enumerate() {
            inverse[old as usize] = new as u32;
        }
        let diagonal = permutation
            .iter()
            .map(|&old| pattern.diagonal(old as usize) as u32)
            .collect();
        let mut symbolic = Self {
            permutation,
            nodes: Vec::with_capacity(supernodes.len()),
            rows: Vec::with_capacity(supernodes.iter().map(|s| s.end - s.first + s.below).sum()),
            parent_places: Vec::with_capacity(supernodes.iter().map(|s| s.below).sum()),
            entries: Vec::new(),
            diagonal,
        };
        let owner = owners(n, &supernodes);
        symbolic.add_nodes(&supernodes);
        symbolic.sort_entries(pattern, &inverse, &owner);
        symbolic.add_rows(&supernodes, &owner).ok_or(failed)?;
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

    /// Nodes without entries and links.
    fn add_nodes(&mut self, supernodes: &[Supernode]) {
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
    }

    /// Entries by node, without their places: a counting sort.
    fn sort_entries(&mut self, pattern: &SymmetricPattern, inverse: &[u32], owner: &[u32]) {
        let below = |j: usize| {
            let ends = &pattern.column_pointers()[j..j + 2];
            // the diagonal comes first
            ends[0] as usize + 1..ends[1] as usize
        };
        let mut starts = vec![0_u32; self.nodes.len() + 1];
        for (j, &b) in inverse.iter().enumerate() {
            for &i in &pattern.row_indices()[below(j)] {
                let column = inverse[i as usize].min(b);
                starts[owner[column as usize] as usize + 1] += 1;
            }
        }
        for (k, node) in self.nodes.iter_mut().enumerate() {
            starts[k + 1] += starts[k];
            node.entries = starts[k] as usize..starts[k + 1] as usize;
        }
        let blank = Entry {
            position: 0,
            row: 0,
            column: 0,
            place: 0,
        };
        self.entries
            .resize(pattern.stored() - pattern.dimension(), blank);
        for (j, &b) in inverse.iter().enumerate() {
            for k in below(j) {
                let a = inverse[pattern.row_indices()[k] as usize];
                let column = a.min(b);
                let next = &mut starts[owner[column as usize] as usize];
                self.entries[*next as usize] = Entry {
                    position: k as u32,
                    row: a.max(b),
                    column,
                    place: 0,
                };
                *next += 1;
            }
        }
    }

    /// Rows of the fronts, from the entries of each node and the rows of its children, and the places of entries and
    /// children in them. `None` if a front exceeds the index range.
    fn add_rows(&mut self, supernodes: &[Supernode], owner: &[u32]) -> Option<()> {
        const NONE: u32 = u32::MAX;
        // last node that saw a row; then the row's place in the front in work
        let mut seen = vec![NONE; owner.len()];
        let mut local = vec![0_u32; owner.len()];
        // children of each node as linked lists
        let mut child = vec![NONE; supernodes.len()];
        let mut sibling = vec![NONE; supernodes.len()];
        for (k, supernode) in supernodes.iter().enumerate() {
            let name = k as u32;
            let (first, end) = (supernode.first as u32, supernode.end as u32);
            let start = self.rows.len();
            let columns = supernode.end - supernode.first;
            self.rows.extend(first..end);
            for entry in &self.entries[self.nodes[k].entries.clone()] {
                if entry.row >= end && seen[entry.row as usize] != name {
                    seen[entry.row as usize] = name;
                    self.rows.push(entry.row);
                }
            }
            let mut next = child[k];
            while next != NONE {
                let node = &self.nodes[next as usize];
                for place in node.rows.start + node.columns..node.rows.end {
                    let row = self.rows[place];
                    if row >= end && seen[row as usize] != name {
                        seen[row as usize] = name;
                        self.rows.push(row);
                    }
                }
                next = sibling[next as usize];
            }
            self.rows[start + columns..].sort_unstable();
            let rows = &self.rows[start..];
            debug_assert_eq!(rows.len(), columns + supernode.below);
            let stride = padded(rows.len());
            u32::try_from(stride * rows.len()).ok()?;
            for (place, &row) in rows.iter().enumerate() {
                local[row as usize] = place as u32;
            }
            for entry in &mut self.entries[self.nodes[k].entries.clone()] {
                entry.place = (entry.column - first) * stride as u32 + local[entry.row as usize];
            }
            // every row of a child is a column or a row of its parent
            let mut next = child[k];
            while next != NONE {
                let node = &mut self.nodes[next as usize];
                node.parent_places = self.parent_places.len();
                let below = &self.rows[node.rows.start + node.columns..node.rows.end];
                self.parent_places
                    .extend(below.iter().map(|&row| local[row as usize]));
                self.nodes[k].children += 1;
                next = sibling[next as usize];
            }
            if let Some(&row) = rows.get(columns) {
                let parent = owner[row as usize] as usize;
                sibling[k] = child[parent];
                child[parent] = name;
            }
        }
        Some(())
    }
}

/// The approximate minimum degree order, `order[new] = old`, and its inverse. `None` without memory for it.
fn minimum_degree(pattern: &SymmetricPattern) -> Option<(Vec<u32>, Vec<u32>)> {
    let n = pattern.dimension();
    let lower = SymbolicSparseColMatRef::new_checked(
        n,
        n,
        pattern.column_pointers(),
        None,
        pattern.row_indices(),
    );
    let (mut order, mut place) = (vec![0_u32; n], vec![0_u32; n]);
    let scratch = amd::order_maybe_unsorted_scratch::<u32>(n, pattern.stored());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    amd::order_maybe_unsorted(
        &mut order,
        &mut place,
        lower,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .ok()?;
    Some((order, place))
}

/// Column pointers and rows of the upper triangle of the permuted matrix, the diagonal left out.
fn upper_triangle(pattern: &SymmetricPattern, place: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let n = place.len();
    let entries = |visit: &mut dyn FnMut(u32, u32)| {
        for (j, ends) in pattern.column_pointers().windows(2).enumerate() {
            for &i in &pattern.row_indices()[ends[0] as usize + 1..ends[1] as usize] {
                let (a, b) = (place[i as usize], place[j]);
                visit(a.min(b), a.max(b));
            }
        }
    };
    let mut pointers = vec![0_u32; n + 2];
    // one ahead, so that filling the columns moves the starts into place
    entries(&mut |_, column| pointers[column as usize + 2] += 1);
    for j in 0..n {
        pointers[j + 2] += pointers[j + 1];
    }
    let mut rows = vec![0_u32; pattern.stored() - n];
    entries(&mut |row, column| {
        let next = &mut pointers[column as usize + 1];
        rows[*next as usize] = row;
        *next += 1;
    });
    pointers.truncate(n + 1);
    (pointers, rows)
}

/// Parents in the elimination tree, negative at roots, and numbers of entries of the factor below the diagonal of each
/// column. `None` without memory for it.
fn elimination_tree(
    n: usize,
    (pointers, rows): &(Vec<u32>, Vec<u32>),
) -> Option<(Vec<i32>, Vec<u32>)> {
    let upper = SymbolicSparseColMatRef::new_unsorted_checked(n, n, pointers, None, rows);
    let (mut parents, mut counts) = (vec![0_i32; n], vec![0_u32; n]);
    let scratch = prefactorize_symbolic_cholesky_scratch::<u32>(n, rows.len());
    let mut memory = MemBuffer::try_new(scratch).ok()?;
    prefactorize_symbolic_cholesky::<u32>(
        &mut parents,
        &mut counts,
        upper,
        MemStack::new(&mut memory),
    );
    // counts include the diagonal
    for count in &mut counts {
        *count -= 1;
    }
    Some((parents, counts))
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
