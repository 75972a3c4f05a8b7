//! Scenes without controls: there is nothing to be constant on intervals, and yet each switch of a plan has to stay in the one where the
//! search has put it. A ball that comes back from an elastic wall half-way strikes it at a node, on whichever side of it the program is.
//!
//! So such a scene is solved on one interval as well, in which switches may be at any time, and that motion is taken where it is
//! clearly better, or costs the same and is proved where the other one is not.

use super::nested;
use super::optima::{costs_the_same, rank};
use crate::Observer;
use crate::model::Model;
use crate::ocp::problem::Problem;
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Status};
use crate::ocp::tuning::equal::MOTION;
use crate::ocp::tuning::grids::{BATCH, ELEMENTS_OF_ONE};
use crate::simulation::InputError;

/// Solves on the grid of the problem and on one interval.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let mut solution = nested::solve(model, problem, settings, observer)?;
    if matches!(solution.status, Status::Interrupted | Status::Unbounded) {
        return Ok(solution);
    }
    let whole = Problem {
        intervals: 1,
        ..problem.clone()
    };
    let settings = Settings {
        elements: settings.elements * ELEMENTS_OF_ONE,
        starts: Some(settings.starts().min(BATCH)),
        ..settings.clone()
    };
    let mut other = nested::solve(model, &whole, &settings, observer)?;
    let (own, least) = (rank(&other), rank(&solution));
    let proves = costs_the_same(&other, &solution)
        && other.status == Status::Solved
        && solution.status == Status::Uncertified;
    let better = own.0 < least.0 || own.1 < least.1 - solution.tolerated(MOTION) || proves;
    if better && own.0 <= least.0 && other.status != Status::Interrupted {
        std::mem::swap(&mut solution, &mut other);
        state_on(&mut solution, problem.intervals);
    }
    solution.counts.add(&other.counts);
    solution.seconds += other.seconds;
    Ok(solution)
}

/// States a motion on one interval on that many.
fn state_on(solution: &mut Solution, intervals: usize) {
    for optimum in &mut solution.optima {
        optimum.intervals = intervals;
    }
    if let Some(previous) = &solution.previous {
        let resampled = previous.resampled(intervals);
        solution.controls = resampled.controls();
        solution.control_times = resampled.control_times();
        solution.previous = Some(resampled);
        let elements = solution.elements.iter().sum::<usize>();
        solution.elements = vec![elements.div_ceil(intervals); intervals];
    }
}
