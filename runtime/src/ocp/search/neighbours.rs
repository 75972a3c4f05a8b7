//! Neighbours of a contact sequence: where a solution presses against the sequence it was given.

use super::pressure::Pressure;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::without;
use crate::ocp::motion::model_input::free_normal_acceleration;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::tuning::neighbours::{APART, CLOSE, ENTRY, LEFT, SHORT, STUCK};
use crate::simulation::ContactMode;

/// A sequence that differs from that of a solution by one change.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Neighbour {
    pub(super) sequence: Sequence,
    /// Whether the solution is a limit of motions with this sequence, so that a claim about the solution needs an answer
    /// of it. None is needed of a sequence without a contact, a flight or a slip that lasts.
    pub(super) adjoins: bool,
}

impl Neighbour {
    pub(super) fn adjoining(sequence: Sequence) -> Self {
        let adjoins = true;
        Self { sequence, adjoins }
    }

    /// A sequence without what lasts that many intervals.
    pub(super) fn without(lasts: f64, sequence: Sequence) -> Self {
        let adjoins = lasts < APART;
        Self { sequence, adjoins }
    }

    /// The neighbour with its switches in order, if they have one.
    pub(super) fn ordered(self, intervals: usize) -> Option<Self> {
        let sequence = self.sequence.ordered(intervals)?;
        Some(Self { sequence, ..self })
    }
}

/// The candidates whose switches have an order, each once.
pub(super) fn distinct(
    candidates: impl Iterator<Item = Neighbour>,
    intervals: usize,
) -> Vec<Neighbour> {
    let mut found: Vec<Neighbour> = Vec::new();
    for candidate in candidates.filter_map(|candidate| candidate.ordered(intervals)) {
        let signature = candidate.sequence.signature();
        let same = |other: &&mut Neighbour| other.sequence.signature() == signature;
        match found.iter_mut().find(same) {
            Some(known) => known.adjoins |= candidate.adjoins,
            None => found.push(candidate),
        }
    }
    found
}

/// Sequences that the solution points to, the most promising first: without a pair of switches that are close to each
/// other, with touches and contacts in the place of each other, with moved switches.
pub(super) fn directed(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (i, j) in pressure.sequence.neighbours() {
        let lasts = switches[j].time - switches[i].time;
        if lasts < CLOSE {
            let sequence = without(pressure.sequence, i, j);
            found.extend(Neighbour::without(lasts, sequence).ordered(pressure.intervals));
        }
    }
    found.extend(touches_and_contacts(pressure));
    found.extend(moved(pressure).into_iter().map(Neighbour::adjoining));
    found.extend(ended(pressure).into_iter().map(Neighbour::adjoining));
    found.extend(struck_last(pressure).into_iter().map(Neighbour::adjoining));
    found
}

/// With a touch a little before the end of a contact that bounces and presses for being struck there: it is open again, and the motion goes
/// on.
fn struck_last(pressure: &Pressure) -> Vec<Sequence> {
    let last = pressure.program.phases.last();
    let Some(stage) = last.and_then(|phase| phase.stages.last()) else {
        return Vec::new();
    };
    let end = pressure.intervals as f64;
    let before = pressure.sequence.switches.last();
    let flight = end - before.map_or(0.0, |switch| switch.time);
    let time = end - pressure.inserted.min(0.5 * flight);
    let presses = |contact: usize| stage.gap_rows[contact].is_some_and(|row| pressure.presses(row));
    let touching = pressure.touching_at_the_end().into_iter();
    let struck = touching.filter(|&(contact, _)| presses(contact) && bounces(pressure, contact));
    let struck = struck.filter_map(|(contact, mode)| {
        let mut sequence = pressure.sequence.clone();
        sequence.switches.push(Switch::touch(contact, mode, time));
        sequence.ordered(pressure.intervals)
    });
    struck.collect()
}

