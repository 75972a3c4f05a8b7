//! The event-driven simulator on random scenes: every run reaches its horizon, penetrates nothing, pulls
//! nowhere and gains no energy.

use crate::common::laws::RoughCrate;
use crate::common::scenes;
use crate::common::{check_energy, gap_at, same_in_every_run, start};
use hangtime::model::Model;
use hangtime::simulation::{
    ControlSignal, EventDriven, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};
use proptest::prelude::*;

fn tolerances() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![1e-4, 1e-6, 1e-9, 1e-12])
}

/// Runs and checks everything but the energy.
fn checked(
    model: &dyn Model,
    problem: &InitialValueProblem,
    tolerance: f64,
) -> Result<Simulation, TestCaseError> {
    let simulator = EventDriven {
        tolerance,
        ..EventDriven::default()
    };
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
    let trajectory = &simulation.trajectory;
    for k in 0..trajectory.time.len() {
        for contact in 0..model.declaration().contacts.len() {
            let gap = gap_at(model, trajectory, contact, k);
            // Closed gaps are known to 1e-12, and dips of a few times that are no crossings.
            prop_assert!(gap >= -1e-11, "gap {} at {}", gap, trajectory.time[k]);
        }
    }
    // Rounding error of gaps and velocities of order one.
    prop_assert!(simulation.residuals.primal <= 1e-11);
    // Forces up to some hundreds vanish to rounding error at a take-off.
    prop_assert!(simulation.residuals.dual <= 1e-9);
    Ok(simulation)
}

proptest! {
    #![proptest_config(same_in_every_run(150))]

    #[test]
    fn bar_thrown_onto_the_ground_loses_energy_and_comes_to_its_horizon(
        (front, rear, radius) in (0.2..2.0, 0.2..2.0, 0.1..2.5),
        (angle, height) in (-0.6..0.6_f64, 0.0..0.5),
        (fall, spin) in (-3.0..3.0, -3.0..3.0),
        tolerance in tolerances(),
    ) {
        let model = scenes::bar(front, rear, radius);
        let z = f64::max(front, rear) * angle.abs().sin() + height;
        let problem = start(&[0.0, z, angle], &[1.0, fall, spin], 2.0);
        let simulation = checked(&model, &problem, tolerance)?;
        check_energy(&model, &simulation, tolerance)?;
    }

    #[test]
    fn mass_on_waves_flies_lands_and_slides_without_gaining_energy(
        (height, number) in (0.02..1.0, 0.3..8.0),
        (y, above) in (-3.0..3.0, prop::sample::select(vec![0.0, 0.1, 0.8])),
        (along, up) in (-6.0..6.0, -3.0..3.0),
        tolerance in tolerances(),
    ) {
        let model = scenes::waves(height, number);
        let z = height * f64::cos(number * y) + above;
        let problem = start(&[y, z], &[along, up], 2.0);
        let simulation = checked(&model, &problem, tolerance)?;
        check_energy(&model, &simulation, tolerance)?;
    }

    #[test]
    fn crate_tumbling_between_walls_comes_to_its_horizon(
        (half_width, half_height) in (0.1..0.5, 0.1..0.5),
        (y, z, angle) in (-0.2..0.2, 0.75..1.5, -3.0..3.0),
        (along, up, spin) in (-4.0..4.0, -3.0..3.0, -3.0..3.0),
        tolerance in tolerances(),
    ) {
        let model = RoughCrate { half_width, half_height, ..RoughCrate::default() };
        let problem = start(&[y, z, angle], &[along, up, spin], 2.0);
        let simulation = checked(&model, &problem, tolerance)?;
        check_energy(&model, &simulation, tolerance)?;
    }

    #[test]
    fn hopper_with_random_controls_comes_to_its_horizon(
        (foot, stretch) in (prop::sample::select(vec![0.0, 0.05, 0.2]), 0.2..0.8),
        (foot_speed, body_speed) in (-2.0..2.0, -3.0..3.0),
        forces in prop::collection::vec(-100.0..60.0, 10),
        tolerance in tolerances(),
    ) {
        let model = scenes::hopper();
        let problem = InitialValueProblem {
            controls: ControlSignal::PiecewiseConstant {
                times: (0..10).map(|k| 0.2 * f64::from(k)).collect(),
                values: forces.into_iter().map(|force: f64| vec![force]).collect(),
            },
            ..start(&[foot, foot + stretch], &[foot_speed, body_speed], 2.0)
        };
        checked(&model, &problem, tolerance)?;
    }
}
