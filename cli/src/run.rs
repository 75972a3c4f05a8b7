//! `hangtime simulate` and `hangtime solve`: a job as tables, as JSON, and as files.

use crate::Scene;
use crate::arguments::{ResultArguments, SimulateArguments, SolveArguments};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::job::Job;
use crate::output::OutputDirectory;
use crate::progress::{Progress, SolveProgress};
use crate::report::{Report, refuse_rows_of_nothing};
use crate::settings::ChosenScene;

/// `hangtime simulate`.
pub(crate) fn simulation(
    scenes: &'static [Scene],
    arguments: &SimulateArguments,
) -> Result<Report, BadInput> {
    refuse_rows_of_nothing(&arguments.result)?;
    let chosen = ChosenScene::from_arguments(scenes, &arguments.scene)?;
    reported(Job::simulate(chosen, arguments)?, &arguments.result)
}

/// `hangtime solve`.
pub(crate) fn solution(
    scenes: &'static [Scene],
    arguments: &SolveArguments,
) -> Result<Report, BadInput> {
    refuse_rows_of_nothing(&arguments.result)?;
    let chosen = ChosenScene::from_arguments(scenes, &arguments.scene)?;
    reported(Job::solve(chosen, arguments)?, &arguments.result)
}

/// Runs a job within its limits; tells what came of it.
fn reported(job: Job, result: &ResultArguments) -> Result<Report, BadInput> {
    let name = job.chosen().scene.name;
    let bounds = Bounds::watch(name, job.limits());
    let directory = result.out.as_deref().map(OutputDirectory::open);
    let directory = directory.transpose()?;
    let run = match job.horizon() {
        Some(horizon) => {
            let mut progress = Progress::new(name, horizon);
            job.run(&mut |now| {
                progress.reach(now.time);
                bounds.asked()
            })?
        }
        None => {
            let mut display = SolveProgress::new(name);
            job.run(&mut |now| {
                let stop = bounds.asked();
                display.report(now, stop);
                stop
            })?
        }
    };
    drop(bounds);
    let json = run.json();
    let mut report = Report::default();
    report.diagnoses.extend(run.line());
    let mut written = String::new();
    if let Some(directory) = directory {
        written = report.deliver(directory, &run.files_with(&json));
    }
    report.text = if result.json {
        json
    } else {
        run.tables() + &written
    };
    Ok(report)
}
