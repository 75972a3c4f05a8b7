//! Neighbours of a sequence in which contacts stick or slip elsewhere: where a solution presses against the edge of a
//! friction cone, or against the direction of a slip.

use super::neighbours::{Neighbour, distinct};
use super::pressure::Pressure;
use crate::ocp::collocation::layout::{Phase, Tangential};
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::tuning::equal::INSTANT;
use crate::ocp::tuning::neighbours::{ENTRY, STUCK};
use crate::simulation::{ContactMode, Direction};

/// A change of the way of sliding, for a while.
struct Change {
    contact: usize,
    to: ContactMode,
    back: ContactMode,
}

/// Sequences in which a contact slips where its force is held in the cone, sticks or turns round where its sliding
/// velocity is held at 0, or does so after an impact.
pub(super) fn sliding(pressure: &Pressure) -> Vec<Neighbour> {
    let adjoining = |found: Vec<Sequence>| found.into_iter().map(Neighbour::adjoining);
    let candidates = adjoining(beginnings(pressure))
        .chain(endings(pressure).map(Neighbour::adjoining))
        .chain(turned(pressure))
        .chain(adjoining(inserted_sliding(pressure)))
        .chain(impacts(pressure));
    distinct(candidates, pressure.intervals)
}

fn slide(contact: usize, mode: ContactMode, place: Place, time: f64) -> Switch {
    Switch {
        place,
        ..Switch::inside(contact, false, mode, time)
    }
}

/// With another mode right from the start: where the first change of a contact sticks there, and where a contact
/// that slips from the start would rather stick.
fn beginnings(pressure: &Pressure) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        let first = !switches[..index]
            .iter()
            .any(|s| s.contact == switch.contact);
        if first && switch.slides() && !switch.accompanies && switch.time < STUCK {
            let mut sequence = pressure.sequence.clone();
            let last = index + Sequence::companions(switches, index).len();
            for member in sequence.switches.drain(index..=last) {
                sequence.initially[member.contact] = member.mode;
            }
            found.push(sequence);
        }
    }
    let Some(phase) = pressure.program.phases.first() else {
        return found;
    };
    let pulled: Vec<usize> = phase
        .pulled
        .iter()
        .filter(|pulled| pressure.presses(pulled.1))
        .map(|pulled| pulled.0)
        .collect();
    for (place, time) in [(Place::Inside, ENTRY), (Place::Start, 1.0)] {
        let mut sequence = pressure.sequence.clone();
        for (index, &contact) in pulled.iter().enumerate() {
            let mode = std::mem::replace(&mut sequence.initially[contact], ContactMode::Stick);
            sequence.switches.push(Switch {
                accompanies: index > 0,
                ..slide(contact, mode, place, time)
            });
        }
        if !pulled.is_empty() {
            found.push(sequence);
        }
    }
    found
}

/// With contacts that come to rest at the end at rest a little before.
fn endings(pressure: &Pressure) -> Option<Sequence> {
    let x = pressure.program.program.physical(&pressure.solution.x);
    let phase = pressure.program.phases.last()?;
    let stage = phase.stages.last()?;
    let end = pressure.intervals as f64;
    let rests = |contact: &usize| {
        let time = pressure.program.horizon_at(&x);
        pressure.mode_at(*contact, stage, time, &x) == ContactMode::Stick
            && !pressure.near(*contact, end)
    };
    let slipping = stage
        .tangential
        .iter()
        .filter(|t| t.mode != ContactMode::Stick);
    let changes: Vec<Change> = slipping
        .filter(|tangential| rests(&tangential.contact))
        .map(|tangential| Change {
            contact: tangential.contact,
            to: ContactMode::Stick,
            back: tangential.mode,
        })
        .collect();
    inserted(pressure, &changes, Place::Inside, end)
}

/// Sequences with a slip or an opening that begins at a jump of the controls earlier or later by an interval. The force
/// of a contact is often as constant as the controls, and seldom lets it go between two jumps, so that no multiplier
/// tells at which of them it should.
pub(in crate::ocp) fn shifted(pressure: &Pressure) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        let sticks = pressure.sequence.mode_before(index, switch.contact) == ContactMode::Stick;
        let jumps = switch.place == Place::Start && !switch.accompanies;
        if !jumps || !(switch.opens() || sticks && switch.slides()) {
            continue;
        }
        let group = index..=index + Sequence::companions(switches, index).len();
        for interval in [switch.interval - 1, switch.interval + 1] {
            let mut sequence = pressure.sequence.clone();
            if interval == 0 {
                for member in sequence.switches.drain(group.clone()) {
                    sequence.initially[member.contact] = member.mode;
                }
            } else {
                for member in &mut sequence.switches[group.clone()] {
                    (member.interval, member.time) = (interval, interval as f64);
                }
            }
            found.extend(sequence.ordered(pressure.intervals));
        }
    }
    found
}

