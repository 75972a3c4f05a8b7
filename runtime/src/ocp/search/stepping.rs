//! Gaits: contact sequences in which surfaces are left and struck in turn.
//!
//! A walk is a contact sequence that random motions seldom lead to, and no neighbour of a jump. So sequences are made up in which one
//! surface, or two in turn, are left and struck again, or, where they are open at first, struck and left. When that has to be is up to the
//! program with intervals of free lengths (`free_lengths.rs`), which asks little of a guess.

use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::start_modes::modes_at_start;
use crate::ocp::motion::mode::{closed_mode, is_frictional};
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::tuning::candidates::BEGINS;
use crate::simulation::ContactMode;

/// The sequences of all gaits for which there are intervals enough, those of fewer steps first.
pub(in crate::ocp) fn stepping(setting: Setting, guess: &Trajectory) -> Vec<Sequence> {
    let model = setting.model;
    let contacts = model.declaration().contacts.iter().enumerate();
    let surfaces = contacts.filter(|(_, contact)| !contact.dry);
    let surfaces: Vec<usize> = surfaces.map(|(contact, _)| contact).collect();
    let standing = Sequence::without_switches(modes_at_start(setting, guess));
    let closed = |contact: usize| closed_mode(is_frictional(model, contact), 0.0, 0.0);
    let intervals = setting.problem.intervals;
    let gaits = gaits(&surfaces).into_iter();
    let sequences = gaits.map(|gait| with_steps(&standing, &gait, closed, intervals));
    let ordered = sequences.filter_map(|sequence| sequence.ordered(intervals));
    ordered.collect()
}

/// A sequence with steps of these surfaces, one after the other, each in its part of the time: off and on again, or the other way round
/// where the surface is open at first.
fn with_steps(
    standing: &Sequence,
    gait: &[usize],
    closed: impl Fn(usize) -> ContactMode,
    intervals: usize,
) -> Sequence {
    let part = intervals as f64 / gait.len() as f64;
    let mut sequence = standing.clone();
    for (step, &contact) in gait.iter().enumerate() {
        let [begins, ends] = [BEGINS, 1.0 - BEGINS].map(|share| (step as f64 + share) * part);
        let flies = standing.initially[contact].is_open();
        let (off, on) = if flies {
            (ends, begins)
        } else {
            (begins, ends)
        };
        let off = Switch {
            place: Place::Start,
            ..Switch::inside(contact, false, ContactMode::Open, off.round().max(1.0))
        };
        let mode = closed(contact);
        let on = Switch {
            impulse: mode,
            ..Switch::inside(contact, true, mode, on)
        };
        sequence
            .switches
            .extend(if flies { [on, off] } else { [off, on] });
    }
    sequence
}

/// Surfaces that step, one after the other: each alone, two in turn, each twice, two in turn twice.
fn gaits(surfaces: &[usize]) -> Vec<Vec<usize>> {
    let alone = surfaces.iter().map(|&one| vec![one]);
    let in_turn = || {
        surfaces.iter().flat_map(|&one| {
            let others = surfaces.iter().filter(move |&&other| other != one);
            others.map(move |&other| vec![one, other])
        })
    };
    let twice = |gait: Vec<usize>| gait.repeat(2);
    let all = alone.clone().chain(in_turn());
    all.chain(alone.map(twice))
        .chain(in_turn().map(twice))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;

    #[test]
    fn two_feet_step_alone_in_turn_and_twice() {
        let all = gaits(&[3, 5]);
        let in_turn = [vec![3, 5], vec![5, 3]];
        assert_eq!(
            all[..4],
            [vec![vec![3], vec![5]], in_turn.to_vec()].concat()
        );
        assert_eq!(all[4..6], [vec![3, 3], vec![5, 5]]);
        assert_eq!(all[6..], [vec![3, 5, 3, 5], vec![5, 3, 5, 3]]);
        assert_eq!(gaits(&[0]), [vec![0], vec![0, 0]]);
    }

    #[test]
    fn foot_that_stands_is_lifted_at_the_end_of_an_interval_and_one_in_the_air_is_set_down() {
        let standing = Sequence {
            initially: vec![ContactMode::Stick, ContactMode::Open],
            pieces: Pieces::default(),
            switches: Vec::new(),
        };
        let walk = with_steps(&standing, &[0, 1], |_| ContactMode::Stick, 10);
        let switches = walk.switches.iter();
        let steps: Vec<(usize, bool, f64)> =
            switches.map(|s| (s.contact, s.closes, s.time)).collect();
        let expected = [
            (0, false, 1.0),
            (0, true, 3.75),
            (1, true, 6.25),
            (1, false, 9.0),
        ];
        assert_eq!(steps, expected);
        assert!(walk.ordered(10).is_some());
        // The first end of an interval is that of the motion.
        let hop = with_steps(&standing, &[0], |_| ContactMode::Stick, 1);
        assert!(hop.ordered(1).is_none());
    }
}
