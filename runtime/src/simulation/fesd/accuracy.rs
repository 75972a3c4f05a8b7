//! The promise of accuracy: runs of increasing accuracy until two agree.
//!
//! Each element is held to an embedded error estimate, which knows neither what the rest of the motion makes
//! of an error nor a switch that was missed. The difference to a looser run contains both.

use super::driver::Driver;
use super::settings::Fesd;
use super::stepping;
use crate::fesd::finite_element::MotionSize;
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::simulation::watch::Watch;
use crate::simulation::{Diagnosis, Event, InitialValueProblem, Simulation, SimulationStatus};

/// Runs after the first one.
const MAX_RUNS: usize = 4;
/// Error estimates of the elements of a run relative to those of the one before.
const TIGHTER: f64 = 1e-2;
/// Smallest error estimate of an element that can be asked for.
const SMALLEST: f64 = 1e-14;

/// Simulates with at most the error `promise`, or ends with a status that says otherwise.
pub(super) fn promised(
    settings: &Fesd,
    promise: f64,
    tableau: &ButcherTableau,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let run = |tolerance| Driver::new(settings, tableau, model, problem).controlled(tolerance);
    // The estimate has order `s`, the result about twice that; a tenth is in hand. The run that is returned
    // keeps the promise inside its elements too.
    let s = tableau.stages() as f64;
    let mut tolerance = 0.1 * promise.powf((s + 1.0) / (2.0 * s));
    watch.restart(false);
    let (mut looser, _) = stepping::run(run(tolerance).forgetful(), watch);
    let stopped = |run: &Simulation| matches!(run.status, SimulationStatus::Interrupted(_));
    if stopped(&looser) {
        return looser;
    }
    tolerance = promise.min(0.1 * tolerance);
    let mut spent = Spent::of(&looser);
    for runs in 1..=MAX_RUNS {
        watch.restart(true);
        let (mut tighter, motion) = stepping::run(run(tolerance.max(SMALLEST)), watch);
        spent.add(&tighter);
        if stopped(&tighter) {
            return spent.charge(tighter);
        }
        let failed = [&looser, &tighter].map(|run| run.status != SimulationStatus::Solved);
        if failed == [false, false] {
            let error = difference(&looser, &tighter, &motion);
            tighter.error_estimate = Some(error);
            if error > promise && runs == MAX_RUNS {
                tighter.status = inaccurate(problem.horizon, error, promise);
            }
            if error <= promise || runs == MAX_RUNS {
                return spent.charge(tighter);
            }
        } else if failed[1] && (failed[0] || runs == MAX_RUNS) {
            return spent.charge(tighter);
        } else if runs == MAX_RUNS {
            // Nothing confirms the only run that reached the horizon.
            return spent.charge(looser);
        }
        looser = tighter;
        tolerance *= TIGHTER;
    }
    looser
}

/// The status of a run that differs by `error` from a looser one.
fn inaccurate(time: f64, error: f64, promise: f64) -> SimulationStatus {
    SimulationStatus::Inaccurate(Diagnosis {
        time,
        step: 0,
        contact: None,
        message: format!(
            "runs with smaller and smaller elements still differ by {error:.1e} of the largest values, more \
             than the tolerance {promise:.0e}: the motion depends on its start too sensitively, or on \
             which of several contacts comes first; shorten the horizon or raise the tolerance"
        ),
    })
}

/// Largest difference of two runs at the end and at events, relative to the `motion`.
fn difference(looser: &Simulation, tighter: &Simulation, motion: &MotionSize) -> f64 {
    let (a, b) = (&looser.trajectory, &tighter.trajectory);
    let (Some(time), Some(qa), Some(qb), Some(va), Some(vb)) = (
        b.time.last(),
        a.q.last(),
        b.q.last(),
        a.v.last(),
        b.v.last(),
    ) else {
        return f64::INFINITY;
    };
    let length = time / tighter.counts.elements.max(1) as f64;
    let position = largest_difference(qa, qb).max(at_events(&looser.events, &tighter.events));
    motion.relative(position, largest_difference(va, vb), length)
}

/// Largest distance between the coordinates of corresponding events, at the same time to first order.
fn at_events(looser: &[Event], tighter: &[Event]) -> f64 {
    let mut largest = 0.0_f64;
    for (k, event) in tighter.iter().enumerate() {
        let same = |other: &&Event| other.kind == event.kind && other.contact == event.contact;
        let Some(other) = looser
            .iter()
            .filter(same)
            .nth(tighter[..k].iter().filter(same).count())
        else {
            continue;
        };
        let late = event.time - other.time;
        for ((a, b), v) in other.q.iter().zip(&event.q).zip(&event.v_before) {
            largest = largest.max((a + v * late - b).abs());
        }
    }
    largest
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// The work of several runs.
struct Spent {
    counts: crate::simulation::Counts,
    seconds: f64,
}

impl Spent {
    fn of(run: &Simulation) -> Self {
        Self {
            counts: run.counts,
            seconds: run.seconds.total,
        }
    }

    fn add(&mut self, run: &Simulation) {
        self.counts.interior_point += run.counts.interior_point;
        self.counts.crossover += run.counts.crossover;
        self.counts.newton += run.counts.newton;
        self.counts.factorizations += run.counts.factorizations;
        self.counts.evaluations += run.counts.evaluations;
        self.counts.fallbacks += run.counts.fallbacks;
        self.seconds += run.seconds.total;
    }

    /// The result with the work of all runs; elements are those of the result.
    fn charge(mut self, mut result: Simulation) -> Simulation {
        self.counts.elements = result.counts.elements;
        result.counts = self.counts;
        result.seconds.total = self.seconds;
        result
    }
}
