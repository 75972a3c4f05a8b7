//! The command line of hangtime over the shipped scenes.

use std::process::ExitCode;

use hangtime_cli::CommandLine;
use hangtime_models::scenes;

fn main() -> ExitCode {
    CommandLine::new(scenes()).run(std::env::args_os())
}
