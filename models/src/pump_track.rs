//! A pump track: bike and rider gain speed on a wavy track by pushing against each other.
//!
//! Source: J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics and Optimal
//! Control: Ski Jumping and Accelerating a Bike Without Pedaling", section III-B.
//!
//! The scene exists in two forms that differ in one line, the direction in which the track pushes.
//! At an impact the link between bike and rider is meant to be rigid, so that the whole mass takes
//! the impulse along the normal of the track. With `l` held, the coordinates `(y, s)` have the inertia
//! of one point mass on the curve `z = track(y) + s`, and the impulse direction is
//! `(-track', 1 + track'^2, 0)`: form `holding`. The publication uses `(-track', 1, 0)`: form
//! `paper`. Scaled to a unit change of the normal velocity, `y` receives `-track'` instead of
//! `-track' / (1 + track'^2)`, that is, a push that is not perpendicular to the track: while the bike
//! slides without input, the published direction changes the energy (it slows down more on the way up
//! and gains more on the way down, and is back at its speed where the track is level), the other one
//! keeps it. Without input at 15 km/h the goal is reached after 1.8565 s in form `paper` and after
//! 1.8100 s in form `holding`.

use crate::published;
use hangtime_cli::{Charted, Scene, Variant};

hangtime::model_file!("scenes/pump-track.hang");
hangtime::model_file!("scenes/pump-track-holding.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    published: published::pump_track::CASES,
    published_sizes: published::pump_track::SIZES,
    // 240 intervals, re-simulated to 1e-12 m.
    best_known: Some(1.411_592_101_2),
    charted: &[
        charted("10 km/h", &["speed=10km/h"]),
        charted("15 km/h", &["speed=15km/h"]),
        charted("22 km/h", &["speed=22km/h"]),
    ],
    ..Scene::new(
        "pump-track",
        "a bike and its rider gain speed on a wavy track by pushing against each other",
        &[
            Variant {
                settings: &[("law", "paper")],
                model: || Box::new(PumpTrack::default()),
            },
            Variant {
                settings: &[("law", "holding")],
                model: || Box::new(PumpTrackHolding::default()),
            },
        ],
    )
};

/// A ride without input.
const fn charted(what: &'static str, settings: &'static [&'static str]) -> Charted {
    Charted {
        what,
        settings,
        horizon: None,
    }
}
