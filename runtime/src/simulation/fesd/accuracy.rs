//! The promise of accuracy: runs of increasing accuracy until two agree.
//!
//! Each element is held to an embedded error estimate, which knows neither what the rest of the motion makes
//! of an error nor a switch that was missed. The difference to a looser run contains both; what both runs damp alike, the local
//! errors of the elements. Where impacts follow each
//! other too fast to be told apart, all runs join them alike, and the event-driven method has to confirm the result.

use super::driver::Driver;
use super::settings::Fesd;
use super::stepping;
use crate::model::Model;
use crate::rk::ButcherTableau;
use crate::simulation::agreement::{Comparison, Spent};
use crate::simulation::event;
use crate::simulation::watch::Watch;
use crate::simulation::{InitialValueProblem, Simulation, SimulationStatus};

/// Runs after the first one.
const MAX_RUNS: usize = 5;
/// Error estimates of the elements of a run relative to those of the one before.
const TIGHTER: f64 = 1e-2;
/// Relative error estimates of a run that confirms one which is accurate enough, and takes few elements more.
const WITNESS: f64 = 0.3;
/// Longest elements of each run relative to those of the first that is returned: what an element damps or passes over, another
/// one of its length does as well.
const LONGEST: [f64; MAX_RUNS + 1] = [0.77, 1.0, 0.59, 0.46, 0.35, 0.27];
/// Smallest error estimate of an element that can be asked for.
const SMALLEST: f64 = 1e-14;
/// Tolerance of the event-driven run that confirms clusters of impacts, relative to what is promised.
const CONFIRMS: f64 = 1e-4;

/// Simulates with at most the error `promise`, or ends with a status that says otherwise.
pub(super) fn promised(
    settings: &Fesd,
    promise: f64,
    tableau: &ButcherTableau,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let run = |number: usize, tolerance| {
        let driver = Driver::new(settings, tableau, model, problem);
        driver.controlled(tolerance, LONGEST[number])
    };
    // The estimate has order `s`, the result about twice that; a tenth is in hand. The run that is returned
    // keeps the promise inside its elements too.
    let s = tableau.stages() as f64;
    let mut tolerance = 0.1 * promise.powf((s + 1.0) / (2.0 * s));
    watch.restart(false);
    let mut looser = stepping::run(run(0, tolerance).forgetful(), watch);
    let stopped = |run: &Simulation| matches!(run.status, SimulationStatus::Interrupted(_));
    if stopped(&looser) {
        return looser;
    }
    let mut ratio = (promise / tolerance).min(0.1);
    tolerance *= ratio;
    let mut spent = Spent::default();
    spent.add(&looser);
    for runs in 1..=MAX_RUNS {
        watch.restart(true);
        let mut tighter = stepping::run(run(runs, tolerance.max(SMALLEST)), watch);
        spent.add(&tighter);
        if stopped(&tighter) {
            return spent.charge(tighter);
        }
        let failed = [&looser, &tighter].map(|run| run.status != SimulationStatus::Solved);
        if failed == [false, false] {
            let compared = Comparison::of(&looser, &mut tighter, (model, problem), promise);
            let kept = compared.error <= promise;
            let last = runs == MAX_RUNS || compared.stays();
            if !kept && last {
                tighter.status = inaccurate(&compared, promise);
            }
            if kept {
                confirm(&mut tighter, promise, (model, problem), watch, &mut spent);
            }
            if kept || last {
                return spent.charge(tighter);
            }
            // A witness that disagrees is none: the errors are not yet what their order says.
            let witness = ratio != WITNESS
                && compared
                    .apart()
                    .is_some_and(|apart| needs_witness(apart, ratio, promise, s));
            ratio = if witness { WITNESS } else { TIGHTER };
        } else if failed[1] && (failed[0] || runs == MAX_RUNS) {
            return spent.charge(tighter);
        } else if runs == MAX_RUNS {
            // Nothing confirms the only run that reached the horizon.
            return spent.charge(looser);
        } else {
            ratio = TIGHTER;
        }
        looser = tighter;
        tolerance *= ratio;
    }
    looser
}

