//! The check between the stages: gaps and bounds over the continuous motion of a solved program.

use super::collocation::{Collocation, Cut, CutKind};

/// Points of a phase that are looked at.
const POINTS: usize = 64;

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
            for (phase, theta) in lows(&flight, &mut gap, limits.gap) {
                found.push(cut(phase, theta, CutKind::Gap(contact, limits.margin)));
            }
        }
    }
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
        for (phase, theta) in lows(&all, &mut inside, -limits.bound) {
            found.push(cut(phase, theta, CutKind::Bounds(k)));
        }
    }
    found
}

/// Local minima below the limit of a function over consecutive phases, as (phase, theta): those before and
/// after which it exceeds the limit, and those below the negative limit wherever they are.
fn lows(
    phases: &[usize],
    value: &mut dyn FnMut(usize, f64) -> f64,
    limit: f64,
) -> Vec<(usize, f64)> {
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
        if !(first < i && i < last) && here > -limit.abs() {
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
            found.push((phase, theta));
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
