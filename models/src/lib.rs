//! The shipped scenes, each declared in the modelling language, and the published data that they reproduce.
//!
//! [`scenes`] is the only place that knows which scenes exist; names, parameters, pictures and published results are
//! read from there.

mod bouncing_ball;
mod elastic_box;
mod incline;
mod published;
mod pump_track;
mod ski_jump;

use hangtime_cli::Scene;

pub use bouncing_ball::BouncingBall;
pub use elastic_box::ElasticBox;
pub use incline::Incline;
pub use pump_track::{PumpTrack, PumpTrackHolding};
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
