//! A block on an incline: Coulomb friction, sliding and sticking.
//!
//! The block slides down with the deceleration `g (mu cos(incline) - sin(incline))`, and sticks where it stops if `mu`
//! is at least the slope of the incline.

use hangtime_cli::{Plane, Scene, Variant};

hangtime::model! {
    /// A block that slides down an incline with Coulomb friction.
    pub Incline {
        parameters {
            /// Mass of the block.
            m: kg = 2,
            /// Gravitational acceleration.
            g: m/s^2 = 9.81,
            /// Angle of the incline.
            incline: deg = 15,
            /// Coefficient of friction.
            mu = 0.5,
            /// Speed down the incline at the start.
            speed: m/s = 3,
        }
        coordinates {
            /// Horizontal position.
            y: m,
            /// Height.
            z: m,
        }

        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ramp: y*sin(incline) + z*cos(incline) >= 0
        impact ramp: inelastic, friction mu

        start { dot(y): speed*cos(incline), dot(z): -speed*sin(incline) }
        horizon 2 [s]
    }
}

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene::new(
    "incline",
    "a block slides down a rough incline, stops, and sticks",
    &[Variant::new(|| Box::new(Incline::default()))],
)
.drawn(Plane::of_one_body(&["block"], ["y [m]", "z [m]"]));
