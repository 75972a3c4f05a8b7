//! How good the optima of all scenes are, and what they cost.
//!
//! `cargo bench --bench zoo` prints a table: for each scene and number of intervals the objective, how far it is from the
//! best known value, status, stationarity, CPU time, and of the time-freezing formulation the largest product of its program, with
//! iterations and CPU time; and for each way to solve them how many scenes come within 1 %,
//! 0.1 % and 1e-5 of the best, with the median and largest CPU time. It draws these shares against CPU time to
//! `target/zoo/share_*.svg`. `-- --ways default,one` chooses ways (`default`, `one` start, `many` starts,
//! `time-freezing`; `default!flip!touch` without these rules of the search), `--starts 4` the number of starts of all ways,
//! `--intervals 10,40` grids, `--only three-carts,hop` scenes, `--files FOLDER` the scenes of a folder instead, whose best value is the best of
//! all ways of this run, `--seconds 60` when a solve is stopped.
//! `--ablate` solves by default and without each rule of the search, one at a time, and prints what each of them earns.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hangtime::model::Model;
use hangtime::ocp::{self, Formulation, Problem, RULES, Settings, Solution, Status};
use hangtime_zoo::{Half, best, exhibits};
use kuva::prelude::{Layout, LinePlot, Plot, render_to_svg};

/// Relative distances from the best known value, and their names.
const WITHIN: [(f64, &str); 3] = [(1e-2, "1 %"), (1e-3, "0.1 %"), (1e-5, "1e-5")];
/// Relative difference of an objective that a rule makes.
const SAME: f64 = 1e-5;
/// Starts of the way `many`.
const MANY: usize = 32;
/// Colours of the curves.
const COLOURS: [&str; 4] = ["#0072b2", "#e69f00", "#009e73", "#cc79a7"];

type Failure = Box<dyn std::error::Error>;

/// A scene that is solved.
struct Scene {
    name: String,
    half: Half,
    model: Box<dyn Model>,
}

/// A solve.
struct Run {
    scene: String,
    intervals: usize,
    way: String,
    half: Half,
    /// Infinite without a motion.
    objective: f64,
    gap: f64,
    iterations: usize,
    seconds: f64,
    status: Status,
}

fn option(name: &str, default: &str) -> String {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1).unwrap_or_else(|| default.to_owned())
}

/// The settings of a way: its name, and behind it the rules that are left out.
fn settings(way: &str) -> Result<Settings, String> {
    let mut settings = Settings::default();
    let mut parts = way.split('!');
    match parts.next().unwrap_or_default() {
        "default" => {}
        "one" => settings.starts = Some(1),
        "many" => settings.starts = Some(MANY),
        "time-freezing" => settings.formulation = Formulation::TimeFreezing(Default::default()),
        other => {
            return Err(format!(
                "`{other}` is no way to solve; default, one, many, time-freezing are"
            ));
        }
    }
    settings.without.extend(parts.map(str::to_owned));
    Ok(settings)
}

