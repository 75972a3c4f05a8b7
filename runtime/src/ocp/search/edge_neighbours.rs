//! Neighbours of a sequence in which edges are passed elsewhere, or not at all.

use super::neighbours::{Neighbour, distinct};
use super::pressure::Pressure;
use crate::model::edge;
use crate::ocp::collocation::layout::Phase;
use crate::ocp::motion::edit_sequence::{lasts_at_edge, touching_at_edge};
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::tuning::neighbours::CLOSE;
use crate::simulation::ContactMode;

/// Sequences without a passage and the way back, with both where a piece is kept though another one is larger, with an end
/// of contact at an edge where the motion presses towards it, with an opening that comes before the edge or not, and with an impact
/// right at the edge.
pub(super) fn edges(pressure: &Pressure) -> Vec<Neighbour> {
    if edge(pressure.program.model).is_none() {
        return Vec::new();
    }
    let candidates = there_and_back(pressure)
        .into_iter()
        .chain(ends(pressure))
        .chain(goes_on(pressure))
        .chain(touches(pressure))
        .chain(pressed(pressure).into_iter().map(Neighbour::adjoining));
    distinct(candidates, pressure.intervals)
}

/// Without two passages that lead back to the same piece.
fn there_and_back(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (i, there) in switches.iter().enumerate() {
        let left = pressure.sequence.pieces_before(i).acting(there.contact);
        let own = |s: &&Switch| s.passes && (s.contact == left || is_other(pressure, left, s));
        let rest = switches[i + 1..].iter();
        let back = rest.clone().find(own);
        let Some(back) = back.filter(|back| back.contact == left) else {
            continue;
        };
        if there.passes && !there.accompanies && back.time - there.time < CLOSE {
            let mut sequence = pressure.sequence.clone();
            sequence.switches.retain(|s| s != there && s != back);
            found.push(Neighbour::without(back.time - there.time, sequence));
        }
    }
    found
}

/// Whether a switch is of another piece of the edge of a contact.
fn is_other(pressure: &Pressure, contact: usize, switch: &Switch) -> bool {
    let contacts = pressure.program.model.declaration().contacts;
    contacts[contact].alternatives.contains(&switch.contact)
}

/// With a contact that opens before the edge at which it ends, and with one that ends at the edge that it passes soon after
/// its opening.
fn ends(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (index, opening) in switches.iter().enumerate().filter(|(_, s)| s.opens()) {
        let mut sequence = pressure.sequence.clone();
        if Sequence::ends_at_edge(switches, index) {
            let phases = pressure.program.phases.iter();
            let mut ending = phases.filter(|phase| match opening.place {
                Place::Inside => phase.ends_with == Some(index),
                Place::Start => {
                    phase.interval + 1 == opening.interval && phase.index.0 + 1 == phase.index.1
                }
            });
            if ending.any(|phase| is_let_go(pressure, phase, opening.contact)) {
                let time = (opening.time - pressure.inserted).max(0.0);
                sequence.switches[index].time = time;
                sequence.switches[index].interval = time as usize;
                sequence.switches[index].place = Place::Inside;
                found.push(Neighbour::adjoining(sequence));
            }
            continue;
        }
        let mut rest = switches[index + 1..].iter().enumerate();
        let own = rest.find(|(_, s)| is_other(pressure, opening.contact, s));
        let passage = own.filter(|(_, s)| s.passes && s.time - opening.time < CLOSE);
        if let Some((after, passage)) = passage {
            sequence.switches.remove(index + 1 + after);
            let end = Switch {
                contact: opening.contact,
                passes: false,
                impulse: opening.impulse,
                ..*passage
            };
            let passage = Switch {
                accompanies: true,
                ..*passage
            };
            sequence.switches.splice(index..=index, [end, passage]);
            found.push(Neighbour::without(passage.time - opening.time, sequence));
        }
    }
    found
}

/// With a contact that takes over from one that opens a little before it closes, and with one that takes over closing later.
fn goes_on(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (i, opening) in switches.iter().enumerate().filter(|(_, s)| s.opens()) {
        let Some(j) = (i + 1..switches.len()).find(|&j| !switches[j].passes) else {
            continue;
        };
        let closing = &switches[j];
        if opening.accompanies || !closing.stays() || closing.contact == opening.contact {
            continue;
        }
        let mut sequence = pressure.sequence.clone();
        if Sequence::takes_over(switches, j) {
            if is_entered_without_force(pressure, i, closing.contact) {
                let time = closing.time + pressure.inserted;
                sequence.switches[j] = Switch {
                    accompanies: false,
                    interval: time as usize,
                    place: Place::Inside,
                    time,
                    ..*closing
                };
                found.push(Neighbour::adjoining(sequence));
            }
        } else if !closing.accompanies && closing.time - opening.time < CLOSE {
            let time = 0.5 * (opening.time + closing.time);
            for (index, switch) in sequence.switches[i..=j].iter_mut().enumerate() {
                *switch = Switch {
                    accompanies: index > 0,
                    interval: time as usize,
                    place: Place::Inside,
                    time,
                    ..*switch
                };
            }
            found.push(Neighbour::without(closing.time - opening.time, sequence));
        }
    }
    found
}

