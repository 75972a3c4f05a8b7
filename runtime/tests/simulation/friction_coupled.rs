//! Coulomb friction where normal and tangential directions couple, or several contacts share: closed forms by every simulator that locates
//! events, Painleve's paradox, random motions.

use crate::common::assembled::Assembled;
use crate::common::event::{run, sequence};
use crate::common::laws::{Feet, Rod, Room, Table};
use crate::common::located::{endings, motions};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, distance, last, same_in_every_run, start};
use hangtime::model::Model;
use hangtime::simulation::{EventDriven, EventKind, SimulationStatus};
use proptest::prelude::*;

#[test]
fn coupled_impact_of_a_rod_follows_the_mode_that_is_consistent() {
    // Rod of half length a, tip below at angle phi < 0: n = (0, 1, a cos), b = (1, 0, -a sin).
    for (phi, mu, v) in [
        (-0.9_f64, 0.1_f64, [2.0, -1.0, 0.5]),
        (-0.9, 0.6, [0.2, -2.0, -1.0]),
        (-0.5, 0.3, [-3.0, -1.0, 1.0]),
        (-1.2, 0.05, [1.0, -2.0, 0.0]),
    ] {
        let (half, gyration) = (1.0, 0.577_f64);
        let model = Rod {
            inertia: gyration * gyration,
            arm: half,
            mu,
            ..Rod::default()
        };
        let (n, b) = ([0.0, 1.0, half * phi.cos()], [1.0, 0.0, -half * phi.sin()]);
        let inverse = [1.0, 1.0, gyration.powi(-2)];
        let product =
            |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|k| a[k] * inverse[k] * b[k]).sum() };
        let (nn, nb, bb) = (product(n, n), product(n, b), product(b, b));
        let along = |a: [f64; 3]| -> f64 { a.iter().zip(v).map(|(a, v)| a * v).sum() };
        let (v_n, v_t) = (along(n), along(b));
        assert!(v_n < 0.0);
        // Impulses (P_n, P_t) of the three modes; exactly one is consistent.
        let determinant = nn * bb - nb * nb;
        let grip = [
            (-v_n * bb + v_t * nb) / determinant,
            (-v_t * nn + v_n * nb) / determinant,
        ];
        let mut consistent = Vec::new();
        if grip[0] >= 0.0 && grip[1].abs() <= mu * grip[0] {
            consistent.push(grip);
        }
        for sense in [1.0, -1.0] {
            let normal = -v_n / (nn - sense * mu * nb);
            let tangential = -sense * mu * normal;
            let after = v_t + nb * normal + bb * tangential;
            if normal > 0.0 && sense * after > 0.0 {
                consistent.push([normal, tangential]);
            }
        }
        let [impulse] = consistent[..] else {
            panic!("{consistent:?}")
        };
        let after: [f64; 3] =
            std::array::from_fn(|k| v[k] + inverse[k] * (n[k] * impulse[0] + b[k] * impulse[1]));
        let problem = start(&[0.0, -half * phi.sin(), phi], &v, 1e-4);
        for (name, simulation) in motions(&model, &problem) {
            let found = &simulation.events[0].v_after;
            assert!(
                distance(found, &after) < 1e-13,
                "{name}: {found:?} {after:?}"
            );
        }
    }
}

#[test]
fn both_feet_stick_together() {
    // Each body decelerates at mu g, stops, and stays on both feet.
    let bar = Feet {
        gyration: 0.6,
        front: 0.5,
        rear: 0.8,
        mu: 0.3,
        ..Feet::default()
    };
    let table = Table {
        height: 0.6,
        mu: 0.5,
        ..Table::default()
    };
    for (model, height, mu, speed) in [(bar.boxed(), 0.0, 0.3, 1.5), (table.boxed(), 0.6, 0.5, 2.0)]
    {
        let stop = speed / (mu * GRAVITY);
        let problem = start(&[0.0, height, 0.0], &[speed, 0.0, 0.0], 1.0);
        for (name, simulation) in motions(&*model, &problem) {
            let kinds = [(EventKind::Stick, 0), (EventKind::Stick, 1)];
            assert_eq!(sequence(&simulation), kinds, "{name}");
            for event in &simulation.events {
                assert!((event.time - stop).abs() < 2e-14, "{name}");
            }
            // Parabolas, which the schemes reproduce: rounding error.
            let (q, v) = last(&simulation.trajectory);
            assert!((q[0] - 0.5 * speed * stop).abs() < 2e-14, "{name}: {q:?}");
            assert!(distance(v, &[0.0; 3]) < 1e-14, "{name}: {v:?}");
            let sum = |forces: &[Vec<f64>]| forces.last().unwrap().iter().sum::<f64>();
            assert!(
                sum(&simulation.trajectory.friction_force).abs() < 1e-13,
                "{name}"
            );
            let weight = sum(&simulation.trajectory.contact_force);
            assert!((weight - GRAVITY).abs() < 1e-12, "{name}");
        }
    }
}

