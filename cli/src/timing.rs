//! Fair times: a run is repeated, and its fastest repetition counts.

use hangtime::simulation::{InitialValueProblem, InputError, Simulation};

use crate::method::ChosenMethod;
use crate::settings::ChosenScene;

/// Tolerance of the event-driven run that the others are measured against: close to rounding error.
pub(crate) const EXACT_TOLERANCE: f64 = 1e-13;
/// A run is repeated until this much CPU time is spent [s].
const TIMED_SECONDS: f64 = 0.02;
/// What a repetition counts at least [s], so that a coarse clock ends the repetitions too.
const SHORTEST_RUN: f64 = 1e-4;

/// Runs a simulation a few times and keeps the one with the least CPU time; the results are equal. One is interrupted
/// where `goes_on` says so.
pub(crate) fn fastest(
    chosen: &ChosenScene,
    method: &ChosenMethod,
    problem: &InitialValueProblem,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Simulation, InputError> {
    let run = || method.simulate(chosen.model.as_ref(), problem, &mut |_| goes_on());
    let mut best = run()?;
    let mut spent = best.seconds.total;
    while spent < TIMED_SECONDS && goes_on() {
        let next = run()?;
        spent += next.seconds.total.max(SHORTEST_RUN);
        if next.status == best.status && next.seconds.total < best.seconds.total {
            best = next;
        }
    }
    Ok(best)
}
