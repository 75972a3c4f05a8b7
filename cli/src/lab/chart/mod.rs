//! `hangtime chart`: accuracy against CPU time and step size, of every simulation method and of the solver, for one
//! scene or for all of them on one page.

mod drawn;
mod hard_optima;
mod measure;
mod optimum;
mod peers;
mod reading;
mod searches;
mod side_by_side;
mod simulation;
mod stability;
mod study;
mod sweep;
mod verdict;

use std::path::Path;

use crate::arguments::ChartArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::output::OutputDirectory;
use crate::page::{Block, Figure, Page, Section};
use crate::report::Report;
use crate::settings::ChosenScene;
use crate::table::table;

use crate::{HardOptimum, HardScene, Scene};
use optimum::Known;
use peers::Peers;
use study::{Charted, Study, charted, listed};

/// What the program knows that can be charted.
pub(crate) struct Listed {
    pub(crate) scenes: &'static [Scene],
    pub(crate) hard: &'static [HardScene],
    pub(crate) hard_optima: &'static [HardOptimum],
    /// Runs of other programs, as CSV.
    pub(crate) peers: &'static str,
}

pub(crate) fn run(listed: &Listed, arguments: &ChartArguments) -> Result<Report, BadInput> {
    if arguments.stability {
        return stability::run(listed.scenes, listed.hard, listed.hard_optima, arguments);
    }
    let charted = charted(listed.scenes, arguments)?;
    let (peers, fresh, left_out) = match &arguments.peers {
        None => (
            Peers::of(listed.peers, &arguments.out)?,
            String::new(),
            String::new(),
        ),
        Some(script) => {
            let names: Vec<&str> = charted.iter().map(|charted| charted.scene.name).collect();
            Peers::measured_by(script, &names, listed.peers)?
        }
    };
    let bounds = Bounds::watch("chart", &arguments.limits);
    let directory = OutputDirectory::open(&arguments.out)?;
    let mut drawn = Drawn::default();
    let many: usize = charted.iter().map(|charted| charted.studies.len()).sum();
    let mut done = 0;
    for Charted { scene, studies } in &charted {
        // A scene that lists no simulation is there for its optimum, which is seen first.
        let optimum_first = scene.charted.is_empty();
        if optimum_first {
            drawn.add_optimum(scene, arguments, &bounds)?;
        }
        for study in studies {
            if bounds.asked().is_none() {
                done += 1;
                let of_many = if many > 1 {
                    format!("{done}/{many} ")
                } else {
                    String::new()
                };
                drawn.add(simulation::chart(study, &peers, &bounds, &of_many)?);
            }
        }
        if !optimum_first {
            drawn.add_optimum(scene, arguments, &bounds)?;
        }
    }
    let mut report = Report {
        text: drawn.text(charted.len() > 1),
        diagnoses: drawn.diagnoses,
        ..Report::default()
    };
    report.text += &left_out;
    let mut files = drawn.files;
    if !fresh.is_empty() {
        files.push((peers::FILE.to_owned(), fresh));
    }
    if !drawn.sections.is_empty() {
        let links = directory.pages();
        files.push(page(&charted, links, drawn.sections, drawn.overview));
    }
    report.diagnoses.extend(
        bounds
            .asked()
            .map(|stop| stop.line("chart", &arguments.limits)),
    );
    drop(bounds);
    let written = report.deliver(directory, &files);
    // Every figure is also on the page; the pages and data are what one looks for.
    report.text += &written;
    Ok(report)
}

/// Errors over CPU time of one simulation, for the page of published results: what to read off the chart, and the chart. The
/// `settings` are those of the scene; other programs are known by the stored runs, and by those in the output directory. `None`
/// where there is nothing to measure against.
pub(crate) fn opening(
    scene: &'static Scene,
    settings: &[String],
    (peers, out): (&str, &Path),
    bounds: &Bounds,
) -> Result<Option<(String, Figure)>, BadInput> {
    let chosen = ChosenScene::new(scene, settings)?;
    // The listed one with these parameters, which is the one that other programs ran.
    let listed = listed(scene)?.into_iter();
    let mut same = listed.filter(|study| study.chosen.parameters() == chosen.parameters());
    let study = match same.next() {
        Some(study) => study,
        None => Study::new(chosen, None, None)?,
    };
    simulation::opening(&study, &Peers::of(peers, out)?, bounds)
}

/// What was drawn so far.
#[derive(Default)]
struct Drawn {
    texts: Vec<String>,
    /// The texts of what the overview does not show.
    solved: String,
    sections: Vec<Section>,
    overview: Vec<Vec<String>>,
    files: Vec<(String, String)>,
    diagnoses: Vec<String>,
}

impl Drawn {
    /// The searches and optima of a scene with an objective.
    fn add_optimum(
        &mut self,
        scene: &'static Scene,
        arguments: &ChartArguments,
        bounds: &Bounds,
    ) -> Result<(), BadInput> {
        if bounds.asked().is_none() {
            let chosen = ChosenScene::new(scene, &arguments.settings)?;
            let known = known(scene, arguments);
            let optimum = optimum::chart(&chosen, &optimum::ALL, known, bounds)?;
            optimum.into_iter().for_each(|chart| self.add(chart));
        }
        Ok(())
    }

    fn add(&mut self, chart: drawn::Chart) {
        if chart.overview.is_none() {
            self.solved.push_str(&chart.text);
        }
        self.texts.push(chart.text);
        self.sections.extend(chart.section);
        self.overview.extend(chart.overview);
        self.files.extend(chart.files);
        self.diagnoses.extend(chart.diagnoses);
    }

    /// For the standard output stream: all tables of one scene; of several the overview and the tables of optima.
    fn text(&self, several: bool) -> String {
        if several {
            let overview = table(simulation::overview_header(), self.overview.clone());
            format!(
                "{}\n\n{overview}\n{}",
                simulation::overview_text(self.overview.len()),
                self.solved
            )
        } else {
            self.texts.concat()
        }
    }
}

/// What is known of the optimum of a scene, if its parameters are those for which it is known.
fn known(scene: &Scene, arguments: &ChartArguments) -> Known {
    if arguments.settings.is_empty() {
        Known {
            any: scene.best_known,
            on: scene.question.map(|question| question.known),
        }
    } else {
        Known::default()
    }
}

/// The page: of one scene, or of all with an overview.
fn page(
    charted: &[Charted],
    links: Vec<String>,
    mut sections: Vec<Section>,
    overview: Vec<Vec<String>>,
) -> (String, String) {
    let overview = (overview.len() > 1).then(|| Section {
        heading: "Overview".to_owned(),
        blocks: vec![
            Block::Text(simulation::overview_text(overview.len())),
            Block::table(simulation::overview_header(), overview),
        ],
        ..Section::default()
    });
    // The chart of the first simulation is what a page of one scene opens with.
    let lead = match overview {
        Some(overview) if charted.len() > 1 => overview,
        overview => {
            sections.extend(overview);
            sections.remove(0)
        }
    };
    let (title, name) = match charted {
        [one] => (
            format!("{}: accuracy and its price", one.scene.name),
            format!("chart-{}.html", one.scene.name),
        ),
        _ => ("Accuracy and its price".to_owned(), "chart.html".to_owned()),
    };
    let page = Page {
        title,
        lead: vec![lead],
        sections,
        notes: vec![simulation::LEGEND.to_owned()],
        links: links.into_iter().filter(|link| *link != name).collect(),
    };
    let html = page.html();
    (name, html)
}
