//! Elimination tree, supernodes and row structures.

use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};

use crate::linalg::{FactorizationError, SymmetricPattern};

/// A node of the assembly tree.
#[derive(Debug, Clone)]
pub(crate) struct Supernode {
    /// Its columns, in elimination order.
    pub(crate) first: usize,
    pub(crate) end: usize,
    /// Rows below the columns, increasing.
    pub(crate) rows: Vec<usize>,
    /// Number of children; in postorder they are the last that many open nodes.
    pub(crate) children: usize,
    pub(crate) is_root: bool,
}

/// An entry of the pattern in the permuted matrix, row >= column. Half the width of `usize` keeps the scans
/// over all entries short.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// Position in the value array of the pattern.
    pub(crate) position: u32,
    pub(crate) row: u32,
    pub(crate) column: u32,
}

/// Everything that depends on the pattern alone.
#[derive(Debug, Clone)]
pub(crate) struct Symbolic {
    /// `permutation[new] = old`.
    pub(crate) permutation: Vec<usize>,
    pub(crate) nodes: Vec<Supernode>,
    /// Entries of the pattern by the column that is eliminated first, with the start of each column.
    pub(crate) entries: Vec<Entry>,
    pub(crate) entry_starts: Vec<usize>,
}

const NONE: usize = usize::MAX;

impl Symbolic {
    pub(crate) fn new(pattern: &SymmetricPattern) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        if u32::try_from(pattern.stored()).is_err() {
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
        let column = |j: usize| &factor.row_idx()[factor.col_ptr()[j]..factor.col_ptr()[j + 1]];
        let parent: Vec<usize> = (0..n)
            .map(|j| column(j).get(1).copied().unwrap_or(NONE))
            .collect();

        let post = postorder(&parent);
        let mut position = vec![0; n];
        for (new, &old) in post.iter().enumerate() {
            position[old] = new;
        }
        let permutation: Vec<usize> = post.iter().map(|&j| order[j]).collect();
        let parent: Vec<usize> = post
            .iter()
            .map(|&j| match parent[j] {
                NONE => NONE,
                p => position[p],
            })
            .collect();
        let structure = |j: usize| -> Vec<usize> {
            let mut rows: Vec<usize> = column(post[j])[1..].iter().map(|&i| position[i]).collect();
            rows.sort_unstable();
            rows
        };
        let nodes = supernodes(n, &parent, &structure);

        let mut inverse = vec![0; n];
        for (new, &old) in permutation.iter().enumerate() {
            inverse[old] = new;
        }
        let mut entries = Vec::with_capacity(pattern.stored());
        for j in 0..n {
            for k in pattern.column_pointers()[j]..pattern.column_pointers()[j + 1] {
                let (a, b) = (inverse[pattern.row_indices()[k]], inverse[j]);
                entries.push(Entry {
                    position: k as u32,
                    row: a.max(b) as u32,
                    column: a.min(b) as u32,
                });
            }
        }
        entries.sort_unstable_by_key(|entry| (entry.column, entry.row));
        let mut entry_starts = vec![0; n + 1];
        for entry in &entries {
            entry_starts[entry.column as usize + 1] += 1;
        }
        for j in 0..n {
            entry_starts[j + 1] += entry_starts[j];
        }
        Ok(Self {
            permutation,
            nodes,
            entries,
            entry_starts,
        })
    }
}

/// Postorder of a forest given by parents.
fn postorder(parent: &[usize]) -> Vec<usize> {
    let n = parent.len();
    let mut first_child = vec![NONE; n];
    let mut sibling = vec![NONE; n];
    let mut roots = Vec::new();
    for j in (0..n).rev() {
        if parent[j] == NONE {
            roots.push(j);
        } else {
            sibling[j] = first_child[parent[j]];
            first_child[parent[j]] = j;
        }
    }
    roots.reverse();
    let mut order = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in roots {
        stack.push(root);
        while let Some(&top) = stack.last() {
            let child = first_child[top];
            if child == NONE {
                stack.pop();
                order.push(top);
            } else {
                first_child[top] = sibling[child];
                stack.push(child);
            }
        }
    }
    order
}

/// Whether merging a child of `child_columns` columns and `child_rows` rows below into its parent of
/// `columns` and `rows` pays: no or few zeros, or a child too small to be worth a front of its own.
fn merges(child_columns: usize, child_rows: usize, columns: usize, rows: usize) -> bool {
    let added = columns + rows - child_rows;
    let zeros = child_columns * added;
    added == 0
        || child_columns < 4
        || (child_columns < 16 && zeros * 5 < (columns + child_columns) * (columns + rows))
        || zeros * 20 < (columns + child_columns) * (columns + rows)
}

/// Fundamental supernodes, then merged with their parents where [`merges`] says so.
fn supernodes(
    n: usize,
    parent: &[usize],
    structure: &dyn Fn(usize) -> Vec<usize>,
) -> Vec<Supernode> {
    let mut nodes: Vec<Supernode> = Vec::new();
    // nodes whose parent column has not come yet, as a stack; postorder keeps children on top
    for (j, &above) in parent.iter().enumerate() {
        let rows = structure(j);
        let mut node = Supernode {
            first: j,
            end: j + 1,
            rows,
            children: 0,
            is_root: above == NONE,
        };
        // the last node is a child of j exactly if its first row below is j
        if let Some(last) = nodes.last()
            && last.rows.first() == Some(&j)
            && last.end == j
        {
            let columns = last.end - last.first;
            let own_rows = node.rows.len();
            if merges(columns, last.rows.len(), 1, own_rows) && columns < 64 {
                node.first = last.first;
                nodes.pop();
            }
        }
        nodes.push(node);
    }
    count_children(&mut nodes, n);
    nodes
}

fn count_children(nodes: &mut [Supernode], n: usize) {
    let mut owner = vec![0; n];
    for (k, node) in nodes.iter().enumerate() {
        owner[node.first..node.end].fill(k);
    }
    let parents: Vec<Option<usize>> = nodes
        .iter()
        .map(|node| node.rows.first().map(|&row| owner[row]))
        .collect();
    for parent in parents.into_iter().flatten() {
        nodes[parent].children += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postorder_children_come_before_parents() {
        // 0 and 1 are children of 3, 2 is a child of 4, 3 a child of 4
        let order = postorder(&[3, 3, 4, 4, NONE]);
        let place = |j| order.iter().position(|&k| k == j).unwrap();
        assert!(place(0) < place(3) && place(1) < place(3));
        assert!(place(2) < place(4) && place(3) < place(4));
    }

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
        assert!(symbolic.nodes[0].rows.is_empty());
    }
}
