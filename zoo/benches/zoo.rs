//! How good the optima of all scenes are, and what they cost.
//!
//! `cargo bench --bench zoo` prints a table: for each scene and number of intervals the objective, how far it is from the
//! best known value, status, stationarity, CPU time, and of the time-freezing formulation the largest product of its program, with
//! iterations and CPU time; and for each way to solve them how many scenes come within 1 %,
//! 0.1 % and 1e-5 of the best, with the median and largest CPU time. It draws these shares against CPU time to
//! `target/zoo/share_*.svg`. `-- --ways default,one` chooses ways (`default`, `one` start, `many` starts,
//! `time-freezing`), `--starts 4` the number of starts of all ways, `--intervals 10,40` grids, `--only three-carts,hop` scenes,
//! `--seconds 60` when a solve is stopped.

use std::fs;
use std::time::Instant;

use hangtime::ocp::{self, Formulation, Problem, SearchSpace, Settings, Solution, Status};
use hangtime_zoo::{Exhibit, Half, exhibits};
use kuva::prelude::{Layout, LinePlot, Plot, render_to_svg};

/// Relative distances from the best known value, and their names.
const WITHIN: [(f64, &str); 3] = [(1e-2, "1 %"), (1e-3, "0.1 %"), (1e-5, "1e-5")];
/// Starts of the way `many`.
const MANY: usize = 32;
/// Colours of the curves.
const COLOURS: [&str; 4] = ["#0072b2", "#e69f00", "#009e73", "#cc79a7"];

/// A solve.
struct Run {
    way: String,
    half: Half,
    gap: f64,
    seconds: f64,
    status: Status,
}

fn option(name: &str, default: &str) -> String {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1).unwrap_or_else(|| default.to_owned())
}

fn settings(way: &str) -> Result<Settings, String> {
    let mut settings = Settings::default();
    match way {
        "default" => {}
        "words" => settings.search = SearchSpace::Words,
        "one" => settings.starts = Some(1),
        "many" => settings.starts = Some(MANY),
        "time-freezing" => settings.formulation = Formulation::TimeFreezing(Default::default()),
        other => {
            return Err(format!(
                "`{other}` is no way to solve; default, words, one, many, time-freezing are"
            ));
        }
    }
    Ok(settings)
}

