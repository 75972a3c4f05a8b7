//! How good the optima of many control scenes are, and what they cost, for some ways to solve them.

use std::time::Instant;

use hangtime::ocp::{self, Problem};
use hangtime_scene_files::of_text;

use super::drawn::Chart;
use super::searches::WAYS;
use super::side_by_side::side_by_side;
use crate::ControlScene;
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::figure::{Curve, Dot, LogLog};
use crate::page::{Block, Figure, Section};
use crate::spreadsheet::csv_text;
use crate::table::{seconds, table};

/// Control intervals.
const GRIDS: [usize; 2] = [10, 20];
/// Relative distances from the best known objective that are counted.
const WITHIN: [f64; 3] = [1e-2, 1e-3, 1e-5];
/// The distance that is drawn, and in words.
const DRAWN: (f64, &str) = (1e-3, "0.1 %");
/// Time after which a solve is stopped [s].
const PATIENCE: f64 = 15.0;

/// One solve.
struct Run {
    scene: &'static str,
    way: usize,
    intervals: usize,
    /// Relative excess over the best known objective; infinite without a motion.
    gap: f64,
    objective: f64,
    distance: f64,
    certificate: &'static str,
    seconds: f64,
    /// CPU time after which its best motion so far is near the best one known; infinite if none ever is.
    near: f64,
    status: &'static str,
}

/// Solves all `scenes` in every way, on every grid for which an objective is known.
pub(super) fn chart(scenes: &[ControlScene], bounds: &Bounds) -> Result<Chart, BadInput> {
    let known = |scene: &ControlScene, intervals| (scene.best)(scene.name, intervals);
    let asked: Vec<(&ControlScene, usize, (usize, f64))> = scenes
        .iter()
        .flat_map(|scene| {
            let grids = GRIDS
                .into_iter()
                .filter_map(|n| known(scene, n).map(|best| (n, best)));
            let ways = grids.flat_map(|grid| (0..WAYS.len()).map(move |way| (way, grid)));
            ways.map(move |(way, grid)| (scene, way, grid))
                .collect::<Vec<_>>()
        })
        .collect();
    let says = |&(scene, way, (intervals, _)): &(&ControlScene, usize, (usize, f64))| {
        format!(
            "{}: {}, {intervals} intervals",
            scene.name,
            WAYS[way].name()
        )
    };
    let runs = side_by_side(
        "control scenes",
        &asked,
        bounds,
        says,
        |&(scene, way, grid)| solve(scene, way, grid, bounds),
    )?;
    Ok(report(&runs))
}

fn solve(
    scene: &ControlScene,
    way: usize,
    (intervals, best): (usize, f64),
    bounds: &Bounds,
) -> Result<Run, BadInput> {
    let model = of_text(scene.name, scene.text);
    let model = model.map_err(|mistakes| BadInput::new(mistakes.to_string()))?;
    let clock = Instant::now();
    let solution = ocp::solve(
        &model,
        &Problem::of(&model, intervals),
        &WAYS[way].settings(),
        &mut |_| bounds.asked().is_none() && clock.elapsed().as_secs_f64() < PATIENCE,
    );
    let mut run = Run {
        scene: scene.name,
        way,
        intervals,
        gap: f64::INFINITY,
        objective: f64::NAN,
        distance: f64::NAN,
        certificate: "none",
        seconds: f64::NAN,
        near: f64::INFINITY,
        status: "not_applicable",
    };
    match solution {
        Ok(solution) => {
            run.objective = solution.objective;
            if solution.objective.is_finite() {
                run.gap = excess(solution.objective, best);
            }
            run.distance = solution.resimulation_error;
            run.certificate = solution.stationarity.name();
            run.seconds = solution.seconds.total;
            let near = |objective: f64| excess(objective, best) <= DRAWN.0;
            let mut improvements = solution.improvements.iter();
            let first = improvements.find(|found| near(found.objective));
            run.near = first.map_or(f64::INFINITY, |found| found.cpu);
            run.status = solution.status.name();
        }
        Err(error) if error.is_unsupported() => {}
        Err(error) => return Err(BadInput::new(format!("{}: {error}", scene.name))),
    }
    Ok(run)
}

