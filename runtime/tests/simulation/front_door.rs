//! `simulate(&model)` and what its results say.

#![allow(clippy::unwrap_used, reason = "test code")]

use std::f64::consts::PI;

use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, Simulator};

hangtime::model! {
    /// A mass on a spring.
    pub Spring {
        parameters { m: kg = 2, k: N/m = 8 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - k/2*z^2
        surface far_away: z + 100[m] >= 0
        impact far_away: inelastic
        start { z: 1 [m] }
        horizon 3 [s]
    }
}

hangtime::model! {
    /// A ball that bounces once in a while and is pushed.
    pub Ball {
        parameters { m: kg = 0.5, g: m/s^2 = 9.81, e = 0.7 }
        coordinates { x: m, z: m }
        controls { push: N }
        lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
        forces { x: push }
        surface floor: z >= 0
        impact floor: restitution e
        start { z: 2 [m], dot(x): 1 [m/s] }
        horizon 1 [s]
    }
}

/// Largest errors of coordinate and velocity between the points, against `cos(2 t)`.
fn spring_errors(steps: usize) -> (f64, f64) {
    let method = Fesd::default().with_grid(steps, 1);
    let spring = Spring::default();
    let run = simulate(&spring).method(method).run().unwrap();
    let mut errors = (0.0_f64, 0.0_f64);
    for k in 0..=1000 {
        let time = 3.0 * f64::from(k) / 1000.0;
        let state = run.at(time).unwrap();
        errors.0 = errors.0.max((state["z"] - (2.0 * time).cos()).abs());
        errors.1 = errors
            .1
            .max((state["dot(z)"] + 2.0 * (2.0 * time).sin()).abs());
    }
    errors
}

#[test]
fn states_between_points_are_of_order_four_and_three() {
    let (coarse, fine) = (spring_errors(30), spring_errors(60));
    // The grid itself is of order 5; half an order is left to the higher terms.
    assert!(coarse.0 / fine.0 > 2.0_f64.powf(3.5), "{coarse:?} {fine:?}");
    assert!(coarse.1 / fine.1 > 2.0_f64.powf(2.5), "{coarse:?} {fine:?}");
    // max |q''''| h^4 / 384 with h = 0.05, |q''''| = 16; and |q''''| h^3 / (72 sqrt 3) for the slope.
    assert!(fine.0 < 1.5 * 16.0 * 0.05_f64.powi(4) / 384.0, "{fine:?}");
    assert!(fine.1 < 1.5 * 16.0 * 0.05_f64.powi(3) / 124.7, "{fine:?}");
}

#[test]
fn states_on_both_sides_of_an_impact_follow_their_own_parabola() {
    let (g, e) = (9.81, 0.7);
    let ball = Ball::default();
    for method in [&Fesd::default() as &dyn Simulator, &EventDriven::default()] {
        let problem = InitialValueProblem::of(&ball, None).unwrap();
        let run = method.simulate(&ball, &problem, &mut |_| true).unwrap();
        let impact = (2.0_f64 * 2.0 / g).sqrt();
        let found = run.events[0].time;
        assert!((found - impact).abs() < 1e-9);
        // Cubics reproduce parabolas; what remains is the time of the impact.
        for time in [0.1, 0.5, impact - 1e-7, impact + 1e-7, 0.7, 0.999] {
            let state = run.at(time).unwrap();
            let since = time - impact;
            let (z, v) = if since < 0.0 {
                (2.0 - g / 2.0 * time * time, -g * time)
            } else {
                let up = e * g * impact;
                (up * since - g / 2.0 * since * since, up - g * since)
            };
            assert!((state["z"] - z).abs() < 1e-8, "{time}: {state}");
            assert!((state["dot(z)"] - v).abs() < 1e-8, "{time}: {state}");
            assert!((state["x"] - time).abs() < 1e-12);
        }
        let (before, after) = (run.just_before(found).unwrap(), run.at(found).unwrap());
        assert!((before["dot(z)"] + g * impact).abs() < 1e-8);
        assert!((after["dot(z)"] - e * g * impact).abs() < 1e-8);
        assert_eq!(before.time, after.time);
    }
}

#[test]
fn state_outside_of_what_was_simulated_is_refused() {
    let ball = Ball::default();
    let run = simulate(&ball).run().unwrap();
    for time in [-1e-9, 1.0 + 1e-9, f64::NAN, f64::INFINITY] {
        let refused = run.at(time).unwrap_err().to_string();
        assert!(
            refused.contains("in 0..=1 s") || refused.contains("in 0..=1"),
            "{refused}"
        );
    }
    let stopped = simulate(&ball)
        .observer(|now| now.time < 0.25)
        .run()
        .unwrap();
    assert!(stopped.at(0.9).is_err() && stopped.at(0.2).is_ok());
}

#[test]
fn series_and_states_know_the_names_of_the_scene() {
    let ball = Ball::default();
    let run = simulate(&ball)
        .controls(ControlSignal::constant(&[0.25]))
        .run()
        .unwrap();
    let last = run.trajectory.time.len() - 1;
    assert_eq!(run["time"][last], 1.0);
    assert_eq!(run["x"][last], run.trajectory.q[last][0]);
    assert_eq!(run["dot( z )"][last], run.trajectory.v[last][1]);
    assert!(run["push"].iter().all(|&push| push == 0.25));
    assert_eq!(run["force(floor)"].len(), last + 1);
    let state = run.at(0.5).unwrap();
    // Uniform acceleration by 0.25 N / 0.5 kg.
    assert!((state["x"] - (0.5 + 0.5 / 2.0 * 0.25)).abs() < 1e-12);
    assert_eq!(state.get("push"), Some(0.25));
    for unknown in ["y", "dot(push)", "force(z)", "friction(floor)", ""] {
        assert_eq!(state.get(unknown), None, "{unknown}");
        assert!(run.series(unknown).is_none(), "{unknown}");
    }
    assert_eq!(
        state.to_string(),
        format!(
            "t = 0.5 s: x = 0.5625 m, z = {:.5} m, dot(x) = 1.25 m/s, dot(z) = {:.3} m/s, push = 0.25 N",
            2.0 - 9.81 / 8.0,
            -9.81 / 2.0
        )
    );
}

#[test]
#[should_panic(
    expected = "`Ball` has no `y`; it has x, z, dot(x), dot(z), push, force(floor), impulse(floor), time"
)]
fn indexing_by_an_unknown_name_tells_the_known_ones() {
    let ball = Ball::default();
    let run = simulate(&ball).run().unwrap();
    let _ = run["y"];
}

