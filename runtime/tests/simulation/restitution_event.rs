//! Restitution in the event-driven simulator, against closed forms.

use crate::common::event::{accurate, run, sequence};
use crate::common::laws::{Disc, Ground, Rod, Room, Table};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, energies, last, same_in_every_run, start};
use hangtime::model::{Model, contact_point};
use hangtime::simulation::{EventDriven, EventKind, Simulation, SimulationStatus, Simulator};
use proptest::prelude::*;

/// Normal velocities of the first contact before and after an event.
fn normal_velocities(model: &dyn Model, simulation: &Simulation, event: usize) -> (f64, f64) {
    let event = &simulation.events[event];
    let n = event.q.len();
    let velocity = |v: &[f64]| {
        let mut x = [&event.q[..], v].concat();
        x.resize(model.declaration().inputs(), 0.0);
        let mut point = vec![0.0; contact_point::length(n)];
        model.contact(event.contact, &x, &mut point);
        point[contact_point::NORMAL_VELOCITY]
    };
    (velocity(&event.v_before), velocity(&event.v_after))
}

#[test]
fn bouncing_ball_has_the_times_and_heights_of_the_closed_form() {
    let height: f64 = 1.0;
    let (time, speed): (f64, f64) = (
        (2.0 * height / GRAVITY).sqrt(),
        (2.0 * GRAVITY * height).sqrt(),
    );
    for e in [0.3, 0.5, 0.9, 1.0] {
        let model = Ground {
            e,
            ..Ground::default()
        };
        let simulation = run(
            &accurate(),
            &model,
            &start(&[0.0, height], &[0.7, 0.0], 3.0),
        );
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert!(
            simulation
                .events
                .iter()
                .all(|event| event.kind == EventKind::Impact)
        );
        let mut exact = (time, speed);
        for event in simulation.events.iter().take(11) {
            // A dozen parabolas, each exact to rounding error; short ones divide it by their length.
            assert!(
                (event.time - exact.0).abs() < 1e-13,
                "e = {e}: {event:?} {exact:?}"
            );
            assert!((event.v_before[1] + exact.1).abs() < 1e-13, "e = {e}");
            assert!((event.v_after[1] - e * exact.1).abs() < 1e-13, "e = {e}");
            assert_eq!(event.v_after[0], 0.7);
            let apex = event.q[1] + event.v_after[1].powi(2) / (2.0 * GRAVITY);
            assert!((apex - e * e * exact.1 * exact.1 / (2.0 * GRAVITY)).abs() < 1e-13);
            exact = (exact.0 + 2.0 * e * exact.1 / GRAVITY, e * exact.1);
        }
        let expected = if e == 1.0 {
            // First impact at 0.45 s, then one every 0.90 s.
            3
        } else {
            // Bounces end once they are lower than 1e-11 m.
            let lowest: f64 = (2.0 * GRAVITY * 1e-11_f64).sqrt();
            let bounces = f64::ln(lowest / speed) / f64::ln(e);
            let ends = time + 2.0 * e * speed / GRAVITY / (1.0 - e);
            if ends > 3.0 {
                simulation.events.len()
            } else {
                bounces.ceil() as usize + 1
            }
        };
        assert_eq!(simulation.events.len(), expected, "e = {e}");
    }
}

