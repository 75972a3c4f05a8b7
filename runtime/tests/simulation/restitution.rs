//! Restitution against closed forms, by every simulator that locates events.

use crate::common::event::{accurate, run, sequence};
use crate::common::laws::{Disc, Ground, Rod, Room, SmoothRoom, Table};
use crate::common::located::{located, motions};
use crate::common::scenes::GRAVITY;
use crate::common::{check_energy, distance, energies, last, same_in_every_run, start};
use hangtime::model::{Model, contact_point};
use hangtime::simulation::{
    Event, EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus,
    Simulator, StepFormulation,
};
use proptest::prelude::*;

/// Both located methods, with bounces that end at a speed [m/s].
fn bounces_until(speed: f64) -> [(&'static str, Box<dyn Simulator>); 2] {
    let rest_velocity = Some(speed);
    [
        (
            "event-driven",
            Box::new(EventDriven {
                rest_velocity,
                ..accurate()
            }),
        ),
        (
            "elements",
            Box::new(Fesd {
                rest_velocity,
                ..Fesd::default()
            }),
        ),
    ]
}

fn solved(
    simulator: &dyn Simulator,
    model: &dyn Model,
    problem: &InitialValueProblem,
) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    simulation
}

/// Normal velocity of the first contact.
fn normal_velocity(model: &dyn Model, q: &[f64], v: &[f64]) -> f64 {
    let mut x = [q, v].concat();
    x.resize(model.declaration().inputs(), 0.0);
    let mut point = vec![0.0; contact_point::length(q.len())];
    model.contact(0, &x, &mut point);
    point[contact_point::NORMAL_VELOCITY]
}

fn impacts(simulation: &Simulation) -> Vec<&Event> {
    let events = simulation.events.iter();
    events
        .filter(|event| event.kind == EventKind::Impact)
        .collect()
}

#[test]
fn bouncing_ball_has_the_times_and_heights_of_the_geometric_series() {
    const REST: f64 = 1e-5;
    for e in [0.3, 0.5, 0.9, 1.0] {
        let model = Ground {
            e,
            ..Ground::default()
        };
        let problem = start(&[0.0, 1.0], &[0.7, 0.0], 6.0);
        for (name, simulator) in bounces_until(REST) {
            let simulation = solved(&*simulator, &model, &problem);
            let mut time = (2.0 / GRAVITY).sqrt();
            let mut speed = GRAVITY * time;
            let impacts = impacts(&simulation);
            assert_eq!(impacts.len(), simulation.events.len(), "{name}");
            for (k, impact) in impacts.iter().enumerate() {
                // Flights are parabolas, which the schemes reproduce: rounding of the times, and of the speeds by which
                // they are divided.
                let rounding = 1e-15 * (10 + k) as f64 * time * (1.0 + 1.0 / speed);
                let late = (impact.time - time).abs();
                assert!(
                    late < rounding,
                    "{name}, e = {e}: {late:e} at {time}, speed {speed:e}"
                );
                // A speed is as wrong as the time, times g.
                let wrong = 1e-14 + GRAVITY * rounding;
                assert!(
                    (impact.v_before[1] + speed).abs() < wrong,
                    "{name}, e = {e}"
                );
                let ends = speed <= REST;
                let after = if ends { 0.0 } else { e * speed };
                assert!((impact.v_after[1] - after).abs() < wrong, "{name}, e = {e}");
                assert!((impact.v_after[0] - 0.7).abs() < 1e-15, "{name}, e = {e}");
                speed *= e;
                time += 2.0 * speed / GRAVITY;
            }
            if time > 6.0 {
                assert!(
                    simulation.notes.is_empty(),
                    "{name}: {:?}",
                    simulation.notes
                );
                continue;
            }
            // The cascade ended at the first impact slower than the rest velocity.
            assert!(
                speed / e <= REST && speed / (e * e) > REST,
                "{name}: {speed:e}"
            );
            let (q, v) = last(&simulation.trajectory);
            assert!(q[1].abs() < 1e-14 && v[1].abs() < 1e-14, "{name}");
            assert!((q[0] - 4.2).abs() < 1e-13, "{name}");
            let force = simulation.trajectory.contact_force.last().unwrap()[0];
            assert!((force - GRAVITY).abs() < 1e-12, "{name}");
            let [note] = &simulation.notes[..] else {
                panic!("{name}: {:?}", simulation.notes)
            };
            assert!(
                note.contains("`ground`") && note.contains("bounc"),
                "{name}: {note}"
            );
        }
    }
}

