//! A ball in a box: four surfaces, and no energy lost.

use hangtime::model::Model;

use hangtime_cli::{GroundLine, Plane, Scene, Variant, parameter};

hangtime::model_file!("scenes/elastic-box.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    closed_form: Some(crate::closed_form::elastic_box),
    ..Scene::new(
        "box",
        "a ball bounces in a box and keeps its energy",
        &[Variant::new(|| Box::new(ElasticBox::default()))],
    )
    .drawn(Plane {
        ground: sides,
        ..Plane::of_one_body(&["ball"], ["y [m]", "z [m]"])
    })
};

/// The four sides, whatever part of them is in sight.
fn sides(model: &dyn Model, _from: f64, _to: f64) -> Vec<GroundLine> {
    let (width, height) = (parameter(model, "width"), parameter(model, "height"));
    let line = |name, points: [[f64; 2]; 2]| GroundLine {
        name,
        points: points.into(),
    };
    vec![
        line("floor", [[0.0, 0.0], [width, 0.0]]),
        line("ceiling", [[0.0, height], [width, height]]),
        line("left", [[0.0, 0.0], [0.0, height]]),
        line("right", [[width, 0.0], [width, height]]),
    ]
}
