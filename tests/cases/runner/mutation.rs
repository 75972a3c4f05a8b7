//! Expectations that are changed so that they must not hold: a runner that accepts one of them accepts too much.

use crate::statement::{Claim, Comparison, Expectation, KINDS, Which};
use hangtime::prelude::EventKind;

/// By how many tolerances numbers are moved.
const MOVED: f64 = 10.0;

/// A sequence of numbers that look like chance (Vigna's splitmix64).
#[derive(Debug, Clone)]
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn next(&mut self) -> u64 {
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
    changed.claim = match &expectation.claim {
        Claim::Event(which, Some(time)) if chance.coin() => {
            changed.moved = moved;
            Claim::Event(which.clone(), Some(*time))
        }
        // Another event may be there as well, but not so many of them.
        Claim::Event(which, _) => Claim::Event(
            Which {
                number: which.number + 1_000_000,
                ..which.clone()
            },
            None,
        ),
        Claim::NoEvent(Some(which)) => Claim::Event(which.clone(), None),
        Claim::NoEvent(None) => Claim::Events(vec![(of_kind(EventKind::Impact), None)]),
        Claim::Events(events) => {
            let mut events = events.clone();
            let place = (chance.next() % events.len() as u64) as usize;
            match events[place].1.is_some() && chance.coin() {
                true => changed.moved = moved,
                false => events[place].0.kind = another(events[place].0.kind, chance),
            }
            Claim::Events(events)
        }
        Claim::Value(left, instant, comparison, right) => {
            let comparison = match comparison {
                Comparison::Equal => {
                    changed.moved = moved;
                    Comparison::Equal
                }
                Comparison::AtMost => Comparison::More,
                Comparison::AtLeast => Comparison::Less,
                Comparison::Less => Comparison::AtLeast,
                Comparison::More => Comparison::AtMost,
            };
            Claim::Value(left.clone(), instant.clone(), comparison, right.clone())
        }
        Claim::SameEvents => {
            changed.moved = moved;
            Claim::SameEvents
        }
        Claim::Constant(id) => {
            changed.moved = moved;
            Claim::Constant(*id)
        }
        Claim::Status(names, _) => {
            let other = ["interrupted", "unbounded", "event_limit"];
            let other = other
                .into_iter()
                .find(|name| names.iter().all(|n| n != name));
            Claim::Status(vec![other.unwrap_or_default().to_owned()], None)
        }
        Claim::NotStatus(_) => Claim::Status(vec!["interrupted".to_owned()], None),
        Claim::Text(kind, words, present) => {
            let (words, present) = otherwise(words, *present, chance);
            Claim::Text(*kind, words, present)
        }
        Claim::Obstacle(by, words, present) => {
            let (words, present) = otherwise(words, *present, chance);
            Claim::Obstacle(by.clone(), words, present)
        }
        Claim::Limit(by, side, limit) => {
            let (change, words) = limit.clone().unwrap_or_default();
            let (words, kept) = otherwise(&words, true, chance);
            changed.moved = if kept { 0.0 } else { moved };
            Claim::Limit(by.clone(), *side, Some((change, words)))
        }
        Claim::Message(code, words, place) => message((code, words, place), chance),
        Claim::Certificate(name) => {
            let other = if name == "S" { "B" } else { "S" };
            Claim::Certificate(other.to_owned())
        }
    };
    changed
}

/// Other words, or the same as absent where they are present.
fn otherwise(words: &str, present: bool, chance: &mut Chance) -> (String, bool) {
    match present && !words.is_empty() && chance.coin() {
        true => (altered(words), true),
        false => (words.to_owned(), !present),
    }
}

/// A message with another code, other words or another place.
fn message(
    (code, words, place): (&Option<String>, &Option<String>, &Option<String>),
    chance: &mut Chance,
) -> Claim {
    match (words, place) {
        (Some(words), place) if chance.coin() => {
            Claim::Message(code.clone(), Some(altered(words)), place.clone())
        }
        (words, Some(place)) if chance.coin() => {
            Claim::Message(code.clone(), words.clone(), Some(altered(place)))
        }
        (words, place) => Claim::Message(Some("E99".to_owned()), words.clone(), place.clone()),
    }
}

fn of_kind(kind: EventKind) -> Which {
    Which {
        kind,
        number: 1,
        name: None,
    }
}

fn another(kind: EventKind, chance: &mut Chance) -> EventKind {
    let others: Vec<EventKind> = KINDS.into_iter().filter(|known| *known != kind).collect();
    others[(chance.next() % others.len() as u64) as usize]
}

/// A text with one letter of another kind.
fn altered(words: &str) -> String {
    let mut letters: Vec<char> = words.chars().collect();
    let middle = letters.len() / 2;
    letters[middle] = match letters[middle] {
        'q' => 'x',
        _ => 'q',
    };
    letters.into_iter().collect()
}