/// With a slip in the place of a stick whose force is held in the cone, or before it: a contact that has just come to rest
/// is pulled on or back.
fn turned(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        if switch.accompanies || !switch.slides() || switch.mode != ContactMode::Stick {
            continue;
        }
        let phases = &pressure.program.phases;
        let after = match switch.place {
            Place::Start => phases.iter().find(|p| p.interval == switch.interval),
            Place::Inside => {
                let ended = phases.iter().position(|p| p.ends_with == Some(index));
                ended.and_then(|last| phases.get(last + 1))
            }
        };
        let pressed = after.and_then(|phase| {
            let start = phase.cones.iter().filter(|cone| cone.0 == switch.contact);
            let stages = phase.stages.iter().flat_map(|stage| &stage.tangential);
            let stages = stages.filter(|tangential| tangential.contact == switch.contact);
            start
                .map(|&(_, direction, row)| (direction, row))
                .chain(stages.flat_map(|t| t.rows.iter().copied()))
                .find(|&(_, row)| pressure.presses(row))
        });
        let Some((direction, _)) = pressed else {
            continue;
        };
        let mut sequence = pressure.sequence.clone();
        let back =
            pressure.sequence.mode_before(index, switch.contact) != ContactMode::Slip(direction);
        let companions = Sequence::companions(switches, index).len();
        let group = index..=index + companions;
        for member in &mut sequence.switches[group.clone()] {
            let before = pressure.sequence.mode_before(index, member.contact);
            member.mode = match before {
                ContactMode::Slip(direction) if back => ContactMode::Slip(direction.reversed()),
                before => before,
            };
        }
        if back {
            let rest = switches[group].iter().map(|s| (s.contact, s.mode));
            let rest: Vec<(usize, ContactMode)> = rest.collect();
            found.extend(until_soon(pressure, &sequence, &rest, switch.time));
        }
        let next = after_time(switches, &[switch.contact], switch.time);
        let lasts = next - switch.time;
        found.push(Neighbour::without(lasts, sequence.consistent()));
    }
    found
}

/// When the next of these contacts switches after a time, in intervals; infinite if none does.
fn after_time(switches: &[Switch], contacts: &[usize], time: f64) -> f64 {
    let own = switches.iter().filter(|s| contacts.contains(&s.contact));
    let mut later = own.map(|s| s.time).filter(|&then| then > time);
    later.next().unwrap_or(f64::INFINITY)
}

/// A sequence in which contacts come back to other modes soon after a time, unless the motion ends before.
fn until_soon(
    pressure: &Pressure,
    changed: &Sequence,
    back: &[(usize, ContactMode)],
    time: f64,
) -> Option<Neighbour> {
    let contacts: Vec<usize> = back.iter().map(|back| back.0).collect();
    let next = after_time(&changed.switches, &contacts, time);
    let then = time + pressure.inserted.min(0.5 * (next - time));
    if then >= pressure.intervals as f64 {
        return None;
    }
    let mut sequence = changed.clone();
    for (index, &(contact, mode)) in back.iter().enumerate() {
        sequence.switches.push(Switch {
            accompanies: index > 0,
            ..slide(contact, mode, Place::Inside, then)
        });
    }
    Some(Neighbour::adjoining(sequence))
}

/// With another way of sliding inserted for a while, for all contacts together that press for it.
fn inserted_sliding(pressure: &Pressure) -> Vec<Sequence> {
    let x = pressure.program.program.physical(&pressure.solution.x);
    let horizon = pressure.program.horizon_at(&x);
    let intervals = pressure.intervals as f64;
    let solved = pressure.program.solved(&pressure.solution.x);
    let declared = pressure.program.model.declaration().contacts;
    let mut found = Vec::new();
    for (phase, solved) in pressure.program.phases.iter().zip(&solved) {
        let time = |theta: f64| (solved.start + theta * solved.length) / horizon * intervals;
        // At a jump of the controls the force may leave the cone at once.
        let cones = phase.cones.iter().filter(|cone| pressure.presses(cone.2));
        let changes: Vec<Change> = cones
            .filter(|cone| phase.index.0 == 0 && !pressure.near(cone.0, time(0.0)))
            .map(|&(contact, direction, _)| Change {
                contact,
                to: ContactMode::Slip(direction),
                back: ContactMode::Stick,
            })
            .collect();
        found.extend(inserted(pressure, &changes, Place::Start, time(0.0)));
        for (theta, rows) in friction_rows(phase, pressure.program.tableau.c()) {
            let pressed = rows.into_iter().filter(|&(contact, _, row)| {
                pressure.presses(row) && !pressure.near(contact, time(theta))
            });
            let known = |(contact, direction, _)| (contact, phase.modes[contact], direction);
            let mut pressed: Vec<(usize, ContactMode, Direction)> = pressed.map(known).collect();
            pressed.dedup_by_key(|known| known.0);
            // A contact that turns round without a jump of the controls sticks on the way, as friction pushes it the
            // other way then.
            let at_a_jump = (time(theta) - time(theta).round()).abs() < pressure.inserted;
            // What acts on the other side of a switch says nothing of how the motion comes there.
            let crosses = |contact: usize| declared[contact].switch.is_some();
            let turns = at_a_jump || pressed.iter().any(|known| crosses(known.0));
            for turned in [false, true].into_iter().filter(|turned| !turned || turns) {
                let change = |&(contact, back, direction): &(usize, ContactMode, Direction)| {
                    let to = match back {
                        ContactMode::Stick => ContactMode::Slip(direction),
                        _ if turned => ContactMode::Slip(direction.reversed()),
                        _ => ContactMode::Stick,
                    };
                    Change { contact, to, back }
                };
                let changes: Vec<Change> = pressed.iter().map(change).collect();
                found.extend(inserted(pressure, &changes, Place::Inside, time(theta)));
            }
        }
    }
    found
}

