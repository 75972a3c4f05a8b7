//! The best objective over CPU time, for every formulation and number of starts.

use hangtime::ocp::{self, Formulation, Problem, Settings, TimeFreezingSettings};

use crate::anytime::{Search, figure, reading};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::figure::Look;
use crate::page::{Block, Figure};
use crate::progress::Progress;
use crate::settings::ChosenScene;
use crate::table::seconds;
use crate::timing::patience;

/// CPU time after which a search is stopped [s].
pub(super) const PATIENCE: f64 = 60.0;

/// A way to search: the formulation, and the number of starts if it is not the default.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    time_freezing: bool,
    starts: Option<usize>,
}

/// All ways, the default first.
pub(super) const WAYS: [Way; 6] = [
    way(false, None),
    way(false, Some(1)),
    way(false, Some(4)),
    way(false, Some(16)),
    way(true, None),
    way(true, Some(1)),
];

const fn way(time_freezing: bool, starts: Option<usize>) -> Way {
    Way {
        time_freezing,
        starts,
    }
}

impl Way {
    fn formulation(self) -> &'static str {
        if self.time_freezing {
            "time-freezing"
        } else {
            "phases"
        }
    }

    /// Its name in tables and at lines.
    pub(super) fn name(self) -> String {
        let formulation = self.formulation();
        match self.starts {
            None if self.time_freezing => format!("{formulation}, as many starts as agree"),
            None => format!("{formulation} (default)"),
            Some(1) => format!("{formulation}, 1 start"),
            Some(starts) => format!("{formulation}, {starts} starts"),
        }
    }

    /// The colour of its formulation, and a mark for the number of starts; dashed where that is given.
    pub(super) fn look(self) -> Look {
        let look = Look::of(self.formulation());
        match self.starts {
            None => look,
            Some(starts) => look.variant(starts.ilog2() as usize + 1).dashed(),
        }
    }

    /// The settings of the solver.
    pub(super) fn settings(self) -> Settings {
        let mut settings = Settings::default();
        settings.starts = self.starts;
        if self.time_freezing {
            settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
        }
        settings
    }
}

/// What the searches came to.
pub(super) struct Searches {
    /// What to read off them.
    pub(super) reading: String,
    /// The best objective over CPU time.
    pub(super) figure: Figure,
    /// A row for every way.
    rows: Vec<Vec<String>>,
}

const HEADER: [&str; 7] = [
    "search",
    "first motion after",
    "its objective",
    "best objective",
    "found after",
    "whole search",
    "status",
];

impl Searches {
    /// Searches on so many intervals, until `bounds` ask to end. Gaps are those to the best objective `known` on them, or to
    /// the best one found. `None` where nothing was found.
    pub(super) fn of(
        chosen: &ChosenScene,
        ways: &[Way],
        (intervals, known): (usize, Option<f64>),
        bounds: &Bounds,
    ) -> Result<Option<Self>, BadInput> {
        let model = chosen.model.as_ref();
        let name = chosen.scene.name;
        let mut progress = Progress::new(&format!("{name}, searches"), ways.len() as f64);
        let (mut searches, mut rows) = (Vec::new(), Vec::new());
        for (done, way) in ways.iter().enumerate() {
            if bounds.asked().is_some() {
                break;
            }
            progress.say(&format!("{name}: {}, {intervals} intervals", way.name()));
            let problem = Problem::of(model, intervals);
            let patient = patience(PATIENCE);
            let solution = ocp::solve(model, &problem, &way.settings(), &mut |_| {
                bounds.asked().is_none() && patient()
            });
            progress.reach((done + 1) as f64);
            let solution = match solution {
                Ok(solution) => solution,
                Err(error) if error.is_unsupported() => continue,
                Err(error) => return Err(chosen.refuse(&error)),
            };
            let search = Search::of(way.name(), way.look(), &solution);
            rows.push(row(&search, solution.status.name()));
            searches.push(search);
        }
        drop(progress);
        let found = searches.iter().filter_map(Search::best);
        let best = found.fold(known.unwrap_or(f64::INFINITY), f64::min);
        if !best.is_finite() {
            return Ok(None);
        }
        let title = format!("{name}, {intervals} intervals: best objective over CPU time");
        Ok(Some(Self {
            reading: reading(&searches, best),
            figure: figure(&title, &searches, best),
            rows,
        }))
    }

    /// The table.
    pub(super) fn table(&self) -> Block {
        Block::table(HEADER, self.rows.clone())
    }

    /// The table in words, for the standard output stream.
    pub(super) fn text(&self) -> String {
        let table = crate::table::table(HEADER, self.rows.clone());
        format!("{}\n\n{table}", self.reading)
    }
}

fn row(search: &Search, status: &str) -> Vec<String> {
    let none = || "-".to_owned();
    let time = |at: Option<f64>| at.map_or_else(none, seconds);
    let number = |objective: Option<f64>| objective.map_or_else(none, |o| format!("{o:.9}"));
    let (first, last) = (search.found.first(), search.found.last());
    vec![
        search.name.clone(),
        time(first.map(|found| found.0)),
        number(first.map(|found| found.1)),
        number(last.map(|found| found.1)),
        time(last.map(|found| found.0)),
        seconds(search.end),
        status.to_owned(),
    ]
}
