//! One suite that every simulator passes: scenes with closed forms, each at the accuracy that the order of the method
//! explains, and the promises that all results share.

use crate::common::laws::Ground;
use crate::common::scenes::{self, GRAVITY, STIFFNESS};
use crate::common::{distance, gap_at, last, start};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus,
    Simulator,
};

/// A simulator at two resolutions, and what is known of its errors.
struct Method {
    /// The simulator on `steps` steps over the horizon, or as accurate as its own setting of the same rank.
    with: fn(steps: usize) -> Box<dyn Simulator>,
    without_contact: Accuracy,
    /// Error with impacts and switches for steps of length `h`, relative to the accelerations of the case.
    with_switches: fn(h: f64) -> f64,
    events: Events,
    /// Whether it treats restitution and friction.
    laws: bool,
}

enum Accuracy {
    /// Order of the error in the step.
    Order(i32),
    /// Largest error, where a tolerance decides.
    Below(f64),
}

/// How a method reports events.
enum Events {
    /// As exact as the motion.
    Located,
    /// At the ends of steps.
    AtSteps,
    None,
}

/// Steps over the horizon: the finer ones are eight times as many.
const STEPS: [usize; 2] = [400, 3200];
/// Errors of methods that locate switches: roundings of some hundred steps, and tolerances of 1e-12.
const EXACT: f64 = 1e-10;
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
        with_switches: |_| EXACT,
        events: Events::Located,
        laws: true,
    },
    Method {
        with: |steps| {
            let elements = Fesd::default().with_scheme(Scheme::RadauIia, 3);
            Box::new(elements.with_grid(steps / 20, 2))
        },
        without_contact: Accuracy::Order(5),
        with_switches: |_| EXACT,
        events: Events::Located,
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
        // Each of up to three switches is noticed up to a step late.
        with_switches: |h| 3.0 * h,
        events: Events::None,
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
        with_switches: |h| 3.0 * h,
        events: Events::AtSteps,
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
        // It hovers some widths above the ground and reaches it that much later: twenty widths in all.
        with_switches: |h| 2.0 * WIDTH * h,
        events: Events::None,
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
    /// Kind, contact and time of each event.
    events: Vec<(EventKind, usize, f64)>,
    /// Contact forces at the end.
    forces: Vec<f64>,
    /// Largest speeds and accelerations, in s as the unit of time: what an error in time is multiplied with.
    scale: f64,
    /// Whether it needs restitution or friction.
    laws: bool,
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
        events: vec![],
        forces: vec![0.0],
        scale: GRAVITY,
        laws: false,
    }
}

/// A ball falls from 1 m and slides on.
fn fall() -> Case {
    let time = (2.0 / GRAVITY).sqrt();
    Case {
        name: "fall and rest",
        model: Box::new(scenes::ball()),
        problem: start(&[0.0, 1.0], &[1.5, 0.0], 1.0),
        end: (vec![1.5, 0.0], vec![1.5, 0.0]),
        events: vec![(EventKind::Impact, 0, time)],
        forces: vec![0.5 * GRAVITY],
        scale: GRAVITY,
        laws: false,
    }
}

/// A ball rests until a jump of the control lifts it, flies, and falls back.
fn lift() -> Case {
    // up with g from 0.2 s to 0.5 s; then free fall from 0.045 g with 0.3 g
    let lands = 0.5 + 0.3 + f64::sqrt(0.09 + 0.09);
    Case {
        name: "lift by a control",
        model: Box::new(scenes::lifted_ball()),
        problem: InitialValueProblem {
            controls: ControlSignal::PiecewiseConstant {
                times: vec![0.0, 0.2, 0.5],
                values: vec![vec![0.0], vec![2.0 * GRAVITY], vec![0.0]],
            },
            ..start(&[0.0], &[0.0], 1.5)
        },
        end: (vec![0.0], vec![0.0]),
        events: vec![(EventKind::LiftOff, 0, 0.2), (EventKind::Impact, 0, lands)],
        forces: vec![GRAVITY],
        scale: GRAVITY,
        laws: false,
    }
}

/// A block slides on the floor into the wall.
fn wall() -> Case {
    Case {
        name: "slide into a wall",
        model: Box::new(scenes::corner()),
        problem: start(&[0.1, 0.0], &[2.0, 0.0], 1.0),
        end: (vec![1.0, 0.0], vec![0.0, 0.0]),
        events: vec![(EventKind::Impact, 1, 0.45)],
        forces: vec![2.0 * GRAVITY, 0.0],
        scale: GRAVITY,
        laws: false,
    }
}

