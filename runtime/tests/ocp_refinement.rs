//! Plans that the first grid cannot resolve.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::ocp::{self, Component, Goal, Horizon, Objective, Problem, Settings, Status};

hangtime::model! {
    /// A ball over a cushion that is soft far away and stiff nearby.
    Cushion {
        parameters { m: kg = 1, g: m/s^2 = 9.81, p: N = 1, d: m = 0.05 }
        coordinates { y: m, z: m }
        controls { u: N, w: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z - p*d*exp(-z/d)
        forces { y: u, z: w }
        start { z: 1 [m] }
    }
}

#[test]
fn stiff_bounce_gets_more_elements_where_it_happens() {
    let model = Cushion::default();
    let goals = vec![
        Goal {
            component: Component::Coordinate(0),
            value: 1.0,
        },
        Goal {
            component: Component::Coordinate(1),
            value: 1.1,
        },
    ];
    let problem = Problem {
        horizon: Horizon::Fixed(1.0),
        ..Problem::new(&model, Objective::effort(), goals, 8)
    };
    for d in [0.02, 0.05, 0.1] {
        let model = Cushion {
            d,
            ..Cushion::default()
        };
        let solution = ocp::solve(&model, &problem, &Settings::default(), &mut |_| true).unwrap();
        println!(
            "{:?} {:?} {:e} {:?} {:?} {:?}",
            solution.status,
            solution.diagnosis(),
            solution.resimulation_error,
            solution.elements,
            solution.counts,
            solution.objective
        );
        let lowest = solution
            .motion
            .unwrap()
            .trajectory
            .q
            .iter()
            .enumerate()
            .min_by(|a, b| a.1[1].total_cmp(&b.1[1]))
            .map(|(k, q)| (k, q[1]));
        println!("{lowest:?}");
    }
    assert_eq!(1, 2);
}
