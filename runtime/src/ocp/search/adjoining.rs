//! Neighbours of a plan: contact sequences that differ from its own by one edit, at a place where it presses for that.
//!
//! The plan is a limit of motions with such a sequence: a phase that is inserted, moved or left out has no length in it. So a claim about the
//! plan needs an answer of each of them. Where gap and force vanish together a contact may close or open otherwise, where a force is at the
//! edge of its cone or a sliding velocity at 0 it may stick or slip otherwise, and where the pieces of an edge are as large another one may act.

use super::pressing::Pressing;
use crate::model::{edge, tangent_point};
use crate::ocp::collocation::layout::{Phase, SolvedPhase, Stage};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::edit_sequence::{lasts_at_edge, touching_at_edge, without};
use crate::ocp::motion::model_input::{acceleration, free_normal_acceleration};
use crate::ocp::motion::sequence::{At, Place, Sequence, Switch};
use crate::ocp::tuning::equal::INSTANT;
use crate::ocp::tuning::neighbours::{APART, CLOSE, ENTRY, LEFT, SHORT, STUCK};
use crate::simulation::{ContactMode, Direction};

/// A sequence that differs from that of a plan by one edit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Neighbour {
    pub(super) sequence: Sequence,
    /// Whether the plan is a limit of motions with this sequence, so that a claim about it needs an answer of it. None is needed of a
    /// sequence without a contact, a flight or a slip that lasts.
    pub(super) adjoins: bool,
}

impl Neighbour {
    fn adjoining(sequence: Sequence) -> Self {
        let adjoins = true;
        Self { sequence, adjoins }
    }

    /// A sequence without what lasts that many intervals.
    fn without(lasts: f64, sequence: Sequence) -> Self {
        let adjoins = lasts < APART;
        Self { sequence, adjoins }
    }
}

/// What an edit makes of a plan.
type Edit = fn(&Pressing) -> Vec<Neighbour>;

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

/// A change of the way of sliding, for a while.
struct Change {
    contact: usize,
    to: ContactMode,
    back: ContactMode,
}

fn slide(contact: usize, mode: ContactMode, at: At) -> Switch {
    Switch::inside(contact, false, mode, at.time).at(at)
}

/// With contacts that slide otherwise from a place on, or from the start, and back a little after a time unless the motion ends before.
fn slid_around(
    plan: &Pressing,
    changes: &[Change],
    (from, time): (Option<At>, f64),
) -> Option<Neighbour> {
    let until = time + plan.inserted;
    let mut sequence = plan.sequence.clone();
    for (index, change) in changes.iter().enumerate() {
        let accompanies = index > 0;
        let mut push = |mode: ContactMode, at: At| {
            sequence.switches.push(Switch {
                accompanies,
                ..slide(change.contact, mode, at)
            });
        };
        match from {
            Some(from) => push(change.to, from),
            None => sequence.initially[change.contact] = change.to,
        }
        if until < plan.end() {
            push(change.back, At::inside(until));
        }
    }
    (!changes.is_empty()).then(|| Neighbour::adjoining(sequence))
}

/// With another way of sliding right from the start: where the first change of a contact sticks there, and where a contact that slips from
/// the start would rather stick. With contacts that come to rest at the end at rest a little before.
fn begun(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        let own = |s: &Switch| s.contact == switch.contact;
        let first = !switches[..index].iter().any(own);
        if first && switch.slides() && !switch.accompanies && switch.time < STUCK {
            let mut sequence = plan.sequence.clone();
            let last = index + Sequence::companions(switches, index).len();
            for member in sequence.switches.drain(index..=last) {
                sequence.initially[member.contact] = member.mode;
            }
            found.push(Neighbour::adjoining(sequence));
        }
    }
    let first = plan.program.phases.first();
    let pulled = first.map_or(&[][..], |first| &first.pulled).iter();
    let pulled: Vec<usize> = pulled
        .filter(|(_, row)| plan.presses(*row))
        .map(|&(contact, _)| contact)
        .collect();
    for until in [At::inside(ENTRY), At::end_of(1)] {
        let mut sequence = plan.sequence.clone();
        for (index, &contact) in pulled.iter().enumerate() {
            let mode = std::mem::replace(&mut sequence.initially[contact], ContactMode::Stick);
            sequence.switches.push(Switch {
                accompanies: index > 0,
                ..slide(contact, mode, until)
            });
        }
        found.extend((!pulled.is_empty()).then(|| Neighbour::adjoining(sequence)));
    }
    if let Some((_, stage)) = plan.last_stage() {
        let rests = |contact: usize| {
            plan.mode_at(contact, stage, plan.horizon) == ContactMode::Stick
                && !plan.near(contact, plan.end())
        };
        let slipping = stage.tangential.iter();
        let slipping = slipping.filter(|t| t.mode != ContactMode::Stick && rests(t.contact));
        let changes = slipping.map(|t| Change {
            contact: t.contact,
            to: ContactMode::Stick,
            back: t.mode,
        });
        let changes: Vec<Change> = changes.collect();
        let from = At::inside((plan.end() - plan.inserted).max(0.0));
        found.extend(slid_around(plan, &changes, (Some(from), plan.end())));
    }
    found
}

