//! The check between the stages: gaps and bounds over the continuous motion of a solved program.

use super::bounds::{BoundKind, Bounds};
use super::dense_motion::{DenseMotion, POINTS, lows};
use super::friction_cuts::friction;
use super::layout::{Cut, CutKind, SolvedPhase};
use super::limits::Limits;
use super::program::Collocation;
use crate::model::{Model, contact_point};

/// Depth below a surface that rounding and collocation may cause right after an opening, relative to the
/// margin.
const DEPTH: f64 = 1e-4;

/// Share of a phase after an opening, or before a closing, that counts as right there.
const NEAR: f64 = 0.25;
/// Share of the way from there to where the gap is least at which the contact has to part, or to come nearer.
const AFTER: f64 = 0.1;

/// Places where the motion between the stages grazes or enters a surface, or leaves the bounds of a
/// coordinate or a path constraint: minima over the phases, with higher values on either side.
pub(in crate::ocp) fn between_stages(program: &Collocation, x: &[f64], limits: Limits) -> Vec<Cut> {
    let motion = DenseMotion::new(program, x);
    let mut found = gaps(&motion, limits);
    found.extend(departures(program, &motion.solved, limits));
    found.extend(friction(&motion, limits));
    let bounds = Bounds::new(limits.setting);
    if bounds.all.is_empty() {
        return found;
    }
    let all: Vec<usize> = (0..program.phases.len()).collect();
    let table = motion.table(&bounds);
    for (k, bound) in bounds.all.iter().enumerate() {
        let (kind, unit) = match bound.kind {
            BoundKind::Coordinate(c, _) if limits.setting.parabolas[c] => continue,
            BoundKind::Path(_, true) => continue,
            BoundKind::Coordinate(c, _) => (CutKind::Bounds(c), limits.setting.units.states[c]),
            BoundKind::Path(i, false) => (CutKind::Path(i), 1.0),
        };
        let mut value = |phase: usize, theta: f64| {
            let place = theta * POINTS as f64;
            match place.fract() == 0.0 {
                true => table[phase][place as usize][k],
                false => motion.bounds(&bounds, phase, theta)[k],
            }
        };
        let let_pass = limits.bound * unit;
        for (phase, theta, _) in lows(&all, &mut value, -let_pass, let_pass) {
            found.push(cut(program, phase, theta, kind));
        }
    }
    found
}

fn cut(program: &Collocation, phase: usize, theta: f64, kind: CutKind) -> Cut {
    Cut {
        interval: program.phases[phase].interval,
        phase: program.phases[phase].index,
        theta,
        kind,
    }
}

/// Places where flights graze or enter a surface.
fn gaps(motion: &DenseMotion, limits: Limits) -> Vec<Cut> {
    let program = motion.program;
    let model = program.model;
    let declaration = model.declaration();
    let mut input = vec![0.0; declaration.inputs()];
    let mut found = Vec::new();
    for (contact, declared) in declaration.contacts.iter().enumerate() {
        // The pieces of an edge are one surface.
        if declared.alternatives.iter().any(|&other| other < contact) {
            continue;
        }
        let acting = |phase: usize| program.phases[phase].pieces.acting(contact);
        let mut gap = |phase: usize, theta: f64| {
            motion.write(phase, theta, &mut input);
            model.gap(acting(phase), &input)
        };
        let mut next = 0;
        while next < program.phases.len() {
            let open = |phase: &usize| !program.phases[*phase].closed.contains(&acting(*phase));
            // A flight ends where the contact closes or is touched.
            let lands = |phase: &usize| program.phases[*phase].closing.contains(&acting(*phase));
            let until = (next..program.phases.len()).find(lands);
            let until = until.map_or(program.phases.len(), |last| last + 1);
            let flight: Vec<usize> = (next..until).take_while(open).collect();
            next += flight.len().max(1);
            let depth = DEPTH * limits.margin_of(contact);
            for low in lows(&flight, &mut gap, limits.gap_of(contact), depth) {
                let phase = low.0;
                let ends = (phase == flight[0], lands(&phase));
                found.extend(gap_cut(motion, limits, acting(phase), low, ends));
            }
        }
    }
    found
}

