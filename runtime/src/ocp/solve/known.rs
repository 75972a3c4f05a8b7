//! A motion of a neighbouring problem, as a start.

use super::optima::{Found, result};
use super::run::{Begin, Task};
use super::shared_observer::SharedObserver;
use super::words;
use crate::Observer;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::previous::Previous;
use crate::ocp::problem::Problem;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::readings::Readings;
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Source};
use crate::simulation::InputError;

/// Solves from a known motion; where its contact sequence allows none, from the word of it.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    previous: &Previous,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let (solution, stopped) = {
        let observer = SharedObserver::new(observer);
        let task = Task::new((model, problem, settings), &observer);
        let (solution, work) = task.run(Effort::Conclude, |runner| {
            from_previous(&task, runner, previous)
        })?;
        let found = Found {
            source: Source::Start(0),
            cpu: work.1.total,
            solution,
        };
        let stopped = observer.stopped();
        (
            result(vec![found.clone()], vec![found], work, stopped),
            stopped,
        )
    };
    if solution.motion.is_some() || stopped || model.declaration().controls.is_empty() {
        return Ok(solution);
    }
    let mut other = words::solve(model, problem, settings, observer)?;
    other.counts.add(&solution.counts);
    other.seconds += solution.seconds;
    Ok(other)
}

/// What a known motion leads to on the grid of a task.
pub(super) fn from_previous(
    task: &Task,
    runner: &mut Runner,
    previous: &Previous,
) -> Result<Solution, InputError> {
    let trajectory = previous.trajectory(task.model, task.problem)?;
    let begin = Begin {
        candidate: previous.candidate(&trajectory, task.problem.intervals),
        readings: Readings::All,
        elements: task.settings.elements,
    };
    task.conclude(runner, begin)
}
