//! What counts as zero in the event-driven simulator: releases and grazing against closed forms, and that results
//! depend neither on the place of a scene nor on its units.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::model::Model;
use hangtime::simulation::{
    EventDriven, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

hangtime::model! {
    /// A mass on a track of sines.
    pub Crests {
        parameters { m: kg = 0.4, a: m = 0.25, k: 1/m = 1.7, g: m/s^2 = 3.71, v: m/s = 1 }
        coordinates { x: m, z: m }
        fn track(p) = a*sin(k*p)
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface track: z - track(x) >= 0
        impact track: inelastic
        start { dot(x): v, dot(z): v*diff(track)(0) }
        horizon 2.5 [s]
    }
}

hangtime::model! {
    /// A rod whose ends hit an incline with friction and restitution.
    pub Rod {
        parameters {
            m: kg = 1.7, j: kg m^2 = 0.21, a: m = 0.45, b: m = 0.6, g: m/s^2 = 9.81, slope = 0.15, mu = 0.25,
            e_left = 0.4, e_right = 0.3, x0: m = 0, z0: m = 0, height: m = 0.9, angle0 = 0.3, v_x: m/s = 0.8,
            v_z: m/s = -1.1, spin: 1/s = 0.7,
        }
        coordinates { x: m, z: m, angle }
        let left = (x - x0 - a*cos(angle), z - z0 - a*sin(angle))
        let right = (x - x0 + b*cos(angle), z - z0 + b*sin(angle))
        lagrangian m/2*|dot((x, z))|^2 + j/2*dot(angle)^2 - m*g*z
        surface left: left.y*sin(slope) + left.z*cos(slope) >= 0
        surface right: right.y*sin(slope) + right.z*cos(slope) >= 0
        impact left: restitution e_left, friction mu, sliding dot(left.y*cos(slope) - left.z*sin(slope))
        impact right: restitution e_right, friction mu, sliding dot(right.y*cos(slope) - right.z*sin(slope))
        start {
            x: x0, z: z0 + height, angle: angle0, dot(x): v_x, dot(z): v_z, dot(angle): spin,
        }
        horizon 1.2 [s]
    }
}

fn simulate(model: &dyn Model, tolerance: f64) -> Simulation {
    let problem = InitialValueProblem::of(model, None).unwrap();
    let simulator = EventDriven {
        tolerance,
        ..EventDriven::default()
    };
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

#[test]
fn crests_passed_with_vanishing_force_are_passed() {
    for (a, k, g) in [
        (0.25_f64, 1.7_f64, 3.71_f64),
        (0.6, 0.9, 9.81),
        (0.1, 4.0, 1.62),
    ] {
        // On the crest `v_x^2 = g/(a k^2)` makes the force vanish; energy gives the speed at the start.
        let grazing: f64 = ((g / (a * k * k) + 2.0 * g * a) / (1.0 + (a * k).powi(2))).sqrt();
        for deviation in [
            -1e-6, -1e-10, -1e-13, -3e-16, 0.0, 3e-16, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9,
            1e-8, 1e-6,
        ] {
            let model = Crests {
                a,
                k,
                g,
                v: grazing * (1.0 + deviation),
                ..Crests::default()
            };
            for tolerance in [1e-9, 1e-12] {
                let simulation = simulate(&model, tolerance);
                let case = format!("a = {a}, {deviation:e}, {tolerance:e}");
                // So near grazing the errors of a run decide on which side of the crest it goes on, and it may say so.
                let near = deviation.abs() <= 1e-9;
                match &simulation.status {
                    SimulationStatus::Inaccurate(diagnosis) if near => {
                        assert!(diagnosis.time < 2.5, "{case}");
                        assert!(simulation.error_estimate.unwrap() > 1e-6, "{case}");
                    }
                    status => assert_eq!(*status, SimulationStatus::Solved, "{case}"),
                }
                // At each crest one flight at most.
                let crests =
                    (simulation.trajectory.q.last().unwrap()[0] * k / std::f64::consts::TAU).ceil();
                assert!(simulation.events.len() as f64 <= 2.0 * crests, "{case}");
                // Flights of a deviation up to 1e-6 end with impacts that take a smaller share of the energy.
                let energy = |q: &[f64], v: &[f64]| 0.5 * (v[0] * v[0] + v[1] * v[1]) + g * q[1];
                let (q, v) = (&simulation.trajectory.q, &simulation.trajectory.v);
                let change =
                    energy(q.last().unwrap(), v.last().unwrap()) / energy(&q[0], &v[0]) - 1.0;
                let lost = 1e-3 * deviation.abs().max(1e-9) + 100.0 * tolerance;
                assert!(change.abs() < lost.max(1e-7), "{case}: {change:e}");
            }
        }
    }
}

/// Impacts that are compared: each amplifies rounding errors a few times, and those of a rod that comes to rest are
/// many.
const COMPARED: usize = 8;

/// The first events of `found` are those of `expected`, with times to `accuracy`, and contacts renamed.
fn same_events(
    expected: &Simulation,
    found: &Simulation,
    contact: fn(usize) -> usize,
    accuracy: f64,
) {
    assert_eq!(found.status, SimulationStatus::Solved);
    let kinds = |simulation: &Simulation, rename: fn(usize) -> usize| {
        let events = simulation.events.iter().take(COMPARED);
        events
            .map(|event| (event.kind, rename(event.contact)))
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds(expected, |i| i), kinds(found, contact));
    for (a, b) in expected.events.iter().zip(&found.events).take(COMPARED) {
        assert!((a.time - b.time).abs() < accuracy, "{a:?} {b:?}");
    }
}

#[test]
fn rod_in_other_units_has_the_same_events() {
    let base = Rod::default();
    let expected = simulate(&base, 1e-9);
    assert_eq!(expected.status, SimulationStatus::Solved);
    assert!(expected.events.len() >= COMPARED);
    for (length, mass) in [
        (1e-3, 1.0),
        (1e3, 1.0),
        (1.0, 1e-3),
        (1e3, 1e3),
        (1e-3, 1e3),
    ] {
        let model = Rod {
            m: mass * base.m,
            j: mass * length * length * base.j,
            a: length * base.a,
            b: length * base.b,
            g: length * base.g,
            height: length * base.height,
            v_x: length * base.v_x,
            v_z: length * base.v_z,
            ..base
        };
        let found = simulate(&model, 1e-9);
        // Factors of a thousand round: 1e-16, amplified by a dozen impacts of factors below ten.
        same_events(&expected, &found, |i| i, 1e-11);
    }
}

#[test]
fn track_in_other_units_has_the_same_errors() {
    let base = Crests {
        v: 2.6,
        ..Crests::default()
    };
    let expected = simulate(&base, 1e-5);
    assert!(expected.events.len() >= 4);
    for length in [1e-3, 1e3] {
        let model = Crests {
            a: length * base.a,
            k: base.k / length,
            g: length * base.g,
            v: length * base.v,
            ..base
        };
        // The same steps: at this tolerance errors are 1e-6, and what differs is rounding.
        same_events(&expected, &simulate(&model, 1e-5), |i| i, 1e-11);
    }
}

#[test]
fn rod_in_another_place_has_the_same_events() {
    let expected = simulate(&Rod::default(), 1e-9);
    for (x0, z0) in [(1e5, 0.0), (0.0, -1e5), (-1e5, 1e5)] {
        let model = Rod {
            x0,
            z0,
            ..Rod::default()
        };
        // Coordinates of 1e5 round to 1e-11.
        same_events(&expected, &simulate(&model, 1e-9), |i| i, 1e-8);
    }
}

#[test]
fn rod_in_the_mirror_has_the_same_events() {
    let base = Rod::default();
    let model = Rod {
        a: base.b,
        b: base.a,
        e_left: base.e_right,
        e_right: base.e_left,
        slope: -base.slope,
        angle0: -base.angle0,
        v_x: -base.v_x,
        spin: -base.spin,
        ..base
    };
    let (expected, found) = (simulate(&base, 1e-9), simulate(&model, 1e-9));
    // Signs are exact; sums are taken in another order.
    same_events(&expected, &found, |i| 1 - i, 1e-11);
}
