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

const WEIGHT: f64 = 2.0 * 9.81;

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

hangtime::model! {
    /// A mass on wavy, rough ground, lifted and pushed aside.
    Wagon {
        parameters { m: kg = 2, g: m/s^2 = 9.81, a: m = 0.1, w: 1/m = 3 }
        coordinates { y: m, z: m }
        controls { push: N, lift: N }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: push, z: lift }
        surface ground: z - a*sin(w*y) >= 0
        impact ground: inelastic, friction 0.4
    }
}

#[test]
fn random_ramps_over_rough_ground_agree_between_elements_and_event_driven() {
    let model = Wagon::default();
    let event = EventDriven {
        tolerance: 1e-12,
        ..EventDriven::default()
    };
    let elements = Fesd::default().with_tolerance(1e-11);
    let mut switches = 0;
    for seed in 0..12_u64 {
        // SplitMix64, mapped to [0, 1).
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let values = (0..6).map(|_| vec![30.0 * random() - 15.0, 1.4 * WEIGHT * random()]);
        let problem = InitialValueProblem {
            controls: ControlSignal::PiecewiseLinear {
                times: (0..6).map(|k| 0.37 * k as f64).collect(),
                values: values.collect(),
            },
            ..start(&[0.0, 0.0], &[0.0, 0.0], 1.8)
        };
        let [a, b] = [&event as &dyn Simulator, &elements].map(|s| run(s, &model, &problem));
        let kinds = |s: &Simulation| s.events.iter().map(|e| e.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&a), kinds(&b), "seed {seed}");
        switches += a.events.len();
        for (x, y) in a.events.iter().zip(&b.events) {
            assert!((x.time - y.time).abs() < 1e-7, "seed {seed}: {x:?} {y:?}");
        }
        let ((q, v), (p, w)) = (last(&a.trajectory), last(&b.trajectory));
        assert!(
            distance(q, p).max(distance(v, w)) < 1e-7,
            "seed {seed}: {q:?} {p:?}"
        );
    }
    // Sticking, slipping, taking off and landing all happen.
    assert!(switches > 30, "{switches}");
}
