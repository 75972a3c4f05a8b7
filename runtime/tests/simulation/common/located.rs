//! The simulators that locate events, at their most accurate: every closed form is asked of each of them.

use super::event::accurate;
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator};

/// Event-driven, and finite elements of order nine, of controlled length.
pub(crate) fn located() -> [(&'static str, Box<dyn Simulator>); 2] {
    let elements = Fesd::default().with_scheme(Scheme::RadauIia, 5);
    [
        ("event-driven", Box::new(accurate())),
        (
            "elements",
            Box::new(elements.with_grid(1, 1).with_tolerance(1e-12)),
        ),
    ]
}

/// The motion by each of them, with its name; solved, without a fallback, with a row of friction forces for each
/// instant where the scene has friction.
pub(crate) fn motions(
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Vec<(&'static str, Simulation)> {
    let runs = located().map(|(name, simulator)| {
        let simulation = simulator
            .simulate(model, problem, &mut |_| true)
            .expect("the problem is accepted");
        assert_eq!(simulation.status, SimulationStatus::Solved, "{name}");
        assert_eq!(simulation.counts.fallbacks, 0, "{name}");
        let trajectory = &simulation.trajectory;
        let rows = trajectory.friction_force.len();
        assert!(rows == 0 || rows == trajectory.time.len(), "{name}");
        (name, simulation)
    });
    runs.into()
}

/// How the motion ends by each of them, whatever the end.
pub(crate) fn endings(
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Vec<(&'static str, Simulation)> {
    let runs = located().map(|(name, simulator)| {
        let simulation = simulator.simulate(model, problem, &mut |_| true);
        (name, simulation.expect("the problem is accepted"))
    });
    runs.into()
}
