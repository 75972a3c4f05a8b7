//! Optimal control of motions that depend on the time itself, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::root::root;
use crate::support::{assert_program, linear, one_start, solve, time_freezing};
use hangtime::ocp::ControlShape;
use hangtime::simulation::EventKind;

/// The solver's tolerance is 1e-9, that of the re-simulation 1e-12.
const DIGITS: f64 = 1e-8;

hangtime::model! {
    /// A cart in a wind that grows.
    Sail {
        parameters { m: kg = 1, rise: N/s = 1 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u + rise*t }
        minimize time
        finally { y == 1[m] }
    }
}

#[test]
fn least_time_in_a_growing_wind_is_that_of_the_closed_form() {
    // T^2 / 2 + T^3 / 6 = 1
    let fastest = root(|t| 1.0 - t * t / 2.0 - t.powi(3) / 6.0, 0.0, 2.0);
    let sail = Sail::default();
    for settings in [one_start(), linear(), time_freezing()] {
        let solution = solve(&sail, 3, &settings);
        assert!(
            (solution.horizon - fastest).abs() < DIGITS,
            "{} against {fastest}",
            solution.horizon
        );
        if solution.time_freezing.is_some() {
            assert_program(&solution, DIGITS);
        }
    }
}

hangtime::model! {
    /// A cart that is shaken, and has to cross 1 m in 1 s from rest to rest at least effort.
    Shaken {
        parameters { m: kg = 1, f: N = 3, w: 1/s = 7 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u + f*sin(w*t) }
        minimize integral(u^2)
        finally { y == 1[m], dot(y) == 0 }
        horizon 1 [s]
    }
}

#[test]
fn least_effort_of_a_shaken_cart_is_the_closed_form_under_linear_controls() {
    let mut settings = one_start();
    settings.controls = ControlShape::Linear;
    // Order 15: the shaking is no polynomial.
    settings.stages = 8;
    let solution = solve(&Shaken::default(), 4, &settings);
    // The costate of the force is affine in time: u = a + b t, with the impulse and the displacement that the
    // shaking leaves to do: a + b/2 = -p and a/2 + b/6 = 1 - d.
    let (f, w) = (3.0_f64, 7.0_f64);
    let (p, d) = (f * (1.0 - w.cos()) / w, f * (w - w.sin()) / (w * w));
    let b = 12.0 * (-p / 2.0 - (1.0 - d));
    let a = -p - b / 2.0;
    for (node, u) in solution.controls.iter().enumerate() {
        let expected = a + b * node as f64 / 4.0;
        assert!(
            (u[0] - expected).abs() < 1e-7,
            "{} against {expected}",
            u[0]
        );
    }
    let effort = a * a + a * b + b * b / 3.0;
    assert!(
        (solution.objective - effort).abs() < 1e-7,
        "{}",
        solution.objective
    );
}

hangtime::model! {
    /// A ball that is rolled along a platform that swings up and down.
    Platform {
        parameters { m: kg = 1, g: m/s^2 = 9.81, a: m = 0.5, w: 1/s = 6 }
        coordinates { y: m, z: m }
        controls { u: N in -20..=20 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface platform: z - a*sin(w*t) >= 0
        impact platform: inelastic
        minimize integral(u^2)
        finally { y == 1[m], dot(y) == 0 }
        start { dot(z): 3 [m/s] }
        horizon 1 [s]
    }
}

#[test]
fn lift_off_and_landing_on_a_moving_platform_are_those_of_the_ballistic_flight() {
    let (g, a, w) = (9.81_f64, 0.5_f64, 6.0_f64);
    // The platform falls away where its acceleration is that of gravity.
    let lift_off = (g / (a * w * w)).asin() / w;
    let (z, v) = (a * (w * lift_off).sin(), a * w * (w * lift_off).cos());
    let gap =
        |t: f64| z + v * (t - lift_off) - g / 2.0 * (t - lift_off).powi(2) - a * (w * t).sin();
    let soon = lift_off + 0.1;
    assert!(gap(soon) > 0.0 && gap(2.0) < 0.0);
    let landing = root(gap, soon, 2.0);
    for controls in [ControlShape::Constant, ControlShape::Linear] {
        let mut settings = one_start();
        settings.controls = controls;
        // Order 15: the platform moves like no polynomial.
        settings.stages = 8;
        let solution = solve(&Platform::default(), 4, &settings);
        let expected = [(lift_off, EventKind::LiftOff), (landing, EventKind::Impact)];
        assert_eq!(solution.planned_events.len(), 2);
        for (&(time, kind, _), expected) in solution.planned_events.iter().zip(expected) {
            assert_eq!(kind, expected.1);
            assert!(
                (time - expected.0).abs() < DIGITS,
                "{time} against {expected:?}"
            );
        }
        // The platform carries no force along itself.
        let effort = if controls == ControlShape::Linear {
            12.0
        } else {
            12.0 * 16.0 / 15.0
        };
        assert!(
            (solution.objective - effort).abs() < 1e-7,
            "{}",
            solution.objective
        );
    }
}