#[test]
fn result_prints_status_events_and_the_last_state() {
    let ball = Ball::default();
    let run = simulate(&ball).horizon(0.7).run().unwrap();
    let printed = run.to_string();
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines[0], "solved");
    assert_eq!(lines[1], "0.638551 s: impact at floor");
    assert!(
        lines[2].starts_with("t = 0.7 s: x = 0.7 m, z = "),
        "{printed}"
    );
    assert!(lines[2].ends_with(", push = 0 N"), "{printed}");
    let stopped = simulate(&ball)
        .observer(|_| false)
        .run()
        .unwrap()
        .to_string();
    assert!(stopped.starts_with("interrupted at t = "), "{stopped}");
}

#[test]
fn every_method_stops_where_its_observer_says() {
    let spring = Spring::default();
    let methods: [&dyn Simulator; 5] = [
        &EventDriven::default(),
        &Fesd::default(),
        &Moreau::default(),
        &FixedStep::default(),
        &Smooth::default(),
    ];
    let problem = InitialValueProblem::of(&spring, None).unwrap();
    for method in methods {
        let (mut seen, mut last) = (0, -1.0);
        let run = method
            .simulate(&spring, &problem, &mut |now| {
                assert!(now.time >= last && now.step == "simulation");
                (seen, last) = (seen + 1, now.time);
                now.time < 0.8
            })
            .unwrap();
        let name = method.name();
        assert!(
            matches!(run.status, SimulationStatus::Interrupted(_)),
            "{name}: {}",
            run.status
        );
        assert!(
            seen > 1 && (0.8..1.5).contains(&last),
            "{name}: {seen}, {last}"
        );
        assert!(run.at(0.7).is_ok() && run.at(2.9).is_err(), "{name}");
    }
}

