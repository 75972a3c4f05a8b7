//! A scene of one's own with the whole command line: a sledge crosses a hollow in least time.
//!
//! ```sh
//! cargo run --release --example own_command_line -- solve sledge --out out
//! cargo run --release --example own_command_line -- simulate sledge --set hollow=0.5m
//! ```

use std::process::ExitCode;

use hangtime_cli::{CommandLine, Scene, Variant};

hangtime::model! {
    /// A sledge with a propeller that can be tilted.
    pub Sledge {
        parameters { m: kg = 100, g: m/s^2 = 9.81, hollow: m = 1 }
        coordinates { y: m, z: m }
        controls { push: N in -200..=400, lift: N in 0..=700 }

        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: push, z: lift }
        fn snow_line(y) = -hollow*exp(-((y - 5[m])/1[m])^2)
        surface snow: z - snow_line(y) >= 0
        impact snow: inelastic

        minimize time
        finally { y == 10[m], dot(y) == 0[m/s] }
        start { z: snow_line(0[m]) }
        horizon 5 [s]
    }
}

/// The scenes of this program.
pub const SCENES: &[Scene] = &[Scene::new(
    "sledge",
    "a sledge crosses a hollow in least time",
    &[Variant::new(|| Box::new(Sledge::default()))],
)];

fn main() -> ExitCode {
    CommandLine::new(SCENES).run(std::env::args_os())
}
