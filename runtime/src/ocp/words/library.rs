//! What motions went through between two phases with the same modes: cycles that words are given where their solutions press.

use super::word::{Instant, Word};
use crate::ocp::tuning::beginnings::LONGEST_CYCLE;
use crate::simulation::ContactMode;

/// Instants that lead from modes of all contacts back to the same, and how often that was seen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cycle {
    pub(super) modes: Vec<ContactMode>,
    pub(super) instants: Vec<Instant>,
    pub(super) seen: usize,
}

/// The cycles that were seen, in the order in which they were first.
#[derive(Debug, Default)]
pub(in crate::ocp) struct Library {
    cycles: Vec<Cycle>,
}

impl Library {
    /// Adds what a motion with this word went through.
    pub(super) fn learn(&mut self, word: &Word) {
        let modes = word.modes();
        for from in 0..word.instants.len() {
            let last = (from + LONGEST_CYCLE).min(word.instants.len());
            for to in (from + 1..=last).filter(|&to| modes[to] == modes[from]) {
                self.add(&modes[from], &word.instants[from..to]);
            }
        }
    }

    fn add(&mut self, modes: &[ContactMode], instants: &[Instant]) {
        let mut known = self.cycles.iter_mut();
        match known.find(|cycle| cycle.modes == modes && cycle.instants == instants) {
            Some(cycle) => cycle.seen += 1,
            None => self.cycles.push(Cycle {
                modes: modes.to_vec(),
                instants: instants.to_vec(),
                seen: 1,
            }),
        }
    }

    /// The cycles that begin and end with these modes.
    pub(super) fn cycles<'l>(
        &'l self,
        modes: &'l [ContactMode],
    ) -> impl Iterator<Item = &'l Cycle> {
        self.cycles.iter().filter(move |cycle| cycle.modes == modes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::word::between;
    use super::*;
    use crate::model::Pieces;

    #[test]
    fn hop_is_a_cycle_of_two_instants_and_is_counted() {
        let (on, off) = ([ContactMode::Frictionless], [ContactMode::Open]);
        let instants = [between(&on, &off), between(&off, &on)];
        let word = Word {
            initially: on.to_vec(),
            pieces: Pieces::default(),
            instants: instants.iter().chain(&instants).cloned().collect(),
            ends_with_impact: false,
        };
        let mut library = Library::default();
        library.learn(&word);
        let hops: Vec<&Cycle> = library
            .cycles(&on)
            .filter(|cycle| cycle.instants.len() == 2)
            .collect();
        assert_eq!(hops.len(), 1);
        assert_eq!((hops[0].seen, &hops[0].instants[..]), (2, &instants[..]));
        // From the top to the top as well, once.
        let flights: Vec<usize> = library.cycles(&off).map(|cycle| cycle.seen).collect();
        assert_eq!(flights, [1]);
    }
}