#[test]
fn settings_of_the_door_reach_the_method_or_are_refused() {
    let ball = Ball::default();
    let run = simulate(&ball)
        .steps(7)
        .start("z", 5.0)
        .horizon(0.5)
        .run()
        .unwrap();
    assert!((run.at(0.5).unwrap()["z"] - (5.0 - 9.81 / 8.0)).abs() < 1e-12);
    let stiff = simulate(&ball)
        .method(EventDriven::default())
        .tolerance(1e-30);
    assert!(
        stiff
            .run()
            .unwrap_err()
            .to_string()
            .contains("tolerance = ")
    );
    for (refused, said) in [
        (
            simulate(&ball)
                .method(Moreau::default())
                .tolerance(1e-6)
                .run(),
            "a tolerance of method moreau",
        ),
        (
            simulate(&ball)
                .method(EventDriven::default())
                .steps(10)
                .run(),
            "a number of steps of method event",
        ),
        (
            simulate(&ball).start("y", 0.0).run(),
            "the start of `Ball` has no `y`; it has x, dot(x), z, dot(z)",
        ),
        (simulate(&ball).start("push", 1.0).run(), "has no `push`"),
        (
            simulate(&ball).points(3).run(),
            "points of the trajectory = 3: must be at least 100",
        ),
    ] {
        let refused = refused.unwrap_err();
        assert!(refused.to_string().contains(said), "{refused}");
        // What a program prints whose `main` returns the error.
        assert_eq!(format!("{refused:?}"), refused.to_string());
    }
    let nothing = solve(&ball).run().unwrap_err().to_string();
    assert!(
        nothing.contains("`Ball`, which declares no objective"),
        "{nothing}"
    );
}

#[test]
fn horizons_beyond_what_numbers_resolve_are_refused_by_every_method() {
    let spring = Spring::default();
    let methods: [&dyn Simulator; 5] = [
        &EventDriven::default(),
        &Fesd::default(),
        &Moreau::default(),
        &FixedStep::default(),
        &Smooth::default(),
    ];
    for method in methods {
        for horizon in [5e-324, 1e-200, f64::MIN_POSITIVE, 1e250, f64::MAX] {
            let problem = InitialValueProblem::of(&spring, Some(horizon)).unwrap();
            let refused = method
                .simulate(&spring, &problem, &mut |_| true)
                .unwrap_err();
            assert!(
                refused.to_string().contains("from 1e-100 to 1e100"),
                "{refused}"
            );
        }
    }
}

