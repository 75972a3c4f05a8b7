//! Where conditions along the path are imposed.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{most_exceeded, one_start, solve};
use hangtime::ocp::PathPoints;

hangtime::model! {
    /// A mass on a spring whose stop is a path constraint, thrown through the middle as fast as possible.
    Spring {
        parameters { m: kg = 1, c: N/m = 4, stop: m = 0.3 }
        coordinates { y: m }
        controls { u: N in -3..=3 }
        lagrangian m/2*dot(y)^2 - c/2*y^2
        forces { y: u }
        minimize -dot(y)/1[m/s]
        constraint room: stop^2 - y^2 >= 0
        finally { y == 0 }
        horizon 2 [s]
    }
}

#[test]
fn path_constraint_between_its_places_holds_unless_nodes_are_asked_for_and_then_the_excess_is_told()
{
    let spring = Spring::default();
    let mut settings = one_start();
    let mut everywhere = Vec::new();
    for points in [PathPoints::Both, PathPoints::Stages, PathPoints::Ends] {
        settings.path_points = points;
        let solution = solve(&spring, 8, &settings);
        let excess = most_exceeded(&solution);
        // It is that of the re-simulation, which may be so far from the plan.
        assert!(excess < settings.largest_distance, "{points:?}: {excess}");
        everywhere.push(solution.objective);
    }
    settings.bounds_at_nodes = true;
    let nodes = solve(&spring, 8, &settings);
    let excess = &nodes.excess[0];
    assert_eq!([&excess.name[..], &excess.unit], ["room", "m^2"]);
    assert!(excess.amount > 1e-5 && (0.0..=2.0).contains(&excess.time));
    // More room cannot be worse. The violation is that of the re-simulated motion, as far as its points come near the place.
    assert!(
        everywhere
            .iter()
            .all(|everywhere| nodes.objective < everywhere - 1e-7)
    );
    let motion = nodes.motion.unwrap();
    let farthest = motion
        .trajectory
        .q
        .iter()
        .map(|q| q[0].abs())
        .fold(0.0, f64::max);
    assert!((farthest * farthest - 0.09 - excess.amount).abs() < 0.1 * excess.amount);
}