#[test]
fn ball_comes_to_rest_at_the_limit_of_the_geometric_series() {
    let model = Ground {
        e: 0.5,
        ..Ground::default()
    };
    let simulation = run(
        &EventDriven::default(),
        &model,
        &start(&[0.0, 1.0], &[0.7, 0.0], 3.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // Time to fall, and twice e + e^2 + ... of it.
    let rests = (2.0 / GRAVITY).sqrt() * (1.0 + 2.0 * 0.5 / (1.0 - 0.5));
    let event = simulation.events.last().unwrap();
    // Bounces below 1e-11 m are left out: they would have lasted 2 e v / g / (1 - e) with v = 1.4e-5 m/s.
    assert!((rests - event.time) < 3e-6 && rests > event.time);
    assert_eq!(event.v_after[1], 0.0);
    let (q, v) = last(&simulation.trajectory);
    // The ground is met to rounding error.
    assert!(q[1].abs() < 2e-15);
    assert_eq!(v[1], 0.0);
    assert!((q[0] - 2.1).abs() < 1e-14);
    let force = simulation.trajectory.contact_force.last().unwrap()[0];
    assert!((force - GRAVITY).abs() < 1e-14);
    assert_eq!(simulation.notes.len(), 1, "{:?}", simulation.notes);
    let note = &simulation.notes[0];
    assert!(note.contains("`ground` stops bouncing at 1.354"), "{note}");
    let height = (0.5 * event.v_before[1]).powi(2) / (2.0 * GRAVITY);
    assert!(height < 1e-11);
    assert!(note.contains(&format!("{height:.1e} m high")), "{note}");
}

#[test]
fn rest_velocity_ends_the_bounces_at_that_speed() {
    let model = Ground {
        e: 0.9,
        ..Ground::default()
    };
    let simulator = EventDriven {
        rest_velocity: Some(0.5),
        ..accurate()
    };
    let simulation = run(&simulator, &model, &start(&[0.0, 1.0], &[0.0; 2], 10.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let speeds: Vec<f64> = simulation
        .events
        .iter()
        .map(|event| -event.v_before[1])
        .collect();
    let (end, bounces) = speeds.split_last().unwrap();
    assert!(*end <= 0.5 && bounces.iter().all(|&speed| speed > 0.5));
    let height = (0.9 * end).powi(2) / (2.0 * GRAVITY);
    let note = &simulation.notes[0];
    assert!(note.contains(&format!("{height:.1e} m high")), "{note}");
    for velocity in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = EventDriven {
            rest_velocity: Some(velocity),
            ..EventDriven::default()
        }
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |_| true);
        let error = refused.expect_err("the settings are refused");
        assert!(error.to_string().contains("must be"), "{error}");
    }
}

#[test]
fn resting_ball_with_restitution_stays() {
    let model = Ground {
        e: 0.9,
        ..Ground::default()
    };
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[1.0, 0.0], 1.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(simulation.events.is_empty() && simulation.notes.is_empty());
}

#[test]
fn restitution_is_that_of_the_law_whatever_mass_offset_slope_scale_and_curvature() {
    for e in [0.3, 0.5, 0.9, 1.0] {
        for mass in [1.0, 2.0, 10.0] {
            for (slope, offset) in [(0.0, 0.0), (0.0, 0.2), (0.5, 0.2)] {
                for scale in [1.0, 2.0] {
                    for waves in [(0.0, 1.0), (0.3, 2.0)] {
                        let model = Ground {
                            mass,
                            slope,
                            offset,
                            height: waves.0,
                            number: waves.1,
                            scale,
                            e,
                            ..Ground::default()
                        };
                        let problem = start(&[0.1, 1.2], &[0.8, -1.0], 1.0);
                        let simulation = run(&accurate(), &model, &problem);
                        assert_eq!(simulation.status, SimulationStatus::Solved);
                        let (before, after) = normal_velocities(&model, &simulation, 0);
                        // Velocities of some m/s, twice as large with the scale: rounding error only.
                        assert!(before < -0.5);
                        assert!((after / before + e).abs() < 1e-14, "{after} {before} {e}");
                    }
                }
            }
        }
    }
}

#[test]
fn elastic_ball_in_a_room_keeps_its_energy_over_hundreds_of_impacts() {
    let model = Room {
        gravity: GRAVITY,
        e: 1.0,
        ..Room::default()
    };
    let simulation = run(&accurate(), &model, &start(&[0.3, 0.6], &[7.3, 4.1], 50.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(simulation.events.len() > 400, "{}", simulation.events.len());
    let energies = energies(&model, &simulation);
    let worst = energies
        .iter()
        .fold(0.0_f64, |s, energy| s.max((energy - energies[0]).abs()));
    // Energy 80 J; every impact rounds it by some 1e-14.
    assert!(worst < 1e-10, "{worst:e}");
}

#[test]
fn elastic_ball_that_hits_corners_returns_on_its_path() {
    // Without gravity along the diagonal: both walls of a corner at once, hundreds of times.
    let model = Room {
        gravity: 0.0,
        e: 1.0,
        ..Room::default()
    };
    let simulation = run(&accurate(), &model, &start(&[0.5, 0.5], &[1.0, 1.0], 200.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // Corners at 0.5, 1.5, ... 199.5 s: 200 of them, two impacts each.
    assert_eq!(simulation.events.len(), 400);
    for (k, pair) in simulation.events.chunks(2).enumerate() {
        // Rounding error of 200 times and positions of order 1 to 200.
        assert!((pair[0].time - (k as f64 + 0.5)).abs() < 1e-10);
        assert_eq!(pair[0].time, pair[1].time);
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        assert!((pair[0].v_after[0] - side).abs() < 1e-12);
        assert!((pair[0].v_after[1] - side).abs() < 1e-12);
    }
    assert!(simulation.notes.iter().any(|note| note.contains("Moreau")));
    let (q, _) = last(&simulation.trajectory);
    assert!((q[0] - 0.5).abs() < 1e-10 && (q[1] - 0.5).abs() < 1e-10);
}

#[test]
fn elastic_ball_never_ends_its_bounces_and_inelastic_numbers_stay_finite() {
    let model = Ground {
        e: 1.0,
        ..Ground::default()
    };
    let simulation = run(
        &EventDriven::default(),
        &model,
        &start(&[0.0, 1.0], &[0.0; 2], 500.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // One at 0.4515 s and then one every 0.9030 s.
    assert_eq!(simulation.events.len(), 554);
    // So many bounces that the limit on events ends the run: a status, not an endless loop.
    let model = Ground {
        e: 0.9999,
        ..Ground::default()
    };
    let simulator = EventDriven {
        max_events: 500,
        ..EventDriven::default()
    };
    let simulation = run(&simulator, &model, &start(&[0.0, 1.0], &[0.0; 2], 1e4));
    assert!(matches!(simulation.status, SimulationStatus::EventLimit(_)));
}

#[test]
fn impact_that_gains_energy_by_newtons_law_with_friction_is_noted() {
    // A rod that sticks with its tip: v_n+ = -e v_n-, v_t+ = 0. In terms of the tip's velocity the energy is
    // v' D^-1 v / 2; at v_t- = 0.7, v_n- = -1, angle 1, that grows for e = 0.95.
    let model = Rod {
        e: 0.95,
        mu: 1.0,
        ..Rod::default()
    };
    let angle: f64 = 1.0;
    let problem = start(&[0.0, angle.sin(), angle], &[0.7, -1.0, 0.0], 0.01);
    let simulation = run(&accurate(), &model, &problem);
    let energies = energies(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let (sin, cos) = angle.sin_cos();
    let (d_nn, d_nt, d_tt) = (
        1.0 + 3.0 * cos * cos,
        -3.0 * sin * cos,
        1.0 + 3.0 * sin * sin,
    );
    let twice = |v_n: f64, v_t: f64| {
        (d_tt * v_n * v_n - 2.0 * d_nt * v_n * v_t + d_nn * v_t * v_t) / (d_nn * d_tt - d_nt * d_nt)
    };
    let gain = 0.5 * (twice(0.95, 0.0) - twice(-1.0, 0.7));
    assert!(gain > 0.05);
    assert!((energies[1] - energies[0] - gain).abs() < 1e-14 * energies[0]);
    assert!(
        simulation.notes[0].contains("raises the kinetic energy"),
        "{:?}",
        simulation.notes
    );
}

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
