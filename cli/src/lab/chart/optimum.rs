//! The accuracy of the solver against its CPU time, over formulations, stages and intervals.

use hangtime::ocp::{self, Formulation, Problem, Settings, TimeFreezingSettings};

use super::drawn::Chart;
use super::searches::{Searches, WAYS, Way};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::figure::{Curve, Dot, LogLog, Look};
use crate::page::{Block, Section};
use crate::progress::Progress;
use crate::settings::ChosenScene;
use crate::spreadsheet::csv_text;
use crate::table::{seconds, table};
use crate::task::INTERVALS;

/// What differs between the runs of one line.
#[derive(Debug, Clone, Copy)]
struct Grid {
    /// Whether the contact sequence comes from the time-freezing complementarity problem.
    time_freezing: bool,
    /// Stages of the phases, or of the complementarity problem.
    stages: usize,
    /// Tolerance of the programs, if it is not the default.
    tolerance: Option<f64>,
    /// Control intervals, increasing.
    intervals: &'static [usize],
}

/// The lines of a chart. With fewer stages the phases confirm no plan on coarse grids.
const GRIDS: [Grid; 5] = [
    phases(4, None),
    phases(6, None),
    phases(4, Some(1e-6)),
    time_freezing(2),
    time_freezing(3),
];

const fn phases(stages: usize, tolerance: Option<f64>) -> Grid {
    Grid {
        time_freezing: false,
        stages,
        tolerance,
        intervals: &[10, 20, 30, 40, 60],
    }
}

const fn time_freezing(stages: usize) -> Grid {
    Grid {
        time_freezing: true,
        stages,
        tolerance: None,
        intervals: &[10, 20, 30],
    }
}

impl Grid {
    fn name(&self) -> String {
        let formulation = if self.time_freezing {
            "time-freezing"
        } else {
            "phases"
        };
        let tolerance = self.tolerance.map_or_else(String::new, |tolerance| {
            format!(", tolerance {tolerance:.0e}")
        });
        format!("{formulation}, {} stages{tolerance}", self.stages)
    }

    fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        if self.time_freezing {
            let mut freezing = TimeFreezingSettings::default();
            freezing.stages = self.stages;
            settings.formulation = Formulation::TimeFreezing(freezing);
            settings.starts = Some(1);
        } else {
            settings.stages = self.stages;
        }
        settings.tolerance = self.tolerance.unwrap_or(settings.tolerance);
        settings
    }
}

/// One solve.
struct Run {
    line: usize,
    name: String,
    intervals: usize,
    status: &'static str,
    solved: bool,
    stationarity: &'static str,
    objective: f64,
    distance: f64,
    iterations: usize,
    seconds: f64,
}

/// What is tried on a scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// The searches that are compared over CPU time.
    ways: &'static [Way],
    /// The grids whose optima are compared.
    grids: &'static [Grid],
}

/// All of it.
pub(super) const ALL: Plan = Plan {
    ways: &WAYS,
    grids: &GRIDS,
};

/// What is known of an optimum.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Known {
    /// The least objective seen on any grid.
    pub(super) any: Option<f64>,
    /// A number of control intervals, and the least objective seen on them.
    pub(super) on: Option<(usize, f64)>,
}

/// Searches in every way, and solves on every grid; `None` for a scene without an objective. Gaps are those to the best
/// objective `known`, or to the best run.
pub(super) fn chart(
    chosen: &ChosenScene,
    &Plan { ways, grids }: &Plan,
    known: Known,
    bounds: &Bounds,
) -> Result<Option<Chart>, BadInput> {
    let model = chosen.model.as_ref();
    if model.declaration().optimal_control.is_none() {
        return Ok(None);
    }
    let name = chosen.scene.name;
    let intervals = known.on.map_or(INTERVALS, |(intervals, _)| intervals);
    let on_it = known.on.map(|(_, objective)| objective);
    let searches = Searches::of(chosen, ways, (intervals, on_it), bounds)?;
    let total: usize = grids.iter().map(|grid| grid.intervals.len()).sum();
    let mut progress = Progress::new(&format!("{name}, solver"), total as f64);
    let mut runs: Vec<Run> = Vec::with_capacity(total);
    for (line, grid) in grids.iter().enumerate() {
        for &intervals in grid.intervals {
            if bounds.asked().is_some() {
                break;
            }
            progress.say(&format!("{name}: {}, {intervals} intervals", grid.name()));
            let problem = Problem::of(model, intervals);
            let solution = ocp::solve(model, &problem, &grid.settings(), &mut |_| {
                bounds.asked().is_none()
            })
            .map_err(|error| chosen.refuse(&error))?;
            runs.push(Run {
                line,
                name: grid.name(),
                intervals,
                status: solution.status.name(),
                solved: solution.status.is_solved(),
                stationarity: solution.stationarity.name(),
                objective: solution.objective,
                distance: solution.resimulation_error,
                iterations: solution.counts.global_iterations + solution.counts.iterations,
                seconds: solution.seconds.total,
            });
            progress.reach(runs.len() as f64);
        }
    }
    drop(progress);
    let solved = runs.iter().filter(|run| run.solved);
    let best = solved
        .map(|run| run.objective)
        .fold(known.any.unwrap_or(f64::INFINITY), f64::min);
    Ok(Some(report(name, searches.as_ref(), &runs, best)))
}

