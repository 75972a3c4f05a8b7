//! The event-driven simulator against certified solutions and closed forms.

use crate::common::event::{accurate, check_consistency, run};
use crate::common::scenes::{self, GRAVITY};
use crate::common::start;
use hangtime::simulation::{EventDriven, Simulation, SimulationStatus, Simulator};

fn ski_jump(simulator: &EventDriven) -> Simulation {
    let model = scenes::ski_jump();
    let simulator = EventDriven {
        output_times: 5,
        ..simulator.clone()
    };
    let simulation = run(
        &simulator,
        &model,
        &start(&scenes::SKI_JUMP_START, &[0.0; 2], 5.0),
    );
    check_consistency(&model, &simulation);
    simulation
}

#[test]
fn numerical_time_of_the_ski_jump_is_independent_of_the_steps() {
    // dtau = (1 + r / a_bar) dt in contact, dt in flight, |v_n| / a_bar at the landing.
    let end = |tolerance| {
        let simulation = ski_jump(&EventDriven {
            tolerance,
            ..EventDriven::default()
        });
        *simulation.trajectory.numerical_time.last().unwrap()
    };
    let (coarse, fine) = (end(1e-8), end(1e-13));
    assert!((coarse - fine).abs() < 1e-6);
    assert!(fine > 5.0 && fine < 5.1);
}

#[test]
fn numerical_time_of_a_fall_passes_in_its_jump_and_in_contact() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[1.5, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let (time, speed) = ((2.0 / GRAVITY).sqrt(), (2.0 * GRAVITY).sqrt());
    // The jump takes |v_n| / a_bar, contact runs at 1 + g / a_bar.
    let a_bar = 981.0;
    let numerical = time + speed / a_bar + (1.0 - time) * (1.0 + GRAVITY / a_bar);
    let found = simulation.trajectory.numerical_time.last().unwrap();
    assert!((found - numerical).abs() < 1e-14);
}

#[test]
fn limit_on_steps_ends_the_run_with_a_diagnosis() {
    let simulator = EventDriven {
        max_steps: 5,
        ..accurate()
    };
    let model = scenes::ski_jump();
    let simulation = run(
        &simulator,
        &model,
        &start(&scenes::SKI_JUMP_START, &[0.0; 2], 5.0),
    );
    assert!(matches!(simulation.status, SimulationStatus::StepLimit(_)));
}

#[test]
fn settings_out_of_range_are_refused() {
    let model = scenes::ball();
    let problem = start(&[0.0, 1.0], &[0.0; 2], 1.0);
    for simulator in [
        EventDriven {
            tolerance: 0.0,
            ..EventDriven::default()
        },
        EventDriven {
            tolerance: f64::NAN,
            ..EventDriven::default()
        },
        EventDriven {
            tolerance: 1.0,
            ..EventDriven::default()
        },
        EventDriven {
            max_step: Some(0.0),
            ..EventDriven::default()
        },
        EventDriven {
            max_step: Some(f64::NAN),
            ..EventDriven::default()
        },
        EventDriven {
            auxiliary_acceleration: 0.0,
            ..EventDriven::default()
        },
        EventDriven {
            max_steps: 0,
            ..EventDriven::default()
        },
    ] {
        let error = simulator
            .simulate(&model, &problem, &mut |_| true)
            .unwrap_err();
        assert!(
            error.to_string().contains("must be"),
            "{simulator:?}: {error}"
        );
    }
}

#[test]
fn progress_reports_the_times_of_accepted_steps() {
    let model = scenes::ball();
    let mut times = Vec::new();
    let simulation = EventDriven::default()
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |now| {
            times.push(now.time);
            true
        })
        .unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // A run to compare with may be stopped as well, but time does not pass in it.
    assert_eq!(times.first(), Some(&0.0));
    times.dedup();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(times.last(), Some(&1.0));
}
