//! Neighbours of a sequence in which a contact rests: through a slip in which nothing moves, and before it turns round at a jump of the
//! controls.
//!
//! A slip that never leaves the velocity 0 holds the force at the edge of the friction cone, where a stick would leave it free: the
//! multipliers of the velocities press, but between switches that are an interval apart, where no other switch is inserted. And a contact that
//! turns round where controls jump may come to rest a little before, if the force that holds it then lies within the cone; no
//! multiplier tells.

use super::neighbours::Neighbour;
use super::pressure::Pressure;
use crate::model::tangent_point;
use crate::ocp::collocation::layout::{Phase, SolvedPhase};
use crate::ocp::motion::model_input::acceleration;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::tuning::neighbours::{ENTRY, LEFT};
use crate::simulation::{ContactMode, Direction};

/// Sequences in which one contact rests where it slips.
pub(super) fn resting(pressure: &Pressure) -> Vec<Neighbour> {
    let found = still(pressure).into_iter().chain(before_turning(pressure));
    found.map(Neighbour::adjoining).collect()
}

/// The switches with which a slip begins and ends; none at the start and at the end of the motion.
type Ends = (Option<usize>, Option<usize>);

/// With a stick in the place of each slip in which nothing moves.
fn still(pressure: &Pressure) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let mut found = Vec::new();
    for (contact, mode) in pressure.sequence.initially.iter().enumerate() {
        let first = switches.iter().position(|s| s.contact == contact);
        if is_slip(*mode) && is_still(pressure, contact, (None, first)) {
            let mut sequence = pressure.sequence.clone();
            sequence.initially[contact] = ContactMode::Stick;
            found.push(sequence.consistent());
        }
    }
    for (index, switch) in switches.iter().enumerate() {
        let own = |s: &Switch| s.contact == switch.contact;
        let next = switches[index + 1..].iter().position(own);
        let next = next.map(|next| index + 1 + next);
        let slips = switch.slides() && is_slip(switch.mode);
        if slips && is_still(pressure, switch.contact, (Some(index), next)) {
            let mut sequence = pressure.sequence.clone();
            sequence.switches[index].mode = ContactMode::Stick;
            found.push(sequence.consistent());
        }
    }
    found
}

fn is_slip(mode: ContactMode) -> bool {
    matches!(mode, ContactMode::Slip(_))
}

/// Whether a contact that slips between two switches, or from the start or until the end, does not move at any stage.
fn is_still(pressure: &Pressure, contact: usize, (from, to): Ends) -> bool {
    let switches = &pressure.sequence.switches;
    let begin = from.map_or(0.0, |from| switches[from].time);
    let end = to.map_or(f64::INFINITY, |to| switches[to].time);
    let x = pressure.program.program.physical(&pressure.solution.x);
    let interval = pressure.program.horizon_at(&x) / pressure.intervals as f64;
    let phases = pressure.program.phases.iter();
    let within = phases.zip(pressure.program.solved(&pressure.solution.x));
    let within = within.filter(|(_, solved)| {
        let middle = (solved.start + 0.5 * solved.length) / interval;
        begin < middle && middle < end
    });
    let mut rows = within
        .flat_map(|(phase, _)| velocity_rows(phase, contact))
        .peekable();
    rows.peek().is_some() && rows.all(|row| pressure.slacks[row] < LEFT)
}

/// Rows of the sliding velocities of a contact at the stages.
fn velocity_rows(phase: &Phase, contact: usize) -> impl Iterator<Item = usize> + '_ {
    let stages = phase.stages.iter().flat_map(|stage| &stage.tangential);
    let own = stages.filter(move |t| t.contact == contact && t.force.is_none());
    own.flat_map(|t| &t.rows).map(|&(_, row)| row)
}

/// With a stick before each jump of the controls at which a contact turns round, if its force would lie within the cone.
fn before_turning(pressure: &Pressure) -> Vec<Sequence> {
    let switches = &pressure.sequence.switches;
    let solved = pressure.program.solved(&pressure.solution.x);
    let mut found = Vec::new();
    for (index, switch) in switches.iter().enumerate() {
        let before = pressure.sequence.mode_before(index, switch.contact);
        let turns = switch.slides() && switch.place == Place::Start && !switch.accompanies;
        let (ContactMode::Slip(before), ContactMode::Slip(_)) = (before, switch.mode) else {
            continue;
        };
        let ended = pressure
            .program
            .phases
            .iter()
            .rposition(|phase| phase.interval < switch.interval);
        let alone = Sequence::companions(switches, index).is_empty();
        let Some(ended) = ended.filter(|_| turns && alone) else {
            continue;
        };
        let phase = &pressure.program.phases[ended];
        if !could_stick(pressure, (phase, &solved[ended]), switch.contact, before) {
            continue;
        }
        let time = switch.time - ENTRY;
        let mut sequence = pressure.sequence.clone();
        sequence.switches.push(Switch::inside(
            switch.contact,
            false,
            ContactMode::Stick,
            time,
        ));
        found.extend(sequence.ordered(pressure.intervals));
    }
    found
}

/// Whether the force that would hold a contact at rest at the end of a phase, in which it slips, lies within the cone: under its normal force
/// there.
fn could_stick(
    pressure: &Pressure,
    (phase, solved): (&Phase, &SolvedPhase),
    contact: usize,
    slips: Direction,
) -> bool {
    let model = pressure.program.model;
    let (Some(stage), Some(input)) = (phase.stages.last(), solved.inputs.last()) else {
        return false;
    };
    let x = pressure.program.program.physical(&pressure.solution.x);
    let force = |variable: usize| x[variable] / solved.length;
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
