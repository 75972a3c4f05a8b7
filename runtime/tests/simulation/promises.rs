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

hangtime::model! {
    /// A rod that is pushed along rough ground, tip ahead.
    pub Rod {
        parameters { m: kg = 1.4, l: m = 0.9, j: kg m^2 = 0.03, g: m/s^2 = 9.81, mu = 1.3, angle0 = 1.1, v: m/s = -6 }
        coordinates { x: m, z: m, angle }
        let tip = (x - l/2*cos(angle), z - l/2*sin(angle))
        lagrangian m/2*(dot(x)^2 + dot(z)^2) + j/2*dot(angle)^2 - m*g*z
        surface ground: tip.z >= 0
        impact ground: inelastic, friction mu, sliding dot(tip.y)
        start { z: l/2*sin(angle0), angle: angle0, dot(x): v }
        horizon 0.7 [s]
    }
}

hangtime::model! {
    /// A ball that is thrown into a corner.
    pub Corner {
        parameters { m: kg = 2, g: m/s^2 = 9, e = 0.8, mu = 1.2, h: m = 0.5, w: m = 0.6 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface floor: z >= 0
        surface wall: w - x >= 0
        impact floor, wall: restitution e, friction mu
        start { z: h, dot(x): w/sqrt(2*h/g) }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A ball that falls.
    pub Ball {
        parameters { m: kg = 3, g: m/s^2 = 8, height: m = 0.7 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic
        start { z: height }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A jump from a lip that is rounded by two nanometres.
    pub Lip {
        parameters {
            m: kg = 60, g: m/s^2 = 9.81, mu = 0.08, run: m = 25, up: deg = 32, down: deg = 40, drop: m = 1.5,
            cliff: 1/m = 150, eps: m = 0.000000002,
        }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface incline: z*cos(up) + x*sin(up) + cliff*(x + sqrt(x^2 + eps^2))^2 >= 0
        surface landing: (z + drop)*cos(down) + x*sin(down) + 0.01[1/m]*(x - sqrt(x^2 + eps^2))^2 >= 0
        impact incline, landing: inelastic, friction mu
        start { x: -run*cos(up), z: run*sin(up) }
        horizon 4.5 [s]
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
fn event_driven_run_says_by_how_much_another_one_differs() {
    let run = run(&EventDriven::default(), &fast_on_waves(), None);
    assert_eq!(run.status, SimulationStatus::Solved);
    let estimate = run.error_estimate.unwrap();
    assert!((0.0..=1e-6).contains(&estimate), "{estimate:e}");
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

#[test]
fn run_that_stops_at_its_start_keeps_it_and_names_the_contact() {
    for method in methods() {
        let found = run(&*method, &Rod::default(), None);
        let SimulationStatus::AmbiguousContact(diagnosis) = &found.status else {
            panic!("{}", found.status);
        };
        assert_eq!(diagnosis.contact, Some(0), "{}", method.name());
        assert!(!diagnosis.message.contains("free motion"), "{diagnosis:?}");
        assert_eq!(found.trajectory.time, [0.0], "{}", method.name());
        assert_eq!(found.trajectory.q[0][2], 1.1);
        assert_eq!(found.trajectory.v[0][0], -6.0);
        assert_eq!(found.trajectory.contact_force.len(), 1);
        assert!(found.at(0.0).is_ok());
    }
}

#[test]
fn message_of_a_corner_names_nothing_that_the_scene_does_not_declare() {
    for method in methods() {
        let found = run(&*method, &Corner::default(), None);
        let SimulationStatus::AmbiguousContact(diagnosis) = &found.status else {
            panic!("{}", found.status);
        };
        assert!(
            !diagnosis.message.contains("along"),
            "{}",
            diagnosis.message
        );
        assert!(diagnosis.contact.is_some());
    }
}

#[test]
fn impact_is_found_within_a_horizon_of_ages() {
    for method in methods() {
        let longest = if method.name() == "event" { 1e9 } else { 1e6 };
        for horizon in [1e4, 1e6, longest] {
            let found = run(&*method, &Ball::default(), Some(horizon));
            let name = method.name();
            assert_eq!(found.status, SimulationStatus::Solved, "{name} {horizon:e}");
            assert_eq!(found.events.len(), 1, "{name} {horizon:e}");
            let late = found.events[0].time - (2.0 * 0.7 / 8.0_f64).sqrt();
            // Rounding of the time, whose size is that of the horizon in sums.
            let rounding = 4.0 * f64::EPSILON * horizon;
            assert!(
                late.abs() < rounding.max(1e-9),
                "{name} {horizon:e}: {late:e}"
            );
        }
    }
}

#[test]
fn take_off_from_a_sharp_lip_is_where_the_lip_is() {
    let model = Lip::default();
    let exact = run(&EventDriven::default(), &model, None);
    assert_eq!(exact.status, SimulationStatus::Solved);
    let take_off = &exact.events[0];
    assert_eq!(take_off.kind, EventKind::LiftOff);
    assert!(take_off.q[0].abs() < 1e-6);
    for method in [Fesd::default(), Fesd::default().with_tolerance(1e-9)] {
        let found = run(&method, &model, None);
        assert_eq!(found.status, SimulationStatus::Solved);
        let event = &found.events[0];
        assert_eq!(event.kind, EventKind::LiftOff);
        assert!((event.time - take_off.time).abs() < 1e-5, "{event:?}");
        assert!(event.q[0].abs() < 1e-4, "{event:?}");
    }
}

hangtime::model! {
    /// A seesaw on the ground, and a block that slips along its plank to a stop.
    pub Seesaw {
        parameters { m: kg = 15, i: kg*m^2 = 50, g: m/s^2 = 9.81, half: m = 2, pivot: m = 0.9, mu = 0.3, e = 0.3 }
        coordinates { phi: rad, s: m, h: m }
        let block = rotation(phi)*(s, h)
        lagrangian i/2*dot(phi)^2 + m/2*|dot(block)|^2 - m*g*block.z
        surface plank: h >= 0
        surface ground: pivot >= -half*sin(phi)
        surface stop: s <= half - 0.2[m]
        impact plank: inelastic, friction mu, sliding dot(s)
        impact ground: inelastic
        impact stop: restitution e
        start { s: 0.6 [m] }
        horizon 3 [s]
    }
}

#[test]
fn forces_that_hold_all_coordinates_are_those_of_statics_and_residuals_small() {
    // The states of such elements are known before their forces, whose directions depend on the states.
    let seesaw = Seesaw::default();
    let run = hangtime::simulate(&seesaw).run().unwrap();
    assert!(run.status.is_solved(), "{run}");
    let rest = run.events.last().unwrap().time;
    // Lengths of the plank on the ground at the angle `phi`: the block presses across the plank with m g cos(phi).
    let lean = (seesaw.pivot / seesaw.half).asin();
    let weight = seesaw.m * seesaw.g;
    let ground = weight * lean.cos() * (seesaw.half - 0.2) / (seesaw.half * lean.cos());
    let trajectory = &run.trajectory;
    let mut seen = 0;
    for (time, forces) in trajectory.time.iter().zip(&trajectory.contact_force) {
        if *time > rest {
            seen += 1;
            let close = |force: f64, exact: f64| (force - exact).abs() < 1e-8 * weight;
            assert!(close(forces[0], weight * lean.cos()), "{time}: {forces:?}");
            assert!(close(forces[1], ground), "{time}: {forces:?}, {ground}");
        }
    }
    assert!(seen > 6, "{seen} instants at rest");
    assert!(run.residuals.primal < 1e-8, "{:?}", run.residuals);
}
