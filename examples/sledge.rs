//! The smallest optimal control program: a sledge crosses a hollow in least time.

use hangtime::prelude::*;

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

fn main() -> Result<(), InputError> {
    println!("{}", solve(&Sledge::default()).intervals(10).run()?);
    Ok(())
}
