//! Goals that leave an impact one time only.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::solve;
use hangtime::ocp::{self, Horizon, Problem, Settings};

hangtime::model! {
    /// Three equal elastic balls: the first one is pushed, and the last one passes a mark at 1 m/s in the end. It is struck one second before
    /// the end, and the second one 0.4 s before that: no guess and no relaxed motion has impacts there, and some grids a node.
    Relay {
        coordinates { a, b, c }
        controls { u in -5..=5 }
        lagrangian (dot(a)^2 + dot(b)^2 + dot(c)^2)/2
        forces { a: u }
        surface first: b - a - 0.1 >= 0
        surface second: c - b - 0.1 >= 0
        impact first, second: restitution 1
        minimize integral(u^2)
        finally { c == 2, dot(c) == 1 }
        start { b: 0.5, c: 1 }
        horizon 2.5
    }
}

/// Least effort that brings the first ball 0.4 m on at 1 m/s at the first impact, by forces on intervals of length `h`: a combination
/// of the rows of way and velocity.
fn least_effort(horizon: f64, intervals: usize) -> f64 {
    let (h, impact) = (horizon / intervals as f64, horizon - 1.4);
    let left = |k: usize| (impact - k as f64 * h).max(0.0);
    let rows = (0..intervals).map(|k| {
        let (from, to) = (left(k), left(k + 1));
        (0.5 * (from * from - to * to), from - to)
    });
    let (a, b, c) = rows.fold((0.0, 0.0, 0.0), |(a, b, c), (way, v)| {
        (a + way * way, b + way * v, c + v * v)
    });
    let (way, v) = (0.4, 1.0);
    h * (c * way * way - 2.0 * b * way * v + a * v * v) / (a * c - b * b)
}

#[test]
fn impacts_are_found_where_alone_they_may_be() {
    let relay = Relay::default();
    for (horizon, intervals) in [(2.5, 10), (2.45, 10)] {
        let problem = Problem {
            horizon: Horizon::Fixed(horizon),
            ..Problem::of(&relay, intervals)
        };
        let solution = ocp::solve(&relay, &problem, &Settings::default(), &mut |_| true).unwrap();
        assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
        let best = least_effort(horizon, intervals);
        let off = (solution.objective - best).abs();
        assert!(off < 1e-11, "{intervals} {} {best}", solution.objective);
    }
}

hangtime::model! {
    /// A weakly driven cart between two walls that is to become fast.
    Walls {
        parameters { m: kg = 1, e = 0.9, w: m = 0.5 }
        coordinates { x: m }
        controls { u: N in -0.3..=0.3 }
        lagrangian m/2*dot(x)^2
        forces { x: u }
        surface walls: |x| <= w
        impact walls: restitution e
        minimize time
        finally { dot(x) == 1 [m/s] }
        horizon 4 [s]
    }
}

#[test]
fn cart_gains_speed_from_wall_to_wall_and_not_at_one_alone() {
    // By collocation with impacts on one wall and then on the other, on the same grids; by one wall alone it is 8.3 and 12.1 s.
    for (intervals, known) in [(8, 4.4033), (12, 4.1442)] {
        let found = solve(&Walls::default(), intervals, &Settings::default());
        assert!(
            found.horizon < known + 1e-4,
            "{intervals}: {}",
            found.horizon
        );
    }
}
