//! Neighbours of a plan: contact sequences that differ from its own by one edit, at a place where it presses for that.
//!
//! The plan is a limit of motions with such a sequence: a phase that is inserted, moved or left out has no length in it. So a claim about the
//! plan needs an answer of each of them. Where gap and force vanish together a contact may close or open otherwise, where a force is at the
//! edge of its cone or a sliding velocity at 0 it may stick or slip otherwise, and where the pieces of an edge are as large another one may act.

use super::neighbour::{Edit, Neighbour};
use super::passing::edges;
use super::pressing::Pressing;
use super::sliding::{begun, rested, slid, struck, turned};
use crate::ocp::collocation::layout::Phase;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::without;
use crate::ocp::motion::model_input::free_normal_acceleration;
use crate::ocp::motion::sequence::{At, Place, Sequence, Switch};
use crate::ocp::tuning::neighbours::{CLOSE, ENTRY, LEFT, SHORT, STUCK};
use crate::simulation::ContactMode;

/// The edits, in the order in which their neighbours are asked.
const EDITS: [Edit; 11] = [
    cancelled, touched, moved, ended, inserted, begun, turned, slid, struck, rested, edges,
];

/// All neighbours whose switches have an order, each once.
pub(super) fn neighbours(plan: &Pressing) -> Vec<Neighbour> {
    let mut found: Vec<Neighbour> = Vec::new();
    for Neighbour { sequence, adjoins } in EDITS.iter().flat_map(|edit| edit(plan)) {
        let Some(sequence) = sequence.ordered(plan.intervals) else {
            continue;
        };
        let signature = sequence.signature();
        let same = |other: &&mut Neighbour| other.sequence.signature() == signature;
        match found.iter_mut().find(same) {
            Some(known) => known.adjoins |= adjoins,
            None => found.push(Neighbour { sequence, adjoins }),
        }
    }
    found
}

/// The sequence with a switch, and what accompanies it, at another place.
fn with_moved(plan: &Pressing, index: usize, to: At) -> Neighbour {
    let companions = Sequence::companions(plan.switches(), index).len();
    Neighbour::adjoining(plan.with(|switches| {
        for switch in &mut switches[index..=index + companions] {
            *switch = switch.at(to);
        }
    }))
}

/// A little before and after the end of an interval.
fn beside(node: usize) -> (Option<At>, At) {
    let time = node as f64;
    let before = node.checked_sub(1).map(|interval| At {
        interval,
        place: Place::Inside,
        time: time - ENTRY,
    });
    (before, At::inside(time + ENTRY))
}

/// Without two switches of a contact that are close to each other.
fn cancelled(plan: &Pressing) -> Vec<Neighbour> {
    let mut found = Vec::new();
    for (i, j) in plan.sequence.neighbours() {
        let lasts = plan.switches()[j].time - plan.switches()[i].time;
        if lasts < CLOSE {
            found.push(Neighbour::without(lasts, without(plan.sequence, i, j)));
        }
    }
    found
}

/// With a touch in the place of a short contact; without a touch that grazes, and with a short contact in the place of one after which
/// nothing pulls the contact open.
fn touched(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (i, j) in plan.sequence.neighbours() {
        let lasts = switches[j].time - switches[i].time;
        if switches[i].stays() && switches[j].opens() && lasts < SHORT {
            let touch = plan.with(|switches| {
                switches[i].mode = ContactMode::Open;
                switches.remove(j);
            });
            found.push(Neighbour::without(lasts, touch));
        }
    }
    for (index, touch) in switches.iter().enumerate().filter(|(_, s)| s.touches()) {
        let own = |other: &Switch| {
            (other.contact, other.interval, other.place)
                == (touch.contact, touch.interval, touch.place)
        };
        let mut rows = plan.program.touches.iter();
        if rows.any(|(other, row)| own(other) && plan.presses(*row)) {
            found.push(Neighbour::adjoining(plan.with(|switches| {
                switches.remove(index);
            })));
        }
        let phases = plan.program.phases.iter();
        let mut openings = phases.flat_map(|phase| &phase.openings);
        if openings.any(|&(contact, row)| contact == touch.contact && plan.presses(row)) {
            let time = (touch.time + plan.inserted).min(plan.end() - STUCK);
            found.push(Neighbour::adjoining(plan.with(|switches| {
                switches[index].mode = touch.impulse;
                switches.push(Switch {
                    closes: false,
                    mode: ContactMode::Open,
                    ..touch.at(At::inside(time))
                });
            })));
        }
    }
    found
}

