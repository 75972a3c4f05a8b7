//! A ball falls onto a slope, slides down, and stops at a wall.

use hangtime::prelude::*;

hangtime::model! {
    /// A ball on a slope with a wall.
    pub BallOnSlope {
        parameters { m: kg = 1, g: m/s^2 = 9.81, tilt = 0.5, wall_x: m = 3 }
        coordinates { x: m, z: m }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        surface slope: z + tilt*x >= 0
        surface wall: wall_x - x >= 0
        impact slope: inelastic
        impact wall: inelastic
        start { z: 1 [m] }
        horizon 2 [s]
    }
}

fn main() -> Result<(), InputError> {
    let model = BallOnSlope {
        tilt: 0.4,
        ..BallOnSlope::default()
    };
    println!("{}", simulate(&model).run()?);
    Ok(())
}
