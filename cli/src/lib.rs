//! The command line for any list of scenes.
//!
//! A program with [`CommandLine`] simulates, solves, charts and explains its scenes, and writes their figures, tables
//! and pages. What it knows about a scene is a [`Scene`].

mod animation;
mod arguments;
mod authoring;
mod bounds;
mod chart;
mod command_line;
mod explain;
mod failure;
mod figure;
mod files;

mod json;
mod list;
mod markup;
mod method;
mod motion;
mod output;
mod page;
mod program;
mod progress;
mod published;
mod quantity;
mod report;
mod reproduce;
mod sampling;
mod scene;
mod scene_file;
mod settings;
mod shell;
mod simulate;
mod sizes;
mod solve;
mod spreadsheet;
mod table;
#[cfg(test)]
mod testing;
mod thinning;
mod timing;
mod watch;

pub use command_line::CommandLine;
pub use published::{
    ComparedValue, Measure, PublishedCase, PublishedCurve, PublishedData, PublishedDataError,
    PublishedPoint, PublishedSize, Quantity, Reference, Task,
};
pub use scene::{
    Charted, ClosedForm, ControlScene, GroundLine, HardScene, Plane, Right, Scene, Variant,
    heights, parameter,
};