#[test]
fn long_trajectory_is_thinned_with_a_note_and_keeps_its_motion() {
    let spring = Spring::default();
    let whole = simulate(&spring).method(Moreau::default()).steps(20_000);
    let whole = whole.run().unwrap();
    assert!(whole["time"].len() == 20_001 && whole.notes.len() == 1);
    for (method, steps) in [
        (
            Box::new(Moreau {
                steps: 20_000,
                ..Moreau::default()
            }) as Box<dyn Simulator>,
            20_000,
        ),
        (
            Box::new(FixedStep {
                steps: 9_000,
                ..FixedStep::default()
            }),
            9_000,
        ),
        (Box::new(Fesd::default().with_grid(1_500, 2)), 3_000),
    ] {
        let mut problem = InitialValueProblem::of(&spring, None).unwrap();
        problem.points = 600;
        let run = method.simulate(&spring, &problem, &mut |_| true).unwrap();
        let name = method.name();
        assert!(
            // Beyond half of the most points every other one goes.
            (150..=600).contains(&run["time"].len()),
            "{name}: {}",
            run["time"].len()
        );
        assert!(run.counts.elements >= steps, "{name}");
        assert!(
            run.notes.iter().any(|note| note.contains("raise `points`")),
            "{name}"
        );
        assert_eq!(run["time"].last(), Some(&3.0), "{name}");
        // Points no wider than 3/150 apart: the cubic is exact to 16 h^4 / 384.
        for time in [0.3, 1.7, 2.95] {
            let error = (run.at(time).unwrap()["z"] - (2.0 * time).cos()).abs();
            assert!(error < 1e-7, "{name}: {error:e} at {time}");
        }
    }
    let mut problem = InitialValueProblem::of(&spring, None).unwrap();
    problem.points = 400;
    let dense = EventDriven {
        output_times: 401,
        ..EventDriven::default()
    };
    let refused = dense
        .simulate(&spring, &problem, &mut |_| true)
        .unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("output times = 401: must be at most 400; raise")
    );
}

#[test]
fn signals_without_or_with_short_values_are_refused() {
    let ball = Ball::default();
    let signals = [
        ControlSignal::PiecewiseConstant {
            times: vec![],
            values: vec![],
        },
        ControlSignal::PiecewiseLinear {
            times: vec![0.0, 1.0],
            values: vec![vec![1.0]],
        },
        ControlSignal::PiecewiseLinear {
            times: vec![0.0],
            values: vec![vec![]],
        },
        ControlSignal::constant(&[1.0, PI]),
    ];
    for signal in signals {
        let mut u = [0.0];
        assert!(signal.write(0.5, &mut u).is_err(), "{signal:?}");
        assert!(simulate(&ball).controls(signal).run().is_err());
    }
}

hangtime::model! {
    /// A ball with friction whose quantities are recorded.
    Recorded {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        outputs { energy: J = m/2*|dot((y, z))|^2 + m*g*z, rub: N = friction_force(floor), shifted: m = y + 3 [m/s]*t }
        start { dot(y): 3 }
        horizon 0.5 [s]
    }
}

#[test]
fn outputs_are_known_by_name_at_the_points_and_between_them() {
    let scene = Recorded::default();
    let methods: [Box<dyn Simulator>; 3] = [
        Box::new(Fesd::default()),
        Box::new(EventDriven::default()),
        Box::new(Moreau::default()),
    ];
    for method in methods {
        let problem = InitialValueProblem::of(&scene, None).unwrap();
        let run = method.simulate(&scene, &problem, &mut |_| true).unwrap();
        assert_eq!(run["energy"].len(), run["time"].len());
        assert!((run["energy"][0] - 9.0).abs() < 1e-12);
        let state = run.at(0.123).unwrap();
        // The cubic between two points is exact for a parabola; linear energies would be wrong by their curvature.
        let speed = 3.0 - 0.3 * 9.81 * 0.123;
        assert!((state["energy"] - speed * speed).abs() < 1e-8, "{state}");
        assert!((state["rub"] + 0.3 * 2.0 * 9.81).abs() < 1e-6);
        assert!((state["shifted"] - state["y"] - 0.369).abs() < 1e-12);
        assert_eq!(state.get("energy"), Some(state["energy"]));
        assert_eq!(state.outputs.len(), 3);
        assert!(run.series("energies").is_none());
    }
}

#[test]
#[should_panic(expected = "friction_force(floor), impulse(floor), energy, rub, shifted, time")]
fn indexing_by_an_unknown_name_tells_the_outputs() {
    let run = simulate(&Recorded::default()).run().unwrap();
    let _ = &run["energies"];
}