/// How far an objective is above the best one, as a share of it.
fn excess(objective: f64, best: f64) -> f64 {
    (objective - best) / best.abs().max(f64::MIN_POSITIVE)
}

const HEADER: [&str; 10] = [
    "scene",
    "solved by",
    "intervals",
    "objective",
    "above the best",
    "re-simulation",
    "certificate",
    "near after [s]",
    "CPU time [s]",
    "status",
];

impl Run {
    fn cells(&self) -> Vec<String> {
        let known = |value: f64, text: String| {
            if value.is_finite() {
                text
            } else {
                "-".to_owned()
            }
        };
        vec![
            self.scene.to_owned(),
            WAYS[self.way].name(),
            self.intervals.to_string(),
            known(self.objective, format!("{:.9}", self.objective)),
            known(self.gap, format!("{:.1e}", self.gap)),
            known(self.distance, format!("{:.1e}", self.distance)),
            self.certificate.to_owned(),
            known(self.near, format!("{:.3}", self.near)),
            known(self.seconds, format!("{:.3}", self.seconds)),
            self.status.to_owned(),
        ]
    }
}

/// The runs of a way.
fn of_way(runs: &[Run], way: usize) -> Vec<&Run> {
    runs.iter().filter(|run| run.way == way).collect()
}

fn sums_header() -> Vec<String> {
    let mut header: Vec<String> = ["solved by", "runs"].map(str::to_owned).into();
    header.extend(WITHIN.map(|gap| format!("within {gap:.0e}")));
    header.extend(["certified", "no motion", "CPU, median", "CPU, most"].map(str::to_owned));
    header
}

/// A line for each way: how many of its runs come near the best objective.
fn sums(runs: &[Run]) -> Vec<Vec<String>> {
    let ways = WAYS.iter().enumerate();
    let lines = ways.map(|(way, kind)| {
        let own = of_way(runs, way);
        let count = |is: &dyn Fn(&Run) -> bool| own.iter().filter(|run| is(run)).count();
        let mut times: Vec<f64> = own.iter().map(|run| run.seconds).collect();
        times.retain(|seconds| seconds.is_finite());
        times.sort_by(f64::total_cmp);
        let time = |index: usize| {
            let time = times.get(index);
            time.map_or_else(|| "-".to_owned(), |&time| seconds(time))
        };
        let mut line = vec![kind.name(), own.len().to_string()];
        line.extend(WITHIN.map(|gap| count(&|run| run.gap <= gap).to_string()));
        line.push(count(&|run| run.status == "solved").to_string());
        line.push(count(&|run| run.gap == f64::INFINITY).to_string());
        line.push(time(times.len() / 2));
        line.push(time(times.len().saturating_sub(1)));
        line
    });
    lines.collect()
}

/// For each way the share of runs whose best motion so far is not yet near the best one known, over CPU time.
fn figure(runs: &[Run]) -> Figure {
    let curves = WAYS.iter().enumerate().map(|(way, kind)| {
        let own = of_way(runs, way);
        let mut near: Vec<&&Run> = own.iter().filter(|run| run.near.is_finite()).collect();
        near.sort_by(|a, b| a.near.total_cmp(&b.near));
        let dots = near.iter().enumerate().map(|(index, run)| Dot {
            x: run.near,
            y: 100.0 * (own.len() - index - 1) as f64 / own.len() as f64,
            half: None,
            note: format!(
                "{}, {} intervals, {}: {}",
                run.scene,
                run.intervals,
                kind.name(),
                seconds(run.near)
            ),
        });
        Curve {
            name: kind.name(),
            look: kind.look(),
            steps: true,
            points: dots.collect(),
        }
    });
    Figure::chart(&LogLog {
        title: &format!("Control scenes not yet within {} of the best", DRAWN.1),
        x: "CPU time [s]",
        y: "share of the runs [%]",
        falling: false,
        floor: None,
        curves: curves.collect(),
    })
}

