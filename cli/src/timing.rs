//! Fair times: a run is repeated, and its fastest repetition counts.

use std::time::Instant;

use cpu_time::ProcessTime;
use hangtime::simulation::{InitialValueProblem, InputError, Simulation};

use crate::method::ChosenMethod;
use crate::settings::ChosenScene;

/// Tolerance of the event-driven run that the others are measured against: close to rounding error.
pub(crate) const EXACT_TOLERANCE: f64 = 1e-13;
/// A run is repeated until this much CPU time is spent [s].
const TIMED_SECONDS: f64 = 0.02;
/// What a repetition counts at least [s], so that a coarse clock ends the repetitions too.
const SHORTEST_RUN: f64 = 1e-4;

/// Whether what begins now may go on: until it has taken this much CPU time [s]. Where there is no clock of the process, that on the
/// wall counts.
pub(crate) fn patience(seconds: f64) -> impl Fn() -> bool + Sync {
    let (start, wall) = (ProcessTime::try_now().ok(), Instant::now());
    move || {
        let spent = start.as_ref().and_then(|start| start.try_elapsed().ok());
        spent.unwrap_or_else(|| wall.elapsed()).as_secs_f64() < seconds
    }
}

/// A run that was repeated.
pub(crate) struct Repeated {
    /// The one with the least CPU time.
    pub(crate) fastest: Simulation,
    /// CPU time that half of the repetitions took at most [s].
    pub(crate) half: f64,
}

/// Runs a simulation a few times; the results are equal. One is interrupted where `goes_on` says so.
pub(crate) fn repeated(
    chosen: &ChosenScene,
    method: &ChosenMethod,
    problem: &InitialValueProblem,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Repeated, InputError> {
    let run = || method.simulate(chosen.model.as_ref(), problem, &mut |_| goes_on());
    let mut best = run()?;
    let mut spent = best.seconds.total;
    let mut times = vec![spent];
    while spent < TIMED_SECONDS && goes_on() {
        let next = run()?;
        spent += next.seconds.total.max(SHORTEST_RUN);
        times.push(next.seconds.total);
        if next.status == best.status && next.seconds.total < best.seconds.total {
            best = next;
        }
    }
    times.sort_by(f64::total_cmp);
    Ok(Repeated {
        fastest: best,
        half: times[times.len() / 2],
    })
}

/// The repetition with the least CPU time.
pub(crate) fn fastest(
    chosen: &ChosenScene,
    method: &ChosenMethod,
    problem: &InitialValueProblem,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Simulation, InputError> {
    repeated(chosen, method, problem, goes_on).map(|runs| runs.fastest)
}