/// The scenes of the zoo, or those of a folder, in the order of their names.
fn scenes() -> Result<Vec<Scene>, Failure> {
    let folder = option("--files", "");
    if folder.is_empty() {
        let scene = |exhibit: &hangtime_zoo::Exhibit| Scene {
            name: exhibit.name.to_owned(),
            half: exhibit.half,
            model: exhibit.model(),
        };
        return Ok(exhibits().iter().map(scene).collect());
    }
    let files = fs::read_dir(&folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut files: Vec<PathBuf> = files.collect::<Result<_, _>>()?;
    files.retain(|file| file.extension().is_some_and(|end| end == "hang"));
    files.sort();
    files.iter().enumerate().map(of_file).collect()
}

/// The scene of a file; every second one counts as developed.
fn of_file((index, file): (usize, &PathBuf)) -> Result<Scene, Failure> {
    let name = Path::file_stem(file).unwrap_or_default();
    let half = if index % 2 == 0 {
        Half::Developed
    } else {
        Half::Reported
    };
    Ok(Scene {
        name: name.to_string_lossy().into_owned(),
        half,
        model: Box::new(hangtime_scene_files::read(file)?),
    })
}

fn solve(model: &dyn Model, intervals: usize, way: &str, most: f64) -> Result<Solution, Failure> {
    let problem = Problem::of(model, intervals);
    let mut settings = settings(way)?;
    let starts = option("--starts", "");
    if !starts.is_empty() {
        settings.starts = Some(starts.parse()?);
    }
    let clock = Instant::now();
    let mut goes_on = |_: &hangtime::Progress| clock.elapsed().as_secs_f64() < most;
    Ok(ocp::solve(model, &problem, &settings, &mut goes_on)?)
}

fn main() -> Result<(), Failure> {
    let ablates = std::env::args().any(|argument| argument == "--ablate");
    let ways: Vec<String> = if ablates {
        let without = RULES.iter().map(|rule| format!("default!{}", rule.name));
        std::iter::once("default".to_owned())
            .chain(without)
            .collect()
    } else {
        let ways = option("--ways", "default,one");
        ways.split(',').map(str::to_owned).collect()
    };
    let grids = option("--intervals", "10,20,40");
    let grids: Vec<usize> = grids.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let only = option("--only", "");
    let most: f64 = option("--seconds", "300").parse()?;
    println!(
        "| scene | N | way | objective | gap | status | stationarity | programs | iterations | first motion [s] | CPU [s] | time-freezing |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut runs: Vec<Run> = Vec::new();
    for scene in scenes()? {
        if !only.is_empty() && !only.split(',').any(|name| name == scene.name) {
            continue;
        }
        for &intervals in &grids {
            let first = runs.len();
            let mut solutions = Vec::new();
            for way in &ways {
                let solution = solve(&*scene.model, intervals, way, most)?;
                runs.push(run(&scene, (intervals, way), &solution));
                solutions.push(solution);
            }
            measure(&mut runs[first..], intervals);
            for (run, solution) in runs[first..].iter().zip(&solutions) {
                print(run, solution);
            }
        }
    }
    summary(&runs, &ways);
    if ablates {
        earned(&runs);
    }
    draw(&runs, &ways)
}

fn run(scene: &Scene, (intervals, way): (usize, &str), solution: &Solution) -> Run {
    let moves = matches!(solution.status, Status::Solved | Status::Uncertified);
    Run {
        scene: scene.name.clone(),
        intervals,
        way: way.to_owned(),
        half: scene.half,
        objective: if moves {
            solution.objective
        } else {
            f64::INFINITY
        },
        gap: f64::INFINITY,
        iterations: solution.counts.iterations + solution.counts.global_iterations,
        seconds: solution.seconds.total,
        status: solution.status,
    }
}

/// Sets how far runs of a scene are from the best value that is known, or the best of them without one.
fn measure(runs: &mut [Run], intervals: usize) {
    let Some(name) = runs.first().map(|run| run.scene.clone()) else {
        return;
    };
    let least = runs
        .iter()
        .map(|run| run.objective)
        .fold(f64::INFINITY, f64::min);
    let best = best(&name, intervals).unwrap_or(least);
    for run in runs {
        run.gap = if best.is_infinite() {
            f64::NAN
        } else {
            (run.objective - best) / best.abs().max(f64::MIN_POSITIVE)
        };
    }
}

fn print(run: &Run, solution: &Solution) {
    println!(
        "| {} | {} | {} | {:.9} | {:.1e} | {} | {} | {} | {} | {:.2} | {:.2} | {} |",
        run.scene,
        run.intervals,
        run.way,
        solution.objective,
        run.gap,
        solution.status.name(),
        solution.stationarity.name(),
        solution.counts.programs,
        run.iterations,
        first(solution),
        run.seconds,
        program(solution),
    );
}

/// CPU time until the first motion that its re-simulation confirms; not a number without one.
fn first(solution: &Solution) -> f64 {
    let first = solution.improvements.first();
    first.map_or(f64::NAN, |first| first.cpu)
}

/// What each rule of the search earns: on how many runs the default ends at a better motion, or a worse one, than without it, and the
/// work of the default as a share of that without it.
fn earned(runs: &[Run]) {
    println!(
        "\n| rule | better with it (developed, reported) | worse with it | iterations | CPU | scenes |\n|---|---|---|---|---|---|"
    );
    for rule in &RULES {
        let way = format!("default!{}", rule.name);
        let own = runs.iter().filter(|run| run.way == way);
        let (mut better, mut worse, mut names) = ([0, 0], 0, Vec::new());
        let (mut iterations, mut seconds) = ([0, 0], [0.0, 0.0]);
        for without in own {
            let same = |run: &&Run| {
                run.way == "default"
                    && (&run.scene, run.intervals) == (&without.scene, without.intervals)
            };
            let Some(with) = runs.iter().find(same) else {
                continue;
            };
            iterations[0] += with.iterations;
            iterations[1] += without.iterations;
            seconds[0] += with.seconds;
            seconds[1] += without.seconds;
            let same = SAME * with.objective.abs().min(without.objective.abs());
            if with.objective < without.objective - same {
                better[usize::from(with.half == Half::Reported)] += 1;
                names.push(format!("{} {}", without.scene, without.intervals));
            } else if with.objective > without.objective + same {
                worse += 1;
                names.push(format!("-{} {}", without.scene, without.intervals));
            }
        }
        println!(
            "| {} | {}, {} | {worse} | {:.3} | {:.3} | {} |",
            rule.name,
            better[0],
            better[1],
            iterations[0] as f64 / iterations[1].max(1) as f64,
            seconds[0] / seconds[1].max(f64::MIN_POSITIVE),
            names.join(", "),
        );
    }
}

/// Largest product of a pair of the time-freezing program, its iterations and CPU time.
fn program(solution: &Solution) -> String {
    let report = solution.time_freezing.as_ref();
    report.map_or(String::new(), |report| {
        let (product, iterations) = (report.residuals.complementarity, report.iterations);
        format!("{product:.1e} in {iterations}, {:.2} s", report.seconds)
    })
}

fn summary(runs: &[Run], ways: &[String]) {
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
fn draw(runs: &[Run], ways: &[String]) -> Result<(), Failure> {
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
                    .with_legend(way.as_str());
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
