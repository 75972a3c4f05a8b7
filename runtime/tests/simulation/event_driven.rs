//! Limits, settings and progress of the event-driven simulator.

use crate::common::event::{accurate, run};
use crate::common::scenes;
use crate::common::start;
use hangtime::simulation::{EventDriven, SimulationStatus, Simulator};

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
