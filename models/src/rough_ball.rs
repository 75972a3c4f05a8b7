//! A bouncing ball on a rough floor: restitution and friction in the same impact.
//!
//! An impact with the normal velocity `v` has the impulse `(1 + e) m v`, so friction takes `mu (1 + e) v` of the
//! horizontal velocity, and no more than there is.

use hangtime_cli::{Scene, Variant};

use crate::closed_form;

hangtime::model_file!("scenes/rough-ball.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    closed_form: Some(closed_form::bounces),
    ..Scene::new(
        "rough-ball",
        "a ball bounces along a rough floor and loses speed at every impact",
        &[Variant::new(|| Box::new(RoughBall::default()))],
    )
};
