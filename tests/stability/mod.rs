//! Scenes and problems on which methods fail, a file a phenomenon: what promises an accuracy is right, or stops with a name.
//! `hangtime chart --stability` shows the same for every method.

mod crowds;
mod friction;
mod grazing;
mod jamming;
mod no_values;
mod optimal_control;
mod scales;
mod simultaneous_impacts;
mod starts;
mod steps;
mod sweeps;
mod take_off;
mod zeno;

use hangtime::prelude::*;
use hangtime::simulation::{
    EventDriven, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};
use hangtime_cli::{HardScene, Right};
use hangtime_models::hard_scenes;
use hangtime_scene_files::{TextScene, of_text};

/// The hard scenes of each phenomenon.
const PHENOMENA: [&[&str]; 11] = [
    crowds::SCENES,
    friction::SCENES,
    grazing::SCENES,
    jamming::SCENES,
    no_values::SCENES,
    scales::SCENES,
    simultaneous_impacts::SCENES,
    starts::SCENES,
    steps::SCENES,
    take_off::SCENES,
    zeno::SCENES,
];

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

/// The methods that promise an accuracy are right on the scenes of these names, or stop with a name where there is no motion.
fn assert_outcomes(names: &[&str]) {
    let methods: [(&str, Box<dyn Simulator>); 3] = [
        ("default", Box::new(Fesd::default())),
        (
            "time-freezing",
            Box::new(Fesd::default().with_formulation(StepFormulation::TimeFreezing)),
        ),
        ("event-driven", Box::new(EventDriven::default())),
    ];
    for name in names {
        let hard = hard_scenes().iter().find(|hard| hard.name == *name);
        let hard = hard.unwrap_or_else(|| panic!("no scene {name}"));
        let scene = scene(hard);
        for (method, simulator) in &methods {
            assert_outcome(hard, &scene, method, simulator.as_ref());
        }
    }
}

fn assert_outcome(hard: &HardScene, scene: &TextScene, method: &str, simulator: &dyn Simulator) {
    let name = format!("{} by {method}", hard.name);
    let (run, horizon) = run(scene, simulator);
    match hard.right {
        Right::Formula(formula) => assert_right(&name, &run, horizon, &formula(scene, horizon)),
        Right::Agreed => {
            let exact = EventDriven {
                tolerance: 1e-13,
                ..EventDriven::default()
            };
            let (exact, _) = self::run(scene, &exact);
            let end = exact.trajectory.q.last().expect("a state");
            assert_right(&name, &run, horizon, end);
        }
        Right::Stop => assert!(!run.status.is_solved(), "{name}"),
    }
}

#[test]
fn every_hard_scene_and_problem_shows_one_phenomenon() {
    let mut shown: Vec<&str> = PHENOMENA.concat();
    let mut known: Vec<&str> = hard_scenes().iter().map(|hard| hard.name).collect();
    shown.sort_unstable();
    known.sort_unstable();
    assert_eq!(shown, known);
}
