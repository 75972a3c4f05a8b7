//! Scenes without controls: there is nothing to be constant on intervals, so that a motion has one, in which switches may be at
//! any time.
//!
//! On equal intervals each switch would have to stay in the one where the search has put it: a ball that comes back from an elastic wall
//! half-way strikes it at a node, on whichever side of it the program is. The finite elements of a phase are fewer than the intervals asked
//! for; where the re-simulation wants more, there are more. Whoever asks for several elements of a phase and interval gets as many.

use super::nested;
use crate::Observer;
use crate::model::Model;
use crate::ocp::problem::Problem;
use crate::ocp::settings::Settings;
use crate::ocp::solution::Solution;
use crate::simulation::InputError;

/// Intervals asked for in place of which a phase has one element.
const INTERVALS_OF_AN_ELEMENT: usize = 2;

/// Solves on one interval, and states the result on the grid of the problem.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let whole = Problem {
        intervals: 1,
        ..problem.clone()
    };
    let elements = match settings.elements {
        1 => problem.intervals.div_ceil(INTERVALS_OF_AN_ELEMENT),
        several => several * problem.intervals,
    };
    let settings = Settings {
        elements,
        ..settings.clone()
    };
    let mut solution = nested::solve(model, &whole, &settings, observer)?;
    let intervals = problem.intervals;
    for optimum in &mut solution.optima {
        optimum.intervals = intervals;
    }
    if let Some(previous) = &solution.previous {
        let resampled = previous.resampled(intervals);
        solution.controls = resampled.controls();
        solution.previous = Some(resampled);
        let elements = solution.elements.iter().sum::<usize>();
        solution.elements = vec![elements.div_ceil(intervals); intervals];
    }
    Ok(solution)
}
