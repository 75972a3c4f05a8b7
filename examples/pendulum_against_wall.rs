//! A pendulum swings against a wall below its pivot.

use hangtime::prelude::*;

hangtime::model! {
    /// A mathematical pendulum with a wall on one side.
    pub PendulumAgainstWall {
        parameters {
            m: kg = 1, l: m = 1, g: m/s^2 = 9.81,
            /// Coefficient of restitution.
            e = 0.6,
            /// Angle at the start, from below.
            release: deg = 80,
        }
        coordinates { phi }
        let bob = (l*sin(phi), -l*cos(phi))
        lagrangian m/2*|dot(bob)|^2 - m*g*bob.z
        surface wall: bob.y >= 0
        impact wall: restitution e
        start { phi: release }
        horizon 4 [s]
    }
}

fn main() -> Result<(), InputError> {
    let run = simulate(&PendulumAgainstWall::default()).run()?;
    println!("{run}");
    for event in run
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Impact)
    {
        println!(
            "{:.9} s: the wall turns {:.6} rad/s into {:.6} rad/s",
            event.time, event.v_before[0], event.v_after[0]
        );
    }
    Ok(())
}
