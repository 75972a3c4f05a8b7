//! A falling rod: two contacts of one body, with friction.
//!
//! The first tip slides while the rod turns about it; the second one then hits the floor while the first is in contact.

use hangtime_cli::{Scene, Variant};

hangtime::model_file!("scenes/falling-rod.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "falling-rod",
    "a rod falls on a rough floor with one tip, then the other",
    &[Variant::new(|| Box::new(FallingRod::default()))],
);
