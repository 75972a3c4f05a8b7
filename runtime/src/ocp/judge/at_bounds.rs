//! Bounds of coordinates and path constraints along a re-simulation, beside those of its plan.
//!
//! A plan keeps them on its own polynomials, which may be another motion than that of its controls: where a fast state settles within an
//! element they overshoot, and in a long one they are coarse. So a bound is judged by the re-simulation. Where that breaks it, or plan and
//! re-simulation come differently near to one that either of them reaches, finer elements follow the re-simulation ([`follow`](super::follow)).

use super::dense::{Dense, Step};
use super::follow::Follower;
use crate::ocp::collocation::bounds::{Bound, Bounds};
use crate::ocp::collocation::dense_motion::{DenseMotion, POINTS};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::motion::control_grid::Mesh;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::solution::Excess;
use crate::simulation::Simulation;

/// Difference at a bound, relative to its largest value along the motion, up to which plan and re-simulation are the same there. Chosen.
const AGREES: f64 = 1e-5;

/// Difference that counts for none, however small these values are, as a multiple of what is let pass where conditions are added. Chosen.
const LET_PASS: f64 = 1e3;

/// Parts of a step of a re-simulation between which it is looked at. Chosen.
const PARTS: usize = 4;

/// What a plan and its re-simulation come to at bounds.
#[derive(Default)]
pub(super) struct AtBounds {
    /// The largest violation of each bound by the re-simulation, where there is any.
    pub(super) excess: Vec<Excess>,
    /// The first one that is violated by more than plan and re-simulation may differ, in words.
    pub(super) violated: Option<String>,
    /// The first one that the plan reaches and the re-simulation does not, in words.
    pub(super) apart: Option<String>,
    /// Elements in which the two agree better; none where they agree.
    pub(super) finer: Option<Mesh>,
}

/// The least value of a bound in an interval, and when that is \[s\].
type Low = (f64, f64);

/// A motion in pieces.
struct Pieces<'p> {
    /// The interval of each, and when it begins and ends \[s\].
    spans: Vec<(usize, f64, f64)>,
    /// The values of bounds at points of each piece, at equal distances.
    table: Vec<Vec<Vec<f64>>>,
    /// The same at a share of a piece.
    value: &'p dyn Fn(usize, f64) -> Vec<f64>,
}

impl Pieces<'_> {
    /// The largest value of a bound.
    fn size(&self, bound: usize) -> f64 {
        let values = self.table.iter().flatten().map(|values| values[bound]);
        values.fold(0.0, |most, value| most.max(value.abs()))
    }

    /// The least value of a bound in each of so many intervals; below `near` with what lies between the points.
    fn lows(&self, bound: usize, intervals: usize, near: f64) -> Vec<Low> {
        let mut lows = vec![(f64::INFINITY, 0.0); intervals];
        for (piece, (&(interval, from, to), values)) in
            self.spans.iter().zip(&self.table).enumerate()
        {
            let last = values.len() - 1;
            let at = |point: usize| values[point][bound];
            let lowest = (1..=last).fold(0, |lowest, point| match at(point) < at(lowest) {
                true => point,
                false => lowest,
            });
            let (mut least, mut place) = (at(lowest), lowest as f64);
            let middle = lowest.clamp(1, last - 1);
            let [before, here, after] = [middle - 1, middle, middle + 1].map(at);
            let bend = before - 2.0 * here + after;
            if least < near && bend > 0.0 {
                // The lowest place of the parabola through these.
                let vertex = middle as f64 + 0.5 * (before - after) / bend;
                let vertex = vertex
                    .clamp(place - 1.0, place + 1.0)
                    .clamp(0.0, last as f64);
                let value = (self.value)(piece, vertex / last as f64)[bound];
                if value < least {
                    (least, place) = (value, vertex);
                }
            }
            if least < lows[interval].0 {
                lows[interval] = (least, from + place / last as f64 * (to - from));
            }
        }
        lows
    }
}

