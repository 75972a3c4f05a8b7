//! The files of one result: data, figures, and a page that plays the motion.

use crate::PublishedData;
use hangtime::simulation::Simulation;

use crate::animation::Animation;
use crate::drawing::Drawing;
use crate::figure::over_time;
use crate::motion::{panels, picture};
use crate::page::{Block, Figure, Page, Player, Section};
use crate::settings::ChosenScene;
use crate::spreadsheet::{events_csv, trajectory_csv};

/// A result that is to be written.
pub(crate) struct ResultFiles<'a> {
    /// Name of the files, without extension.
    pub(crate) stem: String,
    /// What the result is, in one line.
    pub(crate) title: String,
    /// The scene.
    pub(crate) chosen: &'a ChosenScene,
    /// The motion.
    pub(crate) simulation: &'a Simulation,
    /// The JSON document.
    pub(crate) json: &'a str,
    /// Published data to show beside the motion.
    pub(crate) published: &'a PublishedData,
    /// Most rows of the trajectory.
    pub(crate) rows: usize,
    /// The page that lists this result among others, if there is one, as (file name, what it holds).
    pub(crate) index: Option<(&'static str, &'static str)>,
    /// What to tell about the result, as (name, value).
    pub(crate) facts: Vec<[String; 2]>,
    /// Charts of how the result came about, as (name, chart).
    pub(crate) charts: Vec<(String, Figure)>,
    /// Further figures (SVG) and data, as (name, content).
    pub(crate) further: Vec<(String, String)>,
}

impl ResultFiles<'_> {
    /// The files, as (name, content).
    pub(crate) fn contents(self) -> Vec<(String, String)> {
        let Self {
            stem,
            title,
            chosen,
            simulation,
            json,
            published,
            rows,
            index,
            facts,
            charts,
            further,
        } = self;
        let model = chosen.model.as_ref();
        let mut files = vec![
            (format!("{stem}.json"), json.to_owned()),
            (
                format!("{stem}-trajectory.csv"),
                trajectory_csv(model, &simulation.trajectory, rows),
            ),
            (
                format!("{stem}-events.csv"),
                events_csv(model, &simulation.events),
            ),
        ];
        let mut figures = Vec::new();
        let drawing = Drawing::of(model, chosen.scene.name);
        if let Some(drawing) = &drawing {
            let svg = picture(title.clone(), drawing, model, simulation, published).svg();
            figures.push((format!("{stem}.svg"), svg));
        }
        let heading = if published.curves.is_empty() {
            title.clone()
        } else {
            format!("{title}: lines computed, dots published")
        };
        let svg = over_time(&heading, &panels(model, simulation, published));
        figures.push((format!("{stem}-time.svg"), svg));
        let (pictures, data): (Vec<_>, Vec<_>) = further
            .into_iter()
            .partition(|(name, _)| name.ends_with(".svg"));
        figures.extend(pictures);
        files.extend(data);
        let animation =
            drawing.and_then(|drawing| Animation::new(&drawing, model, simulation, published));
        let player = animation.map(|animation| Player {
            caption: String::new(),
            animation,
            result: json.to_owned(),
            plays: false,
        });
        let drawn = figures.iter().map(|(_, svg)| Block::figure(svg.clone()));
        let charted = charts.iter().map(|(_, chart)| Block::Figure(chart.clone()));
        let page = Page {
            title: title.clone(),
            lead: vec![Section {
                heading: String::new(),
                blocks: blocks(player, drawn.chain(charted).collect(), facts, about(chosen)),
                files: index
                    .iter()
                    .map(|(file, what)| (String::from(*file), String::from(*what)))
                    .chain(files.iter().map(|(name, _)| (name.clone(), name.clone())))
                    .collect(),
            }],
            ..Page::default()
        };
        files.extend(
            charts
                .into_iter()
                .map(|(name, chart)| (name, chart.svg().to_owned())),
        );
        files.extend(figures);
        files.push((format!("{stem}.html"), page.html()));
        files
    }
}

/// What the scene is, and at which parameters.
fn about(chosen: &ChosenScene) -> String {
    let parameters = chosen.parameters().join(", ");
    format!("{}. Parameters: {parameters}.", chosen.scene.title)
}

/// What moves first, then charts, then numbers, then what they are about.
fn blocks(
    player: Option<Player>,
    figures: Vec<Block>,
    facts: Vec<[String; 2]>,
    about: String,
) -> Vec<Block> {
    let player = player.map(|player| Block::Players(vec![player]));
    let mut blocks: Vec<Block> = player.into_iter().chain(figures).collect();
    let facts = facts.into_iter().map(Vec::from).collect();
    blocks.push(Block::table(["", ""], facts));
    blocks.push(Block::Text(about));
    blocks
}
