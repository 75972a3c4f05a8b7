//! A ball in a box: four surfaces, and no energy lost.

use hangtime::model::Model;

use hangtime_cli::{GroundLine, Plane, Scene, Variant, parameter};

hangtime::model! {
    /// A ball between a floor, a ceiling and two walls, none of which takes energy.
    pub ElasticBox {
        parameters {
            /// Mass of the ball.
            m: kg = 1,
            /// Gravitational acceleration.
            g: m/s^2 = 9.81,
            /// Distance of the walls.
            width: m = 2,
            /// Distance of floor and ceiling.
            height: m = 1.5,
            /// Speed at the start, to the right and upwards.
            speed: m/s = 4,
        }
        coordinates {
            /// Horizontal position.
            y: m,
            /// Height.
            z: m,
        }

        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        surface ceiling: height - z >= 0
        surface left: y >= 0
        surface right: width - y >= 0
        impact floor, ceiling, left, right: restitution 1

        start { y: width/4, z: height/2, dot(y): speed, dot(z): speed }
        horizon 4 [s]
    }
}

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "box",
    "a ball bounces in a box and keeps its energy",
    &[Variant::new(|| Box::new(ElasticBox::default()))],
)
.drawn(Plane {
    ground: sides,
    ..Plane::of_one_body(&["ball"], ["y [m]", "z [m]"])
});

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
