//! Friction of speed, of rest and of load, and in space: motions against closed forms and independent integration.

mod compiled;
mod held;
mod load;
mod space;
mod speed;

use hangtime::prelude::*;
use hangtime_scene_files::of_text;

use super::both::{ends, motions, motions_under, scene};

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
