//! Arguments in, one report and an exit status out.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser as _;

use crate::Scene;
use crate::arguments::{Arguments, Command};
use crate::failure::BadInput;
use crate::report::{BAD_INPUT, Report, complain};
use crate::{chart, explain, list, reproduce, simulate, solve};

/// The command line over a list of scenes.
///
/// # Examples
/// The whole `main.rs` of a program with a scene of its own:
///
/// ```no_run
/// use std::process::ExitCode;
///
/// use hangtime_cli::{CommandLine, Scene, Variant};
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
}

impl CommandLine {
    /// A command line that knows these scenes.
    #[must_use]
    pub const fn new(scenes: &'static [Scene]) -> Self {
        Self { scenes }
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
            Some(Command::Explain(arguments)) => explain::run(scenes, &arguments),
            Some(Command::Reproduce(arguments)) => reproduce::run(scenes, &arguments.out),
            None => reproduce::run(scenes, "out".as_ref()),
        }
    }
}
