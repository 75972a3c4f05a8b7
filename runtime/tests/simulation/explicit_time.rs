//! Forces and grounds that depend on time faster than a body moves: pulses and fast oscillations, from which a body at rest has
//! nothing to tell where to look.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::common::root;
use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;
use std::f64::consts::PI;

hangtime::model! {
    /// A mass on a floor that a machine shakes.
    pub Shaken {
        parameters { m: kg = 1, g: m/s^2 = 9.81, f: N = 12, w: rad/s = 1000 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: f*sin(w*t) }
        surface floor: z >= 0
        impact floor: inelastic
        horizon 2 [s]
    }
}

hangtime::model! {
    /// The same with a machine that runs up.
    pub RunUp {
        parameters { m: kg = 1, g: m/s^2 = 9.81, u: kg m = 1e-4, c: rad/s^2 = 100 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u*(c*t)^2*sin(c*t^2/2) }
        surface floor: z >= 0
        impact floor: inelastic
        horizon 5 [s]
    }
}

hangtime::model! {
    /// A mass on a floor, kicked upwards and to the side.
    pub Kicked {
        parameters { m: kg = 1, g: m/s^2 = 10, up: N = 0, side: N = 0, w: s = 0.01, t0: s = 5.3, mu = 0.5 }
        coordinates { y: m, z: m }
        let kick = exp(-((t - t0)/w)^2)
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: side*kick, z: up*kick }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        horizon 10 [s]
    }
}

