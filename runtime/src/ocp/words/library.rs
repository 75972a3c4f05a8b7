//! What motions went through between two modes: the words of the search are made of that.

use super::word::{Instant, Word};
use crate::ocp::motion::sequence::Switch;
use crate::simulation::ContactMode;

/// Most instants of a cycle or a walk.
const LONGEST: usize = 4;

/// Instants that lead from modes of all contacts to others, or back to the same, and how often that was seen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Walk {
    pub(super) from: Vec<ContactMode>,
    pub(super) to: Vec<ContactMode>,
    pub(super) instants: Vec<Instant>,
    pub(super) seen: usize,
}

/// The walks between modes that were seen, in the order in which they were first.
#[derive(Debug, Default)]
pub(in crate::ocp) struct Library {
    pub(super) walks: Vec<Walk>,
}

impl Library {
    /// Adds what a motion with this word went through.
    pub(super) fn learn(&mut self, word: &Word) {
        let modes = word.modes();
        for from in 0..word.instants.len() {
            for to in from + 1..=(from + LONGEST).min(word.instants.len()) {
                self.add(&modes[from], &modes[to], &word.instants[from..to]);
            }
        }
    }

    fn add(&mut self, from: &[ContactMode], to: &[ContactMode], instants: &[Instant]) {
        let passes = |switch: &Switch| switch.passes;
        // Where edges are passed, which pieces act depends on more than the modes.
        if instants.iter().flatten().any(passes) && from != to {
            return;
        }
        let known = self
            .walks
            .iter_mut()
            .find(|walk| walk.from == from && walk.to == to && walk.instants == instants);
        match known {
            Some(walk) => walk.seen += 1,
            None => self.walks.push(Walk {
                from: from.to_vec(),
                to: to.to_vec(),
                instants: instants.to_vec(),
                seen: 1,
            }),
        }
    }

    /// The cycles that begin and end with these modes.
    pub(super) fn cycles<'l>(&'l self, modes: &'l [ContactMode]) -> impl Iterator<Item = &'l Walk> {
        self.between(modes, modes)
    }

    /// The walks from these modes to those.
    pub(super) fn between<'l>(
        &'l self,
        from: &'l [ContactMode],
        to: &'l [ContactMode],
    ) -> impl Iterator<Item = &'l Walk> {
        self.walks
            .iter()
            .filter(move |walk| walk.from == from && walk.to == to)
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
        let hops: Vec<&Walk> = library
            .cycles(&on)
            .filter(|walk| walk.instants.len() == 2)
            .collect();
        assert_eq!(hops.len(), 1);
        assert_eq!((hops[0].seen, &hops[0].instants[..]), (2, &instants[..]));
        assert!(
            library
                .between(&on, &off)
                .any(|walk| walk.instants.len() == 1)
        );
    }
}
