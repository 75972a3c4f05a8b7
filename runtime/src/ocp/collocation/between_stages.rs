//! The check between the stages: gaps and bounds over the continuous motion of a solved program.

use super::dense_motion::{DenseMotion, POINTS, lows, minimum};
use super::friction_cuts::friction;
use super::layout::{Cut, CutKind, SolvedPhase};
use super::limits::Limits;
use super::program::Collocation;
use crate::model::{Model, contact_point};
use crate::ocp::solution::Excess;

/// Depth below a surface that rounding and collocation may cause right after an opening, relative to the
/// margin.
const DEPTH: f64 = 1e-4;

/// Violation of a bound or a path constraint, relative to the largest value on its side along the motion, that no plan may have.
const VIOLATED: f64 = 1e-4;

/// Violation that counts for none, however small the values along the motion are, as a multiple of what is let pass where conditions are added.
const LET_PASS: f64 = 1e3;

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
    if limits.setting.places.bounds_at_nodes {
        return found;
    }
    let all: Vec<usize> = (0..program.phases.len()).collect();
    let coordinates = program.model.declaration().coordinates.len();
    for k in (0..coordinates).filter(|&k| !limits.setting.parabolas[k]) {
        let bounds = (limits.setting.bounds.0[k], limits.setting.bounds.1[k]);
        if bounds == (f64::NEG_INFINITY, f64::INFINITY) {
            continue;
        }
        let bound = limits.bound * limits.setting.units.states[k];
        for (phase, theta, _) in lows(&all, &mut motion.inside(k, bounds), -bound, bound) {
            found.push(cut(program, phase, theta, CutKind::Bounds(k)));
        }
    }
    for (constraint, inequality) in motion.constraints().into_iter().enumerate() {
        if !inequality {
            continue;
        }
        for (phase, theta, _) in lows(
            &all,
            &mut motion.path(constraint),
            -limits.bound,
            limits.bound,
        ) {
            found.push(cut(program, phase, theta, CutKind::Path(constraint)));
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

/// The largest violation of the bounds of each coordinate and of each path constraint along the whole motion, where there is any.
pub(in crate::ocp) fn excess(program: &Collocation, x: &[f64], limits: Limits) -> Vec<Excess> {
    let mut found = Vec::new();
    each_limit(program, x, limits, |motion, [name, unit], value| {
        found.extend(worst(motion, value).map(|(amount, time)| Excess {
            name: name.to_owned(),
            amount,
            unit: unit.to_owned(),
            time,
        }));
    });
    found
}

/// The first of them by much more than what is let pass where conditions are added, in words: a place so narrow that the motion goes around
/// each condition on it. Where bounds are asked for at nodes only they are left alone.
pub(in crate::ocp) fn violated(program: &Collocation, x: &[f64], limits: Limits) -> Option<String> {
    if limits.setting.places.bounds_at_nodes {
        return None;
    }
    let mut found = None;
    each_limit(program, x, limits, |motion, [name, unit], value| {
        let Some((amount, time)) = worst(motion, value) else {
            return;
        };
        let places = (0..motion.solved.len())
            .flat_map(|phase| (0..=POINTS).map(move |i| (phase, i as f64 / POINTS as f64)));
        let size = places.fold(0.0_f64, |most, (phase, theta)| {
            most.max(value(phase, theta).abs())
        });
        let let_pass = LET_PASS * limits.bound;
        if found.is_none() && amount > (VIOLATED * size).max(let_pass) {
            found = Some(format!(
                "`{name}` is violated by {amount:.1e} {unit} at {time:.6} s, between the places where it is imposed"
            ));
        }
    });
    found
}

/// Looks at the bounds of each coordinate and at each path constraint: name and unit, and what must not be below zero at a place of a phase.
fn each_limit(
    program: &Collocation,
    x: &[f64],
    limits: Limits,
    mut look: impl FnMut(&DenseMotion, [&str; 2], &mut dyn FnMut(usize, f64) -> f64),
) {
    let declaration = program.model.declaration();
    let motion = DenseMotion::new(program, x);
    for (k, coordinate) in declaration.coordinates.iter().enumerate() {
        let bounds = (limits.setting.bounds.0[k], limits.setting.bounds.1[k]);
        if bounds != (f64::NEG_INFINITY, f64::INFINITY) {
            let names = [coordinate.name, coordinate.unit];
            look(&motion, names, &mut motion.inside(k, bounds));
        }
    }
    let constraints = declaration
        .optimal_control
        .map_or(&[][..], |d| d.constraints);
    for (k, constraint) in constraints.iter().enumerate() {
        look(
            &motion,
            [constraint.name, constraint.unit],
            &mut motion.path(k),
        );
    }
}

/// By how much a value of a place in a phase is below 0, where it is so the most, and when that is; nothing where it never is.
fn worst(motion: &DenseMotion, value: &mut dyn FnMut(usize, f64) -> f64) -> Option<(f64, f64)> {
    let mut most: Option<(f64, f64)> = None;
    for (phase, solved) in motion.solved.iter().enumerate() {
        let (mut lowest, mut place) = (f64::INFINITY, 0.0);
        for i in 0..=POINTS {
            let theta = i as f64 / POINTS as f64;
            let here = value(phase, theta);
            if here < lowest {
                (lowest, place) = (here, theta);
            }
        }
        let step = 1.0 / POINTS as f64;
        let (from, to) = ((place - step).max(0.0), (place + step).min(1.0));
        let known = most.map_or(0.0, |(amount, _)| amount);
        if -lowest > known - step * step {
            let better = minimum(&mut |theta| value(phase, theta), from, to);
            let refined = value(phase, better);
            if refined < lowest {
                (lowest, place) = (refined, better);
            }
        }
        if -lowest > known {
            most = Some((-lowest, solved.start + place * solved.length));
        }
    }
    most
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
