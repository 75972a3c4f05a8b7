//! `hangtime reproduce`: the published results beside ours and beside what is known better.

mod case;
mod column;
mod comparison;
mod motion;
mod optimum;
mod overview;
mod simulated;

use std::fmt::Write as _;

use crate::{OpeningRide, PublishedCase, Scene, Task};

use self::case::{Case, Reproduced};
use crate::arguments::ReproduceArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::lab::chart;
use crate::output::OutputDirectory;
use crate::page::{Block, Page, Player, Section};
use crate::progress::Progress;
use crate::report::Report;

/// What the program opens with besides its published results.
pub(crate) struct Opening {
    /// A ride to be solved and shown.
    pub(crate) ride: Option<OpeningRide>,
    /// Runs of other programs, as CSV.
    pub(crate) peers: &'static str,
}

pub(crate) fn run(
    scenes: &'static [Scene],
    opening: &Opening,
    arguments: &ReproduceArguments,
) -> Result<Report, BadInput> {
    if scenes.iter().all(|scene| scene.published.is_empty()) {
        return Err(BadInput::new(
            "none of the scenes has published results to reproduce; run `list` for the scenes, `--help` for the commands",
        ));
    }
    let bounds = Bounds::watch("reproduce", &arguments.limits);
    let directory = OutputDirectory::open(&arguments.out)?;
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
    let ride = match &opening.ride {
        Some(ride) if bounds.asked().is_none() => Some(motion::ride(scenes, ride, &bounds)?),
        _ => None,
    };
    let chart = opening_chart(&reproduced, opening.peers, arguments, &bounds)?;
    let stop = bounds.asked();
    drop(bounds);

    let mut report = Report::of(overview::text(&reproduced));
    report
        .diagnoses
        .extend(stop.map(|stop| stop.line("reproduce", &arguments.limits)));
    let mut files = overview::figures(&reproduced);
    let mut lead = vec![opening_section(&mut reproduced, ride)];
    lead.extend(chart);
    lead.push(overview::section(&reproduced));
    let mut sections = vec![overview::over_time_section(&files)];
    for one in reproduced {
        report.diagnoses.extend(one.diagnoses);
        files.extend(one.files);
        sections.push(one.section);
    }
    let page = Page {
        title: "hangtime: published results, reproduced".to_owned(),
        lead,
        sections,
        notes: vec![overview::NOTE.to_owned()],
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

/// The motions that play: a published one beside the same computed, and the ride.
fn opening_section(reproduced: &mut [Reproduced], ride: Option<Result<Player, String>>) -> Section {
    // An optimal motion has the most to see; of several the last one, which is the fastest.
    let optimal = |one: &&mut Reproduced| {
        one.player.is_some() && matches!(one.case.published.task, Task::Optimize)
    };
    let shown = match reproduced.iter().rposition(|one| one.player.is_some()) {
        None => None,
        Some(last) => {
            let optimal = reproduced.iter_mut().rfind(optimal);
            optimal
                .and_then(|one| one.player.take())
                .or_else(|| reproduced[last].player.take())
        }
    };
    let mut blocks = Vec::new();
    let (ride, refusal) = match ride {
        Some(Ok(player)) => (Some(player), None),
        Some(Err(words)) => (None, Some(words)),
        None => (None, None),
    };
    let players: Vec<Player> = ride.into_iter().chain(shown).collect();
    if !players.is_empty() {
        blocks.push(Block::Players(players));
    }
    blocks.extend(refusal.map(|words| Block::Text(format!("Not shown: {words}."))));
    Section {
        blocks,
        ..Section::default()
    }
}

/// Errors over CPU time on the first published simulation: the chart, and what to read off it.
fn opening_chart(
    reproduced: &[Reproduced],
    peers: &str,
    arguments: &ReproduceArguments,
    bounds: &Bounds,
) -> Result<Option<Section>, BadInput> {
    let simulates = |one: &&Reproduced| matches!(one.case.published.task, Task::Simulate { .. });
    // The last of them, whose ride has the most switches; charts of all are those of `hangtime chart`.
    let Some(one) = reproduced
        .iter()
        .rfind(simulates)
        .filter(|_| bounds.asked().is_none())
    else {
        return Ok(None);
    };
    let settings = one.case.published.settings.iter();
    let settings: Vec<String> = settings
        .map(|(name, value)| format!("{name}={value}"))
        .collect();
    let scene = one.case.chosen.scene;
    let Some((reading, figure)) =
        chart::opening(scene, &settings, (peers, &arguments.out), bounds)?
    else {
        return Ok(None);
    };
    Ok(Some(Section {
        heading: "Error over CPU time".to_owned(),
        blocks: vec![Block::Text(reading), Block::Figure(figure)],
        files: Vec::new(),
    }))
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
