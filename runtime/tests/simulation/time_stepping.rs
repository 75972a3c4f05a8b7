//! The methods without event location, with the orders that are expected of them.

use crate::common::laws::Ground;
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, last, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, InitialValueProblem, Simulation, SimulationStatus, Simulator,
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
    let simulation = run(
        simulator,
        &model,
        &start(&scenes::SKI_JUMP_START, &[0.0; 2], 5.0),
    );
    let (q, v) = last(&simulation.trajectory);
    let exact = &scenes::SKI_JUMP_END;
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
    let changes: [fn(&mut EventDriven); 7] = [
        |event| event.tolerance = 0.0,
        |event| event.tolerance = f64::NAN,
        |event| event.tolerance = 1.0,
        |event| event.max_step = Some(0.0),
        |event| event.max_step = Some(f64::NAN),
        |event| event.auxiliary_acceleration = 0.0,
        |event| event.max_steps = 0,
    ];
    let changed = changes.map(|change| {
        let mut event = EventDriven::default();
        change(&mut event);
        event
    });
    let event = changed.iter().map(|event| event as &dyn Simulator);
    for simulator in refused.into_iter().chain(event) {
        let error = simulator
            .simulate(&model, &problem, &mut |_| true)
            .expect_err("the settings are refused");
        assert!(error.to_string().contains("must be"), "{error}");
    }
}

#[test]
fn limit_on_steps_ends_the_run_with_a_diagnosis() {
    let (mut smooth, mut event) = (Smooth::default(), EventDriven::default());
    (smooth.max_steps, event.max_steps) = (20, 5);
    let (ball, jump) = (scenes::ball(), scenes::ski_jump());
    let runs: [(&dyn Simulator, &dyn Model, _); 2] = [
        (&smooth, &ball, start(&[0.0, 1.0], &[0.0; 2], 1.0)),
        (
            &event,
            &jump,
            start(&scenes::SKI_JUMP_START, &[0.0; 2], 5.0),
        ),
    ];
    for (simulator, model, problem) in runs {
        let run = simulator.simulate(model, &problem, &mut |_| true);
        let status = run.expect("the problem is accepted").status;
        assert!(matches!(status, SimulationStatus::StepLimit(_)));
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
