//! What becomes of a motion at which a method fails: another one takes it over, and a note says so.
//!
//! Finite elements need their equations solved over a whole element, steps from event to event do not. So these get through
//! places where the elements stick. What both stop at is a property of the motion, and the first diagnosis stands.

use super::watch::Watch;
use super::{Simulation, SimulationStatus};

/// A method that takes over, in words.
pub(super) struct Other {
    /// The method that failed.
    pub(super) failed: &'static str,
    /// The one that goes on.
    pub(super) takes_over: &'static str,
}

/// The run of the `other` method, which `simulate` makes, if the first `run` ends for a reason that may be its own and the other
/// gets to the horizon with the accuracy that it promises; the first run otherwise.
pub(super) fn unless_solved(
    mut run: Simulation,
    own_reason: impl Fn(&SimulationStatus) -> bool,
    other: &Other,
    watch: &mut Watch<'_>,
    simulate: impl FnOnce(&mut Watch<'_>) -> Simulation,
) -> Simulation {
    if !own_reason(&run.status) {
        return run;
    }
    let mut second = simulate(watch);
    let ended = match (&second.status, run.status.diagnosis()) {
        (SimulationStatus::Solved, Some(ended)) => ended,
        (SimulationStatus::Interrupted(_), _) => return second,
        _ => {
            run.counts = run.counts.with(&second.counts);
            run.seconds.total += second.seconds.total;
            return run;
        }
    };
    second.notes.push(format!(
        "{} ended with `{}` at t = {} s; this is the motion by {}",
        other.failed,
        run.status.name(),
        super::number(ended.time),
        other.takes_over,
    ));
    second.doubts.handed_over = true;
    second.counts = second.counts.with(&run.counts);
    second.seconds.total += run.seconds.total;
    second
}
