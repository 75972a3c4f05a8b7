//! Surfaces with edges: random motions by two methods.

#![allow(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::{distance, last};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, SimulationStatus, Simulator};

hangtime::model! {
    /// A ball among a hut and a post on a floor.
    Yard {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.4, mu = 0.1, y0: m = 0, z0: m = 1.5, vy: m/s = 1, vz: m/s = 0 }
        coordinates { y: m, z: m }
        fn hut(y, z) = max(z - 0.6 [m], z + |y| - 0.8 [m])
        fn post(y, z) = max(z - 0.9 [m], |y - 2 [m]| - 0.3 [m])
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: min(z, hut(y, z), post(y, z)) >= 0
        impact ground: restitution e, friction mu
        start { y: y0, z: z0, dot(y): vy, dot(z): vz }
        horizon 1.5 [s]
    }
}

/// Random numbers between two bounds.
fn random(mut seed: u64) -> impl FnMut(f64, f64) -> f64 {
    move |low, high| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        low + (high - low) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn random_throws_among_edges_are_the_same_by_two_methods() {
    let mut random = random(20_261_121);
    let (mut solved, mut events, mut edges) = (0, 0, 0);
    for case in 0..100 {
        // Half of them slide over the tops and their edges.
        let (e, y0, z0, vz) = match case % 4 {
            0 => (0.0, random(-0.15, 0.15), 0.61, 0.0),
            2 => (0.0, random(1.75, 2.25), 0.91, 0.0),
            _ => (
                random(0.0, 0.8),
                random(-1.5, 3.5),
                random(1.0, 1.6),
                random(-2.0, 2.0),
            ),
        };
        let yard = Yard {
            e,
            mu: random(0.0, 0.4),
            y0,
            z0,
            vy: random(-3.0, 3.0),
            vz,
            ..Yard::default()
        };
        let problem = InitialValueProblem::of(&yard, None).unwrap();
        let run = Fesd::default()
            .simulate(&yard, &problem, &mut |_| true)
            .unwrap();
        let event = EventDriven {
            tolerance: 1e-11,
            ..EventDriven::default()
        };
        let other = event.simulate(&yard, &problem, &mut |_| true).unwrap();
        // Whatever is said to be solved lies above the ground.
        for q in &run.trajectory.q {
            let hut = (q[1] - 0.6).max(q[1] + q[0].abs() - 0.8);
            let post = (q[1] - 0.9).max((q[0] - 2.0).abs() - 0.3);
            assert!(q[1].min(hut).min(post) > -1e-9, "{case}: {yard:?} at {q:?}");
        }
        if run.status != SimulationStatus::Solved || other.status != SimulationStatus::Solved {
            continue;
        }
        solved += 1;
        events += run.events.len();
        edges += usize::from(run.events.iter().any(|e| {
            let ends = |at: f64| (e.q[0] - at).abs() < 1e-9;
            e.kind == EventKind::LiftOff && [-0.2, 0.2, 1.7, 2.3].into_iter().any(ends)
        }));
        let (ours, theirs) = (last(&run.trajectory), last(&other.trajectory));
        let off = distance(ours.0, theirs.0).max(distance(ours.1, theirs.1));
        assert!(
            off < 1e-5,
            "{case}: off by {off:e}, {yard:?}\n{run}\n{other}"
        );
    }
    assert!(solved >= 97, "{solved} solved");
    assert!(
        events > 500 && edges > 10,
        "{events} events, {edges} runs past an edge"
    );
}