/// A ball with restitution 1/2 after its second bounce.
fn bounces() -> Case {
    let fall = (2.0 / GRAVITY).sqrt();
    let impacts = [fall, 2.0 * fall, 2.5 * fall];
    // the third flight begins with a quarter of the speed, at 2.5 times the time to fall
    let (speed, passed) = (GRAVITY * fall / 8.0, 0.05);
    let height = speed * passed - 0.5 * GRAVITY * passed * passed;
    Case {
        name: "bounces",
        model: Box::new(Ground {
            e: 0.5,
            ..Ground::default()
        }),
        problem: start(&[0.0, 1.0], &[0.7, 0.0], 2.5 * fall + passed),
        end: (
            vec![0.7 * (2.5 * fall + passed), height],
            vec![0.7, speed - GRAVITY * passed],
        ),
        events: impacts.map(|time| (EventKind::Impact, 0, time)).to_vec(),
        forces: vec![0.0],
        scale: GRAVITY,
        laws: true,
    }
}

/// A block slides up an incline, stops and stays.
fn incline() -> Case {
    let (slope, mu, speed, mass) = (0.3_f64, 0.6, 2.0, 3.0);
    // downhill along the falling ground, so that friction alone stops it
    let slowing = GRAVITY * (mu * slope.cos() - slope.sin());
    let (stops, way) = (speed / slowing, speed * speed / (2.0 * slowing));
    let along = [slope.cos(), -slope.sin()];
    Case {
        name: "stop on an incline",
        model: Box::new(Ground {
            slope,
            mu,
            mass,
            ..Ground::default()
        }),
        problem: start(&[0.0; 2], &along.map(|c| c * speed), stops + 0.3),
        end: (along.map(|c| c * way).to_vec(), vec![0.0; 2]),
        events: vec![(EventKind::Stick, 0, stops)],
        forces: vec![mass * GRAVITY * slope.cos()],
        scale: GRAVITY,
        laws: true,
    }
}

fn cases() -> [Case; 6] {
    [swing(), fall(), lift(), wall(), bounces(), incline()]
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
fn every_method_follows_every_closed_form_to_its_accuracy() {
    for case in cases() {
        for method in METHODS.iter().filter(|method| method.laws || !case.laws) {
            for steps in STEPS {
                let simulation = run(method, steps, &case);
                let name = format!("{} on {}", (method.with)(steps).name(), case.name);
                let h = case.problem.horizon / steps as f64;
                let switches = !case.events.is_empty();
                if switches {
                    let allowed = (method.with_switches)(h) * case.scale;
                    let error = error(&simulation, &case);
                    assert!(error <= allowed, "{name}, {steps} steps: {error:e}");
                    check_contacts(method, &simulation, &case, allowed, &name);
                }
                check_events(method, &simulation, &case, h, &name);
            }
        }
    }
}

/// No penetration and no pull beyond the error, and the forces of rest at the end.
fn check_contacts(method: &Method, simulation: &Simulation, case: &Case, allowed: f64, name: &str) {
    let trajectory = &simulation.trajectory;
    for k in 0..trajectory.time.len() {
        for (contact, force) in trajectory.contact_force[k].iter().enumerate() {
            let gap = gap_at(&*case.model, trajectory, contact, k);
            assert!(gap >= -allowed, "{name}: gap {gap:e}");
            // A pull that is noticed at the end of a step is recorded there.
            let may_pull = matches!(method.events, Events::AtSteps);
            assert!(may_pull || *force >= -allowed, "{name}: force {force:e}");
        }
    }
    let forces = trajectory.contact_force.last().expect("a start");
    // masses of up to 3 kg times errors of accelerations
    let error = distance(forces, &case.forces);
    assert!(error <= 3.0 * allowed, "{name}: {forces:?}");
}

fn check_events(method: &Method, simulation: &Simulation, case: &Case, h: f64, name: &str) {
    let (early, late) = match method.events {
        Events::Located => (EXACT, EXACT),
        // Noticed at the ends of steps; a flight that begins late is shorter, by up to 2.4 times the delay.
        Events::AtSteps => (3.0 * h, 3.0 * h),
        Events::None => {
            assert!(simulation.events.is_empty(), "{name}");
            return;
        }
    };
    let found: Vec<_> = simulation
        .events
        .iter()
        .map(|event| (event.kind, event.contact))
        .collect();
    let expected: Vec<_> = case.events.iter().map(|&(kind, i, _)| (kind, i)).collect();
    assert_eq!(found, expected, "{name}");
    for (event, (_, _, time)) in simulation.events.iter().zip(&case.events) {
        let delay = event.time - time;
        assert!((-early..=late).contains(&delay), "{name}: {delay:e} s late");
    }
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
fn every_method_names_a_field_that_ends() {
    // The force is a number up to y = 1 only, which is reached before 1 s.
    let problem = start(&[0.0], &[1.0], 5.0);
    for method in &METHODS {
        let simulator = (method.with)(STEPS[0]);
        let simulation = simulator
            .simulate(&scenes::edge(), &problem, &mut |_| true)
            .expect("the problem is accepted");
        let diagnosis = simulation.status.diagnosis().expect("it cannot go on");
        assert!(diagnosis.time <= 1.0, "{}: {diagnosis:?}", simulator.name());
        assert!(
            matches!(
                simulation.status,
                SimulationStatus::NotFinite(_) | SimulationStatus::StepFailed(_)
            ),
            "{}: {:?}",
            simulator.name(),
            simulation.status
        );
    }
}
