//! The check between the stages: gaps and bounds over the continuous motion of a solved program.

use super::collocation::{Collocation, Cut, CutKind, Places, SolvedPhase, lagrange};
use super::problem::Problem;
use super::settings::BoundsAt;
use super::solution::Excess;
use super::units::Units;
use crate::model::{ConstraintRelation, contact_point};

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
    /// Largest violation of a bound of a coordinate, in its unit of `units`, that is let pass.
    pub(super) bound: f64,
    pub(super) units: &'a Units,
    pub(super) bounds: (&'a [f64], &'a [f64]),
    pub(super) problem: &'a Problem,
    pub(super) places: Places,
}

/// The continuous motion of a solved program.
pub(super) struct Motion<'p, 'm> {
    pub(super) program: &'p Collocation<'m>,
    pub(super) solved: Vec<SolvedPhase>,
    /// Weights of the states of a phase at its points `i / POINTS`.
    weights: Vec<Vec<f64>>,
    /// Physical values of the unknowns.
    pub(super) x: Vec<f64>,
}

impl<'p, 'm> Motion<'p, 'm> {
    fn new(program: &'p Collocation<'m>, x: &[f64]) -> Self {
        let thetas = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
        Self {
            program,
            solved: program.solved(x),
            weights: thetas
                .map(|theta| lagrange(program.tableau, theta, false))
                .collect(),
            x: program.program.physical(x),
        }
    }

    /// Writes the first components of the model's input vector at the share `theta` of a phase.
    pub(super) fn write(&self, phase: usize, theta: f64, input: &mut [f64]) {
        let place = theta * POINTS as f64;
        let between;
        let weights = if place.fract() == 0.0 {
            &self.weights[place as usize]
        } else {
            between = lagrange(self.program.tableau, theta, false);
            &between
        };
        input.fill(0.0);
        for (values, weight) in self.solved[phase].inputs.iter().zip(weights) {
            for (slot, value) in input.iter_mut().zip(values) {
                *slot += weight * value;
            }
        }
    }

    /// Distance of a coordinate from the nearer of its bounds, negative outside.
    fn inside(&self, k: usize, bounds: (f64, f64)) -> impl FnMut(usize, f64) -> f64 + '_ {
        let mut state = vec![0.0; k + 1];
        move |phase, theta| {
            self.write(phase, theta, &mut state);
            (state[k] - bounds.0).min(bounds.1 - state[k])
        }
    }

    /// Value of a path constraint, or minus the amount of one that is to be 0.
    fn path(&self, constraint: usize) -> impl FnMut(usize, f64) -> f64 + '_ {
        let model = self.program.model;
        let declaration = model.declaration();
        let declared = declaration.optimal_control;
        let mut input = vec![0.0; declaration.inputs()];
        let mut values = vec![0.0; declared.map_or(0, |d| d.path_functions())];
        let first = declared.map_or(0, |d| usize::from(d.running_cost));
        let relation = declared.map(|d| d.constraints[constraint].relation);
        move |phase, theta| {
            self.write(phase, theta, &mut input);
            model.path_functions(&input, &mut values);
            let value = values[first + constraint];
            match relation {
                Some(ConstraintRelation::Zero) => -value.abs(),
                _ => value,
            }
        }
    }

    /// Path constraints of the problem: their number and whether each is an inequality.
    fn constraints(&self, limits: &Limits) -> Vec<bool> {
        let declared = limits.problem.declared(self.program.model);
        let constraints = declared.map_or(&[][..], |d| d.constraints).iter();
        constraints
            .map(|c| c.relation == ConstraintRelation::NonNegative)
            .collect()
    }
}

/// Places where the motion between the stages grazes or enters a surface, or leaves the bounds of a
/// coordinate or a path constraint: minima over the phases, with higher values on either side.
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
    let motion = Motion::new(program, x);
    let cut = |phase: usize, theta: f64, kind: CutKind| Cut {
        interval: program.phases[phase].interval,
        phase: program.phases[phase].index,
        theta,
        kind,
    };
    for contact in 0..declaration.contacts.len() {
        let mut gap = |phase: usize, theta: f64| {
            motion.write(phase, theta, &mut input);
            model.gap(contact, &input)
        };
        let mut next = 0;
        while next < program.phases.len() {
            let open = |phase: &usize| !program.phases[*phase].closed.contains(&contact);
            // A flight ends where the contact closes or is touched.
            let lands = |phase: &usize| program.phases[*phase].closing.contains(&contact);
            let until = (next..program.phases.len()).find(lands);
            let until = until.map_or(program.phases.len(), |last| last + 1);
            let flight: Vec<usize> = (next..until).take_while(open).collect();
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
    found.extend(departures(program, &motion.solved, limits));
    found.extend(motion.friction(limits));
    if limits.places.bounds == BoundsAt::Nodes {
        return found;
    }
    let all: Vec<usize> = (0..program.phases.len()).collect();
    for k in (0..n).filter(|&k| !parabolas[k]) {
        let bounds = (limits.bounds.0[k], limits.bounds.1[k]);
        if bounds == (f64::NEG_INFINITY, f64::INFINITY) {
            continue;
        }
        let bound = limits.bound * limits.units.states[k];
        for (phase, theta, _) in lows(&all, &mut motion.inside(k, bounds), (-bound, bound)) {
            found.push(cut(phase, theta, CutKind::Bounds(k)));
        }
    }
    for (constraint, inequality) in motion.constraints(&limits).into_iter().enumerate() {
        if !inequality {
            continue;
        }
        for (phase, theta, _) in lows(
            &all,
            &mut motion.path(constraint),
            (-limits.bound, limits.bound),
        ) {
            found.push(cut(phase, theta, CutKind::Path(constraint)));
        }
    }
    found
}

/// The largest violation of a bound of a coordinate or of a path constraint along the whole motion.
pub(super) fn excess(program: &Collocation, x: &[f64], limits: Limits) -> Option<Excess> {
    let declaration = program.model.declaration();
    let motion = Motion::new(program, x);
    let mut largest: Option<Excess> = None;
    let mut look = |name: &str, value: &mut dyn FnMut(usize, f64) -> f64| {
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
            let known = largest.as_ref().map_or(0.0, |excess| excess.amount);
            if -lowest > known - step * step {
                let better = refine(&mut |theta| value(phase, theta), from, to);
                let refined = value(phase, better);
                if refined < lowest {
                    (lowest, place) = (refined, better);
                }
            }
            if -lowest > known {
                largest = Some(Excess {
                    name: name.to_owned(),
                    amount: -lowest,
                    time: solved.start + place * solved.length,
                });
            }
        }
    };
    for (k, coordinate) in declaration.coordinates.iter().enumerate() {
        let bounds = (limits.bounds.0[k], limits.bounds.1[k]);
        if bounds != (f64::NEG_INFINITY, f64::INFINITY) {
            look(coordinate.name, &mut motion.inside(k, bounds));
        }
    }
    for constraint in 0..motion.constraints(&limits).len() {
        let declared = declaration.optimal_control;
        let name = declared.map_or("", |d| d.constraints[constraint].name);
        look(name, &mut motion.path(constraint));
    }
    largest
}

/// Flights that pass a jump of the controls so shortly after their opening that they are still on the surface,
/// and are pushed back onto it after the jump.
fn departures(program: &Collocation, solved: &[SolvedPhase], limits: Limits) -> Vec<Cut> {
    let model = program.model;
    let declaration = model.declaration();
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
            for (node, (input, slope)) in solved.inputs.iter().zip(&slopes).enumerate() {
                model.contact(contact, input, &mut point);
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
pub(super) fn lows(
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