/// With a slip in the place of a stick whose force is held in the cone, or before it: a contact that has just come to rest is pulled on or back.
fn turned(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        if switch.accompanies || !switch.slides() || switch.mode != ContactMode::Stick {
            continue;
        }
        let after = plan.around(index).1;
        let pressed = after.and_then(|after| plan.program.phases.get(after));
        let pressed = pressed.and_then(|phase| {
            let start = phase.cones.iter().filter(|cone| cone.0 == switch.contact);
            let stages = phase.stages.iter().flat_map(|stage| &stage.tangential);
            let stages = stages.filter(|tangential| tangential.contact == switch.contact);
            start
                .map(|&(_, direction, row)| (direction, row))
                .chain(stages.flat_map(|t| t.rows.iter().copied()))
                .find(|&(_, row)| plan.presses(row))
        });
        let Some((direction, _)) = pressed else {
            continue;
        };
        let before = |contact: usize| plan.sequence.mode_before(index, contact);
        let back = before(switch.contact) != ContactMode::Slip(direction);
        let group = index..=index + Sequence::companions(switches, index).len();
        let sequence = plan.with(|switches| {
            for member in &mut switches[group.clone()] {
                member.mode = match before(member.contact) {
                    ContactMode::Slip(direction) if back => ContactMode::Slip(direction.reversed()),
                    before => before,
                };
            }
        });
        if back {
            let rest = switches[group].iter().map(|s| (s.contact, s.mode));
            let rest: Vec<(usize, ContactMode)> = rest.collect();
            found.extend(until_soon(plan, &sequence, &rest, switch.time));
        }
        let lasts = Pressing::after(switches, &[switch.contact], switch.time) - switch.time;
        found.push(Neighbour::without(lasts, sequence.consistent()));
    }
    found
}

/// A sequence in which contacts come back to other modes soon after a time, unless the motion ends before.
fn until_soon(
    plan: &Pressing,
    changed: &Sequence,
    back: &[(usize, ContactMode)],
    time: f64,
) -> Option<Neighbour> {
    let contacts: Vec<usize> = back.iter().map(|back| back.0).collect();
    let next = Pressing::after(&changed.switches, &contacts, time);
    let then = time + plan.inserted.min(0.5 * (next - time));
    let mut sequence = changed.clone();
    for (index, &(contact, mode)) in back.iter().enumerate() {
        sequence.switches.push(Switch {
            accompanies: index > 0,
            ..Switch::inside(contact, false, mode, then)
        });
    }
    (then < plan.end()).then(|| Neighbour::adjoining(sequence))
}

