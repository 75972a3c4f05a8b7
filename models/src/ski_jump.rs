//! A ski jump: a point mass slides off a curved table, flies, and lands on a straight slope.
//!
//! Source: J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics and Optimal
//! Control: Ski Jumping and Accelerating a Bike Without Pedaling", section III-A; the numbers are
//! those of the authors' scripts and of the data of their Fig. 3.

use crate::published;
use hangtime_cli::{Charted, Scene, Variant};

hangtime::model_file!("scenes/ski-jump.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    published: published::ski_jump::CASES,
    charted: &[
        Charted {
            what: "start 45 m high",
            settings: &[],
            horizon: None,
        },
        Charted {
            what: "start 50 m high",
            settings: &["start_y=8.264"],
            horizon: None,
        },
    ],
    ..Scene::new(
        "ski-jump",
        "a point mass slides off a curved table, flies, and lands on a straight slope",
        &[Variant::new(|| Box::new(SkiJump::default()))],
    )
};
