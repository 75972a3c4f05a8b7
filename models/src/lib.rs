//! The shipped scenes, each declared in the modelling language, and the published data that they reproduce.
//!
//! [`scenes`] is the only place that knows which scenes exist; names, parameters, pictures and published results are
//! read from there.

mod bouncing_ball;
mod closed_form;
mod elastic_box;
mod falling_rod;
mod gallery;
mod hard;
mod hard_optima;
mod hills;
mod incline;
mod published;
mod pump_track;
mod rough_ball;
mod ski_jump;
mod stick_slip;
mod three_blocks;

use std::sync::LazyLock;

use hangtime_cli::Scene;

pub use bouncing_ball::BouncingBall;
pub use elastic_box::ElasticBox;
pub use falling_rod::FallingRod;
pub use hard::hard_scenes;
pub use hard_optima::hard_optima;
pub use hills::Hills;
pub use incline::Incline;
pub use pump_track::{PumpTrack, PumpTrackHolding};
pub use rough_ball::RoughBall;
pub use ski_jump::SkiJump;
pub use stick_slip::StickSlip;
pub use three_blocks::ThreeBlocks;

/// Runs of other programs on the ski jump, the pump track and the incline, as `tools/peers/measure.py` wrote them: CSV for
/// [`hangtime_cli::CommandLine::with_peers`].
#[must_use]
pub const fn peers() -> &'static str {
    include_str!("published/peers.csv")
}

/// All shipped scenes, in the order in which they are listed.
#[must_use]
pub fn scenes() -> &'static [Scene] {
    static SCENES: LazyLock<Vec<Scene>> = LazyLock::new(|| {
        macro_rules! grouped {
            ($($scene:ident $file:literal $picture:literal $group:literal;)*) => {
                [$($scene::SCENE
                    .in_group($group)
                    .compiled_from(include_str!(concat!("../scenes/", $file, ".hang")))
                    .pictured(include_str!(concat!("../pictures/", $picture, ".svg"))),)*]
            };
        }
        let compiled = grouped! {
            ski_jump "ski-jump" "ski-jump" "publication";
            pump_track "pump-track" "pump-track" "publication";
            bouncing_ball "bouncing-ball" "bouncing-ball" "flights and bounces";
            incline "incline" "incline" "friction";
            elastic_box "elastic-box" "box" "flights and bounces";
            rough_ball "rough-ball" "rough-ball" "flights and bounces";
            stick_slip "stick-slip" "stick-slip" "friction";
            hills "hills" "hills" "flights and bounces";
            falling_rod "falling-rod" "falling-rod" "friction";
            three_blocks "three-blocks" "three-blocks" "friction";
        };
        [&compiled, gallery::GALLERY].concat()
    });
    &SCENES
}

/// The texts of the compiled scenes, as (name, text of the file), in the order in which they are listed.
#[must_use]
pub const fn scene_texts() -> &'static [(&'static str, &'static str)] {
    macro_rules! texts {
        ($($name:literal),* $(,)?) => {
            &[$(($name, include_str!(concat!("../scenes/", $name, ".hang")))),*]
        };
    }
    texts![
        "ski-jump",
        "pump-track",
        "pump-track-holding",
        "bouncing-ball",
        "incline",
        "elastic-box",
        "rough-ball",
        "stick-slip",
        "hills",
        "falling-rod",
        "three-blocks",
    ]
}
