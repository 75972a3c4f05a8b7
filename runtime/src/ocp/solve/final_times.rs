//! Free final times: the range that programs look at is moved until a plan lies inside.
//!
//! Programs look at final times within a factor of the guess, since a plan that is far from it is of another size than
//! the units that the program is measured in. That is no bound of the problem: where a plan, or the nearest point of a
//! program without a solution, lies at an end of the range, the search starts again around that end; so it does where
//! controls without bounds come out of another size than they were measured in.

use super::one_grid::{Round, Start, solve_round};
use crate::model::Model;
use crate::mpcc::Stationarity;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::progress::Watch;
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Status};
use crate::simulation::InputError;

/// How often the range is moved, each time by a factor of 20 at most, or the units.
const MOVES: usize = 5;
/// Factor from the centre of a moved range within which a plan is measured in units of its own size: one that is
/// further away may be no more than flat in those of its program.
const NEAR: f64 = 1.5;

/// Solves on the grid of the problem, around the final times that its plans ask for.
pub(super) fn solve_grid<'s>(
    model: &dyn Model,
    problem: &Problem,
    settings: &'s Settings,
    start: Start<'s>,
) -> Result<(Solution, Watch<'s>), InputError> {
    let mut start = start;
    let effort = start.effort;
    let mut centre: Option<f64> = None;
    // The last plan that lies at an end of its range.
    let mut at_the_end: Option<Solution> = None;
    // Why there was none where the scene itself suggests to look.
    let mut failed: Option<Solution> = None;
    let mut looked_at = None;
    let mut moves = 0;
    loop {
        let moved = Problem {
            horizon: match (problem.horizon, centre) {
                (Horizon::Free { .. }, Some(_)) => Horizon::Free { guess: centre },
                (horizon, _) => horizon,
            },
            ..problem.clone()
        };
        let coarser = start.coarser.clone();
        let known = match (&at_the_end, &coarser) {
            (Some(plan), _) => plan.controls.clone(),
            (None, Some(coarser)) => coarser.controls(),
            (None, None) => Vec::new(),
        };
        let round = solve_round(model, &moved, settings, start, centre, &known)?;
        let Round {
            mut solution,
            watch,
            range,
            next,
            of_another_size,
        } = round;
        let all = range.with(looked_at.unwrap_or(range));
        looked_at = Some(all);
        solution.final_times = (all.shortest, all.longest);
        let off_centre = centre.is_some_and(|centre| {
            let factor = solution.horizon / centre;
            solution.motion.is_some() && !(1.0 / NEAR..=NEAR).contains(&factor)
        });
        let off_units = off_centre || of_another_size;
        let next = next.or_else(|| off_units.then_some(solution.horizon));
        let next = next.filter(|_| solution.status != Status::Interrupted && moves < MOVES);
        if let Some(next) = next {
            start = Start {
                watch,
                counts: solution.counts,
                seconds: solution.seconds,
                coarser,
                effort,
            };
            if is_found(&solution) {
                at_the_end = Some(solution);
            } else {
                failed.get_or_insert(solution);
            }
            centre = Some(next);
            moves += 1;
            continue;
        }
        let (counts, seconds) = (solution.counts, solution.seconds);
        let (final_times, status) = (solution.final_times, solution.status);
        let found = is_found(&solution);
        // What was found at an end, and is not found any more beyond it, has no optimum there either.
        let solution = match at_the_end.filter(|_| !found) {
            Some(plan) => unbounded(plan, status),
            None if found && (off_units || range.end_at(solution.horizon).is_some()) => {
                unbounded(solution, status)
            }
            None if found || status == Status::Interrupted => solution,
            None => failed.unwrap_or(solution),
        };
        let solution = Solution {
            counts,
            seconds,
            final_times,
            ..solution
        };
        return Ok((solution, watch));
    }
}

/// Whether there is a motion, and not only a plan that the dynamics do not follow.
fn is_found(solution: &Solution) -> bool {
    solution.motion.is_some() && solution.status != Status::Unconfirmed
}

/// A plan at an end of the final times that were looked at.
fn unbounded(plan: Solution, status: Status) -> Solution {
    Solution {
        status: match status {
            Status::Interrupted => Status::Interrupted,
            _ => Status::Unbounded,
        },
        stationarity: Stationarity::None,
        ..plan
    }
}
