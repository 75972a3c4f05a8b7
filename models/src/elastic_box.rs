//! A ball in a box: four surfaces, and no energy lost.

use hangtime_cli::{Scene, Variant};

hangtime::model_file!("scenes/elastic-box.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    closed_form: Some(crate::closed_form::elastic_box),
    ..Scene::new(
        "box",
        "a ball bounces in a box and keeps its energy",
        &[Variant::new(|| Box::new(ElasticBox::default()))],
    )
};
