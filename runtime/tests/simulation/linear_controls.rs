//! Controls that are linear between nodes, in every simulator: closed forms, orders, refusals.

use crate::common::{distance, last, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventDriven, Fesd, InitialValueProblem, InputError, Simulation,
    SimulationStatus, Simulator,
};

hangtime::model! {
    /// A pendulum with a motor.
    Pendulum {
        parameters { m: kg = 1, l: m = 1, g: m/s^2 = 9.81 }
        coordinates { phi }
        controls { torque: N*m }
        lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
        forces { phi: torque }
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(
        simulation.status,
        SimulationStatus::Solved,
        "{}",
        simulator.name()
    );
    simulation
}

/// Error of the motor-driven pendulum at 2 s, against the event-driven simulator at 1e-13.
fn pendulum_error(simulator: &dyn Simulator) -> f64 {
    let model = Pendulum::default();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseLinear {
            times: vec![0.0, 0.5, 1.5, 2.0],
            values: vec![vec![0.0], vec![8.0], vec![-8.0], vec![2.0]],
        },
        ..start(&[0.3], &[0.0], 2.0)
    };
    let reference = EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    };
    let reference = run(&reference, &model, &problem);
    let simulation = run(simulator, &model, &problem);
    let ((q, v), (q_exact, v_exact)) = (last(&simulation.trajectory), last(&reference.trajectory));
    distance(q, q_exact).max(distance(v, v_exact))
}

/// Order between the resolutions `steps` and `2 steps`.
fn order(error: impl Fn(usize) -> f64, steps: usize) -> f64 {
    (error(steps) / error(2 * steps)).log2()
}

#[test]
fn order_under_ramps_is_that_of_the_method() {
    // Asymptotic orders to a quarter, on steps that meet the nodes.
    let radau = |steps| {
        pendulum_error(
            &Fesd::default()
                .with_scheme(Scheme::RadauIia, 2)
                .with_grid(steps, 1),
        )
    };
    let gauss = |steps| {
        pendulum_error(
            &Fesd::default()
                .with_scheme(Scheme::GaussLegendre, 2)
                .with_grid(steps, 1),
        )
    };
    let fixed = |steps| {
        pendulum_error(&FixedStep {
            steps,
            ..FixedStep::default()
        })
    };
    let moreau = |steps| {
        pendulum_error(&Moreau {
            steps,
            ..Moreau::default()
        })
    };
    for (name, found, expected) in [
        ("radau-iia", order(radau, 40), 3.0),
        ("gauss-legendre", order(gauss, 40), 4.0),
        ("fixed", order(fixed, 80), 4.0),
        ("moreau", order(moreau, 80), 2.0),
    ] {
        assert!((found - expected).abs() < 0.25, "{name}: {found}");
    }
}

#[test]
fn smooth_follows_ramps_to_its_tolerance() {
    let simulator = Smooth {
        tolerance: 1e-10,
        ..Smooth::default()
    };
    // The nodes are not met, where the error estimate alone has to see the change of slope.
    assert!(
        pendulum_error(&simulator) < 1e-7,
        "{:e}",
        pendulum_error(&simulator)
    );
}

#[test]
fn signal_in_the_wrong_shape_is_refused_by_name() {
    let model = Pendulum::default();
    let refused = |times: Vec<f64>, values: Vec<Vec<f64>>| -> InputError {
        let problem = InitialValueProblem {
            controls: ControlSignal::PiecewiseLinear { times, values },
            ..start(&[0.3], &[0.0], 2.0)
        };
        problem.check(&model).expect_err("the signal is wrong")
    };
    let message = refused(vec![0.0, 1.0], vec![vec![0.0]]).to_string();
    assert_eq!(
        message,
        "control values over time has 1 components, expected 2"
    );
    let message = refused(vec![0.0, 1.0, 1.0], vec![vec![0.0]; 3]).to_string();
    assert_eq!(
        message,
        "control time = 1 s: must be one of increasing times, the first at most 0"
    );
    let message = refused(vec![0.5, 1.0], vec![vec![0.0]; 2]).to_string();
    assert_eq!(
        message,
        "control time = 0.5 s: must be one of increasing times, the first at most 0"
    );
    let message = refused(vec![0.0, 1.0], vec![vec![0.0], vec![0.0, 1.0]]).to_string();
    assert_eq!(message, "a control value has 2 components, expected 1");
}
