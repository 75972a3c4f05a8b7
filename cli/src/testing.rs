//! Small scenes for the tests of this library.

use crate::{Scene, Variant};

hangtime::model! {
    /// A point mass above a level table and a slope.
    pub Slide {
        parameters { m: kg = 3, g: m/s^2 = 9.81, start_y: m = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface table: z >= 0
        surface slope: z - 7[m] + y/2 >= 0
        impact table: inelastic
        impact slope: inelastic
        picture { point mass at (y, z) }
        start { y: start_y, z: 20[m] }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A point mass that is pushed over a wavy track; `s` is its height above the track.
    pub Wave {
        parameters { m: kg = 2, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
        coordinates { y: m, s: m }
        controls { u: N in -20..=20 }
        let mass = (y, a*(1 - cos(k*y)) + s)
        lagrangian m/2*|dot(mass)|^2 - m*g*mass.z
        forces { y: u }
        surface ground: s >= 0
        impact ground: inelastic
        picture { point mass, curve track: (w, a*(1 - cos(k*w))) over w }
        minimize time
        finally { y == 1[m] }
        start { dot(y): 1[m/s] }
        horizon 1 [s]
    }
}

/// A scene without and one with an objective.
pub(crate) const SCENES: &[Scene] = &[
    Scene::new(
        "slide",
        "a point mass falls on a slope",
        &[Variant::new(|| Box::new(Slide::default()))],
    ),
    Scene::new(
        "wave",
        "a point mass is pushed over a wavy track",
        &[Variant::new(|| Box::new(Wave::default()))],
    ),
];
