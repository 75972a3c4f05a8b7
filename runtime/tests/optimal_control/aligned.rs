//! Control intervals that are divided among the phases between contacts.

use hangtime::model::Model;
use hangtime::ocp::{
    self, ControlNodes, ControlShape, Formulation, Problem, Settings, Solution, Status,
    TimeFreezingSettings,
};
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

hangtime::model! {
    /// A stone is thrown over a fence.
    Thrown {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: z >= 0
        impact ground: inelastic
        start { z: 1[m] }
        free { dot(y) in 0..=9, dot(z) in -1..=9 }
        minimize time
        finally { y == 3[m] }
    }
}

fn solve(model: &dyn Model, intervals: usize, grid: ControlNodes) -> Solution {
    let mut settings = Settings::default();
    settings.grid = grid;
    attempt(model, intervals, &settings)
}

#[test]
fn two_intervals_are_enough_where_the_controls_change_with_the_contact() {
    let cart = ToTheWall::default();
    // Pushed with u towards the wall, struck with v, and pushed away: far = u/m t^2/2 = e v t' + u/m t'^2/2, and there it is faster than
    // asked for; with a run-up on the other side it took 3.4 s.
    let (a, far, e) = (3.0 / 2.0, 1.3, 0.45);
    let there = f64::sqrt(2.0 * far / a);
    let off = e * a * there;
    let back = (f64::sqrt(off * off + 2.0 * a * far) - off) / a;
    for intervals in [2, 5] {
        let solution = solve(&cart, intervals, ControlNodes::Aligned);
        assert_eq!(
            solution.status,
            Status::Solved,
            "{:?}",
            solution.diagnosis()
        );
        assert!(
            (solution.objective - (there + back)).abs() < 1e-8,
            "{}",
            solution.objective
        );
        let times = &solution.control_times;
        assert_eq!(
            (times.len(), solution.controls.len()),
            (intervals + 1, intervals)
        );
        assert!(
            times.iter().any(|time| (time - there).abs() < 1e-7),
            "{times:?}"
        );
        let impacts: Vec<f64> = solution
            .planned_events
            .iter()
            .map(|event| event.0)
            .collect();
        assert!(
            impacts.len() == 1 && (impacts[0] - there).abs() < 1e-7,
            "{impacts:?}"
        );
        // The controls over time lead a simulation to the goal.
        let run = simulate(&cart)
            .controls(solution.signal())
            .horizon(solution.horizon)
            .run();
        let end = run
            .expect("a good problem")
            .trajectory
            .q
            .last()
            .expect("an end")[0];
        assert!((end - far).abs() < 1e-7, "{end}");
        assert!(matches!(
            solution.signal(),
            ControlSignal::PiecewiseConstant { .. }
        ));
    }
    // With a clock the controls change beside the impact.
    let equal = solve(&cart, 5, ControlNodes::Equal);
    assert!(
        equal.objective > 1.002 * (there + back),
        "{}",
        equal.objective
    );
    let fifth = 0.2 * equal.horizon;
    assert!((equal.control_times[1] - fifth).abs() < 1e-12);
}

#[test]
fn aligned_grid_is_refused_where_nothing_is_divided() {
    let cart = ToTheWall::default();
    let refused = |model: &dyn Model, change: &dyn Fn(&mut Settings)| {
        let mut settings = Settings::default();
        settings.grid = ControlNodes::Aligned;
        change(&mut settings);
        let error = ocp::solve(model, &Problem::of(model, 4), &settings, &mut |_| true);
        error.expect_err("refused").to_string()
    };
    for change in [
        (|s: &mut Settings| s.controls = ControlShape::Linear) as fn(&mut Settings),
        |s| s.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default()),
    ] {
        assert!(refused(&cart, &change).contains("equal grid"));
    }
    let thrown = refused(&Thrown::default(), &|_| ());
    assert!(thrown.contains("without controls"), "{thrown}");
}
