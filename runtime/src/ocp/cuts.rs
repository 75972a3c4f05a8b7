//! The check between the stages: gaps and bounds over the continuous motion of a solved program.

use super::collocation::{Collocation, Cut, CutKind, SolvedPhase, lagrange};
use crate::model::contact_point;

/// Points of a phase that are looked at.
const POINTS: usize = 64;

/// Depth below a surface that rounding and collocation may cause right after an opening, relative to the
/// margin.
const DEPTH: f64 = 1e-4;

/// What to look for.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    /// Gaps below this are grazing or penetrating.
    pub(super) gap: f64,
    /// Gap that a cut asks for.
    pub(super) margin: f64,
    /// Largest violation of a bound of a coordinate that is let pass.
    pub(super) bound: f64,
    pub(super) bounds: (&'a [f64], &'a [f64]),
}

/// Places where the motion between the stages grazes or enters a surface, or leaves the bounds of a
/// coordinate: minima over the phases, with higher values on either side.
pub(super) fn between_stages(
    program: &Collocation,
    x: &[f64],
    parabolas: &[bool],
    limits: Limits,
) -> Vec<Cut> {
    let model = program.model;
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut input = vec![0.0; declaration.inputs()];
    let mut found = Vec::new();
    let solved = program.solved(x);
    let cut = |phase: usize, theta: f64, kind: CutKind| Cut {
        interval: program.phases[phase].interval,
        phase: program.phases[phase].index,
        theta,
        kind,
    };
    for contact in 0..declaration.contacts.len() {
        let mut gap = |phase: usize, theta: f64| {
            for (k, slot) in input.iter_mut().take(n).enumerate() {
                *slot = program.dense(&solved[phase].states, theta, k);
            }
            model.gap(contact, &input)
        };
        let mut next = 0;
        while next < program.phases.len() {
            let open = |phase: &usize| !program.phases[*phase].closed.contains(&contact);
            let flight: Vec<usize> = (next..program.phases.len()).take_while(open).collect();
            next += flight.len().max(1);
            let depth = DEPTH * limits.margin;
            for (phase, theta, between) in lows(&flight, &mut gap, (limits.gap, depth)) {
                // Near an opening there is no room for the whole margin.
                let share = if between { 1.0 } else { DEPTH };
                found.push(cut(
                    phase,
                    theta,
                    CutKind::Gap(contact, share * limits.margin),
                ));
            }
        }
    }
    found.extend(departures(program, &solved, limits));
    for k in (0..n).filter(|&k| !parabolas[k]) {
        let (lower, upper) = (limits.bounds.0[k], limits.bounds.1[k]);
        if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
            continue;
        }
        let mut inside = |phase: usize, theta: f64| {
            let value = program.dense(&solved[phase].states, theta, k);
            (value - lower).min(upper - value)
        };
        let all: Vec<usize> = (0..program.phases.len()).collect();
        for (phase, theta, _) in lows(&all, &mut inside, (-limits.bound, limits.bound)) {
            found.push(cut(phase, theta, CutKind::Bounds(k)));
        }
    }
    found
}

/// Flights that pass a jump of the controls so shortly after their opening that they are still on the surface,
/// and are pushed back onto it after the jump.
fn departures(program: &Collocation, solved: &[SolvedPhase], limits: Limits) -> Vec<Cut> {
    let model = program.model;
    let declaration = model.declaration();
    let mut input = vec![0.0; declaration.inputs()];
    let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
    let slopes = lagrange(program.tableau, 0.0, true);
    let mut found = Vec::new();
    for (index, (phase, solved)) in program.phases.iter().zip(solved).enumerate() {
        if phase.index.0 > 0 || index == 0 {
            continue;
        }
        let before = &program.phases[index - 1];
        for contact in 0..declaration.contacts.len() {
            if phase.closed.contains(&contact) || before.closed.contains(&contact) {
                continue;
            }
            let (mut gap, mut acceleration) = (f64::INFINITY, 0.0);
            for (node, (state, slope)) in solved.states.iter().zip(&slopes).enumerate() {
                input[..state.len()].copy_from_slice(state);
                model.contact(contact, &input, &mut point);
                if node == 0 {
                    gap = point[contact_point::GAP];
                }
                acceleration += slope * point[contact_point::NORMAL_VELOCITY];
            }
            if gap < limits.gap && acceleration < -DEPTH * limits.margin {
                found.push(Cut {
                    interval: phase.interval,
                    phase: phase.index,
                    theta: 0.0,
                    kind: CutKind::Departure(contact),
                });
            }
        }
    }
    found
}

/// Local minima below the limit of a function over consecutive phases, as (phase, theta, whether the function
/// exceeds the limit before and after): those of which that is true, and those deeper than the depth.
fn lows(
    phases: &[usize],
    value: &mut dyn FnMut(usize, f64) -> f64,
    (limit, depth): (f64, f64),
) -> Vec<(usize, f64, bool)> {
    let mut samples = Vec::with_capacity(phases.len() * POINTS + 1);
    for (position, &phase) in phases.iter().enumerate() {
        for i in usize::from(position > 0)..=POINTS {
            let theta = i as f64 / POINTS as f64;
            samples.push((phase, theta, value(phase, theta)));
        }
    }
    let above = |sample: &(usize, f64, f64)| sample.2 > limit;
    let first = samples.iter().position(above).unwrap_or(samples.len());
    let last = samples.iter().rposition(above).unwrap_or(0);
    let mut found = Vec::new();
    for i in 1..samples.len().saturating_sub(1) {
        let (phase, theta, here) = samples[i];
        let between = first < i && i < last;
        if !between && here > -depth {
            continue;
        }
        if here > samples[i - 1].2 || here >= samples[i + 1].2 {
            continue;
        }
        let step = 1.0 / POINTS as f64;
        let theta = if theta < 1.0 {
            refine(&mut |theta| value(phase, theta), theta - step, theta + step)
        } else {
            theta
        };
        if value(phase, theta) < limit {
            found.push((phase, theta, between));
        }
    }
    found
}

/// Minimum of a function between two points, by golden section to the square root of the precision.
fn refine(value: &mut dyn FnMut(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    const SHARE: f64 = 0.381_966_011_250_105;
    const STEPS: usize = 40;
    for _ in 0..STEPS {
        let (a, b) = (from + SHARE * (to - from), to - SHARE * (to - from));
        if value(a) < value(b) {
            to = b;
        } else {
            from = a;
        }
    }
    0.5 * (from + to)
}