const HEADER: [&str; 9] = [
    "formulation",
    "intervals",
    "objective",
    "above the best",
    "re-simulation",
    "certificate",
    "iterations",
    "CPU time",
    "status",
];

impl Run {
    fn cells(&self, best: f64, number: &dyn Fn(f64) -> String, time: String) -> Vec<String> {
        let short = |value: f64| {
            if value.is_finite() {
                format!("{value:.1e}")
            } else {
                "-".to_owned()
            }
        };
        vec![
            self.name.clone(),
            self.intervals.to_string(),
            number(self.objective),
            short(self.objective - best),
            short(self.distance),
            self.stationarity.to_owned(),
            self.iterations.to_string(),
            time,
            self.status.to_owned(),
        ]
    }
}

/// The solved runs of each line.
fn curves(runs: &[Run], x: impl Fn(&Run) -> f64, y: impl Fn(&Run) -> f64) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for run in runs.iter().filter(|run| run.solved) {
        let point = Dot {
            x: x(run),
            y: y(run),
            half: None,
            note: format!(
                "{}, {} intervals: objective {}",
                run.name, run.intervals, run.objective
            ),
        };
        match curves.iter_mut().find(|curve| curve.name == run.name) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name: run.name.clone(),
                look: Look::of(&run.name).variant(run.line),
                steps: false,
                points: vec![point],
            }),
        }
    }
    curves
}

