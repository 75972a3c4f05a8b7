//! The methods without event location, with the orders that are expected of them.

use crate::common::gold;
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, energies, last, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, EventKind, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let trajectory = &simulation.trajectory;
    assert_eq!(trajectory.time.last(), Some(&problem.horizon));
    assert!(trajectory.time.windows(2).all(|pair| pair[0] <= pair[1]));
    simulation
}

fn moreau(steps: usize) -> Moreau {
    Moreau {
        steps,
        ..Moreau::default()
    }
}

fn fixed(steps: usize) -> FixedStep {
    FixedStep {
        steps,
        ..FixedStep::default()
    }
}

fn smooth(width: f64) -> Smooth {
    Smooth {
        width,
        ..Smooth::default()
    }
}

/// Errors of the state of the ski jump at 5 s.
fn ski_jump_error(simulator: &dyn Simulator) -> f64 {
    let model = scenes::ski_jump();
    let gold = &gold::SURFACE_START;
    let simulation = run(simulator, &model, &start(&gold.start, &[0.0; 2], 5.0));
    let (q, v) = last(&simulation.trajectory);
    let (_, exact) = &gold.states[2];
    distance(q, &exact[..2]).max(distance(v, &exact[2..]))
}

/// Slope of log error against log resolution between the first and the last of a sweep.
fn order(errors: &[f64], refinement: f64) -> f64 {
    (errors[0] / errors[errors.len() - 1]).ln() / refinement.ln()
}

#[test]
fn moreau_of_the_ski_jump_has_order_one() {
    let errors: Vec<f64> = [500, 1000, 2000, 4000, 8000]
        .into_iter()
        .map(|steps| ski_jump_error(&moreau(steps)))
        .collect();
    let order = order(&errors, 16.0);
    assert!(
        (0.8..1.2).contains(&order),
        "order {order}, errors {errors:?}"
    );
}

/// Error of a fall onto wavy ground and the slide that follows, against the event-driven simulator.
fn landing_error(simulator: &dyn Simulator) -> f64 {
    let model = scenes::waves(0.3, 1.0);
    let problem = start(&[0.0, 1.0], &[2.0, 0.0], 1.0);
    let reference = run(
        &EventDriven {
            tolerance: 1e-13,
            ..EventDriven::default()
        },
        &model,
        &problem,
    );
    assert_eq!(reference.events.len(), 1);
    let simulation = run(simulator, &model, &problem);
    let ((q, v), (q_exact, v_exact)) = (last(&simulation.trajectory), last(&reference.trajectory));
    distance(q, q_exact).max(distance(v, v_exact))
}

#[test]
fn fixed_step_with_a_landing_on_curved_ground_has_order_one() {
    // The error is proportional to the delay of the landing, anything from nothing to one step; the largest
    // of several neighbouring step sizes follows the step size.
    let worst = |steps: usize| {
        (0..12)
            .map(|k| landing_error(&fixed(steps + steps * k / 100)))
            .fold(0.0, f64::max)
    };
    let errors = [worst(200), worst(3200)];
    let order = order(&errors, 16.0);
    assert!(
        (0.8..1.2).contains(&order),
        "order {order}, errors {errors:?}"
    );
}

#[test]
fn fixed_step_of_the_ski_jump_has_order_two() {
    // Take-off where the force vanishes, landing on a plane: see the method's description.
    let worst = |steps: usize| {
        (0..6)
            .map(|k| ski_jump_error(&fixed(steps + steps * k / 50)))
            .fold(0.0, f64::max)
    };
    let errors = [worst(300), worst(4800)];
    let order = order(&errors, 16.0);
    assert!(
        (1.7..2.3).contains(&order),
        "order {order}, errors {errors:?}"
    );
}

#[test]
fn smooth_of_the_ski_jump_has_order_one_in_the_width() {
    let errors: Vec<f64> = [0.1, 0.03, 0.01]
        .into_iter()
        .map(|width| ski_jump_error(&smooth(width)))
        .collect();
    let order = order(&errors, 10.0);
    assert!(
        (0.7..1.3).contains(&order),
        "order {order}, errors {errors:?}"
    );
}

