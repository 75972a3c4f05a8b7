//! Where conditions along the path are imposed.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{DIGITS, most_exceeded, one_start, solve};
use hangtime::ocp::PathPoints;

hangtime::model! {
    /// A cart in a hurry with a speed limit.
    Limited {
        parameters { m: kg = 2, limit: m/s = 0.5 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        /// The speed limit.
        constraint speed: dot(y) <= limit
        finally { y == 1 [m] }
    }
}

#[test]
fn path_constraint_on_the_speed_makes_the_cart_coast() {
    for points in [PathPoints::Ends, PathPoints::Stages, PathPoints::Both] {
        let mut settings = one_start();
        settings.path_points = points;
        let solution = solve(&Limited::default(), 5, &settings);
        // Half a metre per second after 1 s and 0.25 m, then 1.5 s for the rest: five intervals of half a second.
        assert!(
            (solution.horizon - 2.5).abs() < DIGITS,
            "{points:?}: {}",
            solution.horizon
        );
        let excess = most_exceeded(&solution);
        assert!(excess < 1e-7, "{points:?}: {excess}");
    }
}

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
    settings.path_points = PathPoints::Ends;
    let everywhere = solve(&spring, 8, &settings);
    let excess = most_exceeded(&everywhere);
    assert!(excess < 1e-8, "{excess}");
    settings.bounds_at_nodes = true;
    let nodes = solve(&spring, 8, &settings);
    let excess = &nodes.excess[0];
    assert_eq!([&excess.name[..], &excess.unit], ["room", "m^2"]);
    assert!(excess.amount > 1e-5 && (0.0..=2.0).contains(&excess.time));
    // More room cannot be worse. The plan's violation is also that of the re-simulated motion, as far as its
    // points come near the place.
    assert!(nodes.objective < everywhere.objective - 1e-7);
    let motion = nodes.motion.unwrap();
    let farthest = motion
        .trajectory
        .q
        .iter()
        .map(|q| q[0].abs())
        .fold(0.0, f64::max);
    assert!((farthest * farthest - 0.09 - excess.amount).abs() < 0.1 * excess.amount);
}
