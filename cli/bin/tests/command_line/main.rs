//! The command line, end to end: what the binary prints, writes, and refuses.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

mod ampl;
mod book;
mod browser;
mod design;
mod fit;
mod gallery;
mod gradients;
mod joints;
mod nlp;
mod play;
#[cfg(feature = "play")]
mod play_page;
mod player;
mod random;
mod random_scenes;
mod refusals;
mod scene_files;
mod simulate;
mod solve;
mod start_pictures;
mod studies;
mod support;
mod sweep;
