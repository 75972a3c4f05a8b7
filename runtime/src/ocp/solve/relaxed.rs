//! The relaxed time-freezing program of a task, and the plan that a search begins with.

use super::optima::is_confirmed;
use super::run::{Begin, Task, tableaus};
use crate::ocp::collocation::discretization::{Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::global::guess::guess;
use crate::ocp::global::time_freezing::refuse_resets;
use crate::ocp::global::time_freezing_search::candidate;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::problem::bounds;
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::scale::Scale;
use crate::ocp::search::readings::Readings;
use crate::ocp::settings::{ControlNodes, Guess, TimeFreezingSettings};
use crate::ocp::solution::{Solution, Status, TimeFreezingReport};
use crate::ocp::tuning::freezing::{PROVED, SHORT};
use crate::simulation::InputError;

/// The rule of the search by this name.
const FREEZING: &str = "time-freezing";

/// What the relaxed program tells, and the motion that it leads to, from a kind of guess.
pub(super) fn relaxed(
    task: &Task,
    runner: &mut Runner,
    formulation: &TimeFreezingSettings,
    kind: &Guess,
) -> Result<(Option<TimeFreezingReport>, Option<Candidate>), InputError> {
    let (model, problem, settings) = (task.model, task.problem, task.settings);
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let tableaus = tableaus(settings.stages);
    let tableau = tableaus.first().ok_or_else(|| settings.refuse_stages())?;
    let parabolas = parabolas(model, &problem.start());
    let guessed = guess(model, problem, kind, bounds)?;
    let units = Units::new(model, &Scale::of(model, problem), &guessed, bounds);
    let scene = (model, problem);
    let setting = Setting::new(scene, settings, (tableau, &units), (bounds, &parabolas));
    let simulated = matches!(kind, Guess::Ride | Guess::Random(_));
    let failure = runner.take_failure();
    let relaxed = candidate(runner, setting, formulation, &guessed, simulated)?;
    let (report, found) = relaxed.unzip();
    let found = found.flatten();
    runner.restore_failure(failure, found.is_some());
    Ok((report, found))
}

/// The plan that a search begins with, proved in few programs, or else none: then the search does without an incumbent. The relaxed program is
/// left early; a guess at which functions are not finite is no reason to end.
pub(super) fn first(task: &Task, runner: &mut Runner) -> Option<Solution> {
    let settings = task.settings;
    let asked = settings.grid == ControlNodes::Equal && settings.uses(FREEZING);
    let known = matches!(settings.guess, Guess::Previous(_));
    let driven = !task.model.declaration().controls.is_empty();
    // A price on the time is no part of the objective that words are compared by.
    let priced = settings.haste != 0.0;
    // The relaxed program is measured in the units of the scene: of shorter ways its tolerance says nothing.
    let ways = Scale::of(task.model, task.problem).ways;
    let short = ways.iter().any(|way| *way > 0.0 && *way < SHORT);
    let refused = short || refuse_resets(task.model).is_err();
    if !asked || known || priced || !driven || refused {
        return None;
    }
    let failure = runner.take_failure();
    let found = proved(task, runner);
    runner.restore_failure(failure, true);
    runner.take_refusal();
    runner.effort = Effort::Quick;
    runner.of_a_motion = settings.maximum_programs;
    found.ok().flatten().filter(|plan| plan.motion.is_some())
}

/// The plan that the relaxed program leads to, concluded where its re-simulation confirms it.
fn proved(task: &Task, runner: &mut Runner) -> Result<Option<Solution>, InputError> {
    runner.effort = Effort::Quick;
    let (formulation, guess) = (TimeFreezingSettings::default(), &task.settings.guess);
    let (_, Some(candidate)) = relaxed(task, runner, &formulation, guess)? else {
        return Ok(None);
    };
    let begin = Begin {
        candidate,
        readings: Readings::All,
        elements: task.settings.elements,
    };
    let plan = task.followed(runner, begin)?;
    runner.of_a_motion = PROVED.min(task.settings.maximum_programs);
    match is_confirmed(&plan) {
        true => task.carry(runner, &plan).map(Some),
        false => Ok(Some(plan).filter(|plan| plan.status == Status::Interrupted)),
    }
}
