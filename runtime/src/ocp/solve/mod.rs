//! The order of work: words and what they come to on the grid, or a known motion, or the time-freezing formulation; final times wherever they
//! lie. The top of the layers; nothing else knows it.

mod freezing;
mod guessed;
mod impossible;
mod known;
mod nearest;
mod optima;
mod placing;
mod relaxed;
mod run;
mod searched;
mod shared_observer;
mod waiting;
mod words;

use self::impossible::Shown;
use super::global::time_freezing::refuse_resets;
use super::joined::joined;
use super::problem::Problem;
use super::settings::{ControlNodes, Formulation, Settings};
use super::solution::{Solution, Status};
use super::struck::after_impact;
use super::tuning::on_grid::FINE;
use super::unknown::with_unknowns;
use crate::Observer;
use crate::model::Model;
use crate::refusal;
use crate::simulation::InputError;

/// Solves an optimal control problem; `observer` is called after every interior point iteration and may stop it.
///
/// # Errors
/// [`InputError`] if problem or settings are refused; everything that happens later is a [`Status`](super::Status).
///
/// # Examples
/// See the [module](super).
pub fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    settings.check()?;
    match with_unknowns(model, problem, settings)? {
        Some(unknown) => {
            let solution = solve_given(&unknown.model, &unknown.problem, settings, observer)?;
            Ok(unknown.of_scene(solution))
        }
        None => solve_given(model, problem, settings, observer),
    }
}

/// Solves a problem whose parameters are given.
fn solve_given(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    match joined(model, problem)? {
        Some(known) => {
            let solution = solve_joined(&*known.model, &known.problem, settings, observer)?;
            Ok(known.note(solution))
        }
        None => solve_joined(model, problem, settings, observer),
    }
}

/// Solves a problem whose start fulfils the joints of its scene, from after the impact of its start on.
fn solve_joined(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    match after_impact(model, problem) {
        Some(struck) => {
            let solution = solve_consistent(model, &struck.problem, settings, observer)?;
            Ok(struck.note(solution))
        }
        None => solve_consistent(model, problem, settings, observer),
    }
}

/// Solves a problem whose start fulfils joints and strikes nothing.
fn solve_consistent(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    problem.check(model)?;
    if matches!(settings.formulation, Formulation::TimeFreezing(_)) {
        refuse_resets(model)?;
    }
    if settings.grid == ControlNodes::Aligned && model.declaration().controls.is_empty() {
        let what = "a grid that is aligned with phases, of a scene without controls,";
        return Err(refusal::unsupported(what, "take an equal one"));
    }
    let problem = &problem.on_the_ground(model);
    // On a finer grid the places at which a motion may end would fill the memory.
    let guessed = match problem.intervals > FINE {
        true => None,
        false => guessed::guessed((model, problem, settings), observer)?,
    };
    let hasty = waiting::hasty(model, problem, settings);
    let with = hasty.as_ref().unwrap_or(settings);
    let mut solution = searched::searched(model, problem, with, observer)?;
    if hasty.is_some() || waiting::ends_at_rest(model, problem, settings, &solution) {
        solution = waiting::shortest(model, problem, settings, observer, solution)?;
    }
    if let Some(guessed) = guessed {
        solution = guessed::no_worse((model, problem, settings), observer, solution, guessed)?;
    }
    if matches!(solution.status, Status::NotFound | Status::Failed(_)) && solution.motion.is_none()
    {
        // What it shows holds for given parameters.
        if model.held().is_none()
            && let Shown::Impossible { least_time } = impossible::shown(model, problem)
        {
            solution.status = Status::Infeasible;
            solution.least_time = least_time;
        }
        solution.nearest = nearest::nearest(model, problem, settings)?;
    }
    Ok(solution)
}
