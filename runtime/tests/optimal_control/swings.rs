//! Goals that no control reaches at once: motions that gain energy in swings.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::attempt;
use hangtime::ocp::{Settings, Solution, Status};
use std::f64::consts::PI;

hangtime::model! {
    /// A bead in a trough is to come to rest at the lowest point of the next one. Its push is half of what holds it on the
    /// steepest part of the hill in between.
    Troughs {
        parameters { g: m/s^2 = 9.81, depth: m = 0.4, k: 1/m = 2, most: N = 4 }
        coordinates { y: m, z: m }
        controls { push: N in -most..=most }
        lagrangian 1[kg]*(|dot((y, z))|^2/2 - g*z)
        surface ground: z >= depth*(1 - cos(k*y))
        impact ground: inelastic
        forces { y: push }
        minimize time
        finally { k*y == 2*pi, dot(y) == 0 }
        start { y: 0, z: 0 }
        horizon 3 [s]
    }
}

/// Whether the re-simulation is at rest at the goal, having been behind its start on the way.
fn swung(solution: &Solution) {
    let motion = &solution.motion.as_ref().unwrap().trajectory;
    let (q, v) = (motion.q.last().unwrap(), motion.v.last().unwrap());
    assert!((q[0] - PI).abs() < 1e-6, "{q:?}");
    // A goal is reached to a share of the speeds on the way.
    let fastest = motion.v.iter().map(|v| v[0].abs()).fold(0.0, f64::max);
    assert!(v[0].abs() < 1e-6 * fastest, "{v:?}");
    let behind = motion.q.iter().map(|q| q[0]).fold(0.0, f64::min);
    assert!(behind < -0.3, "{behind}");
}

#[test]
fn bead_with_a_weak_push_swings_over_the_hill_into_the_next_trough() {
    let troughs = Troughs::default();
    // What the push does over both slopes is less than the height of the hill takes, so that it has to swing.
    let (push, hill) = (troughs.most * PI / 2.0, 9.81 * 2.0 * troughs.depth);
    assert!(push < hill);
    let mut before = f64::INFINITY;
    for intervals in [10, 20] {
        let solution = attempt(&troughs, intervals, &Settings::default());
        let found = matches!(solution.status, Status::Solved | Status::Uncertified);
        assert!(found, "{intervals}: {:?}", solution.diagnosis());
        swung(&solution);
        // A finer grid does not lose the swing of a coarser one.
        assert!(solution.objective <= before * (1.0 + 1e-6), "{intervals}");
        before = solution.objective;
    }
}