/// Whether a run that differs by `error` from one whose tolerance was larger by `1 / ratio` is as accurate as is promised, and
/// only nobody has confirmed it: with `s` stages errors are proportional to the power `(2 s - 1) / (s + 1)` of the tolerance.
fn needs_witness(error: f64, ratio: f64, promise: f64, s: f64) -> bool {
    error * ratio.powf((2.0 * s - 1.0) / (s + 1.0)) <= 0.3 * promise
}

/// Steps of the run that the one of twice [`Fesd::DEFAULT_STEPS`] is compared with: no step of the one ends with a step of the other, as
/// what is known to the length of an element only, such as a release right after an impact, would end alike in both.
const OTHER_STEPS: usize = 61;

/// Simulates on a grid that nobody has named, and on another one with fewer steps: where they differ by more than `promise` the status is
/// another than solved.
pub(super) fn compared(
    settings: &Fesd,
    promise: f64,
    tableau: &ButcherTableau,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let steps = 2 * Fesd::DEFAULT_STEPS;
    let twice = settings.clone().with_grid(steps, settings.elements);
    let fewer = settings.clone().with_grid(OTHER_STEPS, settings.elements);
    watch.restart(false);
    let coarse = Driver::new(&fewer, tableau, model, problem).forgetful();
    let coarse = stepping::run(coarse, watch);
    let mut spent = Spent::default();
    spent.add(&coarse);
    if matches!(coarse.status, SimulationStatus::Interrupted(_)) {
        return coarse;
    }
    watch.restart(true);
    let mut fine = stepping::run(Driver::new(&twice, tableau, model, problem), watch);
    spent.add(&fine);
    if fine.status.is_solved() {
        let compared = Comparison::of(&coarse, &mut fine, (model, problem), promise);
        if !coarse.status.is_solved() {
            // Nothing confirms the only run that reached the horizon.
            fine.status = coarse.status;
        } else if compared.error > promise {
            fine.status = compared.inaccurate(format!(
                "runs of {OTHER_STEPS} and {steps} steps agree until here, and {}, more than {promise:.0e}: name a number of steps, or use the default formulation",
                compared.words()
            ));
        }
    }
    spent.charge(fine)
}

/// Has the event-driven method confirm a run that joined impacts of several contacts, or left out bounces that others
/// could feel: where it does so does not depend on its tolerance, so that runs of its own kind say nothing of it.
fn confirm(
    run: &mut Simulation,
    promise: f64,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
    spent: &mut Spent,
) {
    let felt = run.doubts.flights && model.declaration().contacts.len() > 1;
    if !felt && !run.doubts.clusters {
        return;
    }
    let tolerance = (CONFIRMS * promise).max(SMALLEST);
    let other = event::simulate_to_check(tolerance, (model, problem), watch);
    spent.add(&other);
    if matches!(other.status, SimulationStatus::Interrupted(_)) {
        run.status = other.status;
        return;
    }
    let estimate = run.error_estimate;
    let compared = Comparison::of(&other, run, (model, problem), promise);
    let without = match other.status.diagnosis() {
        None if compared.error <= promise => {
            run.error_estimate = estimate.map(|estimate| estimate.max(compared.error));
            return;
        }
        None => format!(
            "gives another motion from here on, {:.1e} of the largest values away at the end",
            compared.error
        ),
        Some(ended) => {
            run.error_estimate = estimate;
            format!("does not confirm the motion after that: {}", ended.message)
        }
    };
    run.status = compared.inaccurate(format!(
        "impacts follow too fast to be told apart, and the event-driven method {without}; shorten the horizon, or use \
         `event` as method"
    ));
}

/// The status of a run that differs from a looser one by more than `promise`.
fn inaccurate(compared: &Comparison, promise: f64) -> SimulationStatus {
    compared.inaccurate(format!(
        "runs with smaller and smaller elements agree until here, and {}, more than the tolerance {promise:.0e}: the motion depends on its start too sensitively, or on which \
         of several contacts comes first; shorten the horizon or raise the tolerance",
        compared.words()
    ))
}
