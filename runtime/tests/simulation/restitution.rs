//! Restitution against closed forms, by every simulator that locates events.

use crate::common::event::{accurate, run};
use crate::common::laws::{Disc, Ground, Rod, Table};
use crate::common::{check_energy, same_in_every_run, start};
use hangtime::simulation::{EventDriven, SimulationStatus};
use proptest::prelude::*;

proptest! {
    #![proptest_config(same_in_every_run(100))]

    #[test]
    fn spinning_disc_with_any_laws_bounces_without_gaining_energy(
        (e, mu) in (0.0..1.0_f64, 0.0..1.5_f64),
        (slope, shape) in (-0.5..0.5_f64, 0.2..1.0),
        (height, along, up, spin) in (0.0..1.0, -4.0..4.0, -3.0..3.0, -20.0..20.0),
    ) {
        let model = Disc { radius: 0.3, shape, slope, e, mu, ..Disc::default() };
        let problem = start(&[0.0, 0.3 / slope.cos() + height, 0.0], &[along, up, spin], 2.0);
        let simulation = run(&EventDriven::default(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
        prop_assert!(simulation.residuals.primal <= 1e-11);
        prop_assert!(simulation.residuals.dual <= 1e-9);
    }

    #[test]
    fn ball_on_waves_bounces_without_gaining_energy(
        e in 0.0..1.0_f64,
        (height, number) in (0.02..0.5, 0.3..5.0),
        (y, above, along, up) in (-3.0..3.0, 0.0..1.0, -4.0..4.0, -3.0..3.0),
    ) {
        let model = Ground { e, height, number, ..Ground::default() };
        let z = height * f64::cos(number * y) + above;
        let simulation = run(&EventDriven::default(), &model, &start(&[y, z], &[along, up], 2.0));
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
    }

    #[test]
    fn table_without_friction_bounces_on_both_feet_without_gaining_energy(
        (e, feet) in (0.0..1.0_f64, 0.1..1.0_f64),
        (angle, above) in (-0.5..0.5_f64, 0.0..0.5),
        (along, up, spin) in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
    ) {
        let model = Table { height: feet, e, ..Table::default() };
        let z = angle.sin().abs() + feet * angle.cos() + above;
        let problem = start(&[0.0, z, angle], &[along, up, spin], 2.0);
        let simulation = run(&EventDriven::default(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        check_energy(&model, &simulation, 1e-9)?;
    }

    #[test]
    fn single_impact_of_a_rod_follows_both_laws(
        (e, mu) in (0.0..1.0_f64, 0.0..1.2_f64),
        angle in 0.1..1.5_f64,
        (along, down, spin) in (-3.0..3.0_f64, 0.1..3.0_f64, -3.0..3.0_f64),
    ) {
        let model = Rod { e, mu, ..Rod::default() };
        let (sin, cos) = angle.sin_cos();
        // Tip velocities; the rod must fall with its tip.
        let (v_n, v_t) = (-down - cos * spin, along + sin * spin);
        prop_assume!(v_n < -0.01);
        let problem = start(&[0.0, sin, angle], &[along, -down, spin], 1e-4);
        let simulation = run(&accurate(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        let event = &simulation.events[0];
        // Impulses (P, S) in N s, by cases, with the Delassus matrix of a slender rod.
        let (d_nn, d_nt, d_tt) = (1.0 + 3.0 * cos * cos, -3.0 * sin * cos, 1.0 + 3.0 * sin * sin);
        let determinant = d_nn * d_tt - d_nt * d_nt;
        let target = -(1.0 + e) * v_n;
        let stick = (
            (d_tt * target + d_nt * v_t) / determinant,
            (-d_nt * target - d_nn * v_t) / determinant,
        );
        let slip = |sign: f64| {
            let p = target / (d_nn - sign * mu * d_nt);
            (p, -sign * mu * p)
        };
        let slides = |(p, s): (f64, f64)| v_t + d_nt * p + d_tt * s;
        let (p, s) = if stick.0 >= 0.0 && stick.1.abs() <= mu * stick.0 {
            stick
        } else if slides(slip(1.0)) > 0.0 {
            slip(1.0)
        } else {
            prop_assert!(slides(slip(-1.0)) <= 0.0);
            slip(-1.0)
        };
        let expected = [along + s, -down + p, spin + 3.0 * (-cos * p + sin * s)];
        for (found, expected) in event.v_after.iter().zip(expected) {
            // Condition number of the matrix below 16.
            prop_assert!((found - expected).abs() < 1e-13, "{:?} {:?}", event.v_after, expected);
        }
    }
}
