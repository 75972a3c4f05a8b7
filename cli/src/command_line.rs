//! Arguments in, one report and an exit status out.

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _};

use crate::arguments::{Arguments, Command, ListArguments, ReproduceArguments};
use crate::failure::{BadInput, visible};
use crate::lab::chart::{self, Listed};
use crate::lab::reproduce;
use crate::report::{BAD_INPUT, NOT_CONVERGED, Report, complain, printed, refuse};
use crate::scene_file::is_path;
use crate::{CommandSettings, HardOptimum, HardScene, OpeningRide, PlayPage, Scene};
use crate::{
    ampl, authoring, explain, list, play, profile, program, run, scene, shell, sweep, watch,
};

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
    hard: &'static [HardScene],
    hard_optima: &'static [HardOptimum],
    page: Option<PlayPage>,
    peers: &'static str,
    opening: Option<OpeningRide>,
}

impl CommandLine {
    /// A command line that knows these scenes.
    #[must_use]
    pub const fn new(scenes: &'static [Scene]) -> Self {
        Self {
            scenes,
            hard: &[],
            hard_optima: &[],
            page: None,
            peers: "",
            opening: None,
        }
    }

    /// This command line, which shows what methods make of these scenes by `chart --stability`.
    #[must_use]
    pub const fn with_hard(self, hard: &'static [HardScene]) -> Self {
        Self { hard, ..self }
    }

    /// This command line, which shows what optimal control makes of these problems by `chart --stability`.
    #[must_use]
    pub const fn with_hard_optima(self, hard_optima: &'static [HardOptimum]) -> Self {
        Self {
            hard_optima,
            ..self
        }
    }

    /// This command line, which writes this page by `play`.
    #[must_use]
    pub const fn with_page(self, page: PlayPage) -> Self {
        Self {
            page: Some(page),
            ..self
        }
    }

    /// This command line, whose charts show runs of other programs on its scenes beside its own: a table in CSV with the columns `date`,
    /// `machine`, `study` (the title of a chart's section), `curve`, `settings`, `CPU time [s]` and
    /// `coordinates at the end` (apart by spaces). A file `peers.csv` in the output directory goes before it.
    #[must_use]
    pub const fn with_peers(self, peers: &'static str) -> Self {
        Self { peers, ..self }
    }

    /// This command line, whose page of published results opens with this ride, beside a published motion.
    #[must_use]
    pub const fn opening_with(self, ride: OpeningRide) -> Self {
        Self {
            opening: Some(ride),
            ..self
        }
    }

    /// Runs one command; `arguments` begin with the name of the program. Prints the report, or one line that says what
    /// was refused and how to mend it (mistakes in a scene file: with the lines of the file). Without a command, published results are reproduced, if a scene has some;
    /// otherwise the scenes are listed.
    ///
    /// The exit status is 0 for a solved problem, 2 for bad input and for files that could not be written, 3 for a
    /// result that did not converge or that a limit ended.
    pub fn run(&self, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
        ExitCode::from(self.status(arguments))
    }

    /// As [`CommandLine::run`], with the exit status as a number, for programs that end by their own means.
    pub fn status(&self, arguments: impl IntoIterator<Item = OsString>) -> u8 {
        keep_write_errors();
        let arguments: Vec<OsString> = arguments.into_iter().collect();
        if let Some(answer) = ampl::told(&arguments) {
            return ended(Ok(Ok(Report::of(answer))));
        }
        if let Some((file, options)) = ampl::call(&arguments) {
            return ended(panic::catch_unwind(|| ampl::run(file, options)));
        }
        let mut command = self.command(arguments.first());
        let outcome = match command
            .try_get_matches_from_mut(arguments.clone())
            .and_then(|matches| Arguments::from_arg_matches(&matches))
        {
            Ok(Arguments {
                command,
                watch: true,
            }) => {
                let refusal = match command.as_ref().and_then(Command::scene) {
                    Some(file) if is_path(file) => {
                        let Err(refusal) = watch::run(file, &arguments);
                        refusal
                    }
                    _ => BadInput::new(
                        "--watch looks at a scene file; give its path, which ends with .hang, as the scene",
                    ),
                };
                Ok(Err(refusal))
            }
            // A mistake in this program must not end it by a panic: its message is on the screen by then.
            Ok(arguments) => panic::catch_unwind(AssertUnwindSafe(|| {
                scene::check(self.scenes)?;
                self.dispatch(command, arguments.command)
            })),
            Err(error) if !error.use_stderr() => {
                // Help and version, in the colours of the terminal.
                return printed(error.print());
            }
            Err(error) => Ok(Err(BadInput::from(error))),
        };
        ended(outcome)
    }