/// With another way of sliding inserted for a while, for all contacts together that press for it.
fn slid(plan: &Pressing) -> Vec<Neighbour> {
    let declared = plan.program.model.declaration().contacts;
    let mut found = Vec::new();
    for (phase, solved) in plan.elements() {
        // At a jump of the controls the force may leave the cone at once.
        let time = plan.time(solved, 0.0);
        let cones = phase.cones.iter();
        let cones = cones.filter(|cone| phase.index.0 == 0 && plan.presses(cone.2));
        let changes = cones.filter(|cone| !plan.near(cone.0, time));
        let changes = changes.map(|&(contact, direction, _)| Change {
            contact,
            to: ContactMode::Slip(direction),
            back: ContactMode::Stick,
        });
        let from = (time >= STUCK).then(|| At::end_of(time.round() as usize));
        found.extend(slid_around(
            plan,
            &changes.collect::<Vec<_>>(),
            (from, time),
        ));
        for (theta, rows) in friction_rows(phase, plan.program.tableau.c()) {
            let time = plan.time(solved, theta);
            let rows = rows.into_iter();
            let pressed = rows.filter(|&(i, _, row)| plan.presses(row) && !plan.near(i, time));
            let known = |(contact, direction, _)| (contact, phase.modes[contact], direction);
            let mut pressed: Vec<(usize, ContactMode, Direction)> = pressed.map(known).collect();
            pressed.dedup_by_key(|known| known.0);
            // A contact that turns round without a jump of the controls sticks on the way, as friction pushes it the
            // other way then.
            let at_a_jump = (time - time.round()).abs() < plan.inserted;
            // What acts on the other side of a switch says nothing of how the motion comes there.
            let crosses = |contact: usize| declared[contact].switch.is_some();
            let turns = at_a_jump || pressed.iter().any(|known| crosses(known.0));
            let from = At::inside((time - plan.inserted).max(0.0));
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
                found.extend(slid_around(plan, &changes, (Some(from), time)));
            }
        }
    }
    found
}

/// Conditions on friction: contact, direction and row.
type Rows = Vec<(usize, Direction, usize)>;

/// The conditions on friction inside an element by the share of its length at which they are: those at one instant together.
fn friction_rows(phase: &Phase, nodes: &[f64]) -> Vec<(f64, Rows)> {
    let rows = |stage: &Stage| -> Rows {
        let tangential = stage.tangential.iter();
        let rows = tangential.flat_map(|t| t.rows.iter().map(|&(d, row)| (t.contact, d, row)));
        rows.collect()
    };
    let stages = phase.stages.iter().zip(nodes);
    let mut places: Vec<(f64, Rows)> = stages.map(|(stage, &c)| (c, rows(stage))).collect();
    for &(theta, contact, direction, row) in &phase.between {
        let same = |place: &&mut (f64, Rows)| (place.0 - theta).abs() <= INSTANT;
        match places.iter_mut().find(same) {
            Some(place) => place.1.push((contact, direction, row)),
            None => places.push((theta, vec![(contact, direction, row)])),
        }
    }
    places
}

/// With another law between the impulses of an impact, and the way of sliding that follows, for a while or until the next switch.
fn struck(plan: &Pressing) -> Vec<Neighbour> {
    let mut found = Vec::new();
    for (index, tangential) in &plan.program.impacts {
        let mut rows = tangential.rows.iter();
        let Some(&(direction, _)) = rows.find(|(_, row)| plan.presses(*row)) else {
            continue;
        };
        let (stick, slip) = (ContactMode::Stick, ContactMode::Slip(direction));
        let back = ContactMode::Slip(direction.reversed());
        let laws = match tangential.mode {
            ContactMode::Stick => &[(slip, slip)][..],
            _ => &[(stick, stick), (stick, back), (stick, slip)],
        };
        for law in laws {
            found.extend(with_law(plan, *index, tangential.contact, *law));
        }
    }
    found
}

/// With that law for the impulse of a contact in an impact, and that way of sliding afterwards.
fn with_law(
    plan: &Pressing,
    index: usize,
    contact: usize,
    (impulse, mode): (ContactMode, ContactMode),
) -> Vec<Neighbour> {
    let mut sequence = plan.sequence.clone();
    let companions = Sequence::companions(&sequence.switches, index).len();
    let mut struck = sequence.switches[index..=index + companions].iter_mut();
    let mut before = plan.sequence.mode_before(index, contact);
    if let Some(switch) = struck.find(|s| s.contact == contact) {
        before = switch.mode;
        switch.impulse = impulse;
        if !switch.mode.is_open() {
            switch.mode = mode;
        }
    } else {
        let companion = Switch {
            contact,
            closes: false,
            mode,
            impulse,
            accompanies: true,
            ..plan.switches()[index]
        };
        sequence.switches.insert(index + 1, companion);
    }
    if before.is_open() || before == mode {
        return vec![Neighbour::adjoining(sequence.consistent())];
    }
    let time = plan.switches()[index].time;
    let soon = until_soon(plan, &sequence, &[(contact, before)], time);
    let lasts = Pressing::after(plan.switches(), &[contact], time) - time;
    let lasting = Neighbour::without(lasts, sequence.consistent());
    soon.into_iter().chain([lasting]).collect()
}