#[test]
fn ball_comes_to_rest_with_its_weight_on_the_ground() {
    let model = scenes::ball();
    let problem = start(&[0.0, 1.0], &[1.5, 0.0], 1.0);
    let cases: [(&dyn Simulator, f64); 3] = [
        // Penetration of one step at 4.4 m/s.
        (&moreau(1000), 5e-3),
        // Moved back onto the ground.
        (&fixed(1000), 1e-12),
        // Some widths above it.
        (&smooth(1e-3), 5e-3),
    ];
    for (simulator, height) in cases {
        let simulation = run(simulator, &model, &problem);
        let (q, v) = last(&simulation.trajectory);
        assert!(q[1].abs() < height, "{}: {}", simulator.name(), q[1]);
        assert!(v[1].abs() < 5e-3, "{}: {}", simulator.name(), v[1]);
        // Smoothing brakes the sliding body by nothing: directions are normal.
        assert!((v[0] - 1.5).abs() < 1e-9, "{}: {}", simulator.name(), v[0]);
        let force = simulation.trajectory.contact_force.last().unwrap()[0];
        assert!(
            (force - 0.5 * GRAVITY).abs() < 1e-2,
            "{}: {force}",
            simulator.name()
        );
        let numerical = simulation.trajectory.numerical_time.last().unwrap();
        // Contact for half of the time at the rate 1 + g / a_bar, and a jump of 4.4 / 981 s.
        let exact = 1.0 + (1.0 - (2.0 / GRAVITY).sqrt()) * 0.01 + (2.0 * GRAVITY).sqrt() / 981.0;
        assert!(
            (numerical - exact).abs() < 1e-3,
            "{}: {numerical} {exact}",
            simulator.name()
        );
    }
}

#[test]
fn fixed_step_reports_switches_at_the_ends_of_steps() {
    let model = scenes::ski_jump();
    let gold = &gold::SURFACE_START;
    let simulation = run(&fixed(1000), &model, &start(&gold.start, &[0.0; 2], 5.0));
    let found: Vec<_> = simulation
        .events
        .iter()
        .map(|event| (event.kind, event.contact))
        .collect();
    assert_eq!(found, [(EventKind::LiftOff, 0), (EventKind::Impact, 1)]);
    for (event, exact) in simulation
        .events
        .iter()
        .zip([gold.take_off.0, gold.landing.0])
    {
        let late = event.time - exact;
        // Never early, and at most one step of 5 ms late, apart from what the late take-off changes.
        assert!((-1e-4..5.1e-3).contains(&late), "{late}");
        let steps = event.time / 5e-3;
        assert!((steps - steps.round()).abs() < 1e-9);
    }
}

#[test]
fn energy_never_grows_beyond_the_error_of_the_method() {
    let model = scenes::bar(1.0, 1.0, 0.5);
    let problem = start(&[0.0, 0.3, 0.2], &[1.0, 0.0, 1.0], 1.5);
    let cases: [(&dyn Simulator, f64); 3] = [
        (&EventDriven::default(), 1e-8),
        // The midpoint rule conserves the energy of a bar in flight; impulses only take energy, and a step
        // in contact moves the tips by the square of the step size.
        (&moreau(3000), 1e-3),
        // Moving the tip back onto the ground lifts the bar by at most speed times step.
        (&fixed(30_000), 1e-2),
    ];
    for (simulator, allowed) in cases {
        let simulation = run(simulator, &model, &problem);
        let energies = energies(&model, &simulation);
        for pair in energies.windows(2) {
            assert!(
                pair[1] <= pair[0] + allowed,
                "{}: {pair:?}",
                simulator.name()
            );
        }
        assert!(energies[energies.len() - 1] < energies[0] - 0.1);
    }
}

#[test]
fn methods_agree_on_a_landing_with_both_tips() {
    let model = scenes::bar(1.0, 0.7, 0.8);
    let problem = start(&[0.0, 0.3, 0.05], &[1.0, 0.0, 0.0], 1.0);
    let reference = run(&EventDriven::default(), &model, &problem);
    let (q_exact, v_exact) = last(&reference.trajectory);
    for simulator in [&moreau(5000) as &dyn Simulator, &fixed(5000)] {
        let simulation = run(simulator, &model, &problem);
        let (q, v) = last(&simulation.trajectory);
        // Order one with 0.2 ms steps and speeds of some m/s.
        assert!(
            distance(q, q_exact) < 5e-3,
            "{}: {q:?} {q_exact:?}",
            simulator.name()
        );
        assert!(
            distance(v, v_exact) < 5e-3,
            "{}: {v:?} {v_exact:?}",
            simulator.name()
        );
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let model = scenes::ball();
    let problem = start(&[0.0, 1.0], &[0.0; 2], 1.0);
    let refused: [&dyn Simulator; 8] = [
        &moreau(0),
        &Moreau {
            auxiliary_acceleration: f64::NAN,
            ..Moreau::default()
        },
        &fixed(0),
        &FixedStep {
            auxiliary_acceleration: -1.0,
            ..FixedStep::default()
        },
        &smooth(0.0),
        &smooth(f64::NAN),
        &smooth(f64::INFINITY),
        &Smooth {
            tolerance: 1.0,
            ..Smooth::default()
        },
    ];
    for simulator in refused {
        let error = simulator
            .simulate(&model, &problem, &mut |_| true)
            .expect_err("the settings are refused");
        assert!(error.to_string().contains("must be"), "{error}");
    }
}

#[test]
fn limit_on_steps_ends_the_smooth_run() {
    let model = scenes::ball();
    let simulator = Smooth {
        max_steps: 20,
        ..Smooth::default()
    };
    let simulation = simulator
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |_| true)
        .expect("the problem is accepted");
    assert!(matches!(simulation.status, SimulationStatus::StepLimit(_)));
}