/// With an impact at the final time of a contact that is open until there and touches then: goals may hold it there without any
/// blow, and nothing presses for one.
fn ended(pressure: &Pressure) -> Vec<Sequence> {
    let ends = pressure.touching_at_the_end().into_iter();
    let ends = ends.filter_map(|(contact, mode)| {
        let mut sequence = pressure.sequence.clone();
        sequence.switches.push(Switch {
            interval: pressure.intervals,
            place: Place::Start,
            ..Switch::inside(contact, true, mode, pressure.intervals as f64)
        });
        sequence.ordered(pressure.intervals)
    });
    ends.collect()
}

/// With a switch that sticks to the end of its interval moved through it or onto it, and with an opening at a jump of the
/// controls moved to the side that it presses against.
fn moved(pressure: &Pressure) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for closes in [false, true] {
        for (index, switch) in switches.iter().enumerate() {
            let own = !switch.accompanies && switch.place == Place::Inside;
            if !own || switch.closes != closes {
                continue;
            }
            let (k, offset) = (switch.interval, switch.time - switch.interval as f64);
            let (to, time) = if offset < STUCK {
                (k.checked_sub(1), k as f64 - ENTRY)
            } else if offset > 1.0 - STUCK {
                (Some(k + 1), (k + 1) as f64 + ENTRY)
            } else {
                continue;
            };
            found.extend(pressure.moved(index, to, Place::Inside, time));
            let nearest = switch.time.round();
            found.extend(pressure.moved(index, Some(nearest as usize), Place::Start, nearest));
        }
    }
    for (index, switch) in switches.iter().enumerate() {
        if switch.accompanies || switch.place != Place::Start {
            continue;
        }
        let k = switch.interval;
        // What ends at a zero of the motion happens at a jump of the controls by chance only.
        let slips = matches!(
            pressure.sequence.mode_before(index, switch.contact),
            ContactMode::Slip(_)
        );
        if switch.closes
            || switch.passes
            || Sequence::ends_at_edge(switches, index)
            || slips && switch.slides()
            || pressure.program.shape == ControlShape::Linear
        {
            let time = k as f64 - ENTRY;
            let ends = k == pressure.intervals;
            let alone = Sequence::companions(switches, index).is_empty();
            if ends && alone && bounces(pressure, switch.contact) {
                found.extend(touched_at(pressure, index, time));
            } else if switch.stays() && is_pulled_off(pressure, k, switch.contact) {
                found.extend(touched_before(pressure, index).filter(|_| !ends));
            } else {
                found.extend(pressure.moved(index, k.checked_sub(1), Place::Inside, time));
            }
            found.extend(pressure.moved(index, Some(k), Place::Inside, k as f64 + ENTRY));
            continue;
        }
        let phases = &pressure.program.phases;
        let after = phases.iter().find(|phase| phase.interval == k);
        let pressed = after.is_some_and(|phase| {
            let mut rows = phase.openings.iter().chain(&phase.pulled);
            rows.any(|&(contact, row)| contact == switch.contact && pressure.presses(row))
        });
        if pressed {
            found.extend(pressure.moved(index, Some(k), Place::Inside, k as f64 + ENTRY));
        }
        let before = phases.iter().rev().find(|phase| phase.interval + 1 == k);
        let pressed = before.is_some_and(|phase| {
            if switch.slides() {
                return pressure.at_the_edge(phase, switch);
            }
            let slot = phase.closed.iter().position(|&i| i == switch.contact);
            let stage = phase.stages.last();
            slot.zip(stage)
                .is_some_and(|(slot, stage)| pressure.is_held(stage.forces[slot]))
        });
        if pressed {
            let time = k as f64 - ENTRY;
            found.extend(pressure.moved(index, k.checked_sub(1), Place::Inside, time));
        }
    }
    found
}

/// With a landing where an interval begins as a touch right before, and the landing after that: of a contact that is pulled off then.
fn touched_before(pressure: &Pressure, index: usize) -> Option<Sequence> {
    let mut sequence = pressure.sequence.clone();
    let landing = sequence.switches[index];
    let node = landing.interval as f64;
    sequence.switches[index] = Switch::touch(landing.contact, landing.impulse, node - ENTRY);
    sequence.switches.push(Switch {
        mode: landing.mode,
        ..Switch::touch(landing.contact, landing.impulse, node + ENTRY)
    });
    sequence.ordered(pressure.intervals)
}

