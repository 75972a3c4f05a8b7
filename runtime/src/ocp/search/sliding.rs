//! Neighbours in which contacts stick or slip otherwise: where a force is at the edge of its cone, or a sliding velocity at 0.

use super::neighbour::Neighbour;
use super::pressing::Pressing;
use crate::model::tangent_point;
use crate::ocp::collocation::layout::{Phase, SolvedPhase, Stage};
use crate::ocp::motion::model_input::acceleration;
use crate::ocp::motion::sequence::{At, Place, Sequence, Switch};
use crate::ocp::tuning::equal::INSTANT;
use crate::ocp::tuning::neighbours::{ENTRY, LEFT, STUCK};
use crate::simulation::{ContactMode, Direction};

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

/// When the next of these contacts switches after a time, in intervals; infinite if none does.
fn next_switch(switches: &[Switch], contacts: &[usize], time: f64) -> f64 {
    let own = switches.iter().filter(|s| contacts.contains(&s.contact));
    let mut later = own.map(|s| s.time).filter(|&then| then > time);
    later.next().unwrap_or(f64::INFINITY)
}

/// With another way of sliding right from the start: where the first change of a contact sticks there, and where a contact that slips from
/// the start would rather stick. With contacts that come to rest at the end at rest a little before.
pub(super) fn begun(plan: &Pressing) -> Vec<Neighbour> {
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
pub(super) fn turned(plan: &Pressing) -> Vec<Neighbour> {
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
        let lasts = next_switch(switches, &[switch.contact], switch.time) - switch.time;
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
    let next = next_switch(&changed.switches, &contacts, time);
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
pub(super) fn slid(plan: &Pressing) -> Vec<Neighbour> {
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
pub(super) fn struck(plan: &Pressing) -> Vec<Neighbour> {
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
    let lasts = next_switch(plan.switches(), &[contact], time) - time;
    let lasting = Neighbour::without(lasts, sequence.consistent());
    soon.into_iter().chain([lasting]).collect()
}

/// With a stick in the place of each slip in which nothing moves: that holds the force at the edge of its cone, where a stick would leave it
/// free. And with one before each jump of the controls at which a contact turns round, if its force would lie within the cone: no multiplier
/// tells.
pub(super) fn rested(plan: &Pressing) -> Vec<Neighbour> {
    let switches = plan.switches();
    let is_slip = |mode: ContactMode| matches!(mode, ContactMode::Slip(_));
    let mut found = Vec::new();
    for (contact, mode) in plan.sequence.initially.iter().enumerate() {
        let until = next_switch(switches, &[contact], f64::NEG_INFINITY);
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
