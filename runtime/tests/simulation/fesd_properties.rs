//! Finite elements with switch detection on random scenes: every run reaches its horizon, penetrates no
//! more than its tolerance explains, and gains no energy.

use crate::common::laws::{Ground, RoughCrate};
use crate::common::scenes;
use crate::common::{check_energy, gap_at, same_in_every_run, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};
use proptest::prelude::*;

/// Stages and tolerance.
fn settings() -> impl Strategy<Value = (usize, f64)> {
    (3..6_usize, prop::sample::select(vec![1e-6, 1e-9]))
}

fn checked(
    model: &dyn Model,
    problem: &InitialValueProblem,
    (stages, tolerance): (usize, f64),
) -> Result<Simulation, TestCaseError> {
    let simulation = Fesd::default()
        .with_scheme(Scheme::RadauIia, stages)
        .with_grid(1, 1)
        .with_tolerance(tolerance)
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    // Where impacts follow too fast to be told apart the event-driven method confirms the usual promise only.
    let joined = matches!(&simulation.status, SimulationStatus::Inaccurate(diagnosis)
        if diagnosis.message.starts_with("impacts follow too fast"));
    let estimate = simulation.error_estimate.unwrap_or(f64::INFINITY);
    prop_assert!(
        simulation.status.is_solved() || joined && estimate <= 1e-6,
        "{:?}, estimate {}",
        simulation.status,
        estimate
    );
    let trajectory = &simulation.trajectory;
    for k in 0..trajectory.time.len() {
        for contact in 0..model.declaration().contacts.len() {
            let gap = gap_at(model, trajectory, contact, k);
            // A contact that was just released may be violated by the local error of its element.
            prop_assert!(
                gap >= -100.0 * tolerance,
                "gap {} at {}",
                gap,
                trajectory.time[k]
            );
        }
    }
    Ok(simulation)
}

/// Largest product of a gap and a normal acceleration: contacts count as touching at gaps up to 1e-9 of the
/// largest coordinate, at least 1, and `accelerations` are what carries them.
fn check_complementarity(simulation: &Simulation, accelerations: f64) -> Result<(), TestCaseError> {
    let residual = simulation.residuals.complementarity;
    let positions = simulation.trajectory.q.iter().flatten();
    let largest = positions.fold(1.0_f64, |largest, q| largest.max(q.abs()));
    prop_assert!(residual <= 1e-9 * largest * accelerations, "{:e}", residual);
    Ok(())
}

proptest! {
    #![proptest_config(same_in_every_run(100))]

    #[test]
    fn bar_thrown_onto_the_ground_loses_energy_and_comes_to_its_horizon(
        (front, rear, radius) in (0.2..2.0, 0.2..2.0, 0.1..2.5),
        (angle, height) in (-0.6..0.6_f64, 0.0..0.5),
        (fall, spin) in (-3.0..3.0, -3.0..3.0),
        settings in settings(),
    ) {
        let model = scenes::bar(front, rear, radius);
        let z = f64::max(front, rear) * angle.abs().sin() + height;
        let problem = start(&[0.0, z, angle], &[1.0, fall, spin], 2.0);
        let simulation = checked(&model, &problem, settings)?;
        check_complementarity(&simulation, 10.0)?;
        check_energy(&model, &simulation, settings.1)?;
    }

    #[test]
    fn mass_on_waves_flies_lands_and_slides_without_gaining_energy(
        (height, number) in (0.02..1.0, 0.3..8.0),
        (y, above) in (-3.0..3.0, prop::sample::select(vec![0.0, 0.1, 0.8])),
        (along, up) in (-6.0..6.0, -3.0..3.0),
        settings in settings(),
    ) {
        let model = scenes::waves(height, number);
        let z = height * f64::cos(number * y) + above;
        let problem = start(&[y, z], &[along, up], 2.0);
        let simulation = checked(&model, &problem, settings)?;
        check_complementarity(&simulation, 10.0)?;
        check_energy(&model, &simulation, settings.1)?;
    }

    #[test]
    fn crate_tumbling_between_walls_comes_to_its_horizon(
        (half_width, half_height) in (0.1..0.5, 0.1..0.5),
        (y, z, angle) in (-0.2..0.2, 0.75..1.5, -3.0..3.0),
        (along, up, spin) in (-4.0..4.0, -3.0..3.0, -3.0..3.0),
        settings in settings(),
    ) {
        let model = RoughCrate { half_width, half_height, ..RoughCrate::default() };
        let problem = start(&[y, z, angle], &[along, up, spin], 2.0);
        let simulation = checked(&model, &problem, settings)?;
        check_complementarity(&simulation, 10.0)?;
        check_energy(&model, &simulation, settings.1)?;
    }

    #[test]
    fn hopper_with_random_controls_comes_to_its_horizon(
        (foot, stretch) in (prop::sample::select(vec![0.0, 0.05, 0.2]), 0.2..0.8),
        (foot_speed, body_speed) in (-2.0..2.0, -3.0..3.0),
        forces in prop::collection::vec(-100.0..60.0, 10),
        settings in settings(),
    ) {
        let model = scenes::hopper();
        let problem = InitialValueProblem {
            controls: ControlSignal::PiecewiseConstant {
                times: (0..10).map(|k| 0.2 * f64::from(k)).collect(),
                values: forces.into_iter().map(|force: f64| vec![force]).collect(),
            },
            ..start(&[foot, foot + stretch], &[foot_speed, body_speed], 2.0)
        };
        let simulation = checked(&model, &problem, settings)?;
        check_complementarity(&simulation, 10.0)?;
    }

    #[test]
    fn rough_crate_tumbling_between_walls_comes_to_its_horizon(
        (half_width, half_height) in (0.1..0.5, 0.1..0.5),
        (y, z, angle) in (-0.2..0.2, 0.75..1.5, -3.0..3.0),
        (along, up, spin) in (-4.0..4.0, -3.0..3.0, -3.0..3.0),
        friction in prop::sample::select(vec![0.1, 0.3, 0.6]),
        settings in settings(),
    ) {
        let model = RoughCrate { half_width, half_height, mu: friction, ..RoughCrate::default() };
        let problem = start(&[y, z, angle], &[along, up, spin], 2.0);
        let simulation = checked(&model, &problem, settings)?;
        // A crate wedged between floor and wall presses with several times its weight.
        check_complementarity(&simulation, 100.0)?;
        check_energy(&model, &simulation, settings.1)?;
    }

    #[test]
    fn rough_mass_on_waves_bounces_slides_and_sticks_without_gaining_energy(
        (height, number) in (0.02..0.4, 0.3..8.0),
        (y, above) in (-3.0..3.0, prop::sample::select(vec![0.0, 0.1, 0.8])),
        (along, up) in (-6.0..6.0, -3.0..3.0),
        (friction, restitution) in (0.0..1.2, prop::sample::select(vec![0.0, 0.4, 0.8])),
        settings in settings(),
    ) {
        let ground = Ground { height, number, ..Ground::default() };
        let model = Ground { mu: friction, e: restitution, ..ground.clone() };
        let problem = start(&[y, ground.height_at(y) + above], &[along, up], 2.0);
        let simulation = checked(&model, &problem, settings)?;
        check_complementarity(&simulation, 10.0)?;
        check_energy(&model, &simulation, settings.1)?;
    }
}
