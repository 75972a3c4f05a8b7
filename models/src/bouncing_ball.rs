//! A bouncing ball: restitution, and infinitely many impacts in finite time.
//!
//! From a height `h` the ball reaches the floor after `sqrt(2 h / g)`, and rests on it after `(1 + e) / (1 - e)` times
//! that time, for a coefficient of restitution `e`.

use hangtime_cli::{Plane, Scene, Variant};

hangtime::model! {
    /// A ball that bounces along a floor.
    pub BouncingBall {
        parameters {
            /// Mass of the ball.
            m: kg = 1,
            /// Gravitational acceleration.
            g: m/s^2 = 9.81,
            /// Coefficient of restitution.
            e = 0.8,
            /// Height of the start.
            height: m = 1,
            /// Horizontal speed, which nothing changes.
            speed: m/s = 0.5,
        }
        coordinates {
            /// Horizontal position.
            y: m,
            /// Height.
            z: m,
        }

        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        impact floor: restitution e

        start { z: height, dot(y): speed }
        horizon 5 [s]
    }
}

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "bouncing-ball",
    "a ball bounces along a floor and comes to rest after infinitely many impacts",
    &[Variant::new(|| Box::new(BouncingBall::default()))],
)
.drawn(Plane::of_one_body(&["ball"], ["y [m]", "z [m]"]));