/// What to read off it: how many runs of each way come near, and how soon half of all do.
fn reading(runs: &[Run]) -> String {
    let ways = WAYS.iter().enumerate().map(|(way, kind)| {
        let own = of_way(runs, way);
        let mut near: Vec<f64> = own.iter().map(|run| run.near).collect();
        near.sort_by(f64::total_cmp);
        let count = near.iter().filter(|seconds| seconds.is_finite()).count();
        let half = near
            .get(near.len() / 2)
            .filter(|seconds| seconds.is_finite());
        let half = half.map_or_else(
            || "less than half of them".to_owned(),
            |half| format!("half of them after {}", seconds(*half)),
        );
        format!("{} {count} of {} ({half})", kind.name(), own.len())
    });
    let ways: Vec<String> = ways.collect();
    format!(
        "Within {} of the best objective known come: {}.",
        DRAWN.1,
        ways.join("; ")
    )
}

fn report(runs: &[Run]) -> Chart {
    let (data, drawing) = ("chart-control.csv", "chart-control.svg");
    let cells: Vec<Vec<String>> = runs.iter().map(Run::cells).collect();
    let text = format!(
        "control scenes: distance from the best objective known\n\n{}\n",
        table(sums_header(), sums(runs))
    );
    let figure = figure(runs);
    let files = vec![
        (data.to_owned(), csv_text(&HEADER, cells.clone())),
        (drawing.to_owned(), figure.svg().to_owned()),
    ];
    let section = Section {
        heading: "Control scenes".to_owned(),
        blocks: vec![
            Block::Text(reading(runs)),
            Block::Figure(figure),
            Block::table(sums_header(), sums(runs)),
            Block::folded("Every run", Block::table(HEADER, cells)),
            Block::Text(format!(
                "Scenes that the search was not made for, each from nothing, on {} and {} control intervals. Counted is how many \
                 come within a share of the best objective that is known on that grid; a solve is stopped after {PATIENCE} s. \
                 An independent event-driven simulation under the controls measures how far the plan is from the motion.",
                GRIDS[0], GRIDS[1]
            )),
        ],
        files: vec![(data.to_owned(), "all runs".to_owned())],
    };
    Chart {
        text,
        section: Some(section),
        files,
        ..Chart::default()
    }
}

#[cfg(test)]
mod tests {
    use super::{GRIDS, WAYS, chart};
    use crate::ControlScene;
    use crate::arguments::LimitArguments;
    use crate::bounds::Bounds;

    /// A scene that can be solved, with an objective that no motion has.
    fn scene() -> ControlScene {
        ControlScene {
            name: "wave",
            text: "parameters { a = 0.2, k = 2 }
                coordinates { y, s }
                controls { u in -20..=20 }
                let mass = (y, a*(1 - cos(k*y)) + s)
                lagrangian |dot(mass)|^2 - 19.62*mass.z
                forces { y: u }
                surface ground: s >= 0
                impact ground: inelastic
                minimize time
                finally { y == 1 }
                start { dot(y): 1 }
                horizon 1",
            best: |name, intervals| (name == "wave" && intervals == GRIDS[0]).then_some(1e-3),
        }
    }

    #[test]
    fn control_scenes_are_counted_by_their_distance_from_what_is_known() {
        let bounds = Bounds::watch("test", &LimitArguments::default());
        let chart = chart(&[scene()], &bounds).unwrap();
        let section = chart.section.unwrap();
        let tables = section.tables();
        assert_eq!(tables[0].rows.len(), WAYS.len());
        // One run each, none of which is near an objective that is far too small.
        for row in &tables[0].rows {
            assert_eq!(row[1..5], ["1", "0", "0", "0"], "{row:?}");
        }
        let runs = &tables[1].rows;
        assert_eq!(runs.len(), WAYS.len());
        let [objective, gap] = [3, 4].map(|column: usize| runs[0][column].parse::<f64>().unwrap());
        // Two digits are written.
        assert!((gap / ((objective - 1e-3) / 1e-3) - 1.0).abs() < 0.05);
        assert_eq!(runs[0][9], "solved");
    }
}
