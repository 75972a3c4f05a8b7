//! Optimal control with Coulomb friction, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::model::Model;
use hangtime::ocp::{self, Problem, Settings, Solution, Status};
use hangtime::simulation::EventKind;

/// The solver's tolerance is 1e-9, that of the re-simulation 1e-12.
const DIGITS: f64 = 1e-7;
const GRAVITY: f64 = 9.81;

fn solve(model: &dyn Model, intervals: usize, settings: &Settings) -> Solution {
    let problem = Problem::of(model, intervals);
    let solution = ocp::solve(model, &problem, settings, &mut |_| true).unwrap();
    if std::env::var("OCP_VERBOSE").is_ok() {
        eprintln!(
            "{:?} {:?} {:.12} {} {:e} {:?} {:?} {:?} {:?}",
            solution.status,
            solution.stationarity,
            solution.objective,
            solution.horizon,
            solution.resimulation_error,
            solution.planned_events,
            solution.counts,
            solution.controls,
            solution.diagnosis(),
        );
    }
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    solution
}

fn kinds(solution: &Solution) -> Vec<EventKind> {
    solution.planned_events.iter().map(|event| event.1).collect()
}

hangtime::model! {
    /// A block that is pushed over a floor with friction, as fast as possible from rest to rest.
    Block {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.3, d: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d, dot(y) == 0 }
    }
}

#[test]
fn block_from_rest_to_rest_accelerates_and_brakes_with_the_help_of_friction() {
    let solution = solve(&Block::default(), 8, &Settings::default());
    // v_y grows with a = F/m - mu g and falls with b = F/m + mu g: T = sqrt(2 d (1/a + 1/b)), and the force may
    // take any value in the interval in which it turns round: d fixes the impulse only up to the grid's choice, so
    // that the optimum on 8 intervals is not below this.
    let (a, b) = (5.0 - 0.3 * GRAVITY, 5.0 + 0.3 * GRAVITY);
    let bound = (2.0 * (1.0 / a + 1.0 / b)).sqrt();
    assert!(solution.horizon >= bound - DIGITS && solution.horizon < 1.02 * bound);
}
