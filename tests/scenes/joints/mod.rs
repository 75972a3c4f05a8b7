//! Motions of scenes with joints against closed forms, and against coordinates that need none.

mod control;
mod mechanisms;
mod random;

use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

fn scene(text: &str) -> TextScene {
    match of_text("scene.hang", text) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    }
}

/// The run of the event-driven method at its tightest, which has to be solved.
fn tight(scene: &TextScene) -> Simulation {
    let run = simulate(scene)
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    solved(run)
}

fn solved(run: Result<Simulation, InputError>) -> Simulation {
    let run = run.unwrap_or_else(|error| panic!("{error}"));
    assert!(run.status.is_solved(), "{}", run.status);
    run
}

/// A value at the end of a run.
fn last(run: &Simulation, name: &str) -> f64 {
    run[name].last().copied().unwrap_or(f64::NAN)
}

#[track_caller]
fn assert_close(found: f64, exact: f64, error: f64, what: &str) {
    let off = (found - exact).abs();
    println!("{what}: off by {off:.1e}, {error:e} allowed");
    assert!(
        off <= error,
        "{what}: {found} against {exact}, off by {off:e}"
    );
}
