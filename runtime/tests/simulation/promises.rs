//! What `solved` means: the error that is estimated, runs that end otherwise, and what is kept of them.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::event_scales::Crests;
use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};

/// A mass that takes off from the waves that it rides over.
fn fast_on_waves() -> Crests {
    Crests {
        v: 6.5,
        a: 0.3,
        k: 1.4,
        g: 9.81,
        ..Crests::default()
    }
}

hangtime::model! {
    /// A ball that bounces on waves, away from where it has been.
    pub BallOnWaves {
        parameters { m: kg = 1, a: m = 0.2, k: 1/m = 3, g: m/s^2 = 9.81, e = 1, x0: m = 0.4, height: m = 1.3 }
        coordinates { x: m, z: m }
        fn track(p) = a*sin(k*p)
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface track: z - track(x) >= 0
        impact track: restitution e
        start { x: x0, z: track(x0) + height }
        horizon 20 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let problem = InitialValueProblem::of(model, horizon).unwrap();
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

fn methods() -> [Box<dyn Simulator>; 2] {
    [Box::new(Fesd::default()), Box::new(EventDriven::default())]
}

/// Largest difference of the last coordinates.
fn apart(a: &Simulation, b: &Simulation) -> f64 {
    let (a, b) = (
        a.trajectory.q.last().unwrap(),
        b.trajectory.q.last().unwrap(),
    );
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn time_freezing_on_a_grid_that_nobody_named_says_how_accurate_it_is() {
    for (v, horizon) in [(2.0, 0.3), (6.5, 0.9)] {
        let model = Crests {
            v,
            ..fast_on_waves()
        };
        let exact = run(
            &EventDriven {
                tolerance: 1e-12,
                ..EventDriven::default()
            },
            &model,
            Some(horizon),
        );
        assert_eq!(exact.status, SimulationStatus::Solved);
        let method = Fesd::default().with_formulation(StepFormulation::Complementarity);
        let found = run(&method, &model, Some(horizon));
        let way = exact.trajectory.q.last().unwrap()[0];
        if v < 3.0 {
            assert_eq!(found.status, SimulationStatus::Solved);
            assert!(found.error_estimate.unwrap() <= 1e-6);
            assert!(apart(&found, &exact) <= 1e-5 * way);
        } else {
            // Jumps and contact share elements here.
            let SimulationStatus::Inaccurate(diagnosis) = &found.status else {
                panic!("{}", found.status);
            };
            assert!(found.error_estimate.unwrap() > 1e-6);
            assert!(diagnosis.time <= horizon && diagnosis.message.contains("agree until"));
            assert!(apart(&found, &exact) <= 1e-4 * way);
        }
    }
}

#[test]
fn chaotic_bounces_are_not_called_solved_and_agree_until_the_time_that_is_named() {
    let model = BallOnWaves::default();
    let runs = methods().map(|method| run(&*method, &model, None));
    for run in &runs {
        let SimulationStatus::Inaccurate(diagnosis) = &run.status else {
            panic!("{}", run.status);
        };
        assert!(run.error_estimate.unwrap() > 1e-6);
        assert!(
            diagnosis.time > 1.0 && diagnosis.time < 19.0,
            "{diagnosis:?}"
        );
    }
    // Until the earlier of the two times both methods have the same impacts.
    let until = |run: &Simulation| run.status.diagnosis().unwrap().time;
    let until = until(&runs[0]).min(until(&runs[1]));
    let impacts = |run: &Simulation| -> Vec<f64> {
        let impacts = run
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact);
        impacts
            .map(|event| event.time)
            .filter(|time| *time < until)
            .collect()
    };
    let (a, b) = (impacts(&runs[0]), impacts(&runs[1]));
    assert!(a.len() > 2);
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}
