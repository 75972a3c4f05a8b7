//! Whether the default simulation and the event-driven one agree, on random scenes.
//!
//! ```sh
//! cargo bench --bench agreement                            # 2,000 draws of each shipped scene, 20,000 random scenes
//! cargo bench --bench agreement -- --shipped 200 --random 2000
//! cargo bench --bench agreement -- --kind rods --seed 17   # one scene, in words
//! cargo bench --bench agreement -- --kind rods --from 2000 # other ones of a kind
//! ```
//!
//! It prints a table by kind of scene and ends with status 1 unless all that both call solved agree to `1e-5` of the
//! largest value, and at most 5 % end otherwise. Draws are deterministic: the seed of a scene is its number.
//! What is compared is said at [`judge::judge`].

mod draw;
mod judge;
mod scenes;
mod table;
mod texts;

use std::process::ExitCode;
use std::time::Instant;

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, InitialValueProblem, Simulator};
use judge::{Verdict, by_default, judge};
use scenes::Kind;
use table::Row;

/// Scenes that take longer are named on stderr \[s\].
const LONG: f64 = 5.0;

/// The value that follows an option.
fn option(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name);
    arguments.nth(1)
}

fn number(name: &str, default: u64) -> Result<u64, std::num::ParseIntError> {
    option(name).map_or(Ok(default), |text| text.parse())
}

/// One line on a verdict that is no agreement.
fn words(verdict: &Verdict) -> Option<String> {
    match verdict {
        Verdict::Agree { .. } => None,
        Verdict::Disagree(difference) => Some(difference.to_string()),
        Verdict::Ended { default, event } => Some(format!(
            "default {} {}; event-driven {} {}",
            default.status, default.message, event.status, event.message
        )),
    }
}

/// The parameters of a scene, to be given to another program.
fn parameters(model: &dyn Model) -> String {
    let declared = model.declaration().parameters.iter().enumerate();
    let words =
        declared.map(|(i, parameter)| format!("{}={:e}", parameter.name, model.parameter(i)));
    words.collect::<Vec<_>>().join(" ")
}

fn row(kind: &Kind, seeds: std::ops::Range<u64>) -> Row {
    let mut row = Row::default();
    for seed in seeds {
        let model = kind.scene(seed);
        let clock = Instant::now();
        let verdict = judge(&*model);
        let seconds = clock.elapsed().as_secs_f64();
        if let Some(words) = words(&verdict) {
            eprintln!("{} {seed}: {words}", kind.name);
        }
        if seconds > LONG {
            eprintln!("{} {seed}: took {seconds:.1} s", kind.name);
        }
        row.add(seed, &verdict);
    }
    row
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let (shipped, random) = (scenes::shipped(), scenes::random());
    let each = number("--random", 20_000)? / random.len() as u64;
    let counts = [(shipped, number("--shipped", 2_000)?), (random, each)];
    let only = option("--kind");
    if let (Some(only), Some(_)) = (&only, option("--seed")) {
        let seed = number("--seed", 0)?;
        for kind in counts.iter().flat_map(|(kinds, _)| kinds) {
            if kind.name == *only {
                let model = kind.scene(seed);
                print!("{}", texts::text(only, &mut draw::Draw::new(only, seed)));
                println!("{}", parameters(&*model));
                let problem = InitialValueProblem::of(&*model, None)?;
                let methods: [&dyn Simulator; 2] = [&by_default(), &EventDriven::default()];
                for method in methods {
                    let run = method.simulate(&*model, &problem, &mut |_| true)?;
                    let estimate = run.error_estimate;
                    println!("{}, error estimate {estimate:?}: {run}", method.name());
                }
                println!(
                    "{}",
                    words(&judge(&*model)).unwrap_or_else(|| "agree".into())
                );
            }
        }
        return Ok(ExitCode::SUCCESS);
    }
    println!("{}", Row::titles());
    let from = number("--from", 0)?;
    let mut holds = true;
    for (kind, count) in counts
        .iter()
        .flat_map(|(kinds, count)| kinds.iter().map(move |kind| (kind, *count)))
    {
        if count == 0 || only.as_ref().is_some_and(|only| *only != kind.name) {
            continue;
        }
        let row = row(kind, from..from + count);
        println!("{}", row.line(&kind.name));
        holds &= row.holds();
    }
    Ok(if holds {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
