//! Coulomb friction where normal and tangential directions couple, or several contacts share: closed forms by every simulator that locates
//! events, Painleve's paradox, random motions.

use crate::common::event::run;
use crate::common::laws::{Rod, Room, Table};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, same_in_every_run, start};
use hangtime::simulation::{EventDriven, SimulationStatus};
use proptest::prelude::*;

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
