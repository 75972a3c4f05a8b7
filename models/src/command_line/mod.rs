//! The command line: arguments in, one report and an exit status out.

mod animation;
mod arguments;
mod chart;
mod explain;
mod failure;
mod figure;
mod files;
mod interrupt;
mod json;
mod list;
mod method;
mod motion;
mod output;
mod page;
mod progress;
mod quantity;
mod reproduce;
mod sampling;
mod settings;
mod simulate;
mod solve;
mod spreadsheet;
mod table;
mod timing;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::Parser as _;

use arguments::{Arguments, Command};
use failure::BadInput;

/// Exit status of a result that did not converge.
const NOT_CONVERGED: u8 = 3;
/// Exit status of bad input.
const BAD_INPUT: u8 = 2;

/// What a command prints.
#[derive(Debug, Default)]
struct Report {
    /// For the standard output stream.
    text: String,
    /// Why the result did not converge, one line each, for the standard error stream.
    diagnoses: Vec<String>,
}

/// Runs one command.
pub(crate) fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let outcome = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => dispatch(arguments.command),
        Err(error) if !error.use_stderr() => {
            // Help and version; a reader that went away needs neither.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => Err(BadInput::from(error)),
    };
    match outcome {
        Ok(report) => report.print(),
        Err(refusal) => {
            complain(&refusal.to_string());
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn dispatch(command: Option<Command>) -> Result<Report, BadInput> {
    match command {
        Some(Command::List(arguments)) => Ok(list::run(&arguments)),
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Solve(arguments)) => solve::run(&arguments),
        Some(Command::Chart(arguments)) => chart::run(&arguments),
        Some(Command::Explain(arguments)) => explain::run(&arguments),
        Some(Command::Reproduce(arguments)) => reproduce::run(&arguments.out),
        None => reproduce::run("out".as_ref()),
    }
}

impl Report {
    fn print(&self) -> ExitCode {
        let mut stdout = io::stdout().lock();
        let written = stdout
            .write_all(self.text.as_bytes())
            .and_then(|()| stdout.flush());
        for diagnosis in &self.diagnoses {
            complain(diagnosis);
        }
        match written {
            // Whoever reads the other end of a pipe may stop whenever they like.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                complain(&format!("standard output: {error}; check where it leads"));
                ExitCode::from(BAD_INPUT)
            }
            _ if self.diagnoses.is_empty() => ExitCode::SUCCESS,
            _ => ExitCode::from(NOT_CONVERGED),
        }
    }
}

/// One line on the standard error stream.
fn complain(message: &str) {
    // If even this stream is closed there is nobody left to tell.
    let _ = writeln!(io::stderr(), "error: {message}");
}
