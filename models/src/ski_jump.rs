//! A ski jump: a point mass slides off a curved table, flies, and lands on a straight slope.
//!
//! Source: J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics and Optimal
//! Control: Ski Jumping and Accelerating a Bike Without Pedaling", section III-A; the numbers are
//! those of the authors' scripts and of the data of their Fig. 3.

use crate::published;
use hangtime_cli::{Plane, Scene, Variant};

hangtime::model! {
    /// A ski jumper: a point mass that slides off a curved table and lands on a straight slope.
    pub SkiJump {
        parameters {
            /// Mass of the jumper.
            m: kg = 80,
            /// Gravitational acceleration.
            g: m/s^2 = 9.81,
            /// Horizontal position of the start on the table; 10.2759 m is 45 m high, 8.264 m is 50 m.
            start_y: m = 10.2759,
        }
        coordinates {
            /// Horizontal position.
            y: m,
            /// Height.
            z: m,
        }

        fn table(y) = -0.0001524[1/m^3]*y^4 - 0.002149[1/m^2]*y^3 + 0.4162[1/m]*y^2 - 9.154*y + 99.15[m]
        fn slope(y) = 45[m] - y/2

        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface table: z - table(y) >= 0
        surface slope: z - slope(y) >= 0
        impact table: inelastic
        impact slope: inelastic

        start { y: start_y, z: table(start_y) }
        horizon 5 [s]
    }
}

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    published: published::ski_jump::CASES,
    ..Scene::new(
        "ski-jump",
        "a point mass slides off a curved table, flies, and lands on a straight slope",
        &[Variant::new(|| Box::new(SkiJump::default()))],
    )
    .drawn(Plane::of_one_body(&["jumper"], ["y [m]", "z [m]"]))
};
