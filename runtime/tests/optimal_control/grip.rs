//! Motions at the edge of a friction cone all the time, which could begin to slip in any interval.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::attempt;
use hangtime::ocp::{Settings, Status};

hangtime::model! {
    /// A driven roller on a rough floor, 3 m from rest to rest in least time: the motor could spin it.
    Roller {
        parameters { m: kg = 3, r: m = 0.3, mu = 0.25, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m, phi: rad }
        controls { torque: N*m in -9..=9 }
        lagrangian m*(dot(y)^2 + dot(z)^2 + r^2*dot(phi)^2/2)/2 - m*g*z
        forces { phi: torque }
        surface floor: z >= r
        impact floor: inelastic, friction mu, sliding dot(y) - r*dot(phi)
        minimize time
        finally { y == 3[m], dot(y) == 0[m/s], dot(phi) == 0[rad/s] }
        start { z: r }
        horizon 3 [s]
    }
}

/// No acceleration is above `mu*g`, so that 3 m take `2*sqrt(3/(mu*g))`. In each of the 16 intervals a slip might begin in more than one
/// way: 30 programs are too few to ask for them one by one.
#[test]
fn many_slips_that_might_begin_are_decided_by_one_program() {
    let exact = 2.0 * (3.0_f64 / (0.25 * 9.81)).sqrt();
    let mut settings = Settings::default();
    settings.starts = Some(1);
    settings.maximum_programs = 30;
    let solution = attempt(&Roller::default(), 16, &settings);
    assert_eq!(solution.status, Status::Solved);
    let excess = solution.objective / exact - 1.0;
    assert!(excess.abs() < 1e-9, "{excess:e}");
}
