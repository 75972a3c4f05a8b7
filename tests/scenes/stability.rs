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

hangtime::model! {
    /// A uniform rod, two metres long, whose tip is pushed over a rough floor.
    pub PushedRod {
        parameters { m: kg = 1, g: m/s^2 = 9.81, mu = 1, start_angle = 1.1071487177940904 }
        coordinates { y: m, z: m, angle }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + m/6*1[m^2]*dot(angle)^2 - m*g*z
        surface floor: z - 1[m]*sin(angle) >= 0
        impact floor: inelastic, friction mu, sliding dot(y - 1[m]*cos(angle))
        start { z: 1[m]*sin(start_angle), angle: start_angle, dot(y): -1 [m/s] }
        horizon 1 [s]
    }
}

#[test]
fn least_friction_at_which_a_rod_neither_slips_nor_sticks_is_that_of_painleve() {
    for simulator in [
        Box::new(Fesd::default()) as Box<dyn Simulator>,
        Box::new(EventDriven::default()),
    ] {
        for start_angle in [0.7, 1.0, 2.0_f64.atan(), 1.3] {
            // The force on the tip moves it by (1 + 3 cos (cos - mu sin)) / m.
            let exact = (1.0 + 3.0 * start_angle.cos().powi(2))
                / (3.0 * start_angle.sin() * start_angle.cos());
            let jams = |mu: f64| {
                let model = PushedRod {
                    mu,
                    start_angle,
                    ..PushedRod::default()
                };
                let problem = InitialValueProblem::of(&model, None).expect("a horizon");
                // Where the start is allowed the first step is the last one.
                let run = simulator.simulate(&model, &problem, &mut |_| false);
                match run.expect("a problem that can be simulated").status.name() {
                    "ambiguous_contact" => true,
                    "interrupted" => false,
                    other => panic!("{other} at a friction of {mu}"),
                }
            };
            let (mut slips, mut jammed) = (0.9 * exact, 1.1 * exact);
            assert!(!jams(slips) && jams(jammed), "{start_angle}");
            while jammed - slips > 1e-7 {
                let middle = f64::midpoint(slips, jammed);
                if jams(middle) {
                    jammed = middle;
                } else {
                    slips = middle;
                }
            }
            assert!(
                (slips - exact).abs() < 1e-6,
                "{start_angle}: {slips} {exact}"
            );
        }
    }
}

/// Runs `model` at 300 values by the default and event-driven: how many disagree by more than their estimates together,
/// how many are solved by both, and how many sequences of events there are.
fn sweep(model: impl Fn(f64) -> Box<dyn Model>) -> (usize, usize, usize) {
    let (mut disagree, mut solved, mut sequences) = (0, 0, Vec::new());
    for k in 0..300 {
        let model = model(f64::from(k) / 299.0);
        let (elements, _) = run(model.as_ref(), &Fesd::default());
        let (events, _) = run(model.as_ref(), &EventDriven::default());
        if !elements.status.is_solved() || !events.status.is_solved() {
            continue;
        }
        solved += 1;
        let ends = [&elements, &events].map(|run| run.trajectory.q.last().expect("a state"));
        let size = largest(elements.trajectory.q.iter().flatten());
        let estimates = [&elements, &events].map(|run| run.error_estimate.expect("an estimate"));
        let allowed = 10.0 * (estimates[0] + estimates[1]) * size + 1e-11 * size;
        let apart = ends[0].iter().zip(ends[1]).map(|(a, b)| (a - b).abs());
        disagree += usize::from(apart.fold(0.0, f64::max) > allowed);
        let sequence: Vec<_> = elements
            .events
            .iter()
            .map(|e| (e.kind, e.contact))
            .collect();
        if !sequences.contains(&sequence) {
            sequences.push(sequence);
        }
    }
    (disagree, solved, sequences.len())
}

#[test]
fn sweeps_of_a_parameter_through_changes_of_the_event_sequence_agree_at_every_value() {
    let ride = |share: f64| -> Box<dyn Model> {
        Box::new(hangtime_models::PumpTrack {
            // From a ride that turns back to one with several flights.
            speed: 8.0 + 22.0 * share,
            ..hangtime_models::PumpTrack::default()
        })
    };
    let rod = |share: f64| -> Box<dyn Model> {
        Box::new(hangtime_models::FallingRod {
            mu: share,
            ..hangtime_models::FallingRod::default()
        })
    };
    for (name, (disagree, solved, sequences)) in [("ride", sweep(ride)), ("rod", sweep(rod))] {
        assert_eq!((disagree, solved), (0, 300), "{name}");
        assert!(sequences >= 3, "{name}: {sequences} sequences of events");
    }
}
