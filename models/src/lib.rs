//! The shipped scenes, each declared in the modelling language, the list of them, and the command line.
//!
//! [`scenes`] is the only place that knows which scenes exist; names, parameters, pictures and published results are
//! read from there. [`CommandLine`] works for these and for any other list of scenes.

mod bouncing_ball;
mod command_line;
mod elastic_box;
mod incline;
mod published;
mod pump_track;
mod scene;
mod ski_jump;

pub use bouncing_ball::BouncingBall;
pub use command_line::CommandLine;
pub use elastic_box::ElasticBox;
pub use incline::Incline;
pub use published::{
    ComparedValue, Measure, PublishedCase, PublishedCurve, PublishedData, PublishedDataError,
    PublishedPoint, Quantity, Reference, Task,
};
pub use pump_track::{PumpTrack, PumpTrackHolding};
pub use scene::{GroundLine, Plane, Scene, Variant, heights};
pub use ski_jump::SkiJump;

/// All shipped scenes, in the order in which they are listed.
#[must_use]
pub fn scenes() -> &'static [Scene] {
    const SCENES: &[Scene] = &[
        ski_jump::SCENE,
        pump_track::SCENE,
        bouncing_ball::SCENE,
        incline::SCENE,
        elastic_box::SCENE,
    ];
    SCENES
}
