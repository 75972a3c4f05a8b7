//! What each contact does in each element, read off a relaxed point.

use super::{SUMS, Transcription};

/// Factor of `sqrt(sigma)` below which both sides of a relaxed pair count as zero: at `x_i x_j = sigma` the
/// smaller one is at most `sqrt(sigma)`.
const BOTH_ZERO: f64 = 3.0;

impl Transcription<'_> {
    /// Which paired variables, and which terms of paired sums, vanish near `x`.
    ///
    /// An element is free (`beta = 0`), jumps (`alpha = 0`) or is in contact (`lp = ln = 0`), it slides one way
    /// (`b+ = 0` or `b- = 0`) or sticks (`c+ = c- = 0`), falls or rises: what vanishes in
    /// a stage vanishes in all of the element, terms with their sum, since a sum of zero leaves its
    /// nonnegative terms no interior. For the same reason both sides of a pair vanish where the mode leaves
    /// neither of them free: `p` and `w` in contact, `ln` in a jump that begins at gap zero.
    /// Not so at the end of an element without a stage there: the scheme keeps `v_n = 0` at stages only.
    pub(super) fn mark_vanishing(&self, x: &[f64], vanishes: &mut [bool]) {
        let largest = self
            .pairs
            .iter()
            .map(|&(i, j)| x[i] * x[j])
            .fold(0.0, f64::max);
        let zero = BOTH_ZERO * largest.sqrt();
        for e in 0..self.elements.len() {
            for group in 0..self.groups.len() {
                let first = self.elements[e].sums + SUMS * group;
                for pair in [0, 2] {
                    let (step, multiplier) = (first + pair, first + pair + 1);
                    if x[step] < x[multiplier] || x[step] <= zero && x[multiplier] <= zero {
                        self.mark_sum(e, group, pair, vanishes);
                    }
                    if x[step] >= x[multiplier] || x[multiplier] <= zero {
                        self.mark_sum(e, group, pair + 1, vanishes);
                    }
                }
            }
        }
        for block in self.elements.iter().flat_map(|element| &element.blocks) {
            for (first, second) in self.dcs.stage_pairs() {
                let pair = (block.variables[first], block.variables[second]);
                if let (Some(p), Some(w)) = pair {
                    let both = !block.boundary && x[p].max(x[w]) <= zero;
                    vanishes[p] |= x[p] < x[w] || both;
                    vanishes[w] |= x[w] <= x[p] || both;
                }
            }
        }
    }

    /// Marks a sum and its terms.
    fn mark_sum(&self, e: usize, group: usize, sum: usize, vanishes: &mut [bool]) {
        vanishes[self.elements[e].sums + SUMS * group + sum] = true;
        for variable in self.sum_variables(e, group, sum) {
            vanishes[variable] = true;
        }
    }
}