/// With a switch that sticks to the end of its interval moved through it or onto it, and with one at a jump of the controls moved to either
/// side, openings to the one that they press against.
fn moved(plan: &Pressing) -> Vec<Neighbour> {
    let leads = |(_, switch): &(usize, &Switch)| !switch.accompanies;
    let leading = || plan.switches().iter().enumerate().filter(leads);
    let mut found = Vec::new();
    for closes in [false, true] {
        let own = |s: &Switch| s.place == Place::Inside && s.closes == closes;
        for (index, switch) in leading().filter(|(_, switch)| own(switch)) {
            let node = switch.time.round() as usize;
            let offset = switch.time - switch.interval as f64;
            let through = if offset < STUCK {
                beside(switch.interval).0
            } else if offset > 1.0 - STUCK {
                Some(beside(switch.interval + 1).1)
            } else {
                continue;
            };
            let to = through.into_iter().chain([At::end_of(node)]);
            found.extend(to.map(|to| with_moved(plan, index, to)));
        }
    }
    for (index, switch) in leading().filter(|(_, switch)| switch.place == Place::Start) {
        found.extend(from_jump(plan, index, switch));
    }
    found
}

/// With a switch at a jump of the controls a little before and after it.
fn from_jump(plan: &Pressing, index: usize, switch: &Switch) -> Vec<Neighbour> {
    let node = switch.interval;
    let (Some(before), after) = beside(node) else {
        return Vec::new();
    };
    let (last, next) = plan.around(index);
    let last = last.map(|last| &plan.program.phases[last]);
    let next = next.map(|next| &plan.program.phases[next]);
    let slips = matches!(
        plan.sequence.mode_before(index, switch.contact),
        ContactMode::Slip(_)
    );
    // What ends at a zero of the motion happens at a jump of the controls by chance only.
    let by_chance = switch.closes
        || switch.passes
        || Sequence::ends_at_edge(plan.switches(), index)
        || slips && switch.slides()
        || plan.program.shape == ControlShape::Linear;
    let earlier = if by_chance {
        sooner(plan, index, switch, before)
    } else {
        let presses = last.is_some_and(|phase| match switch.slides() {
            true => at_the_edge(plan, phase, switch),
            false => plan.lets_go(phase, phase.stages.last(), switch.contact),
        });
        presses.then(|| with_moved(plan, index, before))
    };
    let presses = next.is_some_and(|phase| {
        let mut rows = phase.openings.iter().chain(&phase.pulled);
        rows.any(|&(contact, row)| contact == switch.contact && plan.presses(row))
    });
    let later = (by_chance || presses).then(|| with_moved(plan, index, after));
    match by_chance {
        true => earlier.into_iter().chain(later).collect(),
        false => later.into_iter().chain(earlier).collect(),
    }
}

/// With a switch at a time before the end of an interval where it happens to be: of an impact that ends the motion, and after which the contact
/// bounces, a touch; of a landing that would be pulled off a touch before it, and the landing after it.
fn sooner(plan: &Pressing, index: usize, switch: &Switch, before: At) -> Option<Neighbour> {
    let node = switch.interval;
    let ends = node == plan.intervals;
    let alone = Sequence::companions(plan.switches(), index).is_empty();
    let touch = Switch::touch(switch.contact, switch.impulse, before.time);
    if ends && alone && plan.bounces(switch.contact) {
        let touched = plan.with(|switches| switches[index] = touch);
        return Some(Neighbour::adjoining(touched));
    }
    if switch.stays() && is_pulled_off(plan, node, switch.contact) {
        let landing = Switch {
            accompanies: false,
            ..switch.at(beside(node).1)
        };
        let twice = plan.with(|switches| {
            switches[index] = touch;
            switches.push(landing);
        });
        return (!ends).then(|| Neighbour::adjoining(twice));
    }
    Some(with_moved(plan, index, before))
}

/// Whether the last force of a phase presses against the edge of the cone beyond which the switch leads.
fn at_the_edge(plan: &Pressing, phase: &Phase, switch: &Switch) -> bool {
    let last = phase.stages.last().map_or(&[][..], |last| &last.tangential);
    let mut own = last.iter().filter(|t| t.contact == switch.contact);
    own.any(|tangential| {
        let mut rows = tangential.rows.iter();
        rows.any(|&(direction, row)| {
            switch.mode == ContactMode::Slip(direction) && plan.presses(row)
        })
    })
}

