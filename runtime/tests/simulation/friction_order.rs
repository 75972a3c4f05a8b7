//! Coulomb friction in the finite element simulator keeps its order.

use crate::common::laws::{Ground, Pulled};
use crate::common::{distance, last, order, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

fn solve(simulator: &Fesd, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let rows = simulation.trajectory.friction_force.len();
    assert_eq!(rows, simulation.trajectory.time.len());
    simulation
}

fn kinds(simulation: &Simulation) -> Vec<EventKind> {
    simulation.events.iter().map(|event| event.kind).collect()
}

/// Errors of the state at the end with `stages` against a run of order 13.
fn errors(
    model: &dyn Model,
    problem: &InitialValueProblem,
    stages: usize,
    steps: &[usize],
    events: &[EventKind],
) -> Vec<(usize, f64)> {
    let end = |simulator: &Fesd| {
        let simulation = solve(simulator, model, problem);
        assert_eq!(kinds(&simulation), events, "{stages} stages");
        let (q, v) = last(&simulation.trajectory);
        [q, v].concat()
    };
    let exact = end(&Fesd::default()
        .with_scheme(Scheme::RadauIia, 7)
        .with_grid(80, 1));
    steps
        .iter()
        .map(|&count| {
            let simulator = Fesd::default()
                .with_scheme(Scheme::RadauIia, stages)
                .with_grid(count, 1);
            (count, distance(&end(&simulator), &exact))
        })
        .collect()
}

/// Step counts where the leading error term dominates and rounding does not.
const STEPS: [(usize, &[usize]); 4] = [
    (1, &[640, 1280, 2560]),
    (2, &[80, 160, 320]),
    (3, &[40, 80, 160]),
    (4, &[20, 40, 80]),
];

#[test]
fn order_is_kept_through_turning_round_and_sticking_on_curved_ground() {
    let model = Ground {
        curvature: 1.5,
        mu: 0.25,
        ..Ground::default()
    };
    let problem = start(&[0.8, 0.48], &[0.0, 0.0], 3.0);
    let events = [EventKind::Slip, EventKind::Stick];
    for (stages, steps) in STEPS {
        let errors = errors(&model, &problem, stages, steps, &events);
        let measured = order(&errors);
        let expected = (2 * stages - 1) as f64;
        assert!(
            measured > expected - 0.3,
            "{stages} stages: {measured} of {expected}: {errors:?}"
        );
    }
}

#[test]
fn order_is_kept_through_the_start_of_a_slip() {
    let model = Pulled {
        mu: 0.4,
        stiffness: 5.0,
        hardening: 40.0,
        ..Pulled::default()
    };
    let problem = start(&[0.0; 3], &[0.0, 0.0, 1.5], 1.0);
    for (stages, steps) in STEPS {
        let errors = errors(&model, &problem, stages, steps, &[EventKind::Slip]);
        let measured = order(&errors);
        let expected = (2 * stages - 1) as f64;
        assert!(
            measured > expected - 0.3,
            "{stages} stages: {measured} of {expected}: {errors:?}"
        );
    }
}