/// Conditions on friction: contact, direction and row, as in [`Tangential::rows`].
type Rows = Vec<(usize, Direction, usize)>;

/// The conditions on friction inside an element by the share of its length at which they are: those at one instant together.
fn friction_rows(phase: &Phase, nodes: &[f64]) -> Vec<(f64, Rows)> {
    let all = |tangential: &Tangential| -> Rows {
        let rows = tangential.rows.iter();
        rows.map(|&(direction, row)| (tangential.contact, direction, row))
            .collect()
    };
    let stages = phase.stages.iter().zip(nodes);
    let at_stages = stages.map(|(stage, &c)| (c, stage.tangential.iter().flat_map(all).collect()));
    let mut places: Vec<(f64, Rows)> = at_stages.collect();
    for &(theta, contact, direction, row) in &phase.between {
        let same = |place: &&mut (f64, Rows)| (place.0 - theta).abs() <= INSTANT;
        match places.iter_mut().find(same) {
            Some(place) => place.1.push((contact, direction, row)),
            None => places.push((theta, vec![(contact, direction, row)])),
        }
    }
    places
}

/// The sequence with changes of the way of sliding from a time on, and back a little later unless the motion ends
/// before.
fn inserted(pressure: &Pressure, changes: &[Change], place: Place, time: f64) -> Option<Sequence> {
    if changes.is_empty() {
        return None;
    }
    let mut sequence = pressure.sequence.clone();
    let until = time + pressure.inserted;
    let from = match place {
        Place::Start => time.round(),
        Place::Inside => (time - pressure.inserted).max(0.0),
    };
    for (index, change) in changes.iter().enumerate() {
        let accompanies = index > 0;
        if place == Place::Start && time < STUCK {
            sequence.initially[change.contact] = change.to;
        } else {
            sequence.switches.push(Switch {
                accompanies,
                ..slide(change.contact, change.to, place, from)
            });
        }
        if until < pressure.intervals as f64 {
            sequence.switches.push(Switch {
                accompanies,
                ..slide(change.contact, change.back, Place::Inside, until)
            });
        }
    }
    Some(sequence)
}

/// With another law between the impulses of an impact, and the way of sliding that follows, for a while or until the next
/// switch.
fn impacts(pressure: &Pressure) -> Vec<Neighbour> {
    let mut found = Vec::new();
    for (index, tangential) in &pressure.program.impacts {
        let pressed = tangential
            .rows
            .iter()
            .find(|(_, row)| pressure.presses(*row));
        let Some(&(direction, _)) = pressed else {
            continue;
        };
        let laws = match tangential.mode {
            ContactMode::Stick => {
                vec![(ContactMode::Slip(direction), ContactMode::Slip(direction))]
            }
            _ => vec![
                (ContactMode::Stick, ContactMode::Stick),
                (ContactMode::Stick, ContactMode::Slip(direction.reversed())),
                (ContactMode::Stick, ContactMode::Slip(direction)),
            ],
        };
        for law in laws {
            found.extend(with_law(pressure, *index, tangential.contact, law));
        }
    }
    found
}

/// With that law for the impulse of a contact in an impact, and that way of sliding afterwards.
fn with_law(
    pressure: &Pressure,
    index: usize,
    contact: usize,
    (impulse, mode): (ContactMode, ContactMode),
) -> Vec<Neighbour> {
    let mut sequence = pressure.sequence.clone();
    let companions = Sequence::companions(&sequence.switches, index).len();
    let mut struck = sequence.switches[index..=index + companions].iter_mut();
    let mut before = pressure.sequence.mode_before(index, contact);
    if let Some(switch) = struck.find(|s| s.contact == contact) {
        before = switch.mode;
        switch.impulse = impulse;
        if !switch.mode.is_open() {
            switch.mode = mode;
        }
    } else {
        let switch = pressure.sequence.switches[index];
        let companion = Switch {
            contact,
            closes: false,
            mode,
            impulse,
            accompanies: true,
            ..switch
        };
        sequence.switches.insert(index + 1, companion);
    }
    if before.is_open() || before == mode {
        return vec![Neighbour::adjoining(sequence.consistent())];
    }
    let time = pressure.sequence.switches[index].time;
    let soon = until_soon(pressure, &sequence, &[(contact, before)], time);
    let lasts = after_time(&pressure.sequence.switches, &[contact], time) - time;
    let lasting = Neighbour::without(lasts, sequence.consistent());
    soon.into_iter().chain([lasting]).collect()
}