    /// The commands, their options and defaults, under the name by which the program was called.
    fn command(&self, program: Option<&OsString>) -> clap::Command {
        let command = Arguments::command();
        let stem = program.and_then(|path| Path::new(path).file_stem());
        let command = match stem.and_then(|stem| stem.to_str()) {
            // The parser keeps names for as long as the program runs.
            Some(stem) => command.name(&*visible(stem).leak()),
            None => command,
        };
        let default = if self.has_published() {
            Command::REPRODUCE
        } else {
            "list"
        };
        let after = command.get_after_help().map(ToString::to_string);
        let after = after.unwrap_or_default();
        command
            .mut_subcommand(Command::REPRODUCE, |reproduce| {
                reproduce.hide(!self.has_published())
            })
            .after_help(format!("Without a command, `{default}` runs.\n{after}"))
    }

    /// Every command with its options, for books.
    #[must_use]
    pub fn settings() -> Vec<CommandSettings> {
        shell::settings(&Arguments::command())
    }

    fn charted(&self) -> Listed {
        Listed {
            scenes: self.scenes,
            hard: self.hard,
            hard_optima: self.hard_optima,
            peers: self.peers,
        }
    }

    fn opening(&self) -> reproduce::Opening {
        reproduce::Opening {
            ride: self.opening,
            peers: self.peers,
        }
    }

    fn has_published(&self) -> bool {
        self.scenes.iter().any(|scene| !scene.published.is_empty())
    }

    fn dispatch(
        &self,
        parser: clap::Command,
        command: Option<Command>,
    ) -> Result<Report, BadInput> {
        let scenes = self.scenes;
        match command {
            Some(Command::List(arguments)) => list::run(scenes, &arguments),
            Some(Command::Simulate(arguments)) => run::simulation(scenes, &arguments),
            Some(Command::Solve(arguments)) => run::solution(scenes, &arguments),
            Some(Command::Nlp(arguments)) => program::run(&arguments),
            Some(Command::Sweep(arguments)) => sweep::run(scenes, &arguments),
            Some(Command::Chart(arguments)) => chart::run(&self.charted(), &arguments),
            Some(Command::Explain(arguments)) => explain::run(scenes, &arguments).map(Report::of),
            Some(Command::Check(arguments)) => authoring::check(&arguments),
            Some(Command::Fmt(arguments)) => authoring::format(&arguments),
            Some(Command::New(arguments)) => authoring::new(&arguments),
            Some(Command::Profile(arguments)) => profile::run(&arguments),
            Some(Command::Play(arguments)) => play::run(scenes, self.page, &arguments),
            Some(Command::Reproduce(arguments)) => {
                reproduce::run(scenes, &self.opening(), &arguments)
            }
            Some(Command::Completions(arguments)) => {
                Ok(shell::completions(parser, scenes, &arguments))
            }
            Some(Command::Man(arguments)) => shell::manual(parser, &arguments),
            None if self.has_published() => {
                reproduce::run(scenes, &self.opening(), &ReproduceArguments::default())
            }
            None => list::run(scenes, &ListArguments::default()),
        }
    }
}

/// Prints what a command came to; gives its exit status.
fn ended(outcome: std::thread::Result<Result<Report, BadInput>>) -> u8 {
    match outcome {
        Ok(Ok(report)) => report.print(),
        Ok(Err(refusal)) => {
            refuse(&refusal);
            BAD_INPUT
        }
        Err(_) => {
            complain(
                "internal_error: a mistake in this program, at the place above; please report it",
            );
            NOT_CONVERGED
        }
    }
}

/// A file beyond the system's limit on its size (`ulimit -f`) is an error of the write that can be told, not the end of the program.
fn keep_write_errors() {
    #[cfg(unix)]
    {
        use std::sync::Arc;
        // without it such a write ends the program, as it does everywhere else
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    }
}