/// With a stick in the place of each slip in which nothing moves: that holds the force at the edge of its cone, where a stick would leave it
/// free. And with one before each jump of the controls at which a contact turns round, if its force would lie within the cone: no multiplier
/// tells.
fn rested(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let is_slip = |mode: ContactMode| matches!(mode, ContactMode::Slip(_));
    let mut found = Vec::new();
    for (contact, mode) in plan.sequence.initially.iter().enumerate() {
        let until = Pressing::after(switches, &[contact], f64::NEG_INFINITY);
        if is_slip(*mode) && is_still(plan, contact, (0.0, until)) {
            let mut sequence = plan.sequence.clone();
            sequence.initially[contact] = ContactMode::Stick;
            found.push(Neighbour::adjoining(sequence.consistent()));
        }
    }
    for (index, switch) in switches.iter().enumerate() {
        let mut rest = switches[index + 1..].iter();
        let next = rest.find(|s| s.contact == switch.contact);
        let until = next.map_or(f64::INFINITY, |next| next.time);
        let slips = switch.slides() && is_slip(switch.mode);
        if slips && is_still(plan, switch.contact, (switch.time, until)) {
            let still = plan.with(|switches| switches[index].mode = ContactMode::Stick);
            found.push(Neighbour::adjoining(still.consistent()));
        }
    }
    for (index, switch) in switches.iter().enumerate() {
        let before = plan.sequence.mode_before(index, switch.contact);
        let (ContactMode::Slip(before), ContactMode::Slip(_)) = (before, switch.mode) else {
            continue;
        };
        let alone = Sequence::companions(switches, index).is_empty() && !switch.accompanies;
        let turns = alone && switch.slides() && switch.place == Place::Start;
        let ended = plan.around(index).0.filter(|_| turns);
        let ended = ended.map(|ended| (&plan.program.phases[ended], &plan.solved[ended]));
        if ended.is_some_and(|ended| could_stick(plan, ended, switch.contact, before)) {
            let at = switch.time - ENTRY;
            let stick = Switch::inside(switch.contact, false, ContactMode::Stick, at);
            let resting = plan.with(|switches| switches.push(stick));
            found.push(Neighbour::adjoining(resting));
        }
    }
    found
}

/// Whether a contact that slips between two times, in intervals, does not move at any stage.
fn is_still(plan: &Pressing, contact: usize, (from, until): (f64, f64)) -> bool {
    let within = plan.elements().filter(|(_, solved)| {
        let middle = plan.time(solved, 0.5);
        from < middle && middle < until
    });
    let stages = within.flat_map(|(phase, _)| &phase.stages);
    let own = stages.flat_map(|stage| &stage.tangential);
    let own = own.filter(|t| t.contact == contact && t.force.is_none());
    let mut rows = own.flat_map(|t| &t.rows).peekable();
    rows.peek().is_some() && rows.all(|&(_, row)| plan.slacks[row] < LEFT)
}

/// Whether the force that would hold a contact at rest at the end of a phase, in which it slips, lies within the cone: under its normal force
/// there.
fn could_stick(
    plan: &Pressing,
    (phase, solved): (&Phase, &SolvedPhase),
    contact: usize,
    slips: Direction,
) -> bool {
    let model = plan.program.model;
    let (Some(stage), Some(input)) = (phase.stages.last(), solved.inputs.last()) else {
        return false;
    };
    let force = |variable: usize| plan.x[variable] / solved.length;
    let mut forces: Vec<(usize, f64, f64)> = Vec::new();
    let mut friction = 0.0;
    for (&closed, &normal) in phase.closed.iter().zip(&stage.forces) {
        let normal = force(normal);
        let own = stage.tangential.iter().find(|t| t.contact == closed);
        let tangential = own.map_or(0.0, |t| match (t.force, t.mode) {
            (Some(variable), _) => force(variable),
            (None, ContactMode::Slip(direction)) => {
                -direction.sign() * model.friction(closed) * normal
            }
            (None, _) => 0.0,
        });
        if closed == contact {
            friction = model.friction(closed) * normal;
        }
        forces.push((closed, normal, tangential));
    }
    let n = model.declaration().coordinates.len();
    let a = acceleration(model, input, &forces);
    let mut point = vec![0.0; tangent_point::length(n)];
    model.tangent(contact, input, &mut point);
    let tangent = &point[tangent_point::TANGENT..][..n];
    let direction = &point[tangent_point::direction(n)..][..n];
    let dot = |along: &[f64]| tangent.iter().zip(along).map(|(b, a)| b * a).sum::<f64>();
    // From the friction of the slip to that of the opposite one.
    let slowed = -slips.sign() * (dot(&a) + point[tangent_point::CURVATURE]);
    let range = 2.0 * friction * dot(direction);
    LEFT * range < slowed && slowed < (1.0 - LEFT) * range
}

