//! Scenes on which methods fail: the methods that promise an accuracy are right on all of them, or stop with a name.

use hangtime::prelude::*;
use hangtime::simulation::{
    EventDriven, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};
use hangtime_cli::{HardScene, Right};
use hangtime_models::hard_scenes;
use hangtime_scene_files::{TextScene, of_text};

fn scene(hard: &HardScene) -> TextScene {
    of_text(&format!("{}.hang", hard.name), hard.text)
        .unwrap_or_else(|error| panic!("{}: {error}", hard.name))
}

fn run(scene: &dyn Model, method: &dyn Simulator) -> (Simulation, f64) {
    let problem = InitialValueProblem::of(scene, None).expect("a horizon");
    let run = method
        .simulate(scene, &problem, &mut |_| true)
        .expect("a problem that can be simulated");
    (run, problem.horizon)
}

fn largest<'v>(values: impl Iterator<Item = &'v f64>) -> f64 {
    values.fold(0.0, |largest, value| largest.max(value.abs()))
}

/// Whether a run is as close to the right end as ten times its estimate, or rounding of the way at the largest velocity.
fn assert_right(name: &str, run: &Simulation, horizon: f64, right: &[f64]) {
    assert_eq!(run.status, SimulationStatus::Solved, "{name}");
    let trajectory = &run.trajectory;
    let size = largest(trajectory.q.iter().flatten().chain(right));
    let way = size.max(horizon * largest(trajectory.v.iter().flatten()));
    let estimate = run.error_estimate.expect("an estimate");
    let end = trajectory.q.last().expect("a state");
    for (is, right) in end.iter().zip(right) {
        assert!(
            (is - right).abs() <= (10.0 * estimate * size).max(1e-11 * way),
            "{name}: {is} {right}, estimate {estimate}"
        );
    }
}

#[test]
fn methods_that_promise_an_accuracy_are_right_or_stop_with_a_name() {
    let methods: [(&str, Box<dyn Simulator>); 3] = [
        ("default", Box::new(Fesd::default())),
        (
            "time-freezing",
            Box::new(Fesd::default().with_formulation(StepFormulation::TimeFreezing)),
        ),
        ("event-driven", Box::new(EventDriven::default())),
    ];
    for hard in hard_scenes() {
        let scene = scene(hard);
        for (method, simulator) in &methods {
            let name = format!("{} by {method}", hard.name);
            let (run, horizon) = run(&scene, simulator.as_ref());
            match hard.right {
                Right::Formula(formula) => {
                    assert_right(&name, &run, horizon, &formula(&scene, horizon));
                }
                Right::Agreed => {
                    let exact = EventDriven {
                        tolerance: 1e-13,
                        ..EventDriven::default()
                    };
                    let (exact, _) = self::run(&scene, &exact);
                    let end = exact.trajectory.q.last().expect("a state");
                    assert_right(&name, &run, horizon, end);
                }
                Right::Stop => assert!(!run.status.is_solved(), "{name}"),
            }
        }
    }
}
