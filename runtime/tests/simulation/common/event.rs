//! Runs, and what holds of those by the event-driven simulator.

use super::gap_at;
use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, EventKind, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

pub(crate) fn accurate() -> EventDriven {
    EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    }
}

pub(crate) fn run(
    simulator: &dyn Simulator,
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Simulation {
    simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted")
}

/// Kinds and contacts of the events, in order.
pub(crate) fn sequence(simulation: &Simulation) -> Vec<(EventKind, usize)> {
    simulation
        .events
        .iter()
        .map(|event| (event.kind, event.contact))
        .collect()
}

/// What holds after every run that reached the horizon.
pub(crate) fn check_consistency(model: &dyn Model, simulation: &Simulation) {
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let trajectory = &simulation.trajectory;
    for pair in trajectory.time.windows(2) {
        assert!(pair[0] <= pair[1]);
    }
    for (numerical, physical) in trajectory
        .numerical_time
        .windows(2)
        .zip(trajectory.time.windows(2))
    {
        // Numerical time passes at least as fast as physical time; both carry rounding error.
        assert!(numerical[1] - numerical[0] >= physical[1] - physical[0] - 1e-13);
    }
    for k in 0..trajectory.time.len() {
        for contact in 0..trajectory.contact_force[k].len() {
            let gap = gap_at(model, trajectory, contact, k);
            assert!(gap >= -1e-11, "gap {gap:e} at {}", trajectory.time[k]);
            let force = trajectory.contact_force[k][contact];
            assert!(force >= -1e-9, "force {force:e}");
            if force > 0.0 {
                assert!(gap.abs() <= 1e-12, "gap {gap:e} in contact");
            }
        }
    }
}
