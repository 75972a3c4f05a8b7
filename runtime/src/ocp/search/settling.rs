//! Elastic contacts at the end of a motion: whether they come to rest there by all of their bounces, or bounce off and only touch.
//!
//! A plan takes all bounces until a contact rests for one landing, which needs its time within a control interval. Where that holds the motion
//! back, one bounce more and no landing may be better; and where a motion ends as the contact touches without a blow, a landing before
//! that. Neither adjoins the other.

use super::pressure::Pressure;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::tuning::neighbours::{BOUNCES_BEFORE, ENTRY, TOUCHES};
use crate::simulation::ContactMode;

/// The other way of each elastic contact.
pub(super) fn settling(pressure: &Pressure) -> Vec<Sequence> {
    let model = pressure.program.model;
    let contacts = 0..pressure.sequence.initially.len();
    if !contacts
        .into_iter()
        .any(|contact| model.restitution(contact) > 0.0)
    {
        return Vec::new();
    }
    let mut found = landing_last(pressure);
    for phase in &pressure.program.phases {
        let settling = phase.settling.iter();
        for &(contact, _) in settling.filter(|(_, row)| pressure.presses(*row)) {
            found.extend(bouncing_off(pressure, contact, phase.interval));
            found.extend(resting_later(
                pressure.sequence,
                contact,
                phase.interval,
                pressure.intervals,
            ));
        }
    }
    found
}

/// With the last switch of a contact, which lands within an interval and stays until the end, as a bounce: at that time, or where one of
/// the intervals before it begins.
fn bouncing_off(pressure: &Pressure, contact: usize, within: usize) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let last = switches.iter().rposition(|s| s.contact == contact);
    let stays = |s: &Switch| s.stays() && s.interval == within;
    let Some(index) = last.filter(|&index| stays(&switches[index])) else {
        return Vec::new();
    };
    let landing = switches[index];
    let own = (landing.interval, landing.place, landing.time);
    let nodes = (0..BOUNCES_BEFORE).filter_map(|back| within.checked_sub(back));
    let nodes = nodes.map(|node| (node, Place::Start, node as f64));
    let sequences = std::iter::once(own)
        .chain(nodes)
        .filter_map(|(interval, place, time)| {
            let mut sequence = pressure.sequence.clone();
            sequence.switches[index] = Switch {
                mode: ContactMode::Open,
                interval,
                place,
                time,
                ..landing
            };
            sequence.ordered(pressure.intervals)
        });
    sequences.collect()
}

/// With a landing of which the first bounces are as many touches, and the others come to rest in the interval after that.
fn resting_later(
    given: &Sequence,
    contact: usize,
    within: usize,
    intervals: usize,
) -> Vec<Sequence> {
    let lands = |s: &Switch| s.contact == contact && s.stays() && s.interval == within;
    let index = given.switches.iter().position(lands);
    let Some(index) = index.filter(|_| within + 1 < intervals) else {
        return Vec::new();
    };
    let (landing, node) = (given.switches[index], (within + 1) as f64);
    let struck = |mode: ContactMode, time: f64| Switch {
        impulse: landing.impulse,
        ..Switch::inside(contact, true, mode, time)
    };
    let sequences = (1..=TOUCHES).filter_map(|touches| {
        let mut sequence = given.clone();
        sequence.switches.remove(index);
        let apart = (node - landing.time) / touches as f64;
        let times = (0..touches).map(|k| landing.time + k as f64 * apart);
        let bounces = times.map(|time| struck(ContactMode::Open, time));
        sequence.switches.extend(bounces);
        sequence.switches.push(struck(landing.mode, node + ENTRY));
        sequence.ordered(intervals)
    });
    sequences.collect()
}

/// With a landing in the last interval, at its start or inside, of a contact that bounces and touches at the end.
fn landing_last(pressure: &Pressure) -> Vec<Sequence> {
    let mut found = Vec::new();
    let Some(last) = pressure.intervals.checked_sub(1) else {
        return found;
    };
    let model = pressure.program.model;
    let touching = pressure.touching_at_the_end().into_iter();
    for (contact, mode) in touching.filter(|(contact, _)| model.restitution(*contact) > 0.0) {
        for (place, time) in [
            (Place::Start, last as f64),
            (Place::Inside, last as f64 + 0.5),
        ] {
            let mut sequence = pressure.sequence.clone();
            sequence.switches.push(Switch {
                place,
                ..Switch::inside(contact, true, mode, time)
            });
            found.extend(sequence.ordered(pressure.intervals));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;

    #[test]
    fn landing_at_the_end_of_its_interval_is_bounces_before_it_and_a_landing_after() {
        let closed = ContactMode::Frictionless;
        let given = Sequence {
            initially: vec![ContactMode::Open; 2],
            pieces: Pieces::default(),
            switches: vec![
                Switch::inside(1, true, ContactMode::Open, 2.5),
                Switch::inside(0, true, closed, 4.6),
                Switch::inside(0, false, ContactMode::Open, 7.5),
            ],
        };
        let found = resting_later(&given, 0, 4, 10);
        let times = |sequence: &Sequence| -> Vec<f64> {
            sequence.switches.iter().map(|switch| switch.time).collect()
        };
        assert_eq!(found.len(), TOUCHES);
        assert_eq!(times(&found[0]), [2.5, 4.6, 5.0 + ENTRY, 7.5]);
        assert_eq!(times(&found[1]), [2.5, 4.6, 4.8, 5.0 + ENTRY, 7.5]);
        for sequence in &found {
            let own = sequence
                .switches
                .iter()
                .filter(|s| s.contact == 0 && s.closes);
            let modes: Vec<bool> = own.map(|switch| switch.mode == closed).collect();
            // It stays after the last one only.
            assert!(modes.last() == Some(&true) && modes.iter().filter(|m| **m).count() == 1);
        }
        // In the last interval there is none after it.
        assert!(resting_later(&given, 0, 4, 5).is_empty());
        assert!(resting_later(&given, 1, 2, 10).is_empty());
    }
}
