//! The command line for any list of scenes.
//!
//! A program with [`CommandLine`] simulates, solves, charts and explains its scenes, and writes their figures, tables
//! and pages. What it knows about a scene is a [`Scene`].
//!
//! Without the feature `terminal` there are only the [`Calls`], for hosts that have no files and no terminal.

#![cfg_attr(
    not(feature = "terminal"),
    allow(dead_code, unused_imports, reason = "what only commands need")
)]

mod animation;
#[cfg(feature = "terminal")]
mod anytime;
mod arguments;
mod calls;
mod cells;
mod contour;
mod drawing;
mod ending;
mod explain;
mod failure;
mod job;
mod json;
mod kept;
mod markup;
mod measured;
mod method;
mod numbers;
mod published;
mod quantity;
#[cfg(feature = "terminal")]
mod report;
mod sampling;
mod scene;
mod scene_file;
mod settings;
mod sizes;
mod table;
mod task;
#[cfg(test)]
mod testing;
mod thinning;

#[cfg(feature = "terminal")]
mod ampl;
#[cfg(feature = "terminal")]
mod authoring;
#[cfg(feature = "terminal")]
mod bounds;
#[cfg(feature = "terminal")]
mod command_line;
#[cfg(feature = "terminal")]
mod figure;
#[cfg(feature = "terminal")]
mod files;
#[cfg(feature = "terminal")]
mod fit;
#[cfg(feature = "terminal")]
mod host;
#[cfg(feature = "terminal")]
mod host_program;
#[cfg(feature = "terminal")]
mod lab;
#[cfg(feature = "terminal")]
mod list;
#[cfg(feature = "terminal")]
mod motion;
#[cfg(feature = "terminal")]
mod output;
#[cfg(feature = "terminal")]
mod page;
#[cfg(feature = "terminal")]
mod play;
#[cfg(feature = "terminal")]
mod profile;
#[cfg(feature = "terminal")]
mod program;
#[cfg(feature = "terminal")]
mod program_file;
#[cfg(feature = "terminal")]
mod program_options;
#[cfg(feature = "terminal")]
mod progress;
#[cfg(feature = "terminal")]
mod run;
#[cfg(feature = "terminal")]
mod shell;
#[cfg(feature = "terminal")]
mod simulate;
#[cfg(feature = "terminal")]
mod solve;
#[cfg(feature = "terminal")]
mod spreadsheet;
#[cfg(feature = "terminal")]
mod sweep;
#[cfg(feature = "terminal")]
mod thumbnail;
#[cfg(feature = "terminal")]
mod timing;
#[cfg(feature = "terminal")]
mod watch;

pub use arguments::WARM_CHAIN;
pub use calls::Calls;
#[cfg(feature = "terminal")]
pub use command_line::CommandLine;
#[cfg(feature = "terminal")]
pub use host::{HostScene, Refusal, options};
#[cfg(feature = "terminal")]
pub use host_program::{HostProgram, program_options};
pub use job::Run as HostRun;
pub use json::Columns;
#[cfg(feature = "terminal")]
pub use play::{PlayChapter, PlayPage};
pub use published::{
    ComparedValue, Measure, PublishedCase, PublishedCurve, PublishedData, PublishedDataError,
    PublishedPoint, PublishedSize, Quantity, Reference, Task,
};
pub use scene::{
    Charted, ClosedForm, HardOptimum, HardScene, OpeningRide, Question, Right, RightOptimum, Scene,
    Variant, parameter,
};
#[cfg(feature = "terminal")]
pub use shell::CommandSettings;
#[cfg(feature = "terminal")]
pub use sweep::{SweepPlan, SweepTable, SweepWork};