/// The condition on a contact where its gap is low, at the share `theta` of a phase, `between` places where it is not; `ends` say whether the
/// phase is the one after its opening, or before its closing. None where the low is an error of the interpolation.
fn gap_cut(
    motion: &DenseMotion,
    limits: Limits,
    contact: usize,
    (phase, theta, between): (usize, f64, bool),
    ends: (bool, bool),
) -> Option<Cut> {
    let program = motion.program;
    let (model, tableau) = (program.model, program.tableau);
    let depth = DEPTH * limits.margin_of(contact);
    let mut smooth = vec![0.0; model.declaration().inputs()];
    motion.write_smooth(phase, theta, &mut smooth);
    let low = if between {
        limits.gap_of(contact)
    } else {
        -depth
    };
    if model.gap(contact, &smooth) >= low {
        return None;
    }
    let moves = |weights: &[f64]| moves(model, &motion.solved[phase], contact, weights);
    // Right after an opening the gap grows with a high power of the time: its acceleration says more. So does the velocity right
    // before a closing.
    if !between && ends.0 && theta < NEAR {
        let soon = AFTER * theta;
        let returns = moves(&tableau.slopes_with_start(soon)) < -depth;
        return returns.then(|| cut(program, phase, soon, CutKind::Departure(contact)));
    }
    if !between && ends.1 && theta > 1.0 - NEAR {
        let late = 1.0 - AFTER * (1.0 - theta);
        let parts = moves(&tableau.values_with_start(late)) > depth;
        return parts.then(|| cut(program, phase, late, CutKind::Approach(contact)));
    }
    // Elsewhere there is no room for the whole margin.
    let share = if between { 1.0 } else { DEPTH };
    let kind = CutKind::Gap(contact, share * limits.margin_of(contact));
    Some(cut(program, phase, theta, kind))
}

/// Flights that pass a jump of the controls so shortly after their opening that they are still on the surface,
/// and are pushed back onto it after the jump. A contact that is touched at the jump leaves with its own velocity.
fn departures(program: &Collocation, solved: &[SolvedPhase], limits: Limits) -> Vec<Cut> {
    let model = program.model;
    let declaration = model.declaration();
    let slopes = program.tableau.slopes_with_start(0.0);
    let mut found = Vec::new();
    for (index, (phase, solved)) in program.phases.iter().zip(solved).enumerate() {
        if phase.index.0 > 0 || index == 0 {
            continue;
        }
        let before = &program.phases[index - 1];
        for contact in 0..declaration.contacts.len() {
            let touched = before.closing.contains(&contact);
            let idle = phase.pieces.is_idle(contact) || before.pieces.is_idle(contact);
            if idle
                || touched
                || phase.closed.contains(&contact)
                || before.closed.contains(&contact)
            {
                continue;
            }
            let acceleration = moves(model, solved, contact, &slopes);
            if model.gap(contact, &solved.inputs[0]) < limits.gap_of(contact)
                && acceleration < -DEPTH * limits.margin_of(contact)
            {
                found.push(cut(program, index, 0.0, CutKind::Departure(contact)));
            }
        }
    }
    found
}

/// Way that a contact would part, or come nearer, at its normal velocity for the length of the phase, where the polynomials of the nodes
/// have these values; with their slopes, at its acceleration.
fn moves(model: &dyn Model, solved: &SolvedPhase, contact: usize, weights: &[f64]) -> f64 {
    let mut point = vec![0.0; contact_point::length(model.declaration().coordinates.len())];
    let nodes = solved.inputs.iter().zip(weights);
    let velocities = nodes.map(|(input, weight)| {
        model.contact(contact, input, &mut point);
        weight * point[contact_point::NORMAL_VELOCITY]
    });
    solved.length * velocities.sum::<f64>()
}
