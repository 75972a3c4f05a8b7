//! Elastic contacts at the end of a motion: whether they come to rest there by all of their bounces, or bounce off and only touch.
//!
//! A plan takes all bounces until a contact rests for one landing, which needs its time within a control interval. Where that holds the motion
//! back, one bounce more and no landing may be better; and where a motion ends as the contact touches without a blow, a landing before
//! that. Neither adjoins the other.

use super::pressure::Pressure;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::simulation::ContactMode;

/// Ends of intervals before a landing at which it is tried as a bounce.
const BEFORE: usize = 4;

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
    let nodes = (0..BEFORE).filter_map(|back| within.checked_sub(back));
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
