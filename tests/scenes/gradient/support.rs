//! Scenes, and derivatives to compare with.

use hangtime::derivative::Gradient;
use hangtime::prelude::*;
use hangtime::simulation::Simulator;
use hangtime_scene_files::{TextScene, of_text};

/// The scene of a text, with some of its parameters changed.
pub(crate) fn scene(text: &str, settings: &[(&str, f64)]) -> TextScene {
    let mut scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{error}"));
    for &(name, value) in settings {
        let index = parameter(&scene, name);
        scene.set_parameter(index, value);
    }
    scene
}

/// The place of a parameter.
pub(crate) fn parameter(scene: &TextScene, name: &str) -> usize {
    let parameters = scene.declaration().parameters;
    let place = parameters.iter().position(|known| known.name == name);
    place.unwrap_or_else(|| panic!("no parameter `{name}`"))
}

/// A motion by both methods that locate events, with its derivatives.
pub(crate) fn by_both(scene: &TextScene, by: &[&str]) -> [(Simulation, Gradient); 2] {
    let names = || by.iter().copied();
    [
        located(scene, Fesd::default(), names()),
        located(scene, EventDriven::default(), names()),
    ]
}

fn located<'n>(
    scene: &TextScene,
    method: impl Simulator,
    names: impl Iterator<Item = &'n str>,
) -> (Simulation, Gradient) {
    let run = simulate(scene).method(method).tolerance(TOLERANCE);
    let (run, gradient) = run.gradient(names).unwrap();
    assert!(run.status.is_solved(), "{run}");
    (run, gradient)
}

/// Tolerance of motions that are differentiated here: derivatives are as accurate as the motion.
pub(crate) const TOLERANCE: f64 = 1e-12;

/// Compares a number with what it should be, relative to that or to 1.
#[track_caller]
pub(crate) fn assert_close(found: f64, right: f64, tolerance: f64, what: &str) {
    let error = (found - right).abs() / right.abs().max(1.0);
    assert!(
        error <= tolerance,
        "{what}: {found} instead of {right}, off by {error:e}"
    );
}

/// Compares derivatives with others, as good as the motion: tolerances of 1e-12 leave 1e-9.
#[track_caller]
pub(super) fn assert_row(found: &[f64], right: &[f64], what: &str) {
    assert_eq!(found.len(), right.len());
    for (k, (found, right)) in found.iter().zip(right).enumerate() {
        assert_close(*found, *right, 1e-9, &format!("{what}, quantity {k}"));
    }
}

/// Whether there are derivatives; if not, why.
#[track_caller]
pub(crate) fn assert_exists(gradient: &Gradient) {
    assert!(gradient.obstacle.is_none(), "{:?}", gradient.obstacle);
}
