//! Runs the cases of this folder: scenes, and what is expected of them. README.md beside it tells how they are written.
//!
//! `cargo test --test cases` runs all, `cargo test --test cases friction` those with that word in their names.

mod block;
mod check;
mod document;
mod found;
mod method;
mod mutation;
mod prepared;
mod run;
mod setting;
mod statement;
mod suite;
mod words;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;
use std::sync::Arc;
use suite::Suite;

/// How many expectations are changed to see that they fail then.
const MUTATIONS: usize = 200;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let suite = match Suite::read(MUTATIONS) {
        Ok(suite) => Arc::new(suite),
        Err(mistakes) => {
            eprintln!("{mistakes}");
            return ExitCode::FAILURE;
        }
    };
    let trial = |place: usize| {
        let of = Arc::clone(&suite);
        let trial = Trial::test(suite.sections[place].name.clone(), move || {
            of.section(place).map_err(Into::into)
        });
        trial.with_ignored_flag(suite.sections[place].long)
    };
    let mut trials: Vec<Trial> = (0..suite.sections.len()).map(trial).collect();
    let of = Arc::clone(&suite);
    trials.push(Trial::test("mutations", move || {
        of.mutations().map_err(Into::into)
    }));
    let conclusion = libtest_mimic::run(&arguments, trials);
    match suite.write_snapshots() {
        Ok(()) => conclusion.exit_code(),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
