//! Motions of texts by the default method and by the event-driven one, and where they end.

use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

/// The scene of a text.
pub(crate) fn scene(text: &str) -> TextScene {
    of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The motion of a text by both methods, each solved.
pub(crate) fn motions(text: &str) -> [Simulation; 2] {
    let scene = scene(text);
    [false, true].map(|event_driven| {
        let mut run = simulate(&scene);
        if event_driven {
            run = run.method(EventDriven::default());
        }
        let motion = run.run().unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(motion.status.is_solved(), "{text}: {}", motion.status);
        motion
    })
}

/// Whether a motion ends at these values, each to the accuracy `promise`.
pub(crate) fn ends(motion: &Simulation, values: &[(&str, f64)], promise: f64) {
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
