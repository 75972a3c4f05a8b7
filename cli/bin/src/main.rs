//! The command line of hangtime over the shipped scenes.

use std::process::ExitCode;

use hangtime_cli::{CommandLine, OpeningRide};
#[cfg(feature = "play")]
use hangtime_cli::{PlayChapter, PlayPage};
#[cfg(feature = "play")]
use hangtime_models::scene_texts;
use hangtime_models::{hard_optima, hard_scenes, peers, scenes};

/// The multi-body bike: as few intervals and starts as show how it is ridden, since the page waits for it.
const BIKE: OpeningRide = OpeningRide {
    scene: "rolling-bike",
    intervals: 6,
    starts: 1,
};

/// The chapters of the book, as the build script lists them.
#[cfg(feature = "play")]
const CHAPTERS: &[PlayChapter] = include!(concat!(env!("OUT_DIR"), "/chapters.rs"));

fn main() -> ExitCode {
    let command_line = CommandLine::new(scenes())
        .with_hard(hard_scenes())
        .with_hard_optima(hard_optima())
        .with_peers(peers())
        .opening_with(BIKE);
    #[cfg(feature = "play")]
    let command_line = command_line.with_page(PlayPage {
        module: include_bytes!(concat!(env!("OUT_DIR"), "/module.gz")),
        scenes: scene_texts(),
        chapters: CHAPTERS,
    });
    command_line.run(std::env::args_os())
}