/// Where edges are passed elsewhere, or not at all: without a passage and the way back, with both where a piece is kept though another one is
/// larger, with an end of contact at an edge where the motion presses towards it, with an opening that comes before the edge or not, and with
/// an impact right at the edge.
fn edges(plan: &Pressing) -> Vec<Neighbour> {
    if edge(plan.program.model).is_none() {
        return Vec::new();
    }
    let edits: [Edit; 5] = [passed_back, let_go, gone_on, touched_at_edges, passed];
    edits.iter().flat_map(|edit| edit(plan)).collect()
}

/// Whether a switch is of another piece of the edge of a contact.
fn is_other(plan: &Pressing, contact: usize, switch: &Switch) -> bool {
    let contacts = plan.program.model.declaration().contacts;
    contacts[contact].alternatives.contains(&switch.contact)
}

/// Without two passages that lead back to the same piece.
fn passed_back(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (i, there) in switches.iter().enumerate() {
        let left = plan.sequence.pieces_before(i).acting(there.contact);
        let own = |s: &&Switch| s.passes && (s.contact == left || is_other(plan, left, s));
        let back = switches[i + 1..].iter().find(own);
        let Some(back) = back.filter(|back| back.contact == left) else {
            continue;
        };
        let lasts = back.time - there.time;
        if there.passes && !there.accompanies && lasts < CLOSE {
            let staying = plan.with(|switches| switches.retain(|s| s != there && s != back));
            found.push(Neighbour::without(lasts, staying));
        }
    }
    found
}

/// With a contact that opens before the edge at which it ends, and with one that ends at the edge that it passes soon after its opening.
fn let_go(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (index, opening) in switches.iter().enumerate().filter(|(_, s)| s.opens()) {
        if Sequence::ends_at_edge(switches, index) {
            let ended = plan.around(index).0.map(|last| &plan.program.phases[last]);
            if ended.is_some_and(|ended| plan.lets_go(ended, ended.stages.last(), opening.contact))
            {
                let at = At::inside((opening.time - plan.inserted).max(0.0));
                let before = plan.with(|switches| switches[index] = opening.at(at));
                found.push(Neighbour::adjoining(before));
            }
            continue;
        }
        let mut rest = switches[index + 1..].iter().enumerate();
        let own = rest.find(|(_, s)| is_other(plan, opening.contact, s));
        let passage = own.filter(|(_, s)| s.passes && s.time - opening.time < CLOSE);
        if let Some((after, &passage)) = passage {
            let ending = plan.with(|switches| {
                switches.remove(index + 1 + after);
                let end = opening.at(passage.place());
                let end = Switch {
                    accompanies: passage.accompanies,
                    ..end
                };
                let passage = Switch {
                    accompanies: true,
                    ..passage
                };
                switches.splice(index..=index, [end, passage]);
            });
            found.push(Neighbour::without(passage.time - opening.time, ending));
        }
    }
    found
}

