//! Runs the cases of this folder: scenes, and what is expected of them. README.md beside it tells how they are written.
//!
//! `cargo test --test cases` runs all, `cargo test --test cases friction` those with that word in their names.

mod block;
mod check;
mod document;
#[allow(dead_code, reason = "the bench draws more")]
#[path = "../../../benches/agreement/draw.rs"]
mod draw;
mod found;
mod method;
mod mutation;
mod prepared;
mod run;
mod setting;
mod statement;
mod words;

use block::{Block, blocks};
use draw::Draw;
use libtest_mimic::{Arguments, Trial};
use mutation::changed;
use setting::number;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match trials() {
        Ok(trials) => libtest_mimic::run(&Arguments::from_args(), trials).exit_code(),
        Err(mistakes) => {
            eprintln!("{mistakes}");
            ExitCode::FAILURE
        }
    }
}

/// All sections of all files; those with a run for long tests are ignored.
fn trials() -> Result<Vec<Trial>, String> {
    let entries = fs::read_dir(env!("CARGO_MANIFEST_DIR")).map_err(|error| error.to_string())?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_file = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    let mut files: Vec<PathBuf> = paths.filter(is_file).collect();
    files.sort();
    let (mut trials, mut mistakes) = (Vec::new(), Vec::new());
    let mut names = BTreeSet::new();
    for file in &files {
        for section in document::read(file).unwrap_or_else(|mistake| {
            mistakes.push(mistake);
            Vec::new()
        }) {
            let blocks = match blocks(&section) {
                Ok(blocks) => blocks,
                Err(mistake) => {
                    mistakes.push(mistake);
                    continue;
                }
            };
            let is_long = |block: &Block| number(&block.settings, "long").is_some();
            let is_long = blocks.iter().any(is_long);
            let name = named(&section.file, &section.heading, &mut names);
            let trial = Trial::test(name, move || ran(&blocks).map_err(Into::into));
            trials.push(trial.with_ignored_flag(is_long));
        }
    }
    match mistakes.is_empty() {
        true => Ok(trials),
        false => Err(mistakes.join("\n")),
    }
}

/// A name of letters, digits and lines: that of the file and of the heading, with a number where it is there before.
fn named(file: &str, heading: &str, known: &mut BTreeSet<String>) -> String {
    let letters = |text: &str| {
        let text = text.to_lowercase();
        let words = text.split(|c: char| !c.is_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        words.join("_")
    };
    let stem = file.strip_suffix(".md").unwrap_or(file);
    let name = format!("{}::{}", letters(stem), letters(heading));
    let mut free = name.clone();
    for number in 2.. {
        if known.insert(free.clone()) {
            break;
        }
        free = format!("{name}_{number}");
    }
    free
}

/// Runs all that is said of a scene.
///
/// # Errors
/// All expectations that do not hold: where they stand, what was expected, and what came; and all that hold as well when they are changed.
fn ran(blocks: &[Block]) -> Result<(), String> {
    let mut failures = Vec::new();
    for block in blocks {
        let results = run::results(block);
        let results =
            results.map_err(|why| format!("{}: with{}: {why}", block.file, block.shown))?;
        for expectation in &block.expectations {
            let line = &expectation.line;
            let place = format!("tests/cases/{}:{}: {}", block.file, line.number, line.text);
            let looks = check::check(block, &results, expectation);
            let before = failures.len();
            for (by, unmet) in &looks {
                if let Err(why) = unmet {
                    let with = &block.shown;
                    failures.push(format!("{place} with{with}\n    by {by}: {why}"));
                }
            }
            let changed = changed(expectation, &mut Draw::new("changes", line.number as u64));
            let looks = check::check(block, &results, &changed);
            if failures.len() == before && looks.iter().any(|look| look.1.is_ok()) {
                let (claim, moved) = (&changed.claim, changed.moved);
                failures.push(format!("{place}\n    holds as {claim:?}, moved by {moved}"));
            }
        }
    }
    match failures.is_empty() {
        true => Ok(()),
        false => Err(failures.join("\n")),
    }
}
