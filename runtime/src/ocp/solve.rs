//! The pipeline: global phase, contact sequence, high order, repair, certificate, re-simulation.

use cpu_time::ThreadTime;

use super::collocation::{Places, Setting, parabolas};
use super::levels;
use super::path::Path;
use super::previous::Previous;
use super::problem::{Problem, bounds};
use super::progress::Watch;
use super::search::Search;
use super::settings::Settings;
use super::solution::{Counts, Solution};
use super::starts;
use super::units::Units;
use crate::Observer;
use crate::model::Model;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// By how many stages the scheme grows where the re-simulation does not confirm a plan.
const MORE_STAGES: usize = 2;

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
    problem.check(model)?;
    starts::solve(model, problem, settings, observer)
}

/// Solves from one start.
pub(super) fn solve_once(
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
    let mut solution = levels::solve(model, problem, settings, start)?;
    if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
        solution.seconds = elapsed.as_secs_f64();
    }
    Ok(solution)
}

/// What a solution on one grid takes over from the one before it.
pub(super) struct Start<'s> {
    pub(super) watch: Watch<'s>,
    pub(super) counts: Counts,
    /// The motion on a coarser grid.
    pub(super) coarser: Option<Previous>,
}

/// Solves on the grid of the problem.
pub(super) fn solve_grid<'s>(
    model: &dyn Model,
    problem: &Problem,
    settings: &'s Settings,
    start: Start<'s>,
) -> Result<(Solution, Watch<'s>), InputError> {
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let guess = match &start.coarser {
        Some(coarser) => coarser.path(model, problem)?,
        None => Path::guess(model, problem, &settings.guess, bounds)?,
    };
    let units = Units::new(model, &guess, bounds);
    let stages = (settings.stages..=ButcherTableau::MAX_STAGES).step_by(MORE_STAGES);
    let tableaus: Vec<ButcherTableau> = stages
        .filter_map(|stages| ButcherTableau::new(Scheme::RadauIia, stages))
        .collect();
    let Some(tableau) = tableaus.first() else {
        return Err(settings.refuse_stages());
    };
    let parabolas = parabolas(model, &problem.start());
    let setting = Setting {
        model,
        problem,
        tableau,
        units: &units,
        bounds,
        parabolas: &parabolas,
        places: Places {
            bounds: settings.bounds,
            path: settings.path_points,
        },
        shape: settings.controls,
    };
    let mut search = Search {
        setting,
        tableaus: &tableaus,
        elements: vec![settings.elements; problem.intervals],
        settings,
        watch: start.watch,
        most_programs: start.counts.programs + settings.maximum_programs,
        counts: start.counts,
        explores: start.coarser.is_none(),
        time_freezing: None,
        tried: Vec::new(),
        best: None,
        failure: None,
        last_failure: None,
    };
    let mut solution = search.run(&guess, start.coarser.as_ref())?;
    solution.time_freezing = search.time_freezing;
    Ok((solution, search.watch))
}
