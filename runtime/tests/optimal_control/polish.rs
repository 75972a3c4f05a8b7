//! What is returned is polished.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::attempt;
use hangtime::ocp::{Settings, Status};

hangtime::model! {
    /// A rider on a hill who starts along the surface rolls over two crests and pumps to be at the end soonest: the bike
    /// leaves the ground at once.
    Crests {
        parameters { m: kg = 60, b: kg = 12, g: m/s^2 = 9.81, a: m = 0.3, k: 1/m = 1.5 }
        coordinates { y: m, z: m, r: m in 0.5..=1.1 }
        controls { p: N in -1500..=1500 }
        fn track(y) = a*sin(k*y)
        lagrangian b/2*(dot(y)^2 + dot(z)^2) + m/2*(dot(y)^2 + (dot(z) + dot(r))^2) - b*g*z - m*g*(z + r)
        surface ground: z - track(y) >= 0
        impact ground: inelastic
        forces { r: p }
        minimize time
        finally { y == 8[m] }
        start { y: 0, z: 0, r: 0.8, dot(y): 4, dot(z): 1.8 }
    }
}

/// Polished, this plan begins with a flight that the re-simulation sees as contact for a third of a millisecond: too short to be
/// another motion.
#[test]
fn polish_does_not_lose_a_confirmation() {
    let solution = attempt(&Crests::default(), 20, &Settings::default());
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.disagreement
    );
    assert!(
        (solution.objective - 1.412_432_5).abs() < 1e-6,
        "{}",
        solution.objective
    );
}