/// With the impact that ends the motion as a touch at a time before it, from which the contact bounces.
fn touched_at(pressure: &Pressure, index: usize, time: f64) -> Option<Sequence> {
    let mut sequence = pressure.sequence.clone();
    let last = sequence.switches[index];
    sequence.switches[index] = Switch::touch(last.contact, last.impulse, time);
    sequence.ordered(pressure.intervals)
}

/// Whether a contact that is struck is open again right after it.
fn bounces(pressure: &Pressure, contact: usize) -> bool {
    pressure.program.model.restitution(contact) > 0.0
}

/// Whether a contact that lands alone where an interval begins, or at the end of the motion, would be pulled off by what drives the motion
/// right before: no motion in which it lands a little earlier, and stays, is near; one in which it is touched then may be.
fn is_pulled_off(pressure: &Pressure, interval: usize, contact: usize) -> bool {
    let program = pressure.program;
    let phases = &program.phases;
    let next = phases.iter().position(|phase| phase.interval == interval);
    let after = next.map(|next| &phases[next]);
    let alone = match after {
        Some(after) => after.closed == [contact],
        None => is_alone_at_the_end(pressure.sequence, contact),
    };
    let before = phases[..next.unwrap_or(phases.len())].last();
    let before = before.and_then(|before| before.stages.last());
    let Some(before) = before.filter(|_| alone) else {
        return false;
    };
    let x = program.program.physical(&pressure.solution.x);
    let landed = after.map_or(&program.end, |after| &after.start);
    let acceleration = |drive: &[usize]| {
        let input = landed.iter().chain(drive);
        let input: Vec<f64> = input.map(|&i| x[i]).collect();
        free_normal_acceleration(program.model, contact, &input)
    };
    let then = after.and_then(|after| after.stages.first());
    let then = then.map_or(0.0, |stage| acceleration(&stage.drive));
    acceleration(&before.drive) > LEFT * then.abs()
}

/// Whether a contact is the only one that is closed at the end of the motion.
fn is_alone_at_the_end(sequence: &Sequence, contact: usize) -> bool {
    let end = sequence.switches.len();
    let contacts = 0..sequence.initially.len();
    let mut closed = contacts.filter(|&contact| !sequence.mode_before(end, contact).is_open());
    closed.next() == Some(contact) && closed.next().is_none()
}

/// Sequences with a touch in the place of a short contact, and with a short contact in the
/// place of a touch after which nothing pulls the contact open.
fn touches_and_contacts(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (i, j) in pressure.sequence.neighbours() {
        let (first, second) = (&switches[i], &switches[j]);
        if first.stays() && second.opens() && second.time - first.time < SHORT {
            let mut sequence = pressure.sequence.clone();
            sequence.switches[i].mode = ContactMode::Open;
            sequence.switches.remove(j);
            found.push(Neighbour::without(second.time - first.time, sequence));
        }
    }
    for (index, switch) in switches.iter().enumerate().filter(|(_, s)| s.touches()) {
        let mut touches = pressure.program.touches.iter();
        let grazes = touches.any(|(touch, row)| {
            (touch.contact, touch.interval, touch.place)
                == (switch.contact, switch.interval, switch.place)
                && pressure.presses(*row)
        });
        if grazes {
            let mut sequence = pressure.sequence.clone();
            sequence.switches.remove(index);
            found.push(Neighbour::adjoining(sequence));
        }
        let phases = pressure.program.phases.iter();
        let pressed = phases
            .flat_map(|phase| &phase.openings)
            .any(|&(contact, row)| contact == switch.contact && pressure.presses(row));
        if pressed {
            let mut sequence = pressure.sequence.clone();
            sequence.switches[index].mode = switch.impulse;
            let time = (switch.time + pressure.inserted).min(pressure.intervals as f64 - STUCK);
            sequence.switches.push(Switch {
                closes: false,
                mode: ContactMode::Open,
                interval: time.floor() as usize,
                place: Place::Inside,
                time,
                ..*switch
            });
            found.push(Neighbour::adjoining(sequence));
        }
    }
    let ordered = |neighbour: Neighbour| neighbour.ordered(pressure.intervals);
    found.into_iter().filter_map(ordered).collect()
}

