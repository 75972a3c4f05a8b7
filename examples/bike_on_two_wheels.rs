//! Two contacts: a bike on two wheels crosses a wavy track in least time, with a rider who pushes and pitches.
//!
//! ```sh
//! cargo run --release --example bike_on_two_wheels -- solve bike --starts 4 --out out
//! cargo run --release --example bike_on_two_wheels -- simulate bike
//! ```

use std::process::ExitCode;

use hangtime_cli::{CommandLine, Scene, Variant};

hangtime::model! {
    /// A rigid bike with two small wheels; its rider pulls on the handlebar and shifts weight.
    pub Bike {
        parameters {
            m: kg = 80, j: kg m^2 = 10, g: m/s^2 = 9.81,
            /// Half the distance of the wheels.
            a: m = 0.5,
            /// Half the height of the waves.
            h: m = 0.1,
        }
        coordinates { y: m, z: m, pitch in -1..=1 }
        controls { push: N in -200..=400, lift: N in -400..=1200, turn: N m in -100..=100 }

        fn track(y) = h*(1 - cos(2[1/m]*y))
        let rear = (y - a*cos(pitch), z - a*sin(pitch))
        let front = (y + a*cos(pitch), z + a*sin(pitch))

        lagrangian m/2*(dot(y)^2 + dot(z)^2) + j/2*dot(pitch)^2 - m*g*z
        forces { y: push, z: lift, pitch: turn }
        surface rear_wheel: rear.z - track(rear.y) >= 0
        surface front_wheel: front.z - track(front.y) >= 0
        impact rear_wheel: inelastic
        impact front_wheel: inelastic
        picture {
            point rear_wheel at rear,
            point front_wheel at front,
            link rear_wheel to front_wheel,
            curve track: (w, track(w)) over w,
        }

        minimize time
        finally { y == 5[m] }
        start { z: 0.3[m], dot(y): 3[m/s] }
        horizon 2 [s]
    }
}

/// The scenes of this program.
pub const SCENES: &[Scene] = &[Scene::new(
    "bike",
    "a bike on two wheels crosses a wavy track in least time",
    &[Variant::new(|| Box::new(Bike::default()))],
)];

fn main() -> ExitCode {
    CommandLine::new(SCENES).run(std::env::args_os())
}
