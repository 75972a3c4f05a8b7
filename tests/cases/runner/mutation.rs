//! Expectations that are changed so that they must not hold: a runner that accepts one of them accepts too much.

use crate::draw::Draw;
use crate::statement::{Claim, Comparison, Expectation, KINDS};
use hangtime::prelude::EventKind;

/// By how many tolerances numbers are moved.
const MOVED: f64 = 10.0;

/// What is expected, changed: a number by ten times its tolerance, a name into another.
pub(crate) fn changed(expectation: &Expectation, draw: &mut Draw) -> Expectation {
    let mut changed = expectation.clone();
    let moved = if draw.chance(0.5) { MOVED } else { -MOVED };
    match &mut changed.claim {
        Claim::SameEvents => changed.moved = moved,
        Claim::Value(_, _, comparison, _) => {
            *comparison = match comparison {
                Comparison::Equal => {
                    changed.moved = moved;
                    Comparison::Equal
                }
                Comparison::AtMost => Comparison::More,
                Comparison::AtLeast => Comparison::Less,
                Comparison::Less => Comparison::AtLeast,
                Comparison::More => Comparison::AtMost,
            };
        }
        Claim::Events(events) => {
            let event = draw.below(events.len());
            let is_other = |kind: &EventKind| Some(*kind) != events[event].kind;
            let others: Vec<_> = KINDS.into_iter().filter(is_other).collect();
            events[event].kind = Some(others[draw.below(others.len())]);
        }
        Claim::Text(_, words, present) => {
            match *present && !words[0].is_empty() && draw.chance(0.5) {
                true => words.iter_mut().for_each(altered),
                false => *present = !*present,
            }
        }
        Claim::Message(parts) => {
            let mut known: Vec<&mut String> = parts.iter_mut().flatten().collect();
            let place = draw.below(known.len());
            altered(known[place]);
        }
    }
    changed
}

/// Makes one letter another one.
fn altered(words: &mut String) {
    let mut letters: Vec<char> = words.chars().collect();
    let middle = letters.len() / 2;
    letters[middle] = if letters[middle] == 'q' { 'x' } else { 'q' };
    *words = letters.into_iter().collect();
}