/// The sequence without its last switch: the motion may end before it.
pub(in crate::ocp) fn shortened(pressure: &Pressure) -> Vec<Sequence> {
    let mut sequence = pressure.sequence.clone();
    while sequence.switches.pop().is_some_and(|last| last.accompanies) {}
    let shorter = sequence.switches.len() < pressure.sequence.switches.len();
    let ordered = shorter.then(|| sequence.ordered(pressure.intervals));
    ordered.flatten().into_iter().collect()
}

/// Sequences with a flight inserted where a contact force is held at 0, and with a contact inserted
/// where a gap is held at 0: together with the stuck switches of [`directed`] these
/// are the places where gap and force vanish together. A flight that passes a surface at the gap margin is
/// none of them.
pub(in crate::ocp) fn insertions(pressure: &Pressure) -> Vec<Sequence> {
    let mut places: Vec<(usize, bool, ContactMode, f64)> = Vec::new();
    let contacts = pressure.sequence.initially.len();
    let tableau = pressure.program.tableau;
    let x = pressure.program.program.physical(&pressure.solution.x);
    let horizon = pressure.program.horizon_at(&x);
    let solved = pressure.program.solved(&pressure.solution.x);
    for (phase, solved) in pressure.program.phases.iter().zip(&solved) {
        let opens = phase
            .ends_with
            .map(|index| &pressure.sequence.switches[index])
            .filter(|switch| switch.opens())
            .map(|switch| switch.contact);
        let time = |theta: f64| {
            (solved.start + theta * solved.length) / horizon * pressure.intervals as f64
        };
        for (m, (stage, c)) in phase.stages.iter().zip(tableau.c()).enumerate() {
            let last = m + 1 == phase.stages.len();
            let dry = |contact: usize| contact >= stage.gap_rows.len();
            for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
                if dry(contact) {
                    break;
                }
                let exits = last && opens == Some(contact);
                if !exits && pressure.is_held(force) {
                    places.push((contact, false, phase.modes[contact], time(*c)));
                }
            }
            let open = |i: &usize| !phase.closed.contains(i) && !phase.pieces.is_idle(*i);
            for contact in (0..contacts).filter(|i| !dry(*i) && open(i)) {
                let Some(row) = stage.gap_rows[contact] else {
                    continue;
                };
                let closes = last && phase.closing.contains(&contact);
                if !closes && pressure.presses(row) && pressure.touches(contact, stage, &x) {
                    let seconds = solved.start + c * solved.length;
                    let mode = pressure.mode_at(contact, stage, seconds, &x);
                    places.push((contact, true, mode, time(*c)));
                }
            }
        }
    }
    // Gap and force vanish together at every switch; that is no sign of another one nearby.
    places.retain(|&(contact, .., time)| !pressure.near(contact, time));
    let mut found: Vec<Sequence> = Vec::new();
    let intervals = pressure.intervals as f64;
    for (contact, closes, mode, time) in places {
        let mut sequence = pressure.sequence.clone();
        for (closes, time) in [
            (closes, time - pressure.inserted),
            (!closes, time + pressure.inserted),
        ] {
            // What begins near the end of the motion lasts until there.
            if time >= intervals {
                continue;
            }
            let time = time.max(0.0);
            let after = if closes { mode } else { ContactMode::Open };
            sequence.switches.push(Switch {
                impulse: mode,
                ..Switch::inside(contact, closes, after, time)
            });
        }
        if let Some(sequence) = sequence.ordered(pressure.intervals)
            && !found.iter().any(|s| s.signature() == sequence.signature())
        {
            found.push(sequence);
        }
    }
    found
}
