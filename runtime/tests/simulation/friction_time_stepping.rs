//! Restitution and friction in Moreau-Jean time stepping, against closed forms and the event-driven simulator.

use crate::common::assembled::Assembled;
use crate::common::event::accurate;
use crate::common::laws::{Disc, Ground, Rod, Table};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, energies, last, start};
use hangtime::baselines::Moreau;
use hangtime::model::Model;
use hangtime::simulation::{InitialValueProblem, Simulation, SimulationStatus, Simulator};

fn moreau(steps: usize) -> Moreau {
    Moreau {
        steps,
        ..Moreau::default()
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    simulation
}

/// Distance of the last states of two runs.
fn apart(simulation: &Simulation, reference: &Simulation) -> f64 {
    let ((q, v), (q_exact, v_exact)) = (last(&simulation.trajectory), last(&reference.trajectory));
    distance(q, q_exact).max(distance(v, v_exact))
}

#[test]
fn bouncing_ball_has_the_heights_of_the_law_to_the_order_of_a_step() {
    for e in [0.5, 0.9, 1.0] {
        let model = Ground {
            e,
            ..Ground::default()
        };
        let problem = start(&[0.0, 1.0], &[0.5, 0.0], 1.2);
        let reference = run(&accurate(), &model, &problem);
        let errors: Vec<f64> = [1000, 4000]
            .into_iter()
            .map(|steps| apart(&run(&moreau(steps), &model, &problem), &reference))
            .collect();
        // An impact is up to a step of 1.2 ms late, at a change of speed of some 10 m/s and 10 m/s^2.
        assert!(
            errors[0] < 0.03 && errors[1] < 0.03 / 4.0,
            "{e}: {errors:?}"
        );
    }
}

#[test]
fn bouncing_ball_comes_to_rest() {
    let model = Ground {
        e: 0.5,
        ..Ground::default()
    };
    let simulation = run(&moreau(6000), &model, &start(&[0.0, 1.0], &[0.5, 0.0], 3.0));
    let (q, v) = last(&simulation.trajectory);
    // Bounces of the height g h^2 / 8 and the speed g h remain at most.
    assert!(q[1].abs() < 1e-5, "{}", q[1]);
    assert!(v[1].abs() < 1e-2);
    let impulses: f64 = simulation.trajectory.contact_force[4001..]
        .iter()
        .map(|f| f[0])
        .sum();
    // On average the ground carries the weight.
    assert!((impulses / 2000.0 - GRAVITY).abs() < 1e-2 * GRAVITY);
}

#[test]
fn impacts_of_a_disc_and_a_rod_agree_with_the_event_driven_simulator() {
    let disc = |restitution, friction| Disc {
        radius: 0.3,
        shape: 0.5,
        slope: 0.2,
        e: restitution,
        mu: friction,
        ..Disc::default()
    };
    let thrown = start(&[0.0, 0.8, 0.0], &[1.0, 0.0, 20.0], 0.6);
    let rod = |restitution| Rod {
        e: restitution,
        mu: 0.4,
        ..Rod::default()
    };
    let fall = start(&[0.0, 1.2, 1.1], &[0.5, -0.5, 0.4], 0.5);
    let cases: [(Box<dyn Model>, &InitialValueProblem); 5] = [
        (disc(0.0, 0.1).boxed(), &thrown),
        (disc(0.0, 1.0).boxed(), &thrown),
        (disc(0.6, 0.5).boxed(), &thrown),
        (rod(0.0).boxed(), &fall),
        (rod(0.5).boxed(), &fall),
    ];
    for (case, (model, problem)) in cases.iter().enumerate() {
        let reference = run(&accurate(), &**model, problem);
        assert!(!reference.events.is_empty());
        let errors: Vec<f64> = [1000, 4000]
            .into_iter()
            .map(|steps| apart(&run(&moreau(steps), &**model, problem), &reference))
            .collect();
        // Order 1: an impact is up to a step of 0.6 ms late, and mu (1 + e) g / (shape radius) is 50 rad/s^2.
        assert!(
            errors[0] < 0.06 && errors[1] < 0.06 / 4.0,
            "{case}: {errors:?}"
        );
    }
}

#[test]
fn stick_slip_on_a_belt_agrees_with_the_event_driven_simulator() {
    let belt = Assembled::on_belt(
        &Ground {
            stiffness: 16.0,
            mu: 0.4,
            ..Ground::default()
        },
        0.5,
    );
    let table = Assembled::on_belt(
        &Table {
            height: 0.5,
            stiffness: 16.0,
            mu: 0.4,
            ..Table::default()
        },
        0.5,
    );
    let cases: [(&dyn Model, InitialValueProblem); 2] = [
        (&belt, start(&[-0.1, 0.0], &[0.0; 2], 1.4)),
        (&table, start(&[-0.1, 0.5, 0.0], &[0.0; 3], 1.4)),
    ];
    for (model, problem) in cases {
        let reference = run(&accurate(), model, &problem);
        assert!(reference.events.len() >= 2);
        let errors: Vec<f64> = [1000, 4000]
            .into_iter()
            .map(|steps| apart(&run(&moreau(steps), model, &problem), &reference))
            .collect();
        assert!(errors[0] < 5e-3 && errors[1] < 5e-3 / 4.0, "{errors:?}");
    }
}

#[test]
fn rod_in_the_paradox_stops_its_tip_with_an_impulse() {
    // The inconsistent case that no sustained force can balance: an impulse without collision stops the tip.
    let angle = 2.0_f64.atan();
    let model = Rod {
        mu: 1.8,
        ..Rod::default()
    };
    let problem = start(&[0.0, angle.sin(), angle], &[-2.0, 0.0, 0.0], 1e-3);
    let simulation = run(&moreau(10), &model, &problem);
    let (q, v) = last(&simulation.trajectory);
    let normal = v[1] - q[2].cos() * v[2];
    let sliding = v[0] + q[2].sin() * v[2];
    // Velocities at the middle of the last step vanish, a step of 1e-4 s away.
    assert!(
        normal.abs() < 5e-3 && sliding.abs() < 5e-3,
        "{normal} {sliding}"
    );
    let energies = energies(&model, &simulation);
    // Delassus matrix [1.6, -1.2; -1.2, 3.4]: the tip's sliding energy v_t^2 D_nn / (2 det) is lost.
    let lost = 0.5 * 4.0 * 1.6 / (1.6 * 3.4 - 1.44);
    assert!((energies[0] - energies[energies.len() - 1] - lost).abs() < 1e-2 * lost);
}