#[test]
fn ball_with_a_residual_speed_rests_on_the_ground_and_slides_on() {
    // Flights of less than a hundred thousandth of an element, down to less than the times of a run tell apart.
    let elements = [StepFormulation::ActiveSet, StepFormulation::TimeFreezing].map(|formulation| {
        let both = [Fesd::default(), Fesd::default().with_grid(40, 2)];
        both.map(|simulator| simulator.with_formulation(formulation))
    });
    for simulator in elements.into_iter().flatten() {
        for (e, speed) in [
            (0.9, 0.0),
            (0.5, 2e-5),
            (0.5, 1e-6),
            (0.8, 1e-6),
            (0.1, -1e-6),
            (0.5, -1e-10),
            (0.5, 1e-13),
            (0.5, 1e-14),
        ] {
            let model = Ground {
                e,
                ..Ground::default()
            };
            let case = format!("{:?}, e = {e}, {speed:e} m/s", simulator.formulation);
            let run = solved(&simulator, &model, &start(&[0.0; 2], &[1.0, speed], 1.0));
            let (q, v) = last(&run.trajectory);
            assert!((q[0] - 1.0).abs() < 1e-13 && v[0] == 1.0, "{case}: {q:?}");
            // The flights that are left out are lower than all that are not.
            let highest = speed * speed / (2.0 * GRAVITY);
            let small = q[1].abs() < highest.max(1e-24) && v[1].abs() < 1e-20;
            assert!(small, "{case}: {q:?}, {v:?}");
        }
    }
}

