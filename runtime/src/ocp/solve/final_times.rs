//! Free final times: the range that programs look at is moved until a plan lies inside.
//!
//! Programs look at final times within a factor of the guess, since a plan that is far from it is of another size than
//! the units that the program is measured in. That is no bound of the problem: where a plan, or the nearest point of a
//! program without a solution, lies at an end of the range, the search starts again around that end; so it does where
//! controls without bounds come out of another size than they were measured in.

use hangtime_solver::mpcc::Stationarity;

use super::one_grid::{Round, Start, Trace, solve_round};
use crate::model::Model;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Status};
use crate::ocp::tuning::grids::{MOVES, OFF_CENTRE};
use crate::simulation::InputError;

/// A plan that another round looks beyond.
struct Before {
    plan: Solution,
    /// Whether it lies at an end of its range, or far from the time that it was measured in; else its controls are of
    /// another size than their units.
    at_an_end: bool,
}

/// Solves on the grid of the problem, around the final times that its plans ask for.
pub(super) fn solve_grid<'s>(
    model: &dyn Model,
    problem: &Problem,
    settings: &'s Settings,
    start: Start<'s>,
) -> Result<(Solution, Trace), InputError> {
    let mut start = start;
    let others = start.known.clone();
    let mut known = others.clone();
    let effort = start.effort;
    let mut centre: Option<f64> = None;
    let mut before: Option<Before> = None;
    // Why there was none where the scene itself suggests to look.
    let mut failed: Option<Solution> = None;
    let mut looked_at = None;
    let mut moves = 0;
    loop {
        let moved = around(problem, centre);
        let coarser = start.coarser.clone();
        let controls = match (&before, &coarser) {
            (Some(before), _) => before.plan.controls.clone(),
            (None, Some(coarser)) => coarser.controls(),
            (None, None) => Vec::new(),
        };
        let round = solve_round(model, &moved, settings, start, centre, &controls)?;
        let Round {
            mut solution,
            watch,
            mut trace,
            range,
            next,
            of_another_size,
        } = round;
        let all = range.with(looked_at.unwrap_or(range));
        looked_at = Some(all);
        let allowed = all.allowed(model);
        solution.final_times = (allowed.shortest, allowed.longest);
        let off_centre = centre.is_some_and(|centre| {
            let factor = solution.horizon / centre;
            solution.motion.is_some() && !(1.0 / OFF_CENTRE..=OFF_CENTRE).contains(&factor)
        });
        let (at_an_end, off_units) = (next.is_some(), off_centre || of_another_size);
        let next = next.or_else(|| off_units.then_some(solution.horizon));
        known.extend(trace.known);
        let goes_on = trace.repeats.is_none() && solution.status != Status::Interrupted;
        let next = next.filter(|_| goes_on && moves < MOVES);
        if let Some(next) = next {
            start = Start {
                watch,
                counts: solution.counts,
                seconds: solution.seconds,
                coarser,
                known: others.clone(),
                effort,
            };
            if is_found(&solution) {
                before = Some(Before {
                    at_an_end: at_an_end || off_centre,
                    plan: solution,
                });
            } else {
                failed.get_or_insert(solution);
            }
            centre = Some(next);
            moves += 1;
            continue;
        }
        let (counts, seconds) = (solution.counts, solution.seconds);
        let final_times = solution.final_times;
        let inside = !off_units && range.end_at(solution.horizon).is_none();
        let solution = Solution {
            counts,
            seconds,
            final_times,
            ..conclusion(solution, inside, before, failed)
        };
        trace.known = known;
        return Ok((solution, trace));
    }
}

/// The problem with a free final time around a centre, if there is one.
fn around(problem: &Problem, centre: Option<f64>) -> Problem {
    Problem {
        horizon: match (problem.horizon, centre) {
            (Horizon::Free { .. }, Some(_)) => Horizon::Free { guess: centre },
            (horizon, _) => horizon,
        },
        ..problem.clone()
    }
}

/// What the last round, whose plan lies inside its range or not, the last plan before it, and the first failure come to.
fn conclusion(
    last: Solution,
    inside: bool,
    before: Option<Before>,
    failed: Option<Solution>,
) -> Solution {
    let status = last.status;
    match before.filter(|_| !is_found(&last)) {
        // What was found at an end, and is not found any more beyond it, has no optimum there either.
        Some(before) if before.at_an_end => unbounded(before.plan, status),
        // In units of its own size it was not confirmed.
        Some(before) => demoted(before.plan, status, Status::Uncertified),
        None if is_found(&last) && !inside => unbounded(last, status),
        None if is_found(&last) || status == Status::Interrupted => last,
        None => failed.unwrap_or(last),
    }
}

/// Whether there is a motion, and not only a plan that the dynamics do not follow.
fn is_found(solution: &Solution) -> bool {
    solution.motion.is_some() && solution.status != Status::Unconfirmed
}

/// A plan at an end of the final times that were looked at.
fn unbounded(plan: Solution, status: Status) -> Solution {
    demoted(plan, status, Status::Unbounded)
}

/// A plan without its certificate, of another status, unless the last round was interrupted.
fn demoted(plan: Solution, last: Status, status: Status) -> Solution {
    Solution {
        status: match last {
            Status::Interrupted => Status::Interrupted,
            _ => status,
        },
        stationarity: Stationarity::None,
        ..plan
    }
}
