//! Coulomb friction in the event-driven simulator where normal and tangential directions couple, or several
//! contacts meet: shared loads, Painleve's paradox, random motions.

use crate::common::assembled::Assembled;
use crate::common::event::{accurate, run, sequence};
use crate::common::laws::{Rod, Room, Table};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, distance, last, same_in_every_run, start};
use hangtime::simulation::{EventDriven, EventKind, SimulationStatus};
use proptest::prelude::*;

#[test]
fn tables_share_the_load_of_two_sticking_feet() {
    // Two feet, three degrees of freedom: how they share the friction is not determined, when they slip is.
    for height in [0.3, 0.8] {
        let (stiffness, mu, belt) = (16.0_f64, 0.4, 0.5);
        let omega = stiffness.sqrt();
        let model = Assembled::on_belt(
            &Table {
                height,
                stiffness,
                mu,
                ..Table::default()
            },
            belt,
        );
        let rest = mu * GRAVITY / stiffness;
        // Starts at rest on the belt where the spring is not strained.
        let problem = start(&[0.0, height, 0.0], &[belt, 0.0, 0.0], 1.2);
        let simulation = run(&accurate(), &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let slips = rest / belt;
        let found: Vec<_> = simulation.events.iter().map(|event| event.kind).collect();
        assert_eq!(
            found,
            [EventKind::Slip, EventKind::Slip],
            "{:?}",
            simulation.events
        );
        for event in &simulation.events {
            assert!((event.time - slips).abs() < 1e-12);
        }
        let time = 1.2 - slips;
        let (q, v) = last(&simulation.trajectory);
        assert!((q[0] - rest - belt / omega * (omega * time).sin()).abs() < 1e-11);
        assert!((v[0] - belt * (omega * time).cos()).abs() < 1e-11);
        let trajectory = &simulation.trajectory;
        for k in 0..trajectory.time.len() {
            let (normal, friction) = (&trajectory.contact_force[k], &trajectory.friction_force[k]);
            assert!((normal[0] + normal[1] - GRAVITY).abs() < 1e-12);
            // Moments about the centre: the feet are at -1 and 1, friction acts `height` below it.
            let friction = friction[0] + friction[1];
            assert!((normal[1] - normal[0] + height * friction).abs() < 1e-11);
            if trajectory.time[k] < slips {
                assert!((friction - stiffness * trajectory.q[k][0]).abs() < 1e-11);
            }
        }
        assert!(simulation.residuals.dual < 1e-11);
    }
}

#[test]
fn sliding_table_stops_on_both_feet_at_once() {
    let (mu, height) = (0.5, 0.6);
    let model = Table {
        height,

        mu,
        ..Table::default()
    };
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, height, 0.0], &[2.0, 0.0, 0.0], 1.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(
        sequence(&simulation),
        [(EventKind::Stick, 0), (EventKind::Stick, 1)]
    );
    assert!((simulation.events[0].time - 2.0 / (mu * GRAVITY)).abs() < 1e-14);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[0] - 2.0 / (mu * GRAVITY)).abs() < 1e-13);
    assert!(distance(v, &[0.0; 3]) < 1e-14);
}

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
fn rod_sliding_where_friction_jams_ends_with_the_paradox_by_name() {
    // D_nn - mu |D_nt| = 1 + 3 cos^2 - 3 mu sin cos < 0 around tan angle = 2 for mu > 4/3. Sliding against
    // the lean, the weight would push the tip in (no solution), or fast rotation lift it (two solutions).
    let angle = 2.0_f64.atan();
    let model = Rod {
        mu: 1.8,
        ..Rod::default()
    };
    for spin in [0.0, 8.0] {
        for direction in [-1.0, 1.0] {
            // The tip slides with direction * 2 m/s and has no normal velocity.
            let v = [
                direction * 2.0 - angle.sin() * spin,
                angle.cos() * spin,
                spin,
            ];
            let simulation = run(
                &accurate(),
                &model,
                &start(&[0.0, angle.sin(), angle], &v, 0.05),
            );
            if direction > 0.0 {
                assert_eq!(simulation.status, SimulationStatus::Solved, "{spin}");
                continue;
            }
            let SimulationStatus::AmbiguousContact(diagnosis) = &simulation.status else {
                panic!("{spin}: {:?}", simulation.status);
            };
            assert_eq!((diagnosis.time, diagnosis.contact), (0.0, Some(0)));
            let several = diagnosis.message.contains("several solutions");
            assert_eq!(several, spin != 0.0, "{}", diagnosis.message);
            assert!(
                diagnosis.message.contains("Painleve"),
                "{}",
                diagnosis.message
            );
            assert!(diagnosis.message.contains("`tip`"), "{}", diagnosis.message);
        }
    }
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

#[test]
fn ball_in_a_corner_with_friction_rests_on_both_surfaces() {
    let model = Room {
        gravity: GRAVITY,
        mu: 0.5,
        ..Room::default()
    };
    let simulation = run(&accurate(), &model, &start(&[0.5, 0.2], &[2.0, 0.0], 2.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[1]).abs() < 1e-14, "{q:?}");
    assert_eq!(v, [0.0, 0.0]);
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