#[test]
fn tables_share_the_load_of_two_sticking_feet() {
    // Two feet, three degrees of freedom: how they share the friction is not determined, when they slip is.
    for height in [0.3, 0.8] {
        let (stiffness, mu, belt) = (16.0_f64, 0.4, 0.5);
        let omega = stiffness.sqrt();
        let table = Table {
            height,
            stiffness,
            mu,
            ..Table::default()
        };
        let model = Assembled::on_belt(&table, belt);
        let rest = mu * GRAVITY / stiffness;
        let slips = rest / belt;
        // Starts at rest on the belt where the spring is not strained.
        let problem = start(&[0.0, height, 0.0], &[belt, 0.0, 0.0], 1.2);
        for (name, simulation) in motions(&model, &problem) {
            let kinds: Vec<_> = simulation.events.iter().map(|event| event.kind).collect();
            assert_eq!(kinds, [EventKind::Slip; 2], "{name}");
            for event in &simulation.events {
                assert!((event.time - slips).abs() < 1e-12, "{name}");
            }
            let phase = omega * (1.2 - slips);
            let (q, v) = last(&simulation.trajectory);
            assert!(
                (q[0] - rest - belt / omega * phase.sin()).abs() < 1e-11,
                "{name}"
            );
            assert!((v[0] - belt * phase.cos()).abs() < 1e-11, "{name}");
            let trajectory = &simulation.trajectory;
            for k in 0..trajectory.time.len() {
                let (normal, friction) =
                    (&trajectory.contact_force[k], &trajectory.friction_force[k]);
                assert!((normal[0] + normal[1] - GRAVITY).abs() < 1e-12, "{name}");
                // Moments about the centre: the feet are at -1 and 1, friction acts `height` below it.
                let friction = friction[0] + friction[1];
                let moment = normal[1] - normal[0] + height * friction;
                assert!(moment.abs() < 1e-11, "{name}: {moment:e}");
                if trajectory.time[k] < slips {
                    let pull = stiffness * trajectory.q[k][0];
                    assert!((friction - pull).abs() < 1e-11, "{name}");
                }
            }
            assert!(simulation.residuals.dual < 1e-11, "{name}");
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
    for (name, simulation) in motions(&model, &start(&[0.5, 0.2], &[2.0, 0.0], 2.0)) {
        let (q, v) = last(&simulation.trajectory);
        assert!(q[1].abs() < 1e-14, "{name}: {q:?}");
        assert!(distance(v, &[0.0; 2]) < 1e-15, "{name}: {v:?}");
    }
}

#[test]
fn rod_sliding_where_friction_jams_ends_with_the_paradox_by_name() {
    // D_nn - mu |D_nt| = 1 + 3 cos^2 - 3 mu sin cos < 0 around tan angle = 2 for mu > 4/3. Sliding against
    // the lean, the weight would push the tip in (no solution), or fast rotation lift it (two solutions).
    let slender = (Rod::default().inertia, -1.0, 2.0_f64.atan(), 1.8);
    let heavy = (0.577_f64.powi(2), 1.0, -0.9, 2.5);
    for (inertia, arm, angle, mu) in [slender, heavy] {
        let model = Rod {
            inertia,
            arm,
            mu,
            ..Rod::default()
        };
        let (sin, cos) = (arm * angle.sin(), arm * angle.cos());
        assert!(1.0 + cos * cos / inertia < mu * (sin * cos).abs() / inertia);
        for spin in [0.0, 8.0] {
            for direction in [-1.0, 1.0] {
                // The tip slides with direction * 2 m/s and has no normal velocity; it jams against the lean.
                let v = [direction * 2.0 + sin * spin, -cos * spin, spin];
                let problem = start(&[0.0, -sin, angle], &v, 0.05);
                let jams = direction * sin * cos < 0.0;
                for (name, simulation) in endings(&model, &problem) {
                    let case = format!("{name}, spin {spin}, direction {direction}");
                    if !jams {
                        assert!(
                            simulation.status.is_solved(),
                            "{case}: {}",
                            simulation.status
                        );
                        continue;
                    }
                    assert_eq!(simulation.status.name(), "ambiguous_contact", "{case}");
                    let diagnosis = simulation.status.diagnosis().unwrap();
                    assert_eq!(
                        (diagnosis.time, diagnosis.contact),
                        (0.0, Some(0)),
                        "{case}"
                    );
                    let message = &diagnosis.message;
                    assert!(message.contains("Painleve"), "{case}: {message}");
                    assert!(message.contains("tip"), "{case}: {message}");
                }
            }
        }
    }
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
