//! The command line of hangtime over the shipped scenes.

use std::process::ExitCode;

use hangtime_models::{CommandLine, scenes};

fn main() -> ExitCode {
    CommandLine::new(scenes())
        .compiled_at(hangtime_macros::finished_at!(hangtime_models))
        .run(std::env::args_os())
}
