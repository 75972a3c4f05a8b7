//! Control intervals that are divided among the phases between contacts.

use hangtime::model::Model;
use hangtime::ocp::{ControlNodes, Settings, Solution};
use hangtime::prelude::{ControlSignal, simulate};

use crate::support::attempt;

hangtime::model! {
    /// A cart is driven from rest against a wall, and comes back to where it was at speed, in least time.
    ToTheWall {
        parameters { m: kg = 2, far: m = 1.3, e = 0.45 }
        coordinates { y: m }
        controls { u: N in -3..=3 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        surface wall: y >= 0
        impact wall: restitution e
        start { y: far }
        minimize time
        finally { y == far, dot(y) >= 2.1[m/s] }
    }
}

fn solve(model: &dyn Model, intervals: usize, grid: ControlNodes) -> Solution {
    let mut settings = Settings::default();
    settings.grid = grid;
    attempt(model, intervals, &settings)
}

#[test]
fn controls_change_at_the_contact_on_a_divided_grid_and_beside_it_on_an_equal_one() {
    let cart = ToTheWall::default();
    let there = f64::sqrt(2.0 * 1.3 / 1.5);
    for intervals in [2, 5] {
        let solution = solve(&cart, intervals, ControlNodes::Aligned);
        let times = &solution.control_times;
        assert_eq!(
            (times.len(), solution.controls.len()),
            (intervals + 1, intervals)
        );
        assert!(
            times.iter().any(|time| (time - there).abs() < 1e-7),
            "{times:?}"
        );
        // The controls over time lead a simulation to the goal.
        let run = simulate(&cart)
            .controls(solution.signal())
            .horizon(solution.horizon)
            .run();
        let run = run.expect("a good problem");
        let end = run.trajectory.q.last().expect("an end")[0];
        assert!((end - cart.far).abs() < 1e-7, "{end}");
        assert!(matches!(
            solution.signal(),
            ControlSignal::PiecewiseConstant { .. }
        ));
    }
    let equal = solve(&cart, 5, ControlNodes::Equal);
    let fifth = 0.2 * equal.horizon;
    assert!((equal.control_times[1] - fifth).abs() < 1e-12);
}
