//! A falling rod: two contacts of one body, with friction.
//!
//! The first tip slides while the rod turns about it; the second one then hits the floor while the first is in contact.

use hangtime::model::Model;
use hangtime_cli::{GroundLine, Plane, Scene, Variant, parameter};

hangtime::model_file!("scenes/falling-rod.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "falling-rod",
    "a rod falls on a rough floor with one tip, then the other",
    &[Variant::new(|| Box::new(FallingRod::default()))],
)
.drawn(Plane {
    bodies: &["rear tip", "front tip"],
    links: &[[0, 1]],
    positions: tips,
    ground: |_, from, to| {
        vec![GroundLine {
            name: "floor",
            points: vec![[from, 0.0], [to, 0.0]],
        }]
    },
    ..Plane::of_one_body(&["rod"], ["y [m]", "z [m]"])
});

/// Where the tips are.
fn tips(model: &dyn Model, q: &[f64]) -> Vec<[f64; 2]> {
    let [front, rear] = ["front", "rear"].map(|name| parameter(model, name));
    let (sine, cosine) = q[2].sin_cos();
    [-rear, front]
        .map(|reach| [q[0] + reach * cosine, q[1] + reach * sine])
        .into()
}
