//! `hangtime simulate` and `hangtime solve`: a job as tables, as JSON, and as files.

use crate::arguments::{ResultArguments, SimulateArguments, SolveArguments};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::job::{Job, Run, Work};
use crate::output::OutputDirectory;
use crate::progress::{Progress, SolveProgress};
use crate::report::{Report, refuse_rows_of_nothing};
use crate::settings::ChosenScene;
use crate::thumbnail::thumbnail;
use crate::{PublishedData, Scene};
use crate::{fit, simulate, solve};

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
    let directory = result.out.as_deref().map(OutputDirectory::open);
    let directory = directory.transpose()?;
    let bounds = Bounds::watch(name, job.limits());
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

impl Run {
    /// The result for people.
    fn tables(&self) -> String {
        match &self.work {
            Work::Simulated(task, simulation, gradient) => {
                simulate::tables(task, simulation, gradient.as_ref(), &self.ending)
            }
            Work::Planned(task, solution) => {
                solve::tables(&task.chosen, &task.method, solution, &self.ending)
            }
            Work::Fitted(task, estimate) => fit::tables(&task.chosen, estimate, &self.ending),
        }
    }

    /// The files that the command writes with `--out`, as (name, content): data, figures, and a page that plays the
    /// motion. Without a motion only the JSON document.
    #[must_use]
    pub fn files(&self) -> Vec<(String, String)> {
        self.files_with(&self.json())
    }

    /// The same with a document that is known.
    fn files_with(&self, json: &str) -> Vec<(String, String)> {
        let (chosen, stem) = (self.chosen(), &self.stem);
        let Some(simulation) = self.motion() else {
            return vec![(format!("{stem}.json"), json.to_owned())];
        };
        let (mut charts, mut further) = (Vec::new(), Vec::new());
        let title = match &self.work {
            Work::Simulated(task, ..) => task.method.settings.name().to_owned(),
            Work::Planned(_, solution) => {
                charts = solve::improvements(stem, chosen, solution);
                "optimal".to_owned()
            }
            Work::Fitted(_, estimate) => {
                further = fit::further(stem, estimate);
                fit::title(estimate)
            }
        };
        ResultFiles {
            stem: stem.clone(),
            title: format!("{}, {title}", chosen.scene.name),
            chosen,
            simulation,
            json,
            published: &PublishedData::default(),
            rows: self.rows(),
            index: None,
            facts: self.facts(),
            charts,
            further,
        }
        .contents()
    }

    /// A small picture of the motion as SVG, for lists of scenes; `None` where nothing moved.
    #[must_use]
    pub fn thumbnail(&self) -> Option<String> {
        let model = self.chosen().model.as_ref();
        thumbnail(self.drawing().as_ref(), model, self.motion()?)
    }
}
