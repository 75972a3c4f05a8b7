//! How often the pump track is solved, from many starts and at many speeds.
//!
//! `cargo bench -p hangtime-models --bench robustness` prints a table: for each speed the best final time, how many
//! of the starts end certified, how many within 1e-5 of the best, the CPU time, and the failures by name. With
//! `-- --speeds 10,15` only those speeds; `-- --perturbed 5` changes the number of perturbed starts.

use std::collections::BTreeMap;

use hangtime::ocp::{self, Guess, Problem, Settings, Solution};
use hangtime_models::PumpTrack;

/// Control intervals, as published.
const INTERVALS: usize = 30;
/// Relative difference of the final time that counts as the best.
const BEST: f64 = 1e-5;

fn guesses(perturbed: u64) -> Vec<(String, Guess)> {
    let named = [
        ("rest", Guess::Rest),
        ("straight", Guess::Straight),
        ("ride", Guess::Ride),
    ];
    let named = named.map(|(name, guess)| (name.to_owned(), guess));
    let random = (1..=perturbed).map(|seed| (format!("perturbed {seed}"), Guess::Perturbed(seed)));
    named.into_iter().chain(random).collect()
}

fn run(speed: f64, guess: Guess) -> Result<Solution, Box<dyn std::error::Error>> {
    let model = PumpTrack {
        speed,
        ..PumpTrack::default()
    };
    let mut settings = Settings::default();
    settings.guess = guess;
    let problem = Problem::of(&model, INTERVALS);
    Ok(ocp::solve(&model, &problem, &settings, &mut |_| true)?)
}

/// The value that follows an option.
fn option(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let speeds: Vec<f64> = option("--speeds")
        .unwrap_or_else(|| "8,10,12,14,16,18,20,22,24,26".to_owned())
        .split(',')
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let perturbed = option("--perturbed").map_or(Ok(20), |text| text.parse())?;
    println!(
        "| km/h | best t_f [s] | certified | within 1e-5 of the best | CPU seconds, median (most) | not certified |"
    );
    println!("|---|---|---|---|---|---|");
    let (mut runs, mut certified, mut best) = (0, 0, 0);
    for speed in speeds {
        let mut solutions = Vec::new();
        for (name, guess) in guesses(perturbed) {
            let solution = run(speed, guess)?;
            eprintln!(
                "{speed} {name}: {} {:.7} {}, {} programs, {} + {} iterations, {:.2} s",
                solution.status.name(),
                solution.horizon,
                solution.stationarity.name(),
                solution.counts.programs,
                solution.counts.global_iterations,
                solution.counts.iterations,
                solution.seconds.total
            );
            solutions.push((name, solution));
        }
        let solved = |s: &&(String, Solution)| s.1.status.is_solved();
        let least = solutions.iter().filter(solved).map(|s| s.1.horizon);
        let least = least.fold(f64::INFINITY, f64::min);
        let near = solutions.iter().filter(solved);
        let near = near.filter(|s| s.1.horizon <= least * (1.0 + BEST)).count();
        let confirmed = solutions.iter().filter(solved).count();
        let mut seconds: Vec<f64> = solutions.iter().map(|s| s.1.seconds.total).collect();
        seconds.sort_by(f64::total_cmp);
        let mut failures: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (name, solution) in solutions.iter().filter(|s| !s.1.status.is_solved()) {
            failures
                .entry(solution.status.name())
                .or_default()
                .push(name);
        }
        let failures: Vec<String> = failures
            .iter()
            .map(|(status, names)| format!("{status}: {}", names.join(", ")))
            .collect();
        println!(
            "| {speed} | {least:.7} | {confirmed}/{count} | {near}/{count} | {:.2} ({:.2}) | {} |",
            seconds[seconds.len() / 2],
            seconds[seconds.len() - 1],
            failures.join("; "),
            count = solutions.len(),
        );
        // Below 10 km/h the hill is barely passable; the totals are those of the speeds above.
        if speed >= 10.0 {
            runs += solutions.len();
            certified += confirmed;
            best += near;
        }
    }
    println!(
        "\n{certified} of {runs} certified, {best} of {runs} within 1e-5 of the best of their speed"
    );
    Ok(())
}
