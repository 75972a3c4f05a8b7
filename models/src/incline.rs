//! A block on an incline: Coulomb friction, sliding and sticking.
//!
//! The block slides down with the deceleration `g (mu cos(incline) - sin(incline))`, and sticks where it stops if `mu`
//! is at least the slope of the incline.

use hangtime_cli::{Scene, Variant};

use crate::closed_form;

hangtime::model_file!("scenes/incline.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    closed_form: Some(closed_form::incline),
    ..Scene::new(
        "incline",
        "a block slides down a rough incline, stops, and sticks",
        &[Variant::new(|| Box::new(Incline::default()))],
    )
};