/// What a plan, with so many elements, and its re-simulation come to at bounds; what is let pass where conditions are added.
pub(super) fn at_bounds(
    (setting, elements, let_pass): (Setting, &[usize], f64),
    (program, x): (&Collocation, &[f64]),
    (trajectory, replay): (&Trajectory, &Simulation),
) -> AtBounds {
    let bounds = Bounds::new(setting);
    let dense = Dense::new(setting.model, &trajectory.controls, replay);
    let steps = dense.steps(1);
    if bounds.all.is_empty() || steps.is_empty() {
        return AtBounds::default();
    }
    let motion = DenseMotion::new(program, x);
    let by_step = |step: usize, share: f64| {
        let Step { from, to, .. } = steps[step];
        bounds.values(dense.input(&steps[step], from + share * (to - from)))
    };
    let by_phase = |phase: usize, share: f64| motion.bounds(&bounds, phase, share);
    let shares = (0..=PARTS).map(|part| part as f64 / PARTS as f64);
    let points = |step| shares.clone().map(|share| by_step(step, share)).collect();
    let span = |step: &Step| (dense.interval(step), step.from, step.to);
    let phases = program.phases.iter().zip(&motion.solved);
    let phases =
        phases.map(|(phase, solved)| (phase.interval, solved.start, solved.start + solved.length));
    let motions = [
        Pieces {
            spans: steps.iter().map(span).collect(),
            table: (0..steps.len()).map(points).collect(),
            value: &by_step,
        },
        Pieces {
            spans: phases.collect(),
            table: motion.table(&bounds),
            value: &by_phase,
        },
    ];
    let count = trajectory.controls.intervals();
    let mut found = AtBounds::default();
    let mut differ = Vec::new();
    let mut intervals = vec![false; count];
    for (k, bound) in bounds.all.iter().enumerate() {
        if bounds.reads_forces(bound) {
            // Judged with the forces of the re-simulation.
            continue;
        }
        let size = motions.each_ref().map(|motion| motion.size(k));
        let size = size[0].max(size[1]);
        let agrees = (AGREES * size).max(LET_PASS * let_pass);
        // What is far from a bound at all points is so between them.
        let near = size / POINTS as f64;
        let [simulated, planned] = motions.each_ref().map(|motion| motion.lows(k, count, near));
        let mut differs = false;
        for ((simulated, planned), interval) in
            simulated.into_iter().zip(planned).zip(&mut intervals)
        {
            if found.look(bound, (simulated, planned), agrees) {
                (*interval, differs) = (true, true);
            }
        }
        differ.extend(differs.then_some((k, agrees)));
    }
    if !differ.is_empty() {
        let follower = Follower {
            setting,
            bounds: &bounds,
            dense: &dense,
            steps: &steps,
            differ: &differ,
        };
        found.finer = follower.finer(elements, &motion, &intervals);
    }
    found
}

impl AtBounds {
    /// Adds the lows of a bound in an interval, in the re-simulation and in the plan; whether they differ beside the bound.
    fn look(&mut self, bound: &Bound, (simulated, planned): (Low, Low), agrees: f64) -> bool {
        let (value, time) = simulated;
        let excess = Excess {
            name: bound.name.to_owned(),
            amount: -value,
            unit: bound.unit.to_owned(),
            time,
        };
        if -value > agrees {
            self.violated.get_or_insert_with(|| excess.words());
        }
        if value < 0.0 {
            add(&mut self.excess, excess);
        }
        let differ = value.min(planned.0) < agrees && (value - planned.0).abs() > agrees;
        if differ && value > planned.0 {
            self.apart.get_or_insert_with(|| {
                format!(
                    "`{}` comes no nearer to its bound than {value:.1e} {} in the re-simulation, at {time:.6} s, where the plan reaches it",
                    bound.name, bound.unit
                )
            });
        }
        differ
    }
}

/// Adds a violation, or the larger one of a bound that is violated elsewhere.
pub(super) fn add(all: &mut Vec<Excess>, found: Excess) {
    match all.iter_mut().find(|known| known.name == found.name) {
        Some(known) if known.amount < found.amount => *known = found,
        Some(_) => {}
        None => all.push(found),
    }
}