/// With a contact that takes over from one that opens a little before it closes, and with one that takes over closing later.
fn gone_on(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for (i, opening) in switches.iter().enumerate().filter(|(_, s)| s.opens()) {
        let Some(j) = (i + 1..switches.len()).find(|&j| !switches[j].passes) else {
            continue;
        };
        let closing = &switches[j];
        if opening.accompanies || !closing.stays() || closing.contact == opening.contact {
            continue;
        }
        let lasts = closing.time - opening.time;
        if Sequence::takes_over(switches, j) {
            let phases = &plan.program.phases;
            let ended = phases.iter().position(|p| p.ends_with == Some(i));
            let next = ended.and_then(|ended| phases.get(ended + 1));
            if next.is_some_and(|next| plan.lets_go(next, next.stages.first(), closing.contact)) {
                let at = At::inside(closing.time + plan.inserted);
                found.push(Neighbour::adjoining(plan.with(|switches| {
                    switches[j] = Switch {
                        accompanies: false,
                        ..closing.at(at)
                    };
                })));
            }
        } else if !closing.accompanies && lasts < CLOSE {
            let at = At::inside(0.5 * (opening.time + closing.time));
            let taking_over = plan.with(|switches| {
                for (index, switch) in switches[i..=j].iter_mut().enumerate() {
                    *switch = Switch {
                        accompanies: index > 0,
                        ..switch.at(at)
                    };
                }
            });
            found.push(Neighbour::without(lasts, taking_over));
        }
    }
    found
}

/// With a touch at the edge in the place of a contact that ends there soon after its impact, and with that contact, or with the passage alone,
/// in the place of such a touch.
fn touched_at_edges(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let mut found = Vec::new();
    for pair in plan.sequence.neighbours() {
        let lasts = lasts_at_edge(plan.sequence, pair);
        if let Some(lasts) = lasts.filter(|&lasts| lasts < CLOSE) {
            let touch = touching_at_edge(plan.sequence, pair);
            found.push(Neighbour::without(lasts, touch));
        }
    }
    for (i, touch) in switches.iter().enumerate().filter(|(_, s)| s.touches()) {
        let mut companions = Sequence::companions(switches, i).iter();
        let Some(passage) = companions.position(|s| s.passes).map(|k| i + 1 + k) else {
            continue;
        };
        found.push(Neighbour::adjoining(plan.with(|switches| {
            switches[passage].accompanies = touch.accompanies;
            switches.remove(i);
        })));
        let time = touch.time + plan.inserted;
        found.push(Neighbour::adjoining(plan.with(|switches| {
            let passed = switches.remove(passage);
            switches[i].mode = touch.impulse;
            switches.extend(end_at_edge(touch.contact, passed.contact, time));
        })));
    }
    found
}

/// The end of a contact at the edge to another piece.
fn end_at_edge(contact: usize, other: usize, time: f64) -> [Switch; 2] {
    let passage = Switch {
        accompanies: true,
        ..Switch::passage(other, time)
    };
    [
        Switch::inside(contact, false, ContactMode::Open, time),
        passage,
    ]
}

/// With what a row of a piece of an edge presses for: the end of the contact of the piece that acts, unless it switches near that time, or the
/// passage to another piece for a while.
fn passed(plan: &Pressing) -> Vec<Neighbour> {
    let contacts = plan.program.model.declaration().contacts;
    let mut found = Vec::new();
    for (phase, solved) in plan.elements() {
        for (stage, &c) in phase.stages.iter().zip(plan.program.tableau.c()) {
            let time = plan.time(solved, c);
            let (from, back) = ((time - plan.inserted).max(0.0), time + plan.inserted);
            let rows = stage.gap_rows.iter().enumerate();
            for (contact, _) in rows.filter(|(_, row)| row.is_some_and(|row| plan.presses(row))) {
                let acting = phase.pieces.acting(contact);
                if acting != contact && phase.closed.contains(&acting) {
                    if !plan.near(acting, time) {
                        let ended = end_at_edge(acting, contact, from);
                        let ended = plan.with(|switches| switches.extend(ended));
                        found.push(Neighbour::adjoining(ended));
                    }
                    continue;
                }
                let gap = |contact: usize| plan.gap(contact, stage);
                let others = contacts[contact].alternatives.iter().copied();
                let larger = others.max_by(|&a, &b| gap(a).total_cmp(&gap(b)));
                let larger = larger.filter(|&other| gap(other) > gap(contact));
                if let Some(other) = larger.filter(|_| acting == contact) {
                    found.push(Neighbour::adjoining(plan.with(|switches| {
                        switches.push(Switch::passage(other, from));
                        let back = (back < plan.end()).then(|| Switch::passage(contact, back));
                        switches.extend(back);
                    })));
                }
            }
        }
    }
    found
}
