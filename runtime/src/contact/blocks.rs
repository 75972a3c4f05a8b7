//! Contacts that are not coupled, taken apart: the connected components of the graph of the couplings.

/// The components of `count` contacts of which those with `coupled(i, j)` belong together, each increasing, in the order of
/// their first.
pub(crate) fn blocks(count: usize, coupled: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut block_of: Vec<Option<usize>> = vec![None; count];
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    for first in 0..count {
        if block_of[first].is_some() {
            continue;
        }
        let own = blocks.len();
        let mut block = vec![first];
        block_of[first] = Some(own);
        let mut next = 0;
        while let Some(&i) = block.get(next) {
            next += 1;
            for (j, other) in block_of.iter_mut().enumerate() {
                if other.is_none() && (coupled(i, j) || coupled(j, i)) {
                    *other = Some(own);
                    block.push(j);
                }
            }
        }
        block.sort_unstable();
        blocks.push(block);
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::blocks;

    #[test]
    fn contacts_that_are_joined_through_others_are_one_block() {
        let pairs = [(0, 3), (3, 4), (1, 5)];
        let found = blocks(6, |i, j| pairs.contains(&(i, j)));
        assert_eq!(found, [vec![0, 3, 4], vec![1, 5], vec![2]]);
    }

    #[test]
    fn no_contact_is_no_block() {
        assert!(blocks(0, |_, _| true).is_empty());
    }
}
