//! The command line of hangtime over the shipped scenes.

use std::process::ExitCode;

use hangtime_cli::CommandLine;
use hangtime_models::{hard_scenes, peers, scenes};

fn main() -> ExitCode {
    CommandLine::new(scenes())
        .with_hard(hard_scenes())
        .with_peers(peers())
        .run(std::env::args_os())
}
