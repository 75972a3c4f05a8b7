//! Neighbours in which edges are passed elsewhere, or not at all: where the pieces of an edge are as large.

use super::neighbour::{Edit, Neighbour};
use super::pressing::Pressing;
use crate::model::edge;
use crate::ocp::motion::edit_sequence::{lasts_at_edge, touching_at_edge};
use crate::ocp::motion::sequence::{At, Sequence, Switch};
use crate::ocp::tuning::neighbours::CLOSE;
use crate::simulation::ContactMode;

/// Where edges are passed elsewhere, or not at all: without a passage and the way back, with both where a piece is kept though another one is
/// larger, with an end of contact at an edge where the motion presses towards it, with an opening that comes before the edge or not, and with
/// an impact right at the edge.
pub(super) fn edges(plan: &Pressing) -> Vec<Neighbour> {
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
