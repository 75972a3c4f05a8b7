//! What the default simulation promises, and where it says that it cannot: accuracy, scales of gaps, cascades
//! of impacts, and what is not a number.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator, StepFormulation,
};

hangtime::model! {
    /// A mass on a spring, away from a wall that it never reaches.
    pub Oscillator {
        parameters { m: kg = 2, k: N/m = 50, start_x: m = 0.3 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2 - k/2*x^2
        surface wall: x + 1[m] >= 0
        impact wall: inelastic
        start { x: start_x }
        horizon 20 [s]
    }
}

hangtime::model! {
    /// A ball that bounces to rest.
    pub Bouncing {
        parameters { m: kg = 1, g: m/s^2 = 8, e = 0.97, height: m = 0.5 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height }
    }
}

hangtime::model! {
    /// A block that slides to rest.
    pub Sliding {
        parameters { m: kg = 3, g: m/s^2 = 2, mu = 0.5, v: m/s = 0.4 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        start { dot(x): v }
        horizon 1.6 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let problem = InitialValueProblem::of(model, horizon).unwrap();
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

fn solved(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let simulation = run(simulator, model, horizon);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    simulation
}

fn end(simulation: &Simulation) -> (&[f64], &[f64]) {
    let trajectory = &simulation.trajectory;
    (trajectory.q.last().unwrap(), trajectory.v.last().unwrap())
}

#[test]
fn coarse_grid_of_an_oscillation_reports_its_error_and_says_so() {
    let model = Oscillator::default();
    let rate = (model.k / model.m).sqrt();
    let exact = model.start_x * (rate * 20.0).cos();
    for (stages, steps) in [(1, 200), (2, 70), (3, 30)] {
        let simulator = Fesd::default()
            .with_scheme(Scheme::RadauIia, stages)
            .with_grid(steps, 1);
        let simulation = solved(&simulator, &model, None);
        let error = (end(&simulation).0[0] - exact).abs() / (2.0 * model.start_x);
        let estimate = simulation.error_estimate.unwrap();
        assert!(error > 1e-2, "{stages}: {error:e}");
        assert!(estimate > 0.3 * error, "{stages}: {estimate:e} {error:e}");
        assert!(
            simulation
                .notes
                .iter()
                .any(|note| note.contains("take more steps"))
        );
    }
}

#[test]
fn ball_that_bounces_too_often_is_told_to_raise_the_rest_velocity() {
    let model = Bouncing {
        e: 0.9995,
        ..Bouncing::default()
    };
    let rest = (2.0 * model.height / model.g).sqrt() * (1.0 + model.e) / (1.0 - model.e);
    let limited = Fesd {
        most_events: 5_000,
        ..Fesd::default().with_grid(60, 1)
    };
    let simulation = run(&limited, &model, Some(1.1 * rest));
    let diagnosis = simulation.status.diagnosis().unwrap();
    assert_eq!(simulation.status.name(), "event_limit");
    assert!(
        diagnosis.message.contains("raise the rest velocity"),
        "{}",
        diagnosis.message
    );
    assert_eq!(diagnosis.contact, Some(0));
    // Without the limit it comes to rest, where the closed form says.
    let simulation = run(&Fesd::default().with_grid(60, 1), &model, Some(1.1 * rest));
    assert!(simulation.status.is_solved(), "{}", simulation.status);
    assert!(simulation.events.len() > 5_000);
    let last = simulation.events.last().unwrap().time;
    assert!((last / rest - 1.0).abs() < 1e-3, "{last} {rest}");
}

#[test]
fn time_freezing_program_estimates_its_error_by_the_length_of_its_elements() {
    // A fall on a floor, which keeps the horizontal motion: its time is all that can be wrong.
    let model = Sliding {
        mu: 0.2,
        v: 1.5,
        ..Sliding::default()
    };
    let mut problem = InitialValueProblem::of(&model, Some(0.9)).unwrap();
    problem.q[1] = 0.3;
    let end_of = |simulator: &Fesd| {
        let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
        assert_eq!(simulation.status, SimulationStatus::Solved);
        simulation
    };
    let exact = end_of(&Fesd::default().with_tolerance(1e-9));
    let found = end_of(
        &Fesd::default()
            .with_grid(8, 3)
            .with_formulation(StepFormulation::Complementarity),
    );
    let error = (end(&found).0[0] - end(&exact).0[0]).abs() / end(&exact).0[0];
    let estimate = found.error_estimate.unwrap();
    assert!(
        estimate >= error && estimate > 1e-3,
        "{estimate:e} {error:e}"
    );
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("of the largest values"))
    );
}
