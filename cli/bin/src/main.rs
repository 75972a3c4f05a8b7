//! The command line of hangtime over the shipped scenes.

#[cfg(feature = "play")]
use std::io::Read as _;
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

/// The text, compressed by gzip.
#[cfg(feature = "play")]
fn pack(text: &str) -> Vec<u8> {
    let mut packed = Vec::new();
    let best = flate2::Compression::best();
    let read = flate2::read::GzEncoder::new(text.as_bytes(), best).read_to_end(&mut packed);
    read.map_or_else(|_| Vec::new(), |_| packed)
}

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
        pack,
    });
    command_line.run(std::env::args_os())
}
