//! Friction against ground that moves, by every simulator: closed forms, and the same motion seen from the ground.

#![allow(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::{last, start};
use hangtime::baselines::Moreau;
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator, StepFormulation};

const G: f64 = 9.81;

hangtime::model! {
    /// A parcel on a conveyor belt that moves at the speed `w`, and speeds up at the rate `a`.
    Belt {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.3, w: m/s = 1, a: m/s^2 = 0, e = 0, height: m = 0 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface belt: z >= 0
        impact belt: restitution e, friction mu, sliding dot(y) - w - a*t
        start { z: height }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A block on a belt, held by a spring whose end is at rest.
    Held {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 16, mu = 0.4, w: m/s = 0.5, stretch: m = 1.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z - k/2*y^2
        surface belt: z >= 0
        impact belt: inelastic, friction mu, sliding dot(y) - w
        start { y: stretch }
        horizon 3 [s]
    }
}

hangtime::model! {
    /// The same, seen from the belt: the end of the spring moves.
    Dragged {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 16, mu = 0.4, w: m/s = 0.5, stretch: m = 1.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: -k*(y + w*t) }
        surface belt: z >= 0
        impact belt: inelastic, friction mu, sliding dot(y)
        start { y: stretch, dot(y): -w }
        horizon 3 [s]
    }
}

/// The simulators that locate switches.
fn exact() -> [Box<dyn Simulator>; 3] {
    let event = EventDriven {
        tolerance: 1e-12,
        ..EventDriven::default()
    };
    let mut time_freezing = Fesd::default().with_grid(30, 2);
    time_freezing.formulation = StepFormulation::TimeFreezing;
    [
        Box::new(Fesd::default()),
        Box::new(event),
        Box::new(time_freezing),
    ]
}

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let run = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("accepted");
    assert!(run.status.is_solved(), "{}: {run}", simulator.name());
    run
}

#[test]
fn parcel_slides_until_it_moves_with_the_belt_and_rides_on() {
    // Friction drives it at mu g up to the speed of the belt.
    let belt = Belt::default();
    let problem = InitialValueProblem::of(&belt, None).unwrap();
    let t = belt.w / (belt.mu * G);
    let rides = belt.w * belt.w / (2.0 * belt.mu * G) + belt.w * (1.0 - t);
    for simulator in exact() {
        let run = run(simulator.as_ref(), &belt, &problem);
        assert_eq!(
            run.initial_modes,
            [ContactMode::Slip(Direction::Backward)],
            "{}",
            simulator.name()
        );
        let kinds: Vec<EventKind> = run.events.iter().map(|event| event.kind).collect();
        assert_eq!(kinds, [EventKind::Stick], "{}", simulator.name());
        // Parabolas are exact; the tolerance of the event-driven method is 1e-12.
        assert!((run.events[0].time - t).abs() < 1e-11, "{run}");
        let (q, v) = last(&run.trajectory);
        assert!((q[0] - rides).abs() < 1e-11 && (v[0] - belt.w).abs() < 1e-11);
    }
    // Moreau's method knows the switch to a step.
    let steps = 1000;
    let mut moreau = Moreau::default();
    moreau.set_steps(steps).unwrap();
    let moved = run(&moreau, &belt, &problem);
    let (q, v) = last(&moved.trajectory);
    let step = 1.0 / steps as f64;
    assert!((q[0] - rides).abs() < belt.w * step && (v[0] - belt.w).abs() < 1e-12);
}

#[test]
fn belt_that_speeds_up_takes_along_what_friction_can() {
    for (rate, carried) in [(2.0, true), (4.0, false)] {
        let belt = Belt {
            w: 0.0,
            a: rate,
            ..Belt::default()
        };
        let problem = InitialValueProblem::of(&belt, None).unwrap();
        let acceleration = if carried { rate } else { belt.mu * G };
        for simulator in exact() {
            let run = run(simulator.as_ref(), &belt, &problem);
            let mode = if carried {
                ContactMode::Stick
            } else {
                ContactMode::Slip(Direction::Backward)
            };
            assert_eq!(run.initial_modes, [mode], "{} at {rate}", simulator.name());
            let (q, v) = last(&run.trajectory);
            assert!((q[0] - 0.5 * acceleration).abs() < 1e-11, "{run}");
            assert!((v[0] - acceleration).abs() < 1e-11, "{run}");
        }
    }
}

#[test]
fn landing_on_a_belt_takes_its_speed_as_far_as_friction_allows() {
    for (w, e) in [(1.0, 0.0), (4.0, 0.0), (1.0, 0.5), (4.0, 0.5)] {
        let belt = Belt {
            w,
            e,
            height: 0.5,
            ..Belt::default()
        };
        let mut problem = InitialValueProblem::of(&belt, None).unwrap();
        let fall = (2.0 * belt.height / G).sqrt();
        let speed = G * fall;
        problem.horizon = 1.5 * fall;
        // The tangential impulse is mu times the normal one, m (1 + e) v_n, or what brings it to the speed of the belt.
        let after = f64::min(w, belt.mu * (1.0 + e) * speed);
        for simulator in exact() {
            let run = run(simulator.as_ref(), &belt, &problem);
            let impact = &run.events[0];
            assert_eq!(impact.kind, EventKind::Impact);
            assert!((impact.time - fall).abs() < 1e-11);
            assert!((impact.v_after[0] - after).abs() < 1e-11, "{impact:?}");
            assert!((impact.v_after[1] - e * speed).abs() < 1e-11, "{impact:?}");
            // The belt does work, which is nobody's mistake.
            let warned = run.notes.iter().any(|note| note.contains("raise"));
            assert!(!warned, "{:?}", run.notes);
        }
    }
}

#[test]
fn motion_on_a_belt_is_that_on_the_floor_seen_from_the_belt() {
    let (held, dragged) = (Held::default(), Dragged::default());
    let on_belt = InitialValueProblem::of(&held, None).unwrap();
    let from_belt = InitialValueProblem::of(&dragged, None).unwrap();
    for simulator in exact() {
        let seen = run(simulator.as_ref(), &held, &on_belt);
        let moved = run(simulator.as_ref(), &dragged, &from_belt);
        let kinds = |run: &Simulation| -> Vec<EventKind> {
            run.events.iter().map(|event| event.kind).collect()
        };
        assert_eq!(seen.events.len(), 3, "{seen}");
        assert_eq!(kinds(&seen), kinds(&moved), "{}", simulator.name());
        // Both are accurate to their own estimates.
        let error = seen.error_estimate.unwrap() + moved.error_estimate.unwrap() + 1e-11;
        for (a, b) in seen.events.iter().zip(&moved.events) {
            assert!((a.time - b.time).abs() < 10.0 * error, "{a:?} {b:?}");
        }
        let (q, v) = last(&seen.trajectory);
        let (p, u) = last(&moved.trajectory);
        let way = held.w * on_belt.horizon;
        assert!((q[0] - p[0] - way).abs() < 10.0 * error);
        assert!((v[0] - u[0] - held.w).abs() < 10.0 * error);
    }
}

#[test]
fn body_in_flight_above_a_belt_falls_straight() {
    let belt = Belt::default();
    let run = run(
        &Fesd::default(),
        &belt,
        &start(&[0.0, 10.0], &[0.0, 0.0], 1.0),
    );
    assert!(run.events.is_empty());
    assert_eq!(last(&run.trajectory).0[0], 0.0);
}
