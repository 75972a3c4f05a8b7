//! Fine control grids by way of coarser ones.
//!
//! Contact sequences are found on a coarse grid, where programs are small: the motion found there starts the finer
//! one. Its switches lie elsewhere on the finer grid, so a contact-implicit program on that grid says where.

use cpu_time::ThreadTime;

use super::final_times::solve_grid;
use super::one_grid::Start;
use crate::Observer;
use crate::model::Model;
use crate::ocp::problem::Problem;
use crate::ocp::progress::Watch;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Counts, Solution, Status};
use crate::simulation::InputError;

/// Control intervals that a contact sequence is searched with, at most half as many again.
const COARSE: usize = 30;

/// Solves from one start.
pub(in crate::ocp) fn solve_once(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let clock = ThreadTime::try_now();
    let start = Start {
        watch: Watch::new(observer),
        counts: Counts::default(),
        coarser: None,
    };
    let mut solution = solve(model, problem, settings, start)?;
    if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
        solution.seconds = elapsed.as_secs_f64();
    }
    Ok(solution)
}

/// Solves on the grid of the problem, by way of a coarser one where that has many intervals.
pub(in crate::ocp) fn solve<'s>(
    model: &dyn Model,
    problem: &Problem,
    settings: &'s Settings,
    mut start: Start<'s>,
) -> Result<Solution, InputError> {
    let search = matches!(settings.formulation, Formulation::Phases)
        && !matches!(settings.guess, Guess::Previous(_));
    if search && 2 * problem.intervals > 3 * COARSE {
        let factor = (problem.intervals as f64 / COARSE as f64).round() as usize;
        let coarse = Problem {
            intervals: problem.intervals.div_ceil(factor),
            ..problem.clone()
        };
        let (solution, watch) = solve_grid(model, &coarse, settings, start)?;
        if matches!(solution.status, Status::Interrupted | Status::Unbounded) {
            return Ok(on_grid(solution, problem.intervals));
        }
        start = Start {
            watch,
            counts: solution.counts,
            coarser: solution.previous,
        };
    }
    let (solution, _) = solve_grid(model, problem, settings, start)?;
    Ok(solution)
}

/// A motion on a coarser grid as one on the grid asked for, where every interval of that lies within one of the
/// coarser grid; nothing else.
fn on_grid(solution: Solution, intervals: usize) -> Solution {
    let known = solution.previous.as_ref();
    let Some(previous) = known.filter(|previous| intervals.is_multiple_of(previous.intervals()))
    else {
        return Solution::without_motion(solution.status, solution.violations, solution.counts);
    };
    let factor = intervals / previous.intervals();
    let previous = previous.resampled(intervals);
    let elements = solution.elements.iter();
    Solution {
        elements: elements
            .flat_map(|&elements| std::iter::repeat_n(elements, factor))
            .collect(),
        controls: previous.controls(),
        previous: Some(previous),
        ..solution
    }
}
