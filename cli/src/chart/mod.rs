//! `hangtime chart`: accuracy against CPU time, of every simulation method and of the solver.

mod drawn;
mod optimum;
mod simulation;
mod sweep;

use crate::Scene;
use hangtime::simulation::InitialValueProblem;

use crate::arguments::ChartArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::output::OutputDirectory;
use crate::page::{Page, Section};
use crate::report::Report;
use crate::settings::{ChosenScene, find};

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &ChartArguments,
) -> Result<Report, BadInput> {
    let chosen: Vec<ChosenScene> = match &arguments.scene {
        Some(name) => vec![ChosenScene::new(find(scenes, name)?, &arguments.settings)?],
        None => scenes
            .iter()
            .map(|scene| ChosenScene::new(scene, &[]))
            .collect::<Result<_, _>>()?,
    };
    let problems = chosen
        .iter()
        .map(|chosen| {
            let model = chosen.model.as_ref();
            InitialValueProblem::of(model, None)
                .and_then(|problem| problem.check(model).map(|()| problem))
                .map_err(|error| chosen.refuse(&error))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let directory = OutputDirectory::open(&arguments.out)?;
    let bounds = Bounds::watch("chart", &arguments.limits);
    let mut report = Report::default();
    let mut files = Vec::new();
    for (chosen, problem) in chosen.iter().zip(&problems) {
        if bounds.asked().is_some() {
            break;
        }
        let mut charts = vec![simulation::chart(chosen, problem, &bounds)?];
        charts.extend(optimum::chart(chosen, &optimum::GRIDS, &bounds)?);
        let mut sections = Vec::with_capacity(charts.len());
        for chart in charts {
            report.text += &chart.text;
            report.diagnoses.extend(chart.diagnoses);
            files.extend(chart.files);
            sections.extend(chart.section);
        }
        if !sections.is_empty() {
            files.push(page(chosen, sections));
        }
    }
    report.diagnoses.extend(
        bounds
            .asked()
            .map(|stop| stop.line("chart", &arguments.limits)),
    );
    drop(bounds);
    let written = report.deliver(directory, &files);
    report.text += &written;
    Ok(report)
}

/// The page of one scene.
fn page(chosen: &ChosenScene, sections: Vec<Section>) -> (String, String) {
    let name = chosen.scene.name;
    let page = Page {
        title: format!("{name}: accuracy against CPU time"),
        introduction: format!("Parameters: {}.", chosen.parameters().join(", ")),
        sections,
    };
    (format!("chart-{name}.html"), page.html())
}