/// The figures, as (kind, SVG).
fn figures(name: &str, runs: &[Run], best: f64) -> [(&'static str, String); 3] {
    const GAP: &str = "objective above the best known";
    const TIME: &str = "CPU time [s]";
    let draw = |title: &str, [x, y]: [&str; 2], curves| {
        LogLog {
            title: &format!("{name}: {title}"),
            x,
            y,
            falling: false,
            floor: None,
            curves,
        }
        .svg()
    };
    let (seconds, gap) = (|run: &Run| run.seconds, |run: &Run| run.objective - best);
    [
        (
            "objective",
            draw(
                "gap to the best known objective",
                [TIME, GAP],
                curves(runs, seconds, gap),
            ),
        ),
        (
            "intervals",
            draw(
                "gap to the best known objective",
                ["control intervals", GAP],
                curves(runs, |run| run.intervals as f64, gap),
            ),
        ),
        (
            "resimulation",
            draw(
                "re-simulation at the end",
                [TIME, "distance from the plan"],
                curves(runs, seconds, |run| run.distance),
            ),
        ),
    ]
}

const ABOUT: &str = "Each run starts from nothing. More intervals give the controls more freedom, which lowers the objective; more \
    stages bring the plan closer to the motion that it stands for, which an independent event-driven simulation under its controls \
    measures at the end.";

fn report(name: &str, searches: Option<&Searches>, runs: &[Run], best: f64) -> Chart {
    let decimals = |value: f64| {
        if value.is_finite() {
            format!("{value:.10}")
        } else {
            "-".to_owned()
        }
    };
    let rows: Vec<Vec<String>> = runs
        .iter()
        .map(|run| run.cells(best, &decimals, seconds(run.seconds)))
        .collect();
    let text = format!(
        "{}{name}: objective of the solver, the best known is {}\n\n{}\n",
        searches.map_or_else(String::new, |searches| searches.text() + "\n"),
        decimals(best),
        table(HEADER, rows.clone())
    );
    let figures = figures(name, runs, best);
    let mut header = HEADER;
    header[7] = "CPU time [s]";
    let lines = runs.iter().map(|run| {
        run.cells(
            best,
            &|value: f64| value.to_string(),
            run.seconds.to_string(),
        )
    });
    let mut files = vec![(format!("chart-{name}-solver.csv"), csv_text(&header, lines))];
    let mut blocks = Vec::new();
    if let Some(searches) = searches {
        blocks.push(Block::Text(searches.reading.clone()));
        blocks.push(Block::Figure(searches.figure.clone()));
        blocks.push(searches.table());
    }
    blocks.extend(figures.iter().map(|(_, svg)| Block::figure(svg.clone())));
    blocks.push(Block::table(HEADER, rows));
    blocks.push(Block::Text(ABOUT.to_owned()));
    let section = Section {
        heading: format!("{name}, optimal control"),
        blocks,
        files: vec![(files[0].0.clone(), "all runs".to_owned())],
    };
    if let Some(searches) = searches {
        let name = format!("chart-{name}-searches.svg");
        files.push((name, searches.figure.svg().to_owned()));
    }
    files.extend(
        figures
            .into_iter()
            .map(|(kind, svg)| (format!("chart-{name}-{kind}.svg"), svg)),
    );
    Chart {
        text,
        section: Some(section),
        files,
        ..Chart::default()
    }
}

#[cfg(test)]
mod tests {
    use super::{ALL, Grid, Known, Plan, WAYS, chart};
    use crate::arguments::LimitArguments;
    use crate::bounds::Bounds;
    use crate::page::Block;
    use crate::settings::{ChosenScene, find};

    fn unbounded() -> Bounds {
        Bounds::watch("test", &LimitArguments::default())
    }

    /// The cheapest grids that solve.
    const COARSE: Plan = Plan {
        ways: &[WAYS[0], WAYS[1]],
        grids: &[Grid {
            time_freezing: false,
            stages: 4,
            tolerance: None,
            intervals: &[10, 12],
        }],
    };
    const UNKNOWN: Known = Known {
        any: None,
        on: Some((10, f64::INFINITY)),
    };

    #[test]
    fn chart_of_the_solver_has_a_row_for_every_run_and_measures_from_the_best() {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "wave").unwrap(), &[]).unwrap();
        let chart = chart(&chosen, &COARSE, UNKNOWN, &unbounded())
            .unwrap()
            .unwrap();
        let section = chart.section.unwrap();
        // What is seen first is how good the searches are over time; tables stand after that.
        assert!(matches!(
            section.blocks[..3],
            [Block::Text(_), Block::Figure(_), Block::Table(_)]
        ));
        let searches = &section.tables()[0].rows;
        assert_eq!(searches.len(), COARSE.ways.len());
        let rows = &section.tables()[1].rows;
        assert_eq!(rows.len(), 2);
        let above: Vec<f64> = rows.iter().map(|row| row[3].parse().unwrap()).collect();
        // The best run lies above itself by nothing, and above what is known by what is missing.
        assert!(above.contains(&0.0) && above.iter().all(|&x| x >= 0.0));
        let best: f64 = rows
            .iter()
            .map(|row| row[2].parse::<f64>().unwrap())
            .fold(f64::INFINITY, f64::min);
        let from_known = super::chart(
            &chosen,
            &COARSE,
            Known {
                any: Some(best - 1.0),
                ..UNKNOWN
            },
            &unbounded(),
        )
        .unwrap()
        .unwrap();
        let from_known = from_known.section.unwrap();
        let far = &from_known.tables()[1].rows;
        assert!(far.iter().any(|row| row[3] == "1.0e0"), "{far:?}");
        assert!(rows.iter().all(|row| row[8] == "solved"));
        let names: Vec<&str> = chart.files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            [
                "chart-wave-solver.csv",
                "chart-wave-searches.svg",
                "chart-wave-objective.svg",
                "chart-wave-intervals.svg",
                "chart-wave-resimulation.svg"
            ]
        );
    }

    #[test]
    fn chart_of_the_solver_without_an_objective_is_none() {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        assert!(
            chart(&chosen, &ALL, Known::default(), &unbounded())
                .unwrap()
                .is_none()
        );
    }
}