hangtime::model! {
    /// A free mass that is kicked.
    pub Free {
        parameters { m: kg = 1, f: N = 100, w: s = 0.01, t0: s = 5.3 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2
        forces { x: f*exp(-((t - t0)/w)^2) }
        horizon 10 [s]
    }
}

hangtime::model! {
    /// A mass on a floor that jerks.
    pub Jerk {
        parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.02, w: s = 0.003, t0: s = 5.3 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= a*exp(-((t - t0)/w)^2)
        impact floor: inelastic
        horizon 10 [s]
    }
}

hangtime::model! {
    /// A mass on a dry guide that is shaken.
    pub Guided {
        parameters { m: kg = 1, f: N = 4, bound: N = 3, w: rad/s = 1000 }
        coordinates { y: m }
        lagrangian m/2*dot(y)^2
        forces { y: f*sin(w*t) }
        dry friction guide: bound bound, sliding dot(y)
    }
}

hangtime::model! {
    /// A puck that drifts towards a wall which vibrates.
    pub Paddle {
        parameters { m: kg = 1, r: m = 0.1, w: rad/s = 5000, v: m/s = 0.05, x0: m = 0.15 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2
        surface wall: x >= r*cos(w*t)
        impact wall: restitution 1
        start { x: x0, dot(x): -v }
        horizon 1.01 [s]
    }
}

/// The default run of a scene, that in numerical time, and the event-driven one.
fn runs(scene: &impl Model) -> [(&'static str, Simulation); 3] {
    let frozen = Fesd {
        formulation: StepFormulation::TimeFreezing,
        ..Fesd::default()
    };
    [
        ("default", simulate(scene).run().unwrap()),
        (
            "time-freezing",
            simulate(scene).method(frozen).run().unwrap(),
        ),
        (
            "event",
            simulate(scene)
                .method(EventDriven::default())
                .run()
                .unwrap(),
        ),
    ]
}

/// Times of lift-offs and landings of [`Shaken`], one flight a period.
fn flights(scene: &Shaken, horizon: f64) -> Vec<f64> {
    let Shaken { m, g, f, w, .. } = *scene;
    let a = f / m;
    let lift = (g / a).asin() / w;
    let height = |t: f64| {
        let s = t - lift;
        a / w * (w * lift).cos() * s
            - 0.5 * g * s * s
            - a / (w * w) * ((w * t).sin() - (w * lift).sin())
    };
    let highest = (PI - (g / a).asin()) / w;
    let landing = root(height, highest, lift + 2.0 * PI / w);
    let both = (0..).flat_map(|k| [lift, landing].map(|t| t + f64::from(k) * 2.0 * PI / w));
    both.take_while(|t| *t < horizon).collect()
}

fn assert_times(what: &str, run: &Simulation, expected: &[f64], within: f64) {
    assert!(run.status.is_solved(), "{what}: {:?}", run.status);
    let found: Vec<f64> = run.events.iter().map(|event| event.time).collect();
    assert_eq!(
        found.len(),
        expected.len(),
        "{what}: {:?}",
        &found[..found.len().min(5)]
    );
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() < within,
            "{what}: {found} instead of {expected}"
        );
    }
}

#[test]
fn a_mass_that_is_shaken_lifts_off_in_every_period_however_short_and_brief_that_is() {
    for (f, w, horizon) in [
        (12.0, 1000.0, 2.0),
        (9.82, 1000.0, 2.0),
        (10.0, 4000.0, 0.3),
    ] {
        let scene = Shaken {
            f,
            w,
            ..Shaken::default()
        };
        let expected = flights(&scene, horizon);
        for (method, run) in [
            ("default", simulate(&scene).horizon(horizon).run().unwrap()),
            (
                "event",
                simulate(&scene)
                    .horizon(horizon)
                    .method(EventDriven::default())
                    .run()
                    .unwrap(),
            ),
        ] {
            assert_times(&format!("{method}, {f} N at {w}/s"), &run, &expected, 1e-8);
        }
    }
}

#[test]
fn a_machine_that_runs_up_lifts_off_as_soon_as_it_can() {
    let scene = RunUp::default();
    let RunUp { u, c, g, .. } = scene;
    let surplus = |t: f64| u * (c * t).powi(2) * (0.5 * c * t * t).sin() - g;
    let first = (0..5_000_000)
        .map(|k| 1e-6 * f64::from(k))
        .find(|&t| surplus(t) > 0.0)
        .unwrap();
    let first = root(|t| -surplus(t), first - 1e-6, first);
    assert!((first - 3.135_579).abs() < 1e-6, "{first}");
    for (method, run) in runs(&scene) {
        assert!(run.status.is_solved(), "{method}: {:?}", run.status);
        assert!(
            (run.events[0].time - first).abs() < 1e-7,
            "{method}: {} instead of {first}",
            run.events[0].time
        );
        // As an integration in steps of a microsecond finds.
        assert_eq!(run.events.len(), 242, "{method}");
    }
}

#[test]
fn a_kick_lifts_off_and_pushes_at_its_own_time() {
    for w in [0.03, 0.01, 0.003] {
        let start = |beyond: f64| 5.3 - w * f64::sqrt(f64::ln(beyond));
        let up = Kicked {
            up: 100.0,
            w,
            ..Kicked::default()
        };
        for (method, run) in runs(&up) {
            assert!(run.status.is_solved(), "{method}, {w}: {:?}", run.status);
            assert!(!run.events.is_empty(), "{method}, {w}");
            assert!(
                (run.events[0].time - start(10.0)).abs() < 1e-8,
                "{method}, {w}: {}",
                run.events[0].time
            );
        }
        let side = Kicked {
            side: 100.0,
            w,
            ..Kicked::default()
        };
        for (method, run) in runs(&side) {
            assert!(run.status.is_solved(), "{method}, {w}: {:?}", run.status);
            assert_eq!(run.events.len(), 2, "{method}, {w}");
            assert!(
                (run.events[0].time - start(20.0)).abs() < 1e-8,
                "{method}, {w}: {}",
                run.events[0].time
            );
        }
    }
}

#[test]
fn a_floor_that_jerks_throws_what_rests_on_it() {
    for w in [0.01, 0.003] {
        let scene = Jerk {
            w,
            ..Jerk::default()
        };
        let pressed = |x: f64| scene.a * (4.0 * x * x - 2.0) / (w * w) * f64::exp(-x * x) + scene.g;
        let first = scene.t0 + w * root(pressed, -3.0, 0.0);
        for (method, run) in runs(&scene) {
            // Pressed with 200 times its weight, the clock of the time-freezing system hardly moves.
            if method == "time-freezing" && w == 0.003 && !run.status.is_solved() {
                assert!(matches!(run.status, SimulationStatus::StepLimit(_)));
                continue;
            }
            assert!(run.status.is_solved(), "{method}, {w}: {:?}", run.status);
            assert!(!run.events.is_empty(), "{method}, {w}");
            assert!(
                (run.events[0].time - first).abs() < 1e-8,
                "{method}, {w}: {} instead of {first}",
                run.events[0].time
            );
        }
    }
}

#[test]
fn a_free_mass_takes_up_the_impulse_of_a_kick() {
    for w in [0.1, 0.01, 0.001] {
        let scene = Free {
            w,
            ..Free::default()
        };
        let expected = scene.f * w * PI.sqrt() / scene.m;
        for (method, run) in runs(&scene) {
            assert!(run.status.is_solved(), "{method}, {w}: {:?}", run.status);
            let v = *run.trajectory.v.last().unwrap().first().unwrap();
            assert!(
                (v - expected).abs() < 1e-8 * expected,
                "{method}, {w}: {v} instead of {expected}"
            );
        }
    }
}

#[test]
fn a_dry_guide_slips_and_sticks_alike_in_any_unit_of_time() {
    let at = |w: f64| Guided {
        w,
        ..Guided::default()
    };
    let expected = simulate(&at(1.0)).horizon(20.0).run().unwrap();
    assert!(expected.status.is_solved() && expected.events.len() > 10);
    assert!((expected.events[0].time - 0.75_f64.asin()).abs() < 1e-10);
    for w in [100.0, 1e3, 1e6] {
        for (method, run) in [
            ("default", simulate(&at(w)).horizon(20.0 / w).run().unwrap()),
            (
                "event",
                simulate(&at(w))
                    .horizon(20.0 / w)
                    .method(EventDriven::default())
                    .run()
                    .unwrap(),
            ),
        ] {
            let times: Vec<f64> = expected.events.iter().map(|event| event.time / w).collect();
            assert_times(&format!("{method}, {w}/s"), &run, &times, 1e-8 / w);
        }
    }
}

#[test]
fn the_first_strike_of_a_fast_wall_is_found() {
    let scene = Paddle::default();
    let Paddle { r, w, v, x0, .. } = scene;
    let gap = |t: f64| x0 - v * t - r * (w * t).cos();
    let after = (0..1_100_000)
        .map(|k| 0.9 + 1e-7 * f64::from(k))
        .find(|&t| gap(t) < 0.0)
        .unwrap();
    let first = root(gap, after - 1e-7, after);
    for (method, run) in runs(&scene) {
        let found = run.events.first().unwrap().time;
        assert!(
            (found - first).abs() < 1e-7,
            "{method}: {found} instead of {first}"
        );
    }
}

#[test]
fn what_is_faster_than_any_step_is_said() {
    let said = |run: &Simulation| run.notes.iter().any(|note| note.contains("faster than"));
    let at = |w: f64| Shaken {
        f: 5.0,
        w,
        ..Shaken::default()
    };
    let event = EventDriven::default();
    let run = simulate(&at(1e8)).method(event).run().unwrap();
    assert!(run.status.is_solved() && said(&run), "{:?}", run.notes);
    // Twenty steps know what they are too long for.
    let grid = Fesd::default().with_grid(20, 3);
    let run = simulate(&at(1e3)).method(grid).run().unwrap();
    assert!(said(&run), "{:?}", run.notes);
    for (method, run) in runs(&at(1e3)) {
        assert!(run.notes.is_empty(), "{method}: {:?}", run.notes);
    }
}