/// With a touch at the edge in the place of a contact that ends there soon after its impact, and with that contact, or with the passage
/// alone, in the place of such a touch.
fn touches(pressure: &Pressure) -> Vec<Neighbour> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for pair in pressure.sequence.neighbours() {
        let lasts = lasts_at_edge(pressure.sequence, pair);
        if let Some(lasts) = lasts.filter(|&lasts| lasts < CLOSE) {
            let sequence = touching_at_edge(pressure.sequence, pair);
            found.push(Neighbour::without(lasts, sequence));
        }
    }
    for (i, touch) in switches.iter().enumerate().filter(|(_, s)| s.touches()) {
        let passage = Sequence::companions(switches, i)
            .iter()
            .position(|s| s.passes);
        let Some(passage) = passage.map(|k| i + 1 + k) else {
            continue;
        };
        let mut missed = pressure.sequence.clone();
        missed.switches[passage].accompanies = touch.accompanies;
        missed.switches.remove(i);
        found.push(Neighbour::adjoining(missed));
        let mut lasting = pressure.sequence.clone();
        let passed = lasting.switches.remove(passage);
        lasting.switches[i].mode = touch.impulse;
        let time = touch.time + pressure.inserted;
        let end = Switch::inside(touch.contact, false, ContactMode::Open, time);
        let passed = Switch {
            accompanies: true,
            ..Switch::passage(passed.contact, time)
        };
        lasting.switches.extend([end, passed]);
        found.push(Neighbour::adjoining(lasting));
    }
    found
}

/// Whether the first force of a contact after the switch with this index presses against 0.
fn is_entered_without_force(pressure: &Pressure, index: usize, contact: usize) -> bool {
    let phases = &pressure.program.phases;
    let ended = phases.iter().position(|p| p.ends_with == Some(index));
    let Some(phase) = ended.and_then(|ended| phases.get(ended + 1)) else {
        return false;
    };
    let slot = phase.closed.iter().position(|&closed| closed == contact);
    let force = slot.and_then(|slot| Some(phase.stages.first()?.forces[slot]));
    force.is_some_and(|force| pressure.is_held(force))
}

/// Whether the last force of a phase presses against 0.
fn is_let_go(pressure: &Pressure, phase: &Phase, contact: usize) -> bool {
    let slot = phase.closed.iter().position(|&closed| closed == contact);
    let force = slot.and_then(|slot| Some(phase.stages.last()?.forces[slot]));
    force.is_some_and(|force| pressure.is_held(force))
}

/// With what a row of a piece of an edge presses for.
fn pressed(pressure: &Pressure) -> Vec<Sequence> {
    let x = pressure.program.program.physical(&pressure.solution.x);
    let horizon = pressure.program.horizon_at(&x);
    let solved = pressure.program.solved(&pressure.solution.x);
    let contacts = pressure.program.model.declaration().contacts;
    let mut found = Vec::new();
    for (phase, solved) in pressure.program.phases.iter().zip(&solved) {
        for (stage, c) in phase.stages.iter().zip(pressure.program.tableau.c()) {
            let time = (solved.start + c * solved.length) / horizon * pressure.intervals as f64;
            for (contact, row) in stage.gap_rows.iter().enumerate() {
                if !row.is_some_and(|row| pressure.presses(row)) {
                    continue;
                }
                let gap = |contact: usize| pressure.gap(contact, stage, &x);
                let acting = phase.pieces.acting(contact);
                let others = contacts[contact].alternatives.iter().copied();
                let larger = others.max_by(|&a, &b| gap(a).total_cmp(&gap(b)));
                let larger = larger.filter(|&other| gap(other) > gap(contact));
                if acting != contact && phase.closed.contains(&acting) {
                    found.extend(ended(pressure, acting, contact, time));
                } else if let Some(other) = larger.filter(|_| acting == contact) {
                    found.push(around(pressure, contact, other, time));
                }
            }
        }
    }
    found
}

/// With the passage to another piece for a while.
fn around(pressure: &Pressure, contact: usize, other: usize, time: f64) -> Sequence {
    let mut sequence = pressure.sequence.clone();
    let there = Switch::passage(other, (time - pressure.inserted).max(0.0));
    sequence.switches.push(there);
    let back = time + pressure.inserted;
    if back < pressure.intervals as f64 {
        sequence.switches.push(Switch::passage(contact, back));
    }
    sequence
}

/// With the end of a contact at the edge to another piece, unless it switches near that time.
fn ended(pressure: &Pressure, contact: usize, other: usize, time: f64) -> Option<Sequence> {
    if pressure.near(contact, time) {
        return None;
    }
    let mut sequence = pressure.sequence.clone();
    let passage = Switch::passage(other, (time - pressure.inserted).max(0.0));
    let end = Switch {
        contact,
        passes: false,
        ..passage
    };
    let passage = Switch {
        accompanies: true,
        ..passage
    };
    sequence.switches.extend([end, passage]);
    Some(sequence)
}
