//! `hangtime reproduce`: the published results beside ours and beside what is known better.

mod case;
mod column;
mod comparison;
mod optimum;
mod overview;
mod simulated;

use std::fmt::Write as _;

use crate::{PublishedCase, Scene, Task};

use self::case::{Case, Reproduced};
use crate::arguments::ReproduceArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::output::OutputDirectory;
use crate::page::Page;
use crate::progress::Progress;
use crate::report::Report;

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &ReproduceArguments,
) -> Result<Report, BadInput> {
    if scenes.iter().all(|scene| scene.published.is_empty()) {
        return Err(BadInput::new(
            "none of the scenes has published results to reproduce; run `list` for the scenes, `--help` for the commands",
        ));
    }
    let directory = OutputDirectory::open(&arguments.out)?;
    let bounds = Bounds::watch("reproduce", &arguments.limits);
    let cases: Vec<(&'static Scene, &'static PublishedCase)> = scenes
        .iter()
        .flat_map(|scene| scene.published.iter().map(move |case| (scene, case)))
        .collect();
    let mut progress = Progress::new("reproduce", cases.len() as f64);
    let mut reproduced = Vec::with_capacity(cases.len());
    for (done, (scene, published)) in cases.into_iter().enumerate() {
        if bounds.asked().is_some() {
            break;
        }
        progress.say(published.title);
        reproduced.push(reproduce(scene, published, &bounds)?);
        progress.reach((done + 1) as f64);
    }
    drop(progress);
    let stop = bounds.asked();
    drop(bounds);

    let mut report = Report::of(overview::text(&reproduced));
    report
        .diagnoses
        .extend(stop.map(|stop| stop.line("reproduce", &arguments.limits)));
    let mut files = overview::figures(&reproduced);
    let mut sections = vec![overview::section(&reproduced, &files)];
    for one in reproduced {
        report.diagnoses.extend(one.diagnoses);
        files.extend(one.files);
        sections.push(one.section);
    }
    let page = Page {
        title: "hangtime: published results, reproduced".to_owned(),
        introduction: overview::INTRODUCTION.to_owned(),
        sections,
        links: directory
            .pages()
            .into_iter()
            .filter(|page| page.starts_with("chart") || page == "stability.html")
            .collect(),
    };
    files.push((overview::INDEX.0.to_owned(), page.html()));
    if !report.deliver(directory, &files).is_empty() {
        let index = arguments.out.join(overview::INDEX.0);
        let _ = writeln!(report.text, "\nfigures and data: {}", index.display());
    }
    Ok(report)
}

fn reproduce(
    scene: &'static Scene,
    published: &'static PublishedCase,
    bounds: &Bounds,
) -> Result<Reproduced, BadInput> {
    let case = Case::new(scene, published)?;
    match published.task {
        Task::Simulate { horizon } => simulated::reproduce(case, horizon, bounds),
        Task::Optimize => optimum::reproduce(case, bounds),
    }
}
