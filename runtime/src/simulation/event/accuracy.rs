//! The promise of accuracy: the motion is computed twice, with different tolerances and places of search.
//!
//! The error of a step says neither what the rest of the motion makes of it nor that an event was missed; the
//! difference to another run contains both.

use super::integration::Integration;
use super::settings::EventDriven;
use crate::model::Model;
use crate::simulation::agreement::{Comparison, Spent};
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::watch::Watch;
use crate::simulation::{InitialValueProblem, Simulation, SimulationStatus};
use crate::yardstick;

/// Error that is promised as a multiple of the tolerance.
const TOLERANCES: f64 = 1e3;
/// Tolerance of the run to compare with, relative to that of the run that is returned, and the largest.
const COARSER: f64 = 1e2;
const COARSEST: f64 = 1e-2;
/// Tolerance of a run relative to that of the one before, and the smallest.
const FINER: f64 = 1e-2;
const FINEST: f64 = 1e-14;
/// Runs after the first one.
const MOST_RUNS: usize = 3;
/// Longest step relative to that of the run before: what is looked at inside a step lies elsewhere.
const SHORTER: f64 = 0.77;
/// Longest step where none is named, as a share of the horizon.
const LONGEST: f64 = 1.0 / 16.0;

/// Tolerance with which this error is promised, as far as one can be asked for.
pub(super) fn tolerance(promise: f64) -> f64 {
    (promise / TOLERANCES).max(FINEST)
}

/// Simulates until two runs agree within what is promised, or ends with a status that says otherwise.
pub(super) fn promised(
    settings: &EventDriven,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let promise = yardstick::PROMISE.max(TOLERANCES * settings.tolerance);
    let run = |tolerance: f64, longest: f64, shown: bool, watch: &mut Watch<'_>| {
        watch.restart(shown);
        let settings = EventDriven {
            tolerance,
            max_step: Some(longest),
            output_times: if shown { settings.output_times } else { 0 },
            ..settings.clone()
        };
        let explicit_time = ExplicitTime::of(model, problem);
        Integration::new(&settings, model, problem, explicit_time).run(watch, None)
    };
    let mut longest = settings.max_step.unwrap_or(LONGEST * problem.horizon);
    let mut tolerance = settings.tolerance;
    let coarsest = (COARSER * tolerance).min(COARSEST);
    let mut coarser = run(coarsest, SHORTER * longest, false, watch);
    let mut spent = Spent::default();
    let mut runs = 0;
    loop {
        spent.add(&coarser);
        if stopped(&coarser) {
            return spent.charge(coarser);
        }
        let mut finer = run(tolerance, longest, true, watch);
        runs += 1;
        let mut last = runs == MOST_RUNS || tolerance <= FINEST;
        let failed = [&coarser, &finer].map(|run| !run.status.is_solved());
        let ends = if failed == [false, false] {
            let compared = Comparison::of(&coarser, &mut finer, (model, problem), promise);
            let kept = compared.error <= promise;
            last |= compared.stays();
            if !kept && last {
                finer.status = inaccurate(&compared, promise);
            }
            kept
        } else {
            failed == [true, true] && same_failure(&coarser, &finer)
        };
        if ends || stopped(&finer) {
            spent.add(&finer);
            return spent.charge(finer);
        }
        if last {
            // Nothing confirms the only run that reached the horizon.
            let unconfirmed = failed == [true, false];
            spent.add(&finer);
            return spent.charge(if unconfirmed { coarser } else { finer });
        }
        coarser = finer;
        tolerance = (FINER * tolerance).max(FINEST);
        longest *= SHORTER;
    }
}

fn stopped(run: &Simulation) -> bool {
    matches!(run.status, SimulationStatus::Interrupted(_))
}

/// Whether two runs fail for a reason that smaller steps do not mend.
fn same_failure(coarser: &Simulation, finer: &Simulation) -> bool {
    use SimulationStatus::{Inaccurate, StepFailed};
    finer.status.name() == coarser.status.name()
        && !matches!(finer.status, StepFailed(_) | Inaccurate(_))
}

/// The status of a run that differs from another one by more than `promise`.
fn inaccurate(compared: &Comparison, promise: f64) -> SimulationStatus {
    compared.inaccurate(format!(
        "runs with smaller and smaller tolerances agree until here, and {}, more than {promise:.0e}: the motion depends on its start too sensitively, or on which of several \
         contacts comes first; shorten the horizon",
        compared.words()
    ))
}
