//! Impulses of impacts, at their events and in outputs, against closed forms and the balance of momentum.

#![allow(clippy::unwrap_used, reason = "a failed step fails the test")]

use hangtime::baselines::{Moreau, Smooth};
use hangtime::model::{Model, contact_point, tangent_point};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator, StepFormulation, Trajectory};

hangtime::model! {
    /// A ball falls to the bottom of a valley, where both sides stop it.
    Valley {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface left: z >= -y
        surface right: z >= y
        impact left, right: inelastic
        outputs { left: N s = impulse(left), right: N s = impulse(right) }
        start { z: height }
        horizon 0.6 [s]
    }
}

hangtime::model! {
    /// A ball that bounces.
    Bouncing {
        parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.7, height: m = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        outputs { given: N s = impulse(floor), both: N s = 2*given + 1 [N s] }
        start { z: height }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A ball that is thrown on a rough floor.
    Thrown {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.2, height: m = 1, speed: m/s = 3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        outputs { down: N s = impulse(floor), rub: N s = friction_impulse(floor) }
        start { z: height, dot(y): speed }
        horizon 0.46 [s]
    }
}

hangtime::model! {
    /// A plank with two ends on a rough floor; its centre lies nearer to the right one.
    Plank {
        parameters { m: kg = 2, j: kg m^2 = 0.3, g: m/s^2 = 9.81, mu = 0.2, e = 0, a: m = 0.6, b: m = 0.2 }
        coordinates { y: m, z: m, phi: rad }
        lagrangian m/2*|dot((y, z))|^2 + j/2*dot(phi)^2 - m*g*z
        surface left: z - a*sin(phi) >= 0
        surface right: z + b*sin(phi) >= 0
        impact left, right: restitution e, friction mu, sliding dot(y)
        start { z: 1, dot(y): 3 }
        horizon 0.46 [s]
    }
}

fn run(method: &dyn Simulator, model: &dyn Model) -> Simulation {
    let problem = InitialValueProblem::of(model, None).unwrap();
    let run = method.simulate(model, &problem, &mut |_| true).unwrap();
    assert!(run.status.is_solved(), "{}: {}", method.name(), run.status);
    run
}

/// The methods that know impacts, with the accuracy to which they know their times and velocities here.
fn methods() -> [(Box<dyn Simulator>, f64); 3] {
    let formulated = |formulation, steps| Fesd {
        formulation,
        steps,
        ..Fesd::default()
    };
    [
        (Box::new(Fesd::default()), 1e-9),
        (
            Box::new(formulated(StepFormulation::TimeFreezing, None)),
            1e-9,
        ),
        (Box::new(EventDriven::default()), 1e-9),
    ]
}

fn assert_near(found: &[f64], wanted: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (a, b) in found.iter().zip(wanted) {
        assert!((a - b).abs() <= tolerance, "{what}: {found:?} {wanted:?}");
    }
}

/// A fixed sequence of numbers from -1 to 1.
fn numbers(count: usize) -> impl Iterator<Item = f64> {
    (1..=count).map(|k| (k as f64 * 12.9898).sin() * 43_758.545_3 % 1.0)
}

#[test]
fn impulses_of_tumbling_planks_are_the_change_of_momentum_within_the_laws() {
    let mut random = numbers(600);
    let mut impacts = 0;
    for _ in 0..60 {
        let mut next = || random.next().unwrap();
        let plank = Plank {
            mu: 0.5 * next().abs(),
            e: 0.6 * next().abs(),
            ..Plank::default()
        };
        let mut problem = InitialValueProblem::of(&plank, None).unwrap();
        problem.q[2] = next();
        problem.v = vec![3.0 * next(), 2.0 * next(), 5.0 * next()];
        problem.horizon = 1.0;
        let run = EventDriven::default()
            .simulate(&plank, &problem, &mut |_| true)
            .unwrap();
        for event in &run.events {
            if event.kind != EventKind::Impact {
                continue;
            }
            impacts += 1;
            let (n, mut mass) = (3, [0.0; 9]);
            let x = [&event.q[..], &event.v_after].concat();
            plank.mass_matrix(&x, &mut mass);
            let mut rest: Vec<f64> = (0..n)
                .map(|row| {
                    let jump = event.v_after.iter().zip(&event.v_before);
                    let row = &mass[n * row..n * (row + 1)];
                    row.iter().zip(jump).map(|(m, (a, b))| m * (a - b)).sum()
                })
                .collect();
            for i in 0..2 {
                let (load, rub) = (event.contact_impulse[i], event.friction_impulse[i]);
                let mut point = vec![0.0; contact_point::length(n)];
                let mut tangent = vec![0.0; tangent_point::length(n)];
                plank.contact(i, &x, &mut point);
                plank.tangent(i, &x, &mut tangent);
                for (k, rest) in rest.iter_mut().enumerate() {
                    *rest -= load * point[contact_point::NORMAL + k];
                    *rest -= rub * tangent[tangent_point::TANGENT + k];
                }
                // Bounces of some 1e-6 m/s are ended, whatever the law would make of them.
                assert!(load >= -1e-5 && rub.abs() <= plank.mu * load + 1e-5);
            }
            // Rounding of momenta of some kg m/s.
            assert_near(&rest, &[0.0; 3], 1e-12, "momentum");
        }
    }
    assert!(impacts >= 100, "{impacts}");
}

/// The scene of [`Thrown`] declares its impulses as outputs; whoever asks by the name of the contact gets the same.
#[test]
fn impulses_by_the_name_of_a_contact_are_those_of_outputs() {
    let ball = Thrown::default();
    for (method, _) in methods() {
        let run = run(method.as_ref(), &ball);
        let impact = run.events[0].time;
        for (name, output) in [
            ("impulse(floor)", "down"),
            ("friction_impulse(floor)", "rub"),
        ] {
            assert_eq!(run[name], run[output], "{name}, {}", method.name());
            for time in [0.0, impact, *run["time"].last().unwrap()] {
                let state = run.at(time).unwrap();
                assert_eq!(state[name], state[output], "{name} at {time}");
                assert_eq!(state.get(name), Some(state[output]), "{name} at {time}");
            }
            assert_ne!(run.at(impact).unwrap()[name], 0.0, "{name}");
            assert_eq!(run.just_before(impact).unwrap()[name], 0.0, "{name}");
        }
        assert_eq!(run["friction_force(floor)"], run["friction(floor)"]);
    }
    // No column of a scene without friction is another one.
    let run = run(&Fesd::default(), &Bouncing::default());
    assert_eq!(run["impulse(floor)"], run["given"]);
}

#[test]
fn methods_without_impacts_know_no_impulses() {
    let ball = Valley::default();
    for method in [
        Box::new(Moreau::default()) as Box<dyn Simulator>,
        Box::new(Smooth::default()),
    ] {
        let problem = InitialValueProblem::of(&ball, None).unwrap();
        let run = method.simulate(&ball, &problem, &mut |_| true).unwrap();
        assert!(run["left"].iter().all(|value| value.is_nan()));
        assert!(run["impulse(left)"].iter().all(|value| value.is_nan()));
        let note = run.notes.iter().any(|note| note.contains("impulses"));
        assert!(note, "{}: {:?}", method.name(), run.notes);
    }
    assert!(Trajectory::default().impulses(0).is_empty());
}
