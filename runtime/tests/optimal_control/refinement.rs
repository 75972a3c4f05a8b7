//! Plans that the first grid cannot resolve.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{attempt, one_start};
use hangtime::ocp::{self, ControlShape, Problem, Settings, Solution, Status};
use hangtime::simulation::{Fesd, InitialValueProblem, Simulator};

hangtime::model! {
    /// A cart that has to pass a narrow magnet on its way.
    Passage {
        parameters { m: kg = 1, depth: J = 0.2, place: m = 0.3, width: m = 0.02 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2 + depth*exp(-((y - place)/width)^2/2)
        forces { y: u }
        minimize integral(u^2)
        finally { y == 1[m], dot(y) == 0[m/s] }
        horizon 1 [s]
    }
}

const INTERVALS: usize = 8;

/// From rest to rest over 1 m in 1 s.
fn pass(model: &Passage, settings: &Settings) -> Solution {
    let problem = Problem::of(model, INTERVALS);
    let solution = ocp::solve(model, &problem, settings, &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    solution
}

/// Whether the cart is in the magnet at any time of each interval: 5 widths from it, its force is 2e-5 of its largest.
fn in_the_magnet(model: &Passage, solution: &Solution) -> Vec<bool> {
    let trajectory = &solution.motion.as_ref().unwrap().trajectory;
    let mut inside = vec![false; INTERVALS];
    for (time, q) in trajectory.time.iter().zip(&trajectory.q) {
        let interval = ((time * INTERVALS as f64) as usize).min(INTERVALS - 1);
        inside[interval] |= (q[0] - model.place).abs() < 5.0 * model.width;
    }
    inside
}

#[test]
fn elements_grow_where_the_plan_departs_from_the_motion_and_nowhere_else() {
    for controls in [ControlShape::Constant, ControlShape::Linear] {
        let model = Passage::default();
        let mut settings = one_start();
        settings.controls = controls;
        let solution = pass(&model, &settings);
        assert!(solution.resimulation_error < settings.largest_distance);
        let inside = in_the_magnet(&model, &solution);
        assert!(inside.iter().any(|&inside| inside) && inside.iter().any(|&inside| !inside));
        for (interval, (&elements, inside)) in solution.elements.iter().zip(inside).enumerate() {
            assert_eq!(elements > 1, inside, "{elements} in interval {interval}");
        }
        // A method that had no part in the plan ends at the goal as well.
        let problem = InitialValueProblem {
            controls: solution.signal(),
            ..InitialValueProblem::of(&model, Some(1.0)).unwrap()
        };
        let simulation = Fesd::default()
            .with_tolerance(1e-11)
            .simulate(&model, &problem, &mut |_| true)
            .unwrap();
        let reached = simulation.trajectory.q.last().unwrap()[0];
        assert!(
            (reached - 1.0).abs() < settings.largest_distance,
            "{reached}"
        );
    }
}

#[test]
fn smaller_distances_ask_for_more_elements_and_coarse_scenes_for_none() {
    let mut settings = one_start();
    let count = |solution: &Solution| solution.elements.iter().sum::<usize>();
    let usual = pass(&Passage::default(), &settings);
    settings.largest_distance = 1e-9;
    let strict = pass(&Passage::default(), &settings);
    assert!(
        strict.resimulation_error < 1e-9,
        "{:e}",
        strict.resimulation_error
    );
    assert!(count(&strict) > count(&usual));
    let wide = Passage {
        width: 1.0,
        ..Passage::default()
    };
    let solution = pass(&wide, &one_start());
    assert_eq!(solution.elements, [1; INTERVALS]);
}

hangtime::model! {
    /// A car on a rail with a weak engine, in a valley with a springy buffer, has to get onto the hill in least time.
    Valley {
        parameters { m = 1, g = 10, e = 0.8 }
        coordinates { y }
        controls { u in -2..=2 }
        fn h(y) = 0.5*(1 - cos(2*y))
        lagrangian m/2*|dot((y, h(y)))|^2 - m*g*h(y)
        forces { y: u }
        surface buffer: y >= -0.5
        impact buffer: restitution e
        minimize time
        finally { y >= 1.5 }
        horizon 3
    }
}

#[test]
fn search_takes_finer_elements_where_most_plans_are_no_motions() {
    let solution = attempt(&Valley::default(), 12, &Settings::default());
    // With one element of half a second plans run through the hill.
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    assert!(solution.elements.iter().all(|&elements| elements >= 2));
}
