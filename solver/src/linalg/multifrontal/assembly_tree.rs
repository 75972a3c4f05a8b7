//! The assembly tree: columns of the elimination tree merged into supernodes.

const NONE: u32 = u32::MAX;

/// Most columns of a node that still takes in a child: inside a front elimination is not blocked.
const LARGEST: usize = 64;

/// Columns `first..end` of the permuted matrix with the number of rows below them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Supernode {
    pub(crate) first: usize,
    pub(crate) end: usize,
    pub(crate) below: usize,
}

/// Supernodes in postorder, with the columns of each in the order of elimination.
#[derive(Debug, Clone)]
pub(crate) struct AssemblyTree {
    /// Columns (names before the postorder), node after node.
    pub(crate) columns: Vec<u32>,
    /// Number of columns of each node.
    lengths: Vec<u32>,
}

/// A node during merging; it bears the name of its last column.
#[derive(Debug, Clone, Copy)]
struct Growing {
    /// First column of its linked list, and its last child.
    head: u32,
    child: u32,
    columns: u32,
    below: u32,
}

/// Half nanoseconds, roughly, to build and eliminate a front: a constant for finding its places, one for each
/// multiplication and one for each entry of the Schur complement that moves to the parent.
fn cost(columns: usize, below: usize) -> f64 {
    let (k, h) = (columns as f64, (columns + below) as f64);
    let multiplications = k * h * h - k * k * h + k * k * k / 3.0;
    FRONT + multiplications + (below * below) as f64
}

/// Cost of a front whatever its size.
const FRONT: f64 = 150.0;

impl AssemblyTree {
    /// Merges nodes with their parents wherever that lowers the [`cost`]; column `j` of the factor has `below[j]` entries
    /// below its diagonal, and `parent(j)` is the parent of `j` in the elimination tree.
    pub(crate) fn new(below: &[u32], parent: impl Fn(usize) -> Option<usize>) -> Self {
        let n = below.len();
        let mut nodes: Vec<Growing> = (0..n)
            .map(|j| Growing {
                head: j as u32,
                child: NONE,
                columns: 1,
                below: below[j],
            })
            .collect();
        // linked lists: next column of a node, next sibling of a child
        let mut next = vec![NONE; n];
        let mut sibling = vec![NONE; n];
        let mut roots = Vec::new();
        for j in 0..n {
            let mut child = nodes[j].child;
            nodes[j].child = NONE;
            while child != NONE {
                let c = child as usize;
                child = sibling[c];
                let (node, other) = (nodes[j], nodes[c]);
                let (columns, rows) = (node.columns as usize, node.below as usize);
                let merged = columns + other.columns as usize;
                let apart =
                    cost(columns, rows) + cost(other.columns as usize, other.below as usize);
                if merged <= LARGEST && cost(merged, rows) <= apart {
                    // the child's columns are eliminated first, and its children become children of the node
                    next[c] = node.head;
                    nodes[j].head = other.head;
                    nodes[j].columns = merged as u32;
                    let mut grandchild = other.child;
                    while grandchild != NONE {
                        let after = sibling[grandchild as usize];
                        sibling[grandchild as usize] = nodes[j].child;
                        nodes[j].child = grandchild;
                        grandchild = after;
                    }
                } else {
                    sibling[c] = nodes[j].child;
                    nodes[j].child = c as u32;
                }
            }
            match parent(j) {
                Some(parent) => {
                    sibling[j] = nodes[parent].child;
                    nodes[parent].child = j as u32;
                }
                None => roots.push(j as u32),
            }
        }
        Self::postorder(&nodes, &next, &sibling, &roots)
    }

    fn postorder(nodes: &[Growing], next: &[u32], sibling: &[u32], roots: &[u32]) -> Self {
        let mut tree = Self {
            columns: Vec::with_capacity(nodes.len()),
            lengths: Vec::new(),
        };
        let mut waiting: Vec<u32> = nodes.iter().map(|node| node.child).collect();
        let mut stack = Vec::new();
        for &root in roots {
            stack.push(root);
            while let Some(&top) = stack.last() {
                let child = waiting[top as usize];
                if child == NONE {
                    stack.pop();
                    let mut column = nodes[top as usize].head;
                    loop {
                        tree.columns.push(column);
                        if column == top {
                            break;
                        }
                        column = next[column as usize];
                    }
                    tree.lengths.push(nodes[top as usize].columns);
                } else {
                    waiting[top as usize] = sibling[child as usize];
                    stack.push(child);
                }
            }
        }
        tree
    }

    /// The nodes in the order of elimination.
    pub(crate) fn supernodes(&self, below: &[u32]) -> Vec<Supernode> {
        let mut first = 0;
        let node = |&length: &u32| {
            let end = first + length as usize;
            // every row of an earlier column is among the columns or below the last one
            let below = below[self.columns[end - 1] as usize] as usize;
            let node = Supernode { first, end, below };
            first = end;
            node
        };
        self.lengths.iter().map(node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows below each column of the factor, from the pattern of the strict lower triangle by columns.
    fn fill(mut below: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
        for j in 0..below.len() {
            below[j].sort_unstable();
            below[j].dedup();
            if let Some((&parent, others)) = below[j].clone().split_first() {
                below[parent].extend_from_slice(others);
            }
        }
        below
    }

    fn within(mut rows: Vec<usize>, n: usize) -> Vec<usize> {
        rows.retain(|&i| i < n);
        rows
    }

    fn counts(below: &[Vec<usize>]) -> Vec<u32> {
        below.iter().map(|rows| rows.len() as u32).collect()
    }

    #[test]
    fn new_children_come_before_parents_and_every_column_once() {
        // a long chain with a leaf at every second link
        let n = 400;
        let above = |j: usize| j + 1 + j % 2;
        let below = fill((0..n).map(|j| within(vec![above(j)], n)).collect());
        let tree = AssemblyTree::new(&counts(&below), |j| below[j].first().copied());
        let mut place = vec![usize::MAX; n];
        for (new, &old) in tree.columns.iter().enumerate() {
            assert_eq!(place[old as usize], usize::MAX);
            place[old as usize] = new;
        }
        for j in 0..n {
            for &i in &below[j] {
                assert!(place[j] < place[i], "{j} is eliminated after {i}");
            }
        }
        // merging pays: far fewer nodes than columns
        assert!(tree.lengths.len() < n / 4, "{}", tree.lengths.len());
    }

    #[test]
    fn supernodes_hold_the_rows_of_all_their_columns() {
        let n = 60;
        let below = fill((0..n).map(|j| within(vec![j + 1, j + 7], n)).collect());
        let counts = counts(&below);
        let tree = AssemblyTree::new(&counts, |j| below[j].first().copied());
        let mut next = 0;
        for node in tree.supernodes(&counts) {
            assert_eq!(node.first, next);
            next = node.end;
            let columns = &tree.columns[node.first..node.end];
            let last = columns[columns.len() - 1] as usize;
            assert_eq!(node.below, below[last].len());
            for &column in columns {
                let inside = |i: &usize| columns.contains(&(*i as u32)) || below[last].contains(i);
                assert!(below[column as usize].iter().all(inside));
            }
        }
        assert_eq!(next, n);
    }

    #[test]
    fn cost_one_column_counts_its_square_and_the_complement() {
        // height 3: 9 - 3 + 1/3 multiplications, 4 entries move
        assert!((cost(1, 2) - (FRONT + 9.0 - 3.0 + 1.0 / 3.0 + 4.0)).abs() < 1e-12);
    }
}
