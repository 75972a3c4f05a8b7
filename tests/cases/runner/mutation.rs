//! Expectations that are changed so that they must not hold: a runner that accepts one of them accepts too much.

use crate::statement::{Claim, Comparison, Expectation, KINDS};
use hangtime::prelude::EventKind;

/// By how many tolerances numbers are moved.
const MOVED: f64 = 10.0;

/// A sequence of numbers that look like chance (Vigna's splitmix64).
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn coin(&mut self) -> bool {
        self.next() & 1 == 1
    }
}

/// What is expected, changed: a number by ten times its tolerance, a name into another.
pub(crate) fn changed(expectation: &Expectation, chance: &mut Chance) -> Expectation {
    let mut changed = expectation.clone();
    let moved = if chance.coin() { MOVED } else { -MOVED };
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
            let event = chance.next() as usize % events.len();
            let is_other = |kind: &EventKind| Some(*kind) != events[event].kind;
            let others: Vec<_> = KINDS.into_iter().filter(is_other).collect();
            events[event].kind = Some(others[chance.next() as usize % others.len()]);
        }
        Claim::Text(_, words, present) => match *present && !words[0].is_empty() && chance.coin() {
            true => words.iter_mut().for_each(altered),
            false => *present = !*present,
        },
        Claim::Message(parts) => {
            let mut known: Vec<&mut String> = parts.iter_mut().flatten().collect();
            let place = chance.next() as usize % known.len();
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
