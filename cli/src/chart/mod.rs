//! `hangtime chart`: accuracy against CPU time and step size, of every simulation method and of the solver, for one
//! scene or for all of them on one page.

mod controlled;
mod drawn;
mod hard_optima;
mod measure;
mod optimum;
mod peers;
mod side_by_side;
mod simulation;
mod stability;
mod study;
mod sweep;
mod verdict;

use crate::arguments::ChartArguments;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::output::OutputDirectory;
use crate::page::{Page, Section};
use crate::report::Report;
use crate::settings::ChosenScene;
use crate::table::table;

use crate::{ControlScene, HardOptimum, HardScene, Scene};
use peers::Peers;
use study::{Charted, charted};

/// What the program knows that can be charted.
pub(crate) struct Listed {
    pub(crate) scenes: &'static [Scene],
    pub(crate) hard: &'static [HardScene],
    pub(crate) hard_optima: &'static [HardOptimum],
    pub(crate) controlled: &'static [ControlScene],
    /// Runs of other programs, as CSV.
    pub(crate) peers: &'static str,
}

pub(crate) fn run(listed: &Listed, arguments: &ChartArguments) -> Result<Report, BadInput> {
    if arguments.stability {
        return stability::run(listed.scenes, listed.hard, listed.hard_optima, arguments);
    }
    let charted = charted(listed.scenes, arguments)?;
    let peers = Peers::of(listed.peers, &arguments.out)?;
    let directory = OutputDirectory::open(&arguments.out)?;
    let bounds = Bounds::watch("chart", &arguments.limits);
    let mut drawn = Drawn::default();
    let many: usize = charted.iter().map(|charted| charted.studies.len()).sum();
    let mut done = 0;
    for Charted { scene, studies } in &charted {
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
        if bounds.asked().is_none() {
            let chosen = ChosenScene::new(scene, &arguments.settings)?;
            let known = scene.best_known.filter(|_| arguments.settings.is_empty());
            let optimum = optimum::chart(&chosen, &optimum::GRIDS, known, &bounds)?;
            optimum.into_iter().for_each(|chart| drawn.add(chart));
        }
    }
    if arguments.scenes.is_empty() && !listed.controlled.is_empty() && bounds.asked().is_none() {
        drawn.add(controlled::chart(listed.controlled, &bounds)?);
    }
    let mut report = Report {
        text: drawn.text(charted.len() > 1),
        diagnoses: drawn.diagnoses,
        ..Report::default()
    };
    let mut files = drawn.files;
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

/// The page: of one scene, or of all with an overview.
fn page(
    charted: &[Charted],
    links: Vec<String>,
    mut sections: Vec<Section>,
    overview: Vec<Vec<String>>,
) -> (String, String) {
    if overview.len() > 1 {
        let first = Section {
            heading: "Overview".to_owned(),
            text: simulation::overview_text(overview.len()),
            header: simulation::overview_header(),
            rows: overview,
            ..Section::default()
        };
        sections.insert(0, first);
    }
    let (title, name) = match charted {
        [one] => (
            format!("{}: accuracy and its price", one.scene.name),
            format!("chart-{}.html", one.scene.name),
        ),
        _ => ("Accuracy and its price".to_owned(), "chart.html".to_owned()),
    };
    let page = Page {
        title,
        introduction: simulation::LEGEND.to_owned(),
        sections,
        links: links.into_iter().filter(|link| *link != name).collect(),
    };
    let html = page.html();
    (name, html)
}
