//! What each contact does in each element, read off a relaxed point.

use super::{SUMS, Transcription};
use crate::dcs::{P, W};

/// Factor of `sqrt(sigma)` below which both sides of a relaxed pair count as zero: at `x_i x_j = sigma` the
/// smaller one is at most `sqrt(sigma)`.
const BOTH_ZERO: f64 = 3.0;

impl Transcription<'_> {
    /// Which paired variables, and which terms of paired sums, vanish near `x`.
    ///
    /// An element is free (`beta = 0`), jumps (`alpha = 0`) or is in contact (`lp = ln = 0`): what vanishes in
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
            for contact in 0..self.dcs.contacts() {
                let first = self.elements[e].sums + SUMS * contact;
                for pair in [0, 2] {
                    let (step, multiplier) = (first + pair, first + pair + 1);
                    if x[step] < x[multiplier] || x[step] <= zero && x[multiplier] <= zero {
                        self.mark_sum(e, contact, pair, vanishes);
                    }
                    if x[step] >= x[multiplier] || x[multiplier] <= zero {
                        self.mark_sum(e, contact, pair + 1, vanishes);
                    }
                }
            }
        }
        for block in self.elements.iter().flat_map(|element| &element.blocks) {
            for contact in 0..self.dcs.contacts() {
                let place = |offset| block.variables[self.dcs.algebraic(contact, offset)];
                if let (Some(p), Some(w)) = (place(P), place(W)) {
                    let both = !block.boundary && x[p].max(x[w]) <= zero;
                    vanishes[p] |= x[p] < x[w] || both;
                    vanishes[w] |= x[w] <= x[p] || both;
                }
            }
        }
    }

    /// Marks a sum and its terms.
    fn mark_sum(&self, e: usize, contact: usize, sum: usize, vanishes: &mut [bool]) {
        vanishes[self.elements[e].sums + SUMS * contact + sum] = true;
        for variable in self.sum_variables(e, contact, sum) {
            vanishes[variable] = true;
        }
    }
}
