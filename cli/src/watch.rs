//! `--watch`: the same command again whenever the scene file changes.

use std::convert::Infallible;
use std::ffi::OsString;
use std::fs;
use std::io::{self, IsTerminal as _, Write as _};
use std::process;
use std::thread;
use std::time::{Duration, SystemTime};

use crate::failure::BadInput;

/// The option, which the runs themselves do not get.
const OPTION: &str = "--watch";
/// How often the file is looked at.
const PERIOD: Duration = Duration::from_millis(200);

/// Runs the command of `arguments` as a program of its own, now and after each change of the file, until it is
/// interrupted: limits and memory are those of a single run.
pub(crate) fn run(file: &str, arguments: &[OsString]) -> Result<Infallible, BadInput> {
    let refuse = |error: io::Error| BadInput::new(format!("{OPTION}: {error}; run without it"));
    let program = std::env::current_exe().map_err(refuse)?;
    let arguments = arguments.iter().skip(1);
    let arguments: Vec<&OsString> = arguments.filter(|word| *word != OPTION).collect();
    loop {
        let seen = stamp(file);
        process::Command::new(&program)
            .args(&arguments)
            .status()
            .map_err(refuse)?;
        if io::stderr().is_terminal() {
            let _ = writeln!(io::stderr(), "watching {file}; Ctrl-C ends");
        }
        while stamp(file) == seen {
            thread::sleep(PERIOD);
        }
    }
}

/// When the file was changed last, and its length; nothing while an editor replaces it.
fn stamp(file: &str) -> Option<(SystemTime, u64)> {
    let found = fs::metadata(file).ok()?;
    Some((found.modified().ok()?, found.len()))
}
