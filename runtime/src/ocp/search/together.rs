//! Many neighbours of the best motion in one program.
//!
//! A motion that keeps at the edge of a friction cone, or in a contact without force, has a neighbour for every interval: there a
//! slip or a flight may be inserted. One program has all of these phases, each held at its least length, which is as good as none
//! only up to that length: hence the tolerance of the comparison with the best. In the limit its multipliers fulfil the first
//! order conditions of each neighbour alone, so that every `z` of a held length that is at least 0 decides a neighbour
//! ([`stationary`](super::stationary)); the others are asked one by one. A cut in an interval with further phases has no place
//! any more. With fewer conditions the program allows more, so that what is stationary in it is so with them.

use std::ops::RangeInclusive;

use super::attempt::{Attempt, Attempts, Verdict};
use super::stationary::{none, slope, solved};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::program::runner::Runner;
use crate::ocp::tuning::neighbours::{BETWEEN, PRECISION};
use crate::simulation::InputError;

/// A neighbour with all switches of the best, and others.
pub(super) struct Insertion<'s> {
    sequence: &'s Sequence,
    switches: Vec<Switch>,
    /// Where these are.
    intervals: RangeInclusive<usize>,
}

impl<'s> Insertion<'s> {
    /// `None` if the neighbour is of another kind.
    pub(super) fn of(sequence: &'s Sequence, best: &Sequence) -> Option<Self> {
        let starts_alike =
            (&sequence.initially, &sequence.pieces) == (&best.initially, &best.pieces);
        let others = |switch: &&Switch| !best.switches.contains(switch);
        let switches: Vec<Switch> = sequence.switches.iter().filter(others).copied().collect();
        let intervals = switches.first()?.interval..=switches.last()?.interval;
        let has_all = sequence.switches.len() == best.switches.len() + switches.len();
        (starts_alike && has_all).then_some(Self {
            sequence,
            switches,
            intervals,
        })
    }
}

/// Asks for these neighbours of the best, whose sequence is `around`, as many at once as have their phases apart from each
/// other, and keeps what is decided.
pub(super) fn learn_together(
    attempts: &mut Attempts,
    runner: &mut Runner,
    mut insertions: Vec<Insertion>,
    around: Attempt,
) -> Result<(), InputError> {
    while insertions.len() > 1 && !runner.is_exhausted() {
        let mut taken = vec![false; attempts.setting.problem.intervals + 1];
        let (round, left) = insertions.into_iter().partition(|insertion| {
            let (first, last) = (*insertion.intervals.start(), *insertion.intervals.end());
            let free = !taken[first..=last].contains(&true);
            if free {
                let from = first.saturating_sub(BETWEEN);
                let to = (last + BETWEEN).min(taken.len() - 1);
                taken[from..=to].fill(true);
            }
            free
        });
        insertions = left;
        if round.len() == 1 {
            continue;
        }
        for relaxed in [false, true] {
            if learn_round(attempts, runner, &round, around, relaxed)? {
                break;
            }
        }
    }
    Ok(())
}

/// Whether the program of a round led to the best, so that it says something about its neighbours.
fn learn_round(
    attempts: &mut Attempts,
    runner: &mut Runner,
    round: &[Insertion],
    around: Attempt,
    relaxed: bool,
) -> Result<bool, InputError> {
    let mut sequence = around.sequence.clone();
    let inserted = round.iter().flat_map(|insertion| &insertion.switches);
    sequence.switches.extend(inserted);
    let sequence = sequence.ordered(attempts.setting.problem.intervals);
    let Some(sequence) = sequence else {
        return Ok(true);
    };
    let attempt = Attempt {
        sequence: &sequence,
        ..around
    };
    let solved = solved(attempts, runner, attempt, relaxed)?;
    let Some((program, lengths, Ok(solution))) = solved else {
        return Ok(false);
    };
    let none = none(&program, solution.objective);
    let best = attempts.best_objective();
    let lower = PRECISION * none;
    let Some(best) = best.filter(|best| (-lower..=none).contains(&(solution.objective - best)))
    else {
        return Ok(false);
    };
    for insertion in round {
        let own = program.phases.iter().filter(|phase| {
            lengths.contains(&phase.scale) && insertion.intervals.contains(&phase.interval)
        });
        let slopes = own.map(|phase| slope(attempts, &program, &solution, phase.scale));
        if slopes.reduce(f64::min).is_some_and(|least| least >= -none) {
            attempts.learn(insertion.sequence, Verdict::NotBetter(best));
        }
    }
    Ok(true)
}
