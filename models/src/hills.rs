//! Hills: sliding, taking off tangentially, flying and landing, on a track that is a cosine.

use hangtime_cli::{Scene, Variant};

hangtime::model_file!("scenes/hills.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "hills",
    "a point mass slides over hills, takes off, and lands",
    &[Variant::new(|| Box::new(Hills::default()))],
);
