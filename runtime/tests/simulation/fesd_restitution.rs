//! Restitution in the finite element simulator against closed forms.

use crate::common::laws::{Ground, SmoothRoom};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, energies, last, start};
use hangtime::model::{Model, contact_point};
use hangtime::rk::Scheme;
use hangtime::simulation::{
    Event, EventKind, Fesd, Simulation, SimulationStatus, Simulator, StepFormulation,
};

/// Order 9 with elements of about a hundredth of a motion's time scale: errors near rounding.
fn accurate() -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, 5)
        .with_grid(40, 2)
}

fn simulate(simulator: &Fesd, model: &dyn Model, q: &[f64], v: &[f64], horizon: f64) -> Simulation {
    let simulation = simulator
        .simulate(model, &start(q, v, horizon), &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    simulation
}

fn impacts(simulation: &Simulation) -> Vec<&Event> {
    let events = simulation.events.iter();
    events.filter(|e| e.kind == EventKind::Impact).collect()
}

fn normal_velocity(model: &dyn Model, q: &[f64], v: &[f64]) -> f64 {
    let mut x = q.to_vec();
    x.extend(v);
    x.resize(model.declaration().inputs(), 0.0);
    let mut point = vec![0.0; contact_point::length(q.len())];
    model.contact(0, &x, &mut point);
    point[contact_point::NORMAL_VELOCITY]
}

fn bounces_until(rest_velocity: f64) -> Fesd {
    Fesd {
        rest_velocity: Some(rest_velocity),
        ..Fesd::default()
    }
}

#[test]
fn ball_laid_on_the_ground_with_a_residual_speed_rests_there_and_slides_on() {
    // Flights of less than a hundred thousandth of an element, down to less than the times of a run tell apart.
    for formulation in [StepFormulation::ActiveSet, StepFormulation::TimeFreezing] {
        for simulator in [Fesd::default(), Fesd::default().with_grid(40, 2)] {
            let simulator = simulator.with_formulation(formulation);
            for (e, speed) in [
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
                let case = format!("{formulation:?}, e = {e}, {speed:e} m/s");
                let run = simulate(&simulator, &model, &[0.0, 0.0], &[1.0, speed], 1.0);
                let (q, v) = last(&run.trajectory);
                assert!((q[0] - 1.0).abs() < 1e-13 && v[0] == 1.0, "{case}: {q:?}");
                // The flights that are left out are lower than all that are not.
                let highest = speed * speed / (2.0 * GRAVITY);
                assert!(
                    q[1].abs() < highest.max(1e-24) && v[1].abs() < 1e-20,
                    "{case}: {q:?}, {v:?}"
                );
            }
        }
    }
}

#[test]
fn bouncing_ball_reaches_the_heights_and_times_of_the_geometric_series() {
    for e in [0.3, 0.5, 0.9, 1.0] {
        let model = Ground {
            e,
            ..Ground::default()
        };
        let simulator = bounces_until(1e-5);
        let simulation = simulate(&simulator, &model, &[0.0, 1.0], &[1.0, 0.0], 6.0);
        let mut time = (2.0 / GRAVITY).sqrt();
        let mut speed = GRAVITY * time;
        let impacts = impacts(&simulation);
        for impact in &impacts {
            // Flights are parabolas, which the scheme reproduces: rounding of the times, and of the speeds
            // by which they are divided.
            let rounding = 1e-15 * time * (1.0 + 1.0 / speed);
            assert!(
                (impact.time - time).abs() < 10.0 * rounding,
                "e = {e}: {:e} at {time}, speed {speed:e}",
                impact.time - time
            );
            speed *= e;
            time += 2.0 * speed / GRAVITY;
        }
        if time < 6.0 {
            // The cascade ended at the first impact slower than the rest velocity.
            assert!(speed / e <= 1e-5 && speed / (e * e) > 1e-5, "{speed:e}");
            let (q, v) = last(&simulation.trajectory);
            assert!(q[1].abs() < 1e-14 && v[1].abs() < 1e-14);
            assert_eq!(simulation.notes.len(), 1, "{:?}", simulation.notes);
            assert!(simulation.notes[0].contains("bounces of `ground`"));
        } else {
            assert!(simulation.notes.is_empty());
        }
    }
}

#[test]
fn restitution_is_that_of_the_law_whatever_mass_ground_and_scale() {
    let grounds = [
        Ground::default(),
        Ground {
            offset: 0.2,
            ..Ground::default()
        },
        Ground {
            slope: 0.4,
            offset: -0.3,
            scale: 2.0,
            ..Ground::default()
        },
        Ground {
            curvature: 0.7,
            ..Ground::default()
        },
        Ground {
            height: 0.3,
            number: 2.0,
            ..Ground::default()
        },
    ];
    for e in [0.3, 0.5, 0.9, 1.0] {
        for mass in [1.0, 2.0, 10.0] {
            for ground in &grounds {
                let mut model = Ground {
                    e,
                    ..ground.clone()
                };
                model.mass = mass;
                let simulation = simulate(&accurate(), &model, &[0.3, 1.0], &[0.5, 0.0], 1.0);
                let impacts = impacts(&simulation);
                assert!(!impacts.is_empty());
                for impact in impacts {
                    let before = normal_velocity(&model, &impact.q, &impact.v_before);
                    let after = normal_velocity(&model, &impact.q, &impact.v_after);
                    // Rounding of velocities of order one, relative to the speed of the impact.
                    if after > 0.0 {
                        let error = (after + e * before).abs();
                        assert!(error < 1e-14, "{error:e} at {before:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn elastic_ball_in_a_box_keeps_its_energy_over_hundreds_of_bounces_and_corners() {
    let model = SmoothRoom::default();
    // Along the diagonal every bounce is in a corner; off it the walls are met one by one.
    for (q, v) in [([0.5, 0.5], [10.0, 10.0]), ([0.3, 0.4], [11.0, 7.0])] {
        let simulation = simulate(&Fesd::default(), &model, &q, &v, 20.0);
        let impacts = impacts(&simulation);
        assert!(impacts.len() >= 350, "{}", impacts.len());
        let energies = energies(&model, &simulation);
        for energy in &energies {
            assert!((energy / energies[0] - 1.0).abs() < 1e-12);
        }
        // Unfolded, the motion is a straight line: period 2 in each direction.
        let (end, _) = last(&simulation.trajectory);
        let unfold = |q: f64, v: f64| {
            let place = (q + 20.0 * v).rem_euclid(2.0);
            if place > 1.0 { 2.0 - place } else { place }
        };
        let exact = [unfold(q[0], v[0]), unfold(q[1], v[1])];
        // Each of the 400 bounces adds a rounding of the time, 20 s * 1e-16, times the speed.
        assert!(distance(end, &exact) < 1e-11, "{end:?} {exact:?}");
    }
}

#[test]
fn resting_ball_does_not_bounce_and_a_bounce_lets_it_fly() {
    let model = Ground {
        e: 0.8,
        ..Ground::default()
    };
    let still = simulate(&Fesd::default(), &model, &[0.0, 0.0], &[1.0, 0.0], 1.0);
    assert!(still.events.is_empty());
    assert!(still.notes.is_empty());
    let hit = simulate(&Fesd::default(), &model, &[0.0, 0.0], &[1.0, -2.0], 0.3);
    assert!((hit.events[0].v_after[1] - 1.6).abs() < 1e-14);
    assert_eq!(hit.events[0].time, 0.0);
}

#[test]
fn rest_velocity_decides_how_many_bounces_are_carried_out() {
    let model = Ground {
        e: 0.5,
        ..Ground::default()
    };
    let count = |rest: f64| {
        let simulator = bounces_until(rest);
        let simulation = simulate(&simulator, &model, &[0.0, 1.0], &[0.0, 0.0], 3.0);
        impacts(&simulation).len()
    };
    // Speeds 4.43 / 2^k: the first below the rest velocity are those of k = 9 and 16, which are impacts too.
    assert_eq!((count(1e-2), count(1e-4)), (10, 17));
    let refused = bounces_until(-1.0)
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |_| true)
        .unwrap_err();
    assert_eq!(
        refused.to_string(),
        "rest velocity = -1: must be at least 0 and finite (m/s)"
    );
}
