//! A pump track: bike and rider gain speed on a wavy track by pushing against each other.
//!
//! Source: J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics and Optimal
//! Control: Ski Jumping and Accelerating a Bike Without Pedaling", section III-B.
//!
//! The scene exists in two forms that differ in one line, the direction in which the track pushes.
//! At an impact the link between bike and rider is meant to be rigid, so that the whole mass takes
//! the impulse along the normal of the track. With `l` held, the coordinates `(y, s)` have the inertia
//! of one point mass on the curve `z = track(y) + s`, and the impulse direction is
//! `(-track', 1 + track'^2, 0)`: form `holding`. The publication uses `(-track', 1, 0)`: form
//! `paper`. Scaled to a unit change of the normal velocity, `y` receives `-track'` instead of
//! `-track' / (1 + track'^2)`, that is, a push that is not perpendicular to the track: while the bike
//! slides without input, the published direction changes the energy (it slows down more on the way up
//! and gains more on the way down, and is back at its speed where the track is level), the other one
//! keeps it. Without input at 15 km/h the goal is reached after 1.8565 s in form `paper` and after
//! 1.8100 s in form `holding`.

use hangtime::model::Model;

use crate::published;
use hangtime_cli::{GroundLine, Plane, Scene, Variant, parameter};

/// The scene; its forms differ in the law of the impact.
macro_rules! pump_track {
    ($(#[$documentation:meta])* $name:ident: $($law:tt)+) => {
        hangtime::model! {
            $(#[$documentation])*
            pub $name {
                parameters {
                    /// Mass of the bike.
                    m_b: kg = 15,
                    /// Mass of the rider.
                    m_r: kg = 75,
                    /// Gravitational acceleration.
                    g: m/s^2 = 9.81,
                    /// Amplitude of the track.
                    a: m = 0.2,
                    /// Wave number of the track.
                    k: 1/m = 2,
                    /// Speed at the start.
                    speed: km/h = 15,
                }
                coordinates {
                    /// Horizontal position of both.
                    y: m,
                    /// Height of the bike above the track.
                    s: m,
                    /// Length of the link.
                    l: m in 0.27803..=0.59559,
                }
                controls {
                    /// Force along the link.
                    u: N in -108.25..=376.875,
                }

                fn track(y) = a*(1 - cos(k*y))
                let bike = (y, track(y) + s)
                let rider = (y, track(y) + s + l)

                lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
                forces { l: u }
                surface ground: s >= 0
                impact ground: $($law)+

                minimize time
                finally {
                    /// Two waves of the track as published.
                    y == 2*pi*1[m],
                }
                start { l: 0.4368 [m], dot(y): speed }
                horizon 2 [s]
            }
        }
    };
}

pump_track! {
    /// A bike and its rider, two point masses on a massless link, on a wavy track; the track pushes
    /// along (-track', 1, 0), as published.
    PumpTrack: inelastic, along (-diff(track)(y), 1, 0)
}

pump_track! {
    /// A bike and its rider, two point masses on a massless link, on a wavy track; the track pushes
    /// along its normal while the link is held.
    PumpTrackHolding: inelastic, holding l
}

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    name: "pump-track",
    title: "a bike and its rider gain speed on a wavy track by pushing against each other",
    variants: &[
        Variant::form(&[("law", "paper")], || Box::new(PumpTrack::default())),
        Variant::form(&[("law", "holding")], || {
            Box::new(PumpTrackHolding::default())
        }),
    ],
    plane: Some(Plane {
        axes: ["y [m]", "z [m]"],
        unit: "m",
        bodies: &["bike", "rider"],
        links: &[[0, 1]],
        positions,
        ground,
    }),
    published: published::pump_track::CASES,
};

/// Points of the ground line.
const POINTS: usize = 200;

/// Height of the track above its lowest point at `y` [m].
fn track(model: &dyn Model, y: f64) -> f64 {
    parameter(model, "a") * (1.0 - (parameter(model, "k") * y).cos())
}

/// Bike and rider.
fn positions(model: &dyn Model, q: &[f64]) -> Vec<[f64; 2]> {
    let bike = track(model, q[0]) + q[1];
    vec![[q[0], bike], [q[0], bike + q[2]]]
}

fn ground(model: &dyn Model, from: f64, to: f64) -> Vec<GroundLine> {
    vec![GroundLine {
        name: "track",
        points: (0..=POINTS)
            .map(|i| from + (to - from) * i as f64 / POINTS as f64)
            .map(|y| [y, track(model, y)])
            .collect(),
    }]
}
