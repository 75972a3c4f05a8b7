//! What counts as zero in the event-driven simulator: grazing against its closed form.

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