fn solve(
    exhibit: &Exhibit,
    intervals: usize,
    way: &str,
    most: f64,
) -> Result<Solution, Box<dyn std::error::Error>> {
    let model = (exhibit.model)();
    let problem = Problem::of(&*model, intervals);
    let mut settings = settings(way)?;
    let starts = option("--starts", "");
    if !starts.is_empty() {
        settings.starts = Some(starts.parse()?);
    }
    let clock = Instant::now();
    let mut goes_on = |_: &hangtime::Progress| clock.elapsed().as_secs_f64() < most;
    Ok(ocp::solve(&*model, &problem, &settings, &mut goes_on)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ways = option("--ways", "default,one");
    let ways: Vec<&str> = ways.split(',').collect();
    let grids = option("--intervals", "10,20,40");
    let grids: Vec<usize> = grids.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let only = option("--only", "");
    let most: f64 = option("--seconds", "300").parse()?;
    println!(
        "| scene | N | way | objective | gap | status | stationarity | iterations | CPU [s] | program |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut runs: Vec<Run> = Vec::new();
    for exhibit in exhibits() {
        if !only.is_empty() && !only.split(',').any(|name| name == exhibit.name) {
            continue;
        }
        for &intervals in &grids {
            for &way in &ways {
                let solution = solve(exhibit, intervals, way, most)?;
                let gap = exhibit.gap(intervals, solution.objective);
                println!(
                    "| {} | {intervals} | {way} | {:.9} | {} | {} | {} | {} | {:.2} | {} |",
                    exhibit.name,
                    solution.objective,
                    gap.map_or("unknown".to_owned(), |gap| format!("{gap:.1e}")),
                    solution.status.name(),
                    solution.stationarity.name(),
                    solution.counts.iterations + solution.counts.global_iterations,
                    solution.seconds.total,
                    program(&solution),
                );
                runs.push(Run {
                    way: way.to_owned(),
                    half: exhibit.half,
                    gap: gap.unwrap_or(f64::NAN),
                    seconds: solution.seconds.total,
                    status: solution.status,
                });
            }
        }
    }
    summary(&runs, &ways);
    draw(&runs, &ways)
}

/// Largest product of a pair of the time-freezing program, its iterations and CPU time.
fn program(solution: &Solution) -> String {
    let report = solution.time_freezing.as_ref();
    report.map_or(String::new(), |report| {
        let (product, iterations) = (report.residuals.complementarity, report.iterations);
        format!("{product:.1e} in {iterations}, {:.2} s", report.seconds)
    })
}

fn summary(runs: &[Run], ways: &[&str]) {
    println!(
        "\n| way | scenes | runs | within 1 % | 0.1 % | 1e-5 | uncertified | no motion | CPU, median [s] | most |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    for way in ways {
        for (half, name) in [(Half::Developed, "developed"), (Half::Reported, "reported")] {
            let own: Vec<&Run> = runs
                .iter()
                .filter(|run| run.way == *way && run.half == half)
                .collect();
            let mut seconds: Vec<f64> = own.iter().map(|run| run.seconds).collect();
            seconds.sort_by(f64::total_cmp);
            let Some(most) = seconds.last() else { continue };
            let share = |count: usize| format!("{:.0} %", 100.0 * count as f64 / own.len() as f64);
            let within =
                WITHIN.map(|(gap, _)| share(own.iter().filter(|run| run.gap <= gap).count()));
            let count =
                |is: fn(Status) -> bool| share(own.iter().filter(|run| is(run.status)).count());
            let uncertified = count(|status| status == Status::Uncertified);
            let none = count(|status| !matches!(status, Status::Solved | Status::Uncertified));
            println!(
                "| {way} | {name} | {} | {} | {uncertified} | {none} | {:.2} | {most:.2} |",
                own.len(),
                within.join(" | "),
                seconds[seconds.len() / 2],
            );
        }
    }
}

/// Draws, for each distance, the share of runs that come within it in a CPU time.
fn draw(runs: &[Run], ways: &[&str]) -> Result<(), Box<dyn std::error::Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/zoo");
    fs::create_dir_all(folder)?;
    for (gap, name) in WITHIN {
        let plots: Vec<Plot> = ways
            .iter()
            .zip(COLOURS)
            .filter_map(|(way, colour)| {
                let points = shares(runs, way, gap)?;
                let line = LinePlot::new()
                    .with_data(points)
                    .with_color(colour)
                    .with_legend(*way);
                Some(line.into())
            })
            .collect();
        if plots.is_empty() {
            continue;
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_title(format!("Within {name} of the best known objective"))
            .with_x_label("CPU time [s]")
            .with_y_label("share of scenes")
            .with_log_x();
        let file = format!("{folder}/share_{gap:e}.svg");
        fs::write(&file, render_to_svg(plots, layout))?;
        println!("target/zoo/share_{gap:e}.svg");
    }
    Ok(())
}

/// Steps `(CPU time, share)` of a way; none without a run.
fn shares(runs: &[Run], way: &str, gap: f64) -> Option<Vec<(f64, f64)>> {
    let own: Vec<&Run> = runs.iter().filter(|run| run.way == way).collect();
    let near = own.iter().filter(|run| run.gap <= gap);
    let mut seconds: Vec<f64> = near.map(|run| run.seconds.max(1e-3)).collect();
    seconds.sort_by(f64::total_cmp);
    let mut points = vec![(1e-2, 0.0)];
    for (index, &time) in seconds.iter().enumerate() {
        let count = own.len() as f64;
        points.push((time, index as f64 / count));
        points.push((time, (index + 1) as f64 / count));
    }
    let longest = own.iter().map(|run| run.seconds).fold(0.0, f64::max);
    points.push((longest, points.last()?.1));
    (!own.is_empty()).then_some(points)
}
