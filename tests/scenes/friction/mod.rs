//! Friction of speed, of rest and of load, and in space: motions against closed forms and independent integration.

mod compiled;
mod load;
mod space;
mod speed;

use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

fn scene(text: &str) -> TextScene {
    of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The motion of a text by the default method and by the event-driven one, each solved.
fn motions(text: &str, tolerance: Option<f64>, controls: &ControlSignal) -> [Simulation; 2] {
    let scene = scene(text);
    [false, true].map(|event_driven| {
        let mut run = simulate(&scene).controls(controls.clone());
        if event_driven {
            run = run.method(EventDriven::default());
        }
        if let Some(tolerance) = tolerance {
            run = run.tolerance(tolerance);
        }
        let motion = run.run().unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(motion.status.is_solved(), "{text}: {}", motion.status);
        motion
    })
}

/// Whether a motion ends at these values, each to the accuracy `promise`.
fn ends(motion: &Simulation, values: &[(&str, f64)], promise: f64) {
    let time = motion.trajectory.time.last().expect("a motion");
    let end = motion.at(*time).expect("its end");
    for &(name, value) in values {
        let found = end[name];
        assert!(
            (found - value).abs() < promise,
            "{name}: {found} for {value}"
        );
    }
}

/// Whether the events are these, at times that are known to the accuracy `promise`.
fn events(motion: &Simulation, wanted: &[(EventKind, f64)], promise: f64) {
    let found: Vec<EventKind> = motion.events.iter().map(|event| event.kind).collect();
    let known: Vec<EventKind> = wanted.iter().map(|&(kind, _)| kind).collect();
    assert_eq!(found, known);
    for (event, &(_, time)) in motion.events.iter().zip(wanted) {
        assert!((event.time - time).abs() < promise, "{event} at {time}");
    }
}

/// What the text of a scene is refused with.
fn refusal(text: &str) -> String {
    match of_text("scene.hang", text) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}