/// Whether a contact that lands alone where an interval begins, or at the end of the motion, would be pulled off by what drives the motion
/// right before: no motion in which it lands a little earlier, and stays, is near; one in which it is touched then may be.
fn is_pulled_off(plan: &Pressing, interval: usize, contact: usize) -> bool {
    let phases = &plan.program.phases;
    let next = phases.iter().position(|phase| phase.interval == interval);
    let after = next.map(|next| &phases[next]);
    let alone = match after {
        Some(after) => after.closed == [contact],
        None => {
            let mode = |i| plan.sequence.mode_before(plan.switches().len(), i);
            let contacts = 0..plan.sequence.initially.len();
            contacts.filter(|&i| !mode(i).is_open()).eq([contact])
        }
    };
    let before = phases[..next.unwrap_or(phases.len())].last();
    let before = before.and_then(|before| before.stages.last());
    let Some(before) = before.filter(|_| alone) else {
        return false;
    };
    let landed = after.map_or(&plan.program.end, |after| &after.start);
    let acceleration = |drive: &[usize]| {
        let input = landed.iter().chain(drive);
        let input: Vec<f64> = input.map(|&i| plan.x[i]).collect();
        free_normal_acceleration(plan.program.model, contact, &input)
    };
    let then = after.and_then(|after| after.stages.first());
    let then = then.map_or(0.0, |stage| acceleration(&stage.drive));
    acceleration(&before.drive) > LEFT * then.abs()
}

/// With an impact at the final time of a contact that is open until there and touches then: goals may hold it there without any blow, and
/// nothing presses for one. Where it bounces, and presses for being struck, with a touch a little before as well.
fn ended(plan: &Pressing) -> Vec<Neighbour> {
    let Some((phase, stage)) = plan.last_stage() else {
        return Vec::new();
    };
    let before = plan.switches().last().map_or(0.0, |switch| switch.time);
    let time = plan.end() - plan.inserted.min(0.5 * (plan.end() - before));
    let open = |i: &usize| {
        !phase.closed.contains(i) && !phase.closing.contains(i) && !phase.pieces.is_idle(*i)
    };
    let (mut found, mut touches) = (Vec::new(), Vec::new());
    let touching = (0..stage.gap_rows.len()).filter(open);
    for contact in touching.filter(|&contact| plan.touches(contact, stage)) {
        let mode = plan.mode_at(contact, stage, plan.horizon);
        let add = |switch| Neighbour::adjoining(plan.with(|switches| switches.push(switch)));
        let end = At::end_of(plan.intervals);
        found.push(add(Switch::inside(contact, true, mode, plan.end()).at(end)));
        let presses = stage.gap_rows[contact].is_some_and(|row| plan.presses(row));
        if presses && plan.bounces(contact) {
            touches.push(add(Switch::touch(contact, mode, time)));
        }
    }
    found.extend(touches);
    found
}

/// With a flight inserted where a contact force is held at 0, and with a contact inserted where a gap is held at 0: together with the switches
/// that stick these are the places where gap and force vanish together. A flight that passes a surface at the gap margin is none of them.
fn inserted(plan: &Pressing) -> Vec<Neighbour> {
    let mut places: Vec<(usize, bool, ContactMode, f64)> = Vec::new();
    for (phase, solved) in plan.elements() {
        let ending = phase.ends_with.map(|index| &plan.switches()[index]);
        let opens = ending.filter(|switch| switch.opens());
        let opens = opens.map(|switch| switch.contact);
        for (m, (stage, &c)) in phase
            .stages
            .iter()
            .zip(plan.program.tableau.c())
            .enumerate()
        {
            let last = m + 1 == phase.stages.len();
            let time = plan.time(solved, c);
            let forces = phase.closed.iter().zip(&stage.forces);
            for (&contact, &force) in forces.filter(|(contact, _)| **contact < stage.gap_rows.len())
            {
                let exits = last && opens == Some(contact);
                if !exits && plan.is_held(force) {
                    places.push((contact, false, phase.modes[contact], time));
                }
            }
            for (contact, row) in stage.gap_rows.iter().enumerate() {
                let open = !phase.closed.contains(&contact) && !phase.pieces.is_idle(contact);
                let closes = last && phase.closing.contains(&contact);
                let presses = row.is_some_and(|row| plan.presses(row));
                if open && !closes && presses && plan.touches(contact, stage) {
                    let mode = plan.mode_at(contact, stage, solved.start + c * solved.length);
                    places.push((contact, true, mode, time));
                }
            }
        }
    }
    // Gap and force vanish together at every switch; that is no sign of another one nearby.
    places.retain(|&(contact, .., time)| !plan.near(contact, time));
    let neighbour = |(contact, closes, mode, time): (usize, bool, ContactMode, f64)| {
        let (from, until) = ((time - plan.inserted).max(0.0), time + plan.inserted);
        Neighbour::adjoining(plan.with(|switches| {
            for (closes, time) in [(closes, from), (!closes, until)] {
                let after = if closes { mode } else { ContactMode::Open };
                // What begins near the end of the motion lasts until there.
                if time < plan.end() {
                    switches.push(Switch {
                        impulse: mode,
                        ..Switch::inside(contact, closes, after, time)
                    });
                }
            }
        }))
    };
    places.into_iter().map(neighbour).collect()
}