#[test]
fn resting_ball_does_not_bounce_and_a_bounce_lets_it_fly() {
    let model = Ground {
        e: 0.8,
        ..Ground::default()
    };
    for (name, still) in motions(&model, &start(&[0.0; 2], &[1.0, 0.0], 1.0)) {
        assert!(still.events.is_empty() && still.notes.is_empty(), "{name}");
    }
    for (name, hit) in motions(&model, &start(&[0.0; 2], &[1.0, -2.0], 0.3)) {
        assert!((hit.events[0].v_after[1] - 1.6).abs() < 1e-14, "{name}");
        assert_eq!(hit.events[0].time, 0.0, "{name}");
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
    let note = &simulation.notes[0];
    assert!(note.contains("`ground` stops bouncing at 1.354"), "{note}");
    let height = (0.5 * event.v_before[1]).powi(2) / (2.0 * GRAVITY);
    assert!(height < 1e-11);
    assert!(note.contains(&format!("{height:.1e} m high")), "{note}");
}

#[test]
fn rest_velocity_ends_the_bounces_at_that_speed() {
    // Speeds sqrt(2 g) e^k: the first one below the rest velocity is an impact too.
    for (e, rest) in [(0.5, 1e-2), (0.5, 1e-4), (0.9, 0.5)] {
        let model = Ground {
            e,
            ..Ground::default()
        };
        let bounces = f64::ceil(f64::ln(rest / (2.0 * GRAVITY).sqrt()) / f64::ln(e));
        for (name, simulator) in bounces_until(rest) {
            let simulation = solved(&*simulator, &model, &start(&[0.0, 1.0], &[0.0; 2], 10.0));
            assert_eq!(impacts(&simulation).len(), bounces as usize + 1, "{name}");
        }
    }
    for speed in [-1.0, f64::NAN, f64::INFINITY] {
        for (name, simulator) in bounces_until(speed) {
            let refused = simulator.simulate(
                &Ground::default(),
                &start(&[0.0, 1.0], &[0.0; 2], 1.0),
                &mut |_| true,
            );
            let message = refused.expect_err("the setting is refused").to_string();
            let expected = format!("rest velocity = {speed} m/s: must be at least 0 and finite");
            assert_eq!(message, expected, "{name}");
        }
    }
}

#[test]
fn restitution_is_that_of_the_law_whatever_mass_ground_and_scale() {
    let default = Ground::default;
    let grounds = [
        default(),
        Ground {
            offset: 0.2,
            ..default()
        },
        Ground {
            slope: 0.5,
            offset: 0.2,
            ..default()
        },
        Ground {
            slope: 0.4,
            offset: -0.3,
            scale: 2.0,
            ..default()
        },
        Ground {
            curvature: 0.7,
            ..default()
        },
        Ground {
            height: 0.3,
            number: 2.0,
            ..default()
        },
        Ground {
            slope: 0.5,
            offset: 0.2,
            height: 0.3,
            number: 2.0,
            scale: 2.0,
            ..default()
        },
    ];
    for e in [0.3, 0.5, 0.9, 1.0] {
        for mass in [1.0, 2.0, 10.0] {
            for ground in &grounds {
                let model = Ground {
                    e,
                    mass,
                    ..ground.clone()
                };
                for (name, simulator) in located() {
                    let simulation =
                        solved(&*simulator, &model, &start(&[0.1, 1.2], &[0.8, -1.0], 1.0));
                    let impacts = impacts(&simulation);
                    assert!(!impacts.is_empty(), "{name}");
                    for impact in impacts {
                        let before = normal_velocity(&model, &impact.q, &impact.v_before);
                        let after = normal_velocity(&model, &impact.q, &impact.v_after);
                        // Rounding of velocities of order one; bounces that end have none after.
                        let error = (after + e * before).abs();
                        assert!(
                            after == 0.0 || error < 1e-14,
                            "{name}: {error:e} at {before:e}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn elastic_ball_in_a_room_keeps_its_energy_over_hundreds_of_impacts_and_corners() {
    // Along the diagonal every bounce is in a corner; off it the walls are met one by one.
    for (q, v) in [([0.5, 0.5], [10.0, 10.0]), ([0.3, 0.4], [11.0, 7.0])] {
        let model = SmoothRoom::default();
        for (name, simulation) in motions(&model, &start(&q, &v, 20.0)) {
            assert!(impacts(&simulation).len() >= 350, "{name}");
            let energies = energies(&model, &simulation);
            let kept = |energy: &f64| (energy / energies[0] - 1.0).abs() < 1e-12;
            assert!(energies.iter().all(kept), "{name}");
            // Unfolded, the motion is a straight line: period 2 in each direction.
            let unfold = |q: f64, v: f64| {
                let place = (q + 20.0 * v).rem_euclid(2.0);
                if place > 1.0 { 2.0 - place } else { place }
            };
            let exact = [unfold(q[0], v[0]), unfold(q[1], v[1])];
            // Each of the 400 bounces adds a rounding of the time, 20 s * 1e-16, times the speed.
            let end = last(&simulation.trajectory).0;
            assert!(distance(end, &exact) < 1e-11, "{name}: {end:?} {exact:?}");
        }
    }
    let model = Room {
        gravity: GRAVITY,
        e: 1.0,
        ..Room::default()
    };
    for (name, simulation) in motions(&model, &start(&[0.3, 0.6], &[7.3, 4.1], 50.0)) {
        assert!(simulation.events.len() > 400, "{name}");
        // Energy 80 J; every impact rounds it by some 1e-14.
        let energies = energies(&model, &simulation);
        let kept = |energy: &f64| (energy - energies[0]).abs() < 1e-10;
        assert!(energies.iter().all(kept), "{name}");
    }
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
