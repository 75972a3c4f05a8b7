//! One suite that every simulator passes: its order without contact, what all results share, and what is refused. Closed forms
//! with contacts stand in `tests/cases/methods.md`.

use crate::common::laws::Ground;
use crate::common::scenes::{self, GRAVITY, STIFFNESS};
use crate::common::{distance, last, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventDriven, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

/// A simulator at two resolutions, and what is known of its errors.
struct Method {
    /// The simulator on `steps` steps over the horizon, or as accurate as its own setting of the same rank.
    with: fn(steps: usize) -> Box<dyn Simulator>,
    without_contact: Accuracy,
    /// Whether it treats restitution and friction.
    laws: bool,
}

enum Accuracy {
    /// Order of the error in the step.
    Order(i32),
    /// Largest error, where a tolerance decides.
    Below(f64),
}

/// Steps over the horizon: the finer ones are eight times as many.
const STEPS: [usize; 2] = [400, 3200];

/// Width of the smoothed step functions for each step of the others.
const WIDTH: f64 = 4.0;

const METHODS: [Method; 5] = [
    Method {
        with: |_| {
            Box::new(EventDriven {
                tolerance: 1e-12,
                ..EventDriven::default()
            })
        },
        without_contact: Accuracy::Below(1e-9),
        laws: true,
    },
    Method {
        with: |steps| {
            let elements = Fesd::default().with_scheme(Scheme::RadauIia, 3);
            Box::new(elements.with_grid(steps / 20, 2))
        },
        without_contact: Accuracy::Order(5),
        laws: true,
    },
    Method {
        with: |steps| {
            Box::new(Moreau {
                steps,
                ..Moreau::default()
            })
        },
        without_contact: Accuracy::Order(2),
        laws: true,
    },
    Method {
        with: |steps| {
            Box::new(FixedStep {
                steps,
                ..FixedStep::default()
            })
        },
        without_contact: Accuracy::Order(4),
        laws: false,
    },
    Method {
        with: |steps| {
            Box::new(Smooth {
                width: WIDTH / steps as f64,
                tolerance: 1e-10,
                ..Smooth::default()
            })
        },
        // A tolerance of 1e-10 relative to 20 m, over a hundred steps and with velocities of 25 /s times the way.
        without_contact: Accuracy::Below(1e-6),
        laws: false,
    },
];

/// A motion in closed form.
struct Case {
    name: &'static str,
    model: Box<dyn Model>,
    problem: InitialValueProblem,
    /// Coordinates and velocities at the end.
    end: (Vec<f64>, Vec<f64>),
}

/// Two masses on a spring that fall without touching anything: a parabola and an oscillation about it.
fn swing() -> Case {
    let (amplitude, horizon) = (0.1, 0.5);
    let omega = (STIFFNESS * 1.5).sqrt();
    let centre = 20.0 + 1.0 * horizon - 0.5 * GRAVITY * horizon * horizon;
    let stretch = amplitude * f64::cos(omega * horizon);
    let rate = -amplitude * omega * f64::sin(omega * horizon);
    let speed = 1.0 - GRAVITY * horizon;
    // masses 1 and 2 at distances 2/3 and 1/3 of the length from the centre
    let apart = |length: f64| [-2.0 / 3.0 * length, length / 3.0];
    let ([a, b], [c, d]) = (apart(0.5 + amplitude), apart(0.5 + stretch));
    let [e, f] = apart(rate);
    Case {
        name: "swing without contact",
        model: Box::new(scenes::hopper()),
        problem: start(&[20.0 + a, 20.0 + b], &[1.0, 1.0], horizon),
        end: (vec![centre + c, centre + d], vec![speed + e, speed + f]),
    }
}

fn run(method: &Method, steps: usize, case: &Case) -> Simulation {
    let simulator = (method.with)(steps);
    let mut reached = 0.0;
    let simulation = simulator
        .simulate(&*case.model, &case.problem, &mut |progress| {
            assert!(progress.time >= reached, "time runs back");
            reached = progress.time;
            true
        })
        .expect("the problem is accepted");
    let name = format!("{} on {}", simulator.name(), case.name);
    assert_eq!(simulation.status, SimulationStatus::Solved, "{name}");
    let trajectory = &simulation.trajectory;
    let horizon = case.problem.horizon;
    assert_eq!(trajectory.time[0], 0.0, "{name}");
    assert_eq!(trajectory.time.last(), Some(&horizon), "{name}");
    assert!((reached - horizon).abs() <= 1e-12 * horizon, "{name}");
    assert_eq!(trajectory.q[0], case.problem.q, "{name}");
    assert!(trajectory.time.is_sorted(), "{name}");
    assert!(trajectory.numerical_time.is_sorted(), "{name}");
    let points = trajectory.time.len();
    for rows in [
        &trajectory.q,
        &trajectory.v,
        &trajectory.u,
        &trajectory.contact_force,
    ] {
        assert_eq!(rows.len(), points, "{name}");
    }
    assert!(simulation.events.is_sorted_by_key(|event| event.time));
    for event in &simulation.events {
        let declared = simulation.declaration.contacts[event.contact].name;
        assert_eq!(event.contact_name, declared, "{name}");
    }
    simulation
}

/// Error of the state at the end.
fn error(simulation: &Simulation, case: &Case) -> f64 {
    let (q, v) = last(&simulation.trajectory);
    distance(q, &case.end.0).max(distance(v, &case.end.1))
}

#[test]
fn every_method_has_its_order_without_contact() {
    let case = swing();
    for method in &METHODS {
        let errors = STEPS.map(|steps| error(&run(method, steps, &case), &case));
        let name = (method.with)(STEPS[0]).name();
        let order = match method.without_contact {
            Accuracy::Order(order) => order,
            Accuracy::Below(allowed) => {
                assert!(errors[1] < allowed, "{name}: {errors:?}");
                continue;
            }
        };
        // From above the order shows until rounding: heights of 20 m, over thousands of steps.
        let measured = (errors[0] / errors[1].max(1e-12)).ln() / 8.0_f64.ln();
        let expected = f64::from(order);
        assert!(
            measured > expected - 0.3 || errors[1] < 1e-11,
            "{name}: order {measured} of {expected}, {errors:?}"
        );
        assert!(errors[0] > errors[1], "{name}: {errors:?}");
    }
}

#[test]
fn every_method_refuses_what_it_cannot_treat_by_the_same_words() {
    let methods = METHODS.map(|method| (method.with)(STEPS[0]));
    let ball = scenes::ball();
    let good = start(&[0.0, 1.0], &[0.0; 2], 1.0);
    let bad = [
        start(&[0.0, -0.4], &[0.0; 2], 1.0),
        start(&[0.0, f64::NAN], &[0.0; 2], 1.0),
        start(&[0.0], &[0.0; 2], 1.0),
        start(&[0.0, 1.0], &[0.0, f64::INFINITY], 1.0),
        start(&[0.0, 1.0], &[0.0; 2], 0.0),
        start(&[0.0, 1.0], &[0.0; 2], f64::NAN),
    ];
    for problem in bad {
        let refused = methods.each_ref().map(|simulator| {
            simulator
                .simulate(&ball, &problem, &mut |_| true)
                .expect_err("the problem is refused")
                .to_string()
        });
        assert!(
            refused.iter().all(|message| *message == refused[0]),
            "{refused:?}"
        );
    }
    for law in [
        Ground {
            mu: 0.5,
            ..Ground::default()
        },
        Ground {
            e: 0.5,
            ..Ground::default()
        },
    ] {
        for (method, simulator) in METHODS.iter().zip(&methods) {
            let result = simulator.simulate(&law, &good, &mut |_| true);
            if method.laws {
                assert_eq!(result.expect("a result").status, SimulationStatus::Solved);
                continue;
            }
            let error = result.expect_err("the law is refused");
            assert!(error.is_unsupported(), "{error}");
            assert!(error.to_string().contains(simulator.name()), "{error}");
        }
    }
}

#[test]
fn progress_reports_the_times_of_accepted_steps() {
    let model = scenes::ball();
    let mut times = Vec::new();
    let simulation = EventDriven::default()
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |now| {
            times.push(now.time);
            true
        })
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // A run to compare with may be stopped as well, but time does not pass in it.
    assert_eq!(times.first(), Some(&0.0));
    times.dedup();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(times.last(), Some(&1.0));
}
