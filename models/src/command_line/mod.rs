//! The command line: arguments in, one report and an exit status out.
//!
//! It works for any list of scenes: a program of its own with [`CommandLine`] simulates, solves, charts and explains
//! the scenes of that program, with the same settings, figures and files as the shipped ones.

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

use crate::Scene;

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

/// The command line over a list of scenes.
///
/// # Examples
/// The whole `main.rs` of a program with a scene of its own:
///
/// ```no_run
/// use std::process::ExitCode;
///
/// use hangtime_models::{CommandLine, Scene, Variant};
///
/// hangtime::model! {
///     /// A cart that is pushed against friction of the air.
///     pub Cart {
///         parameters { m: kg = 2, c: kg/m = 0.1 }
///         coordinates { y: m }
///         controls { u: N in -1..=1 }
///         lagrangian m/2*dot(y)^2
///         forces { y: u - c*dot(y)^2 }
///         minimize time
///         finally { y == 1[m] }
///     }
/// }
///
/// const SCENES: &[Scene] = &[Scene::new(
///     "cart",
///     "a cart is pushed over a line in least time",
///     &[Variant::new(|| Box::new(Cart::default()))],
/// )];
///
/// fn main() -> ExitCode {
///     CommandLine::new(SCENES).run(std::env::args_os())
/// }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct CommandLine {
    scenes: &'static [Scene],
    compiled_at: Option<f64>,
}

impl CommandLine {
    /// A command line that knows these scenes.
    #[must_use]
    pub const fn new(scenes: &'static [Scene]) -> Self {
        Self {
            scenes,
            compiled_at: None,
        }
    }

    /// Tells when the library with the scenes was finished \[s since 1970\], for the compile time that `explain` prints.
    #[must_use]
    pub const fn compiled_at(self, seconds: Option<f64>) -> Self {
        Self {
            compiled_at: seconds,
            ..self
        }
    }

    /// Runs one command; `arguments` begin with the name of the program. Prints the report, or one line that says what
    /// was refused and how to mend it.
    ///
    /// The exit status is 0 for a solved problem, 2 for bad input, 3 for a result that did not converge.
    pub fn run(&self, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
        let outcome = match Arguments::try_parse_from(arguments) {
            Ok(arguments) => self.dispatch(arguments.command),
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

    fn dispatch(&self, command: Option<Command>) -> Result<Report, BadInput> {
        let scenes = self.scenes;
        match command {
            Some(Command::List(arguments)) => Ok(list::run(scenes, &arguments)),
            Some(Command::Simulate(arguments)) => simulate::run(scenes, &arguments),
            Some(Command::Solve(arguments)) => solve::run(scenes, &arguments),
            Some(Command::Chart(arguments)) => chart::run(scenes, &arguments),
            Some(Command::Explain(arguments)) => explain::run(scenes, self.compiled_at, &arguments),
            Some(Command::Reproduce(arguments)) => reproduce::run(scenes, &arguments.out),
            None => reproduce::run(scenes, "out".as_ref()),
        }
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
