//! Conditions that set velocities where they come true: between two elements.

use super::laid_out::spans_of_elements;
use super::names;
use super::task::Guess;
use super::transcription::{Transcription, Turn};
use crate::model::Function;
use crate::program::kernel::Kernel;

/// Declares the pairs of all conditions: each is false or true in all of an element, and comes true where it was false and its function
/// vanishes, and where no other one sets the same.
pub(super) fn add_pairs(transcription: &mut Transcription<'_>) {
    let declared = transcription.field.model.declaration().optimal_control;
    let resets = declared.map_or(&[][..], |declared| declared.contacts.resets);
    let set_by = |condition: usize| resets.iter().filter(move |set| set.0 == condition);
    let both = |first: usize, second: usize| {
        set_by(first).any(|set| set_by(second).any(|other| other.1 == set.1))
    };
    for e in 0..transcription.elements.len() {
        for condition in transcription.field.layout.conditions.clone() {
            let held = transcription.sum_that_holds(e, condition);
            transcription.program.pair(held - 2, held);
        }
        let turns = transcription.elements[e].turns.clone();
        for (k, turn) in turns.iter().enumerate() {
            let [sets, waits] = turn.sets;
            let others = turns[..k].iter();
            for other in others.filter(|other| both(other.condition, turn.condition)) {
                transcription.program.pair(other.sets[0], sets);
            }
            let before = transcription.sum_that_holds(e - 1, turn.condition);
            let missing = missing(transcription, e, turn.condition);
            for other in [waits, before].into_iter().chain(missing) {
                transcription.program.pair(sets, other);
            }
        }
    }
}

/// The variable of what a condition misses to be true where an element starts.
fn missing(transcription: &Transcription<'_>, e: usize, condition: usize) -> Option<usize> {
    let layout = &transcription.field.layout;
    let [.., missing] = layout.groups()[layout.slip_group(condition)?].places;
    transcription.block_before(e).variables[missing]
}

/// Conditions that come true at the start of an element.
pub(crate) fn set(transcription: &Transcription<'_>, x: &[f64], e: usize) -> Vec<usize> {
    let turns = transcription.elements[e].turns.iter();
    let set = turns.filter(|turn| x[turn.sets[0]] > 0.5);
    set.map(|turn| turn.condition).collect()
}

/// Adds the rows of conditions at the start of an element, and what they set to its rows of collocation, by state.
pub(super) fn add_rows(
    transcription: &mut Transcription<'_>,
    e: usize,
    rows: &[Vec<Option<usize>>],
) {
    let model = transcription.field.model;
    let Some(declared) = model.declaration().optimal_control else {
        return;
    };
    let (terms, n) = (declared.contacts, transcription.field.coordinates());
    let before = transcription.block_before(e).clone();
    let [q, v, u] = transcription.inputs(&before);
    let share = 1.0 / transcription.tableau.stages() as f64;
    for turn in transcription.elements[e].turns.clone() {
        let Turn {
            condition, sets, ..
        } = turn;
        let own = names::contact(&transcription.field, condition);
        let [side, either] = [("side", 0.0), ("place", 1.0)]
            .map(|(what, value)| transcription.row(format!("{what} of {own}"), value));
        let [now, earlier] = [e, e - 1].map(|e| transcription.sum_that_holds(e, condition));
        let program = &mut transcription.program;
        for (row, variable, factor) in [
            (side, sets[0], 1.0),
            (side, turn.more, -1.0),
            (side, now, -share),
            (side, earlier, share),
            (either, sets[0], 1.0),
            (either, sets[1], 1.0),
        ] {
            program.linear(row, variable, factor);
        }
        let mut uses = Vec::new();
        let set = terms.resets.iter().enumerate();
        for (index, &(_, velocity)) in set.filter(|(_, set)| set.0 == condition) {
            for row in rows.iter().filter_map(|rows| rows[n + velocity]) {
                uses.push((row, terms.of_impacts() + index, -1.0));
                if let Some(value) = before.variables[n + velocity] {
                    program.product(row, &[sets[0], value], 1.0);
                }
            }
        }
        let nothing = vec![None; 2 * model.declaration().contacts.len()];
        program.block_behind(
            &Kernel::Whole(Function::Impact),
            [&q, &v, &u],
            &nothing,
            [sets[0]],
            uses,
        );
    }
}

/// Whether a condition comes true at the start of each element of a known motion.
fn known(transcription: &Transcription<'_>, condition: usize) -> Vec<bool> {
    let Guess::Known(intervals) = &transcription.task.guess else {
        return Vec::new();
    };
    let mut before = None;
    let spans = spans_of_elements(intervals, transcription.task.elements);
    let comes_true = spans.into_iter().map(|span| {
        let begins = !before
            .replace(span)
            .is_some_and(|before| std::ptr::eq(before, span));
        begins && span.sets.contains(&condition)
    });
    comes_true.collect()
}

/// Which conditions come true at the start of an element: as is known, or else by the shares there and before.
pub(super) fn set_guess(transcription: &mut Transcription<'_>, e: usize, guess: &[f64]) {
    for turn in transcription.elements[e].turns.clone() {
        let [now, earlier] =
            [e, e - 1].map(|e| guess[transcription.sum_that_holds(e, turn.condition)]);
        let rise = (now - earlier) / transcription.tableau.stages() as f64;
        let known = known(transcription, turn.condition).get(e).copied();
        let sets = known.map_or(rise.max(0.0), f64::from);
        let program = &mut transcription.program;
        program.set_guess(turn.sets[0], sets);
        program.set_guess(turn.sets[1], 1.0 - sets);
        program.set_guess(turn.more, sets - rise);
    }
}

/// Marks which conditions come true, and which are true in each element, near the relaxed point `x`.
pub(super) fn mark_vanishing(transcription: &Transcription<'_>, x: &[f64], vanishes: &mut [bool]) {
    for (e, element) in transcription.elements.iter().enumerate() {
        for &condition in &transcription.field.layout.conditions {
            let held = transcription.sum_that_holds(e, condition);
            vanishes[if x[held] < x[held - 2] {
                held
            } else {
                held - 2
            }] = true;
        }
        for turn in &element.turns {
            mark(transcription, (e, turn), x[turn.sets[0]] > 0.5, vanishes);
        }
    }
}

/// Marks which conditions come true in a known motion, and returns what has no sign as nothing is to be decided.
pub(super) fn mark_known(transcription: &Transcription<'_>, vanishes: &mut [bool]) -> Vec<usize> {
    let mut unsigned = Vec::new();
    for &condition in &transcription.field.layout.conditions {
        let known = known(transcription, condition);
        for (e, element) in transcription.elements.iter().enumerate() {
            for turn in element
                .turns
                .iter()
                .filter(|turn| turn.condition == condition)
            {
                mark(transcription, (e, turn), known[e], vanishes);
                unsigned.push(turn.more);
            }
        }
    }
    unsigned
}

/// Marks what vanishes where a condition comes true, or does not.
fn mark(
    transcription: &Transcription<'_>,
    (e, turn): (usize, &Turn),
    comes_true: bool,
    vanishes: &mut [bool],
) {
    vanishes[turn.sets[usize::from(comes_true)]] = true;
    if let Some(missing) = missing(transcription, e, turn.condition).filter(|_| comes_true) {
        vanishes[missing] = true;
    }
}
