//! Three blocks in a row, joined by springs: three contacts with friction, whose switches have no common rhythm.

use hangtime_cli::{Scene, Variant};

hangtime::model_file!("scenes/three-blocks.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "three-blocks",
    "three blocks on springs stick and slip on a rough floor",
    &[Variant::new(|| Box::new(ThreeBlocks::default()))],
);
