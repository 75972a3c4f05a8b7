//! Closed forms of shipped scenes, against event-driven runs.

use hangtime::simulation::{EventDriven, InitialValueProblem, Simulator as _};
use hangtime_cli::Scene;

use hangtime_models::scenes;

fn check(scene: &Scene, time: f64) {
    let Some(formula) = scene.closed_form else {
        return;
    };
    let model = (scene.variants[0].model)();
    let exact = formula(model.as_ref(), time).expect("a motion");
    let problem = InitialValueProblem::of(model.as_ref(), Some(time)).expect("a horizon");
    let method = EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    };
    let run = method
        .simulate(model.as_ref(), &problem, &mut |_| true)
        .expect("a run");
    for (a, b) in run.trajectory.q.last().expect("a state").iter().zip(&exact) {
        // Tolerance of the run, over some impacts.
        assert!((a - b).abs() < 1e-11, "{} at {time} s: {a} {b}", scene.name);
    }
}

#[test]
fn formulas_agree_with_event_driven_runs_in_every_phase() {
    let with = scenes().iter().filter(|scene| scene.closed_form.is_some());
    assert_eq!(with.count(), 5);
    for scene in scenes() {
        for time in [0.1, 0.4, 0.9, 1.2, 1.3, 1.6, 2.0, 2.5] {
            check(scene, time);
        }
    }
}
