//! Coulomb friction where normal and tangential directions couple: Painleve's paradox on the way, random motions.

use crate::common::event::run;
use crate::common::laws::{Rod, Room, Table};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, same_in_every_run, start};
use hangtime::simulation::{EventDriven, SimulationStatus};
use proptest::prelude::*;

#[test]
fn rod_whose_force_grows_without_bound_ends_with_the_paradox_by_name() {
    // Slides towards the angle at which 1 - mu |n'e| vanishes; its force passes 1e5 N on the way there.
    let (mu, angle, spin): (f64, f64, f64) = (1.9169, 2.5735, -2.2747);
    let model = Rod {
        mu,
        ..Rod::default()
    };
    let v = [7.1806 - angle.sin() * spin, angle.cos() * spin, spin];
    let mut times = Vec::new();
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let simulator = EventDriven {
            tolerance,
            ..EventDriven::default()
        };
        let problem = start(&[0.0, angle.sin(), angle], &v, 1.0);
        let simulation = run(&simulator, &model, &problem);
        let SimulationStatus::AmbiguousContact(diagnosis) = &simulation.status else {
            panic!("{:?}", simulation.status);
        };
        assert!(diagnosis.message.contains("`tip`"), "{}", diagnosis.message);
        assert!(
            diagnosis.message.contains("Painleve"),
            "{}",
            diagnosis.message
        );
        assert!(simulation.events.is_empty());
        let force = simulation.trajectory.contact_force.last().unwrap()[0];
        assert!(force > 1e5, "{force}");
        times.push(diagnosis.time);
    }
    // The time of the pole is that of the motion, whatever the steps: errors of 1e-6 and below.
    assert!(
        (times[0] - times[2]).abs() < 1e-5 && (times[1] - times[2]).abs() < 1e-8,
        "{times:?}"
    );
}

#[test]
fn rod_that_slides_into_the_paradox_ends_with_a_status() {
    let model = Rod {
        mu: 1.8,
        ..Rod::default()
    };
    for tenth in 7..16 {
        let angle = f64::from(tenth) / 10.0;
        for sliding in [-6.0, -3.0, -1.0, 1.0, 3.0] {
            let v = [sliding, 0.0, 0.0];
            let simulation = run(
                &EventDriven::default(),
                &model,
                &start(&[0.0, angle.sin(), angle], &v, 2.0),
            );
            match &simulation.status {
                SimulationStatus::Solved => {}
                SimulationStatus::AmbiguousContact(diagnosis) => {
                    assert!(
                        diagnosis.message.contains("Painleve"),
                        "{}",
                        diagnosis.message
                    );
                }
                other => panic!("{angle} {sliding} {other:?}"),
            }
        }
    }
}

proptest! {
    #![proptest_config(same_in_every_run(100))]

    #[test]
    fn thrown_table_with_friction_comes_to_its_horizon_without_gaining_energy(
        (mu, feet) in (0.0..1.0_f64, 0.1..1.0_f64),
        (angle, above) in (-0.5..0.5_f64, 0.0..0.5),
        (along, up, spin) in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
        stiffness in prop::sample::select(vec![0.0, 20.0]),
    ) {
        let model = Table { height: feet, stiffness, mu, ..Table::default() };
        let z = angle.sin().abs() + feet * angle.cos() + above;
        let problem = start(&[0.0, z, angle], &[along, up, spin], 2.0);
        let simulation = run(&EventDriven::default(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
        prop_assert!(simulation.residuals.primal <= 1e-11);
        prop_assert!(simulation.residuals.dual <= 1e-9);
    }

    #[test]
    fn rod_with_friction_falls_without_gaining_energy(
        mu in 0.0..1.3_f64,
        angle in 0.2..1.5_f64,
        (above, along, up, spin) in (0.0..0.5, -3.0..3.0, -3.0..3.0, -3.0..3.0),
    ) {
        let model = Rod { mu, ..Rod::default() };
        let problem = start(&[0.0, angle.sin() + above, angle], &[along, up, spin], 1.0);
        let simulation = run(&EventDriven::default(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
    }

    #[test]
    fn ball_in_a_room_with_all_laws_comes_to_its_horizon(
        (e, mu) in (0.0..1.0_f64, 0.0..1.0_f64),
        (y, z, along, up) in (0.0..1.0, 0.0..1.0, -5.0..5.0, -5.0..5.0),
    ) {
        let model = Room { gravity: GRAVITY, e, mu, ..Room::default() };
        let simulation = run(&EventDriven::default(), &model, &start(&[y, z], &[along, up], 5.0));
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
    }
}
