//! A bouncing ball: restitution, and infinitely many impacts in finite time.
//!
//! From a height `h` the ball reaches the floor after `sqrt(2 h / g)`, and rests on it after `(1 + e) / (1 - e)` times
//! that time, for a coefficient of restitution `e`.

use hangtime_cli::{Charted, Scene, Variant};

use crate::closed_form;

hangtime::model_file!("scenes/bouncing-ball.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    charted: &[Charted {
        what: "two bounces and a half",
        settings: &[],
        horizon: Some(2.0),
    }],
    closed_form: Some(closed_form::bounces),
    ..Scene::new(
        "bouncing-ball",
        "a ball bounces along a floor and comes to rest after infinitely many impacts",
        &[Variant::new(|| Box::new(BouncingBall::default()))],
    )
};
