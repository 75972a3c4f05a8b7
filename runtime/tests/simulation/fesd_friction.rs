//! Coulomb friction in the finite element simulator against closed forms and its own order.

use crate::common::laws::{Disc, Feet, Ground, Pulled, Rod};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, last, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};
use std::f64::consts::PI;

fn accurate() -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, 5)
        .with_grid(40, 2)
}

fn solve(simulator: &Fesd, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let rows = simulation.trajectory.friction_force.len();
    assert_eq!(rows, simulation.trajectory.time.len());
    simulation
}

fn kinds(simulation: &Simulation) -> Vec<EventKind> {
    simulation.events.iter().map(|event| event.kind).collect()
}

/// `(angle, mu, v_0, t_stop, s_stop, friction force per mass sliding, stuck)`: closed form, 20 digits.
const BLOCKS: [(f64, f64, f64, f64, f64, f64, f64); 3] = [
    (
        15.0,
        0.5,
        3.0,
        1.364_348_711_498_973_1,
        2.046_523_067_248_46,
        -4.737_866_177_947_88,
        -2.539_014_832_455_728_7,
    ),
    (
        25.0,
        0.6,
        2.0,
        1.682_591_714_644_312_2,
        1.682_591_714_644_312_2,
        -5.334_527_634_497_722,
        -4.145_885_147_676_262,
    ),
    (
        0.0,
        0.3,
        2.0,
        0.679_578_661_230_037_4,
        0.679_578_661_230_037_4,
        -2.943,
        0.0,
    ),
];

#[test]
fn block_on_incline_slides_stops_and_stays_as_in_closed_form() {
    for (angle, mu, speed, t_stop, s_stop, sliding, stuck) in BLOCKS {
        for (mass, scale) in [(1.0, 1.0), (3.0, 2.0)] {
            let angle = f64::to_radians(angle);
            let mut model = Ground {
                slope: angle,
                scale,
                mu,
                ..Ground::default()
            };
            model.mass = mass;
            let along = [angle.cos(), -angle.sin()];
            let problem = start(&[0.0, 0.0], &along.map(|c| speed * c), 3.0);
            let simulation = solve(&Fesd::default().with_grid(60, 3), &model, &problem);
            assert_eq!(kinds(&simulation), [EventKind::Stick]);
            // Parabolas, which the scheme reproduces: rounding error.
            let stop = simulation.events[0].time;
            assert!((stop - t_stop).abs() < 2e-14, "{:e}", stop - t_stop);
            let (q, v) = last(&simulation.trajectory);
            assert!(distance(q, &along.map(|c| s_stop * c)) < 2e-14, "{q:?}");
            assert!(distance(v, &[0.0, 0.0]) < 1e-15, "{v:?}");
            let forces = &simulation.trajectory.friction_force;
            assert!((forces[0][0] * scale - mass * sliding).abs() < 1e-13);
            assert!((forces.last().unwrap()[0] * scale - mass * stuck).abs() < 1e-13);
            assert!(simulation.residuals.dual < 1e-13);
            assert!(simulation.residuals.primal < 1e-13);
            assert_eq!(simulation.counts.fallbacks, 0);
        }
    }
}

#[test]
fn spring_driven_block_turns_round_until_it_sticks() {
    // y'' = -w^2 y -+ mu g: half periods pi / w about centres +-delta, each extent 2 delta smaller.
    let (mu, stiffness, extent) = (0.2_f64, 25.0_f64, 1.0_f64);
    let (omega, delta) = (stiffness.sqrt(), mu * GRAVITY / stiffness);
    let mut model = Ground {
        mu,
        ..Ground::default()
    };
    model.stiffness = stiffness;
    let simulation = solve(
        &accurate().with_grid(100, 2),
        &model,
        &start(&[extent, 0.0], &[0.0, 0.0], 10.0),
    );
    let mut turn = extent;
    for (k, event) in simulation.events.iter().enumerate() {
        turn = -(turn.abs() - 2.0 * delta) * turn.signum();
        let time = (k + 1) as f64 * PI / omega;
        // Order 9 with elements of omega h = 0.25: a local error of about 1e-14, over 200 elements.
        assert!((event.time - time).abs() < 1e-11, "{:e}", event.time - time);
        assert!((event.q[0] - turn).abs() < 1e-11, "{:e}", event.q[0] - turn);
        let kind = if turn.abs() > delta {
            EventKind::Slip
        } else {
            EventKind::Stick
        };
        assert_eq!(event.kind, kind);
    }
    assert!(turn.abs() <= delta);
    assert_eq!(simulation.events.len(), 6);
    let force = simulation.trajectory.friction_force.last().unwrap()[0];
    assert!((force - stiffness * turn).abs() < 1e-8);
}

#[test]
fn pulled_block_sticks_until_the_spring_reaches_the_bound() {
    // Linear spring: slip from t = mu g / (k V), then y = V s - V / w sin(w s).
    let (mu, stiffness, speed) = (0.4, 16.0_f64, 2.0);
    let omega = stiffness.sqrt();
    let model = Pulled {
        mu,
        stiffness,
        ..Pulled::default()
    };
    let slip = mu * GRAVITY / (stiffness * speed);
    let horizon = slip + 1.0;
    let problem = start(&[0.0; 3], &[0.0, 0.0, speed], horizon);
    let simulation = solve(&accurate(), &model, &problem);
    assert_eq!(kinds(&simulation), [EventKind::Slip]);
    assert!((simulation.events[0].time - slip).abs() < 1e-14);
    let (q, v) = last(&simulation.trajectory);
    let y = speed - speed / omega * omega.sin();
    // The start of the slip is of third order in time, far below the error of the scheme.
    assert!((q[0] - y).abs() < 1e-12, "{:e}", q[0] - y);
    assert!((v[0] - speed * (1.0 - omega.cos())).abs() < 1e-12);
}

/// Least-squares slope of log error against log step count, negated.
fn order(errors: &[(usize, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = errors
        .iter()
        .map(|&(count, error)| ((count as f64).ln(), error.ln()))
        .collect();
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
    -covariance / mean(&|p| (p.0 - x).powi(2))
}

/// Errors of the state at the end with `stages` against a run of order 13.
fn errors(
    model: &dyn Model,
    problem: &InitialValueProblem,
    stages: usize,
    steps: &[usize],
    events: &[EventKind],
) -> Vec<(usize, f64)> {
    let end = |simulator: &Fesd| {
        let simulation = solve(simulator, model, problem);
        assert_eq!(kinds(&simulation), events, "{stages} stages");
        assert_eq!(simulation.counts.fallbacks, 0);
        let (q, v) = last(&simulation.trajectory);
        [q, v].concat()
    };
    let exact = end(&Fesd::default()
        .with_scheme(Scheme::RadauIia, 7)
        .with_grid(80, 1));
    steps
        .iter()
        .map(|&count| {
            let simulator = Fesd::default()
                .with_scheme(Scheme::RadauIia, stages)
                .with_grid(count, 1);
            (count, distance(&end(&simulator), &exact))
        })
        .collect()
}

/// Step counts where the leading error term dominates and rounding does not.
const STEPS: [(usize, &[usize]); 4] = [
    (1, &[640, 1280, 2560]),
    (2, &[80, 160, 320]),
    (3, &[40, 80, 160]),
    (4, &[20, 40, 80]),
];

#[test]
fn order_is_kept_through_turning_round_and_sticking_on_curved_ground() {
    let model = Ground {
        curvature: 1.5,
        mu: 0.25,
        ..Ground::default()
    };
    let problem = start(&[0.8, 0.48], &[0.0, 0.0], 3.0);
    let events = [EventKind::Slip, EventKind::Stick];
    for (stages, steps) in STEPS {
        let errors = errors(&model, &problem, stages, steps, &events);
        let measured = order(&errors);
        let expected = (2 * stages - 1) as f64;
        assert!(
            measured > expected - 0.3,
            "{stages} stages: {measured} of {expected}: {errors:?}"
        );
    }
}

#[test]
fn order_is_kept_through_the_start_of_a_slip() {
    let model = Pulled {
        mu: 0.4,
        stiffness: 5.0,
        hardening: 40.0,
        ..Pulled::default()
    };
    let problem = start(&[0.0; 3], &[0.0, 0.0, 1.5], 1.0);
    for (stages, steps) in STEPS {
        let errors = errors(&model, &problem, stages, steps, &[EventKind::Slip]);
        let measured = order(&errors);
        let expected = (2 * stages - 1) as f64;
        assert!(
            measured > expected - 0.3,
            "{stages} stages: {measured} of {expected}: {errors:?}"
        );
    }
}

#[test]
fn disc_with_spin_slips_or_grips_at_an_impact() {
    // Unit mass, inertia k^2; p = v_z-. Grip: s = -(v_y + r w) / (1 + r^2 / k^2), if |s| <= mu p.
    let (radius, gyration) = (0.5_f64, 0.4_f64);
    let body = |friction| Disc {
        radius,
        shape: (gyration / radius).powi(2),
        mu: friction,
        ..Disc::default()
    };
    let (v_y, fall, spin) = (1.0_f64, 3.0_f64, 4.0_f64);
    let full = (v_y + radius * spin) / (1.0 + (radius / gyration).powi(2));
    for mu in [0.1, 0.2, 0.5, 1.0] {
        let model = body(mu);
        let problem = start(&[0.0, radius, 0.0], &[v_y, -fall, spin], 1e-9);
        let simulation = solve(&Fesd::default(), &model, &problem);
        let s = -full.min(mu * fall);
        let after = [v_y + s, 0.0, spin + radius * s / gyration.powi(2)];
        let event = &simulation.events[0];
        assert!(
            distance(&event.v_after, &after) < 1e-14,
            "{:?} {after:?}",
            event.v_after
        );
        // After a grip the disc rolls: no force, no event.
        let friction = simulation.trajectory.friction_force.last().unwrap()[0];
        let expected = if full <= mu * fall {
            0.0
        } else {
            -mu * GRAVITY
        };
        assert!((friction - expected).abs() < 1e-12, "{friction}");
    }
}

#[test]
fn sliding_disc_rolls_after_the_time_of_the_closed_form() {
    let (radius, gyration, mu, v_y, spin) = (0.5_f64, 0.4_f64, 0.3_f64, 2.0_f64, 6.0_f64);
    let model = Disc {
        radius,
        shape: (gyration / radius).powi(2),
        mu,
        ..Disc::default()
    };
    let problem = start(&[0.0, radius, 0.0], &[v_y, 0.0, spin], 3.0);
    let simulation = solve(&Fesd::default(), &model, &problem);
    assert_eq!(kinds(&simulation), [EventKind::Stick]);
    let slowing = mu * GRAVITY * (1.0 + (radius / gyration).powi(2));
    let time = (v_y + radius * spin) / slowing;
    assert!((simulation.events[0].time - time).abs() < 1e-14);
    let (_, v) = last(&simulation.trajectory);
    let rolling = v_y - mu * GRAVITY * time;
    assert!(distance(v, &[rolling, 0.0, -rolling / radius]) < 1e-13);
}

#[test]
fn coupled_impact_of_a_rod_follows_the_mode_that_is_consistent() {
    // Rod of half length a, tip below at angle phi < 0: n = (0, 1, a cos), b = (1, 0, -a sin).
    for (phi, mu, v) in [
        (-0.9_f64, 0.1_f64, [2.0, -1.0, 0.5]),
        (-0.9, 0.6, [0.2, -2.0, -1.0]),
        (-0.5, 0.3, [-3.0, -1.0, 1.0]),
        (-1.2, 0.05, [1.0, -2.0, 0.0]),
    ] {
        let (half, gyration) = (1.0, 0.577_f64);
        let model = Rod {
            inertia: gyration * gyration,
            arm: half,
            mu,
            ..Rod::default()
        };
        let (n, b) = ([0.0, 1.0, half * phi.cos()], [1.0, 0.0, -half * phi.sin()]);
        let inverse = [1.0, 1.0, gyration.powi(-2)];
        let product =
            |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|k| a[k] * inverse[k] * b[k]).sum() };
        let (nn, nb, bb) = (product(n, n), product(n, b), product(b, b));
        let along = |a: [f64; 3]| -> f64 { a.iter().zip(v).map(|(a, v)| a * v).sum() };
        let (v_n, v_t) = (along(n), along(b));
        assert!(v_n < 0.0);
        // Impulses (P_n, P_t) of the three modes; exactly one is consistent.
        let determinant = nn * bb - nb * nb;
        let grip = [
            (-v_n * bb + v_t * nb) / determinant,
            (-v_t * nn + v_n * nb) / determinant,
        ];
        let mut consistent = Vec::new();
        if grip[0] >= 0.0 && grip[1].abs() <= mu * grip[0] {
            consistent.push(grip);
        }
        for sense in [1.0, -1.0] {
            let normal = -v_n / (nn - sense * mu * nb);
            let tangential = -sense * mu * normal;
            let after = v_t + nb * normal + bb * tangential;
            if normal > 0.0 && sense * after > 0.0 {
                consistent.push([normal, tangential]);
            }
        }
        let [impulse] = consistent[..] else {
            panic!("{consistent:?}")
        };
        let after: [f64; 3] =
            std::array::from_fn(|k| v[k] + inverse[k] * (n[k] * impulse[0] + b[k] * impulse[1]));
        let problem = start(&[0.0, -half * phi.sin(), phi], &v, 1e-9);
        let simulation = solve(&Fesd::default(), &model, &problem);
        let found = &simulation.events[0].v_after;
        assert!(distance(found, &after) < 1e-13, "{found:?} {after:?}");
    }
}

#[test]
fn both_feet_of_a_bar_stick_and_slip_together() {
    // Horizontal push of the floor's frame: the bar decelerates at mu g, stops, and stays on both feet.
    let model = Feet {
        gyration: 0.6,
        front: 0.5,
        rear: 0.8,
        mu: 0.3,
        ..Feet::default()
    };
    let problem = start(&[0.0, 0.0, 0.0], &[1.5, 0.0, 0.0], 1.0);
    let simulation = solve(&Fesd::default(), &model, &problem);
    let time = 1.5 / (0.3 * GRAVITY);
    assert_eq!(kinds(&simulation), [EventKind::Stick, EventKind::Stick]);
    for event in &simulation.events {
        assert!((event.time - time).abs() < 1e-14);
    }
    let total: f64 = simulation
        .trajectory
        .friction_force
        .last()
        .unwrap()
        .iter()
        .sum();
    assert!(total.abs() < 1e-13);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[0] - 0.75 * time).abs() < 1e-14 && distance(v, &[0.0; 3]) < 1e-15);
}

#[test]
fn control_jumps_decide_between_sticking_and_slipping() {
    let (mu, mass) = (0.5, 1.0);
    let model = Ground {
        mu,
        ..Ground::default()
    };
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.5, 1.0, 1.5],
            values: vec![vec![4.0], vec![6.0], vec![-4.0], vec![-5.5]],
        },
        ..start(&[0.0, 0.0], &[0.0, 0.0], 2.0)
    };
    let simulation = solve(&Fesd::default(), &model, &problem);
    let bound = mu * mass * GRAVITY;
    let speed = (6.0 - bound) * 0.5;
    let stop = 1.0 + speed / (4.0 + bound);
    let expected = [
        (0.5, EventKind::Slip),
        (stop, EventKind::Stick),
        (1.5, EventKind::Slip),
    ];
    assert_eq!(simulation.events.len(), expected.len());
    for (event, (time, kind)) in simulation.events.iter().zip(expected) {
        assert_eq!(event.kind, kind);
        assert!((event.time - time).abs() < 1e-14);
    }
    let (_, v) = last(&simulation.trajectory);
    assert!((v[0] + (5.5 - bound) * 0.5).abs() < 1e-14);
}

#[test]
fn painleve_rod_ends_as_ambiguous_contact_with_a_diagnosis() {
    // n' (d - mu e) = 1 - mu D_nb / D_nn < 0 while it slides forward and presses: no force holds it.
    let (phi, half, gyration, mu) = (-0.9_f64, 1.0_f64, 0.577_f64, 2.5_f64);
    let model = Rod {
        inertia: gyration * gyration,
        arm: half,
        mu,
        ..Rod::default()
    };
    let (normal, across) = (half * phi.cos(), -half * phi.sin());
    let coupling = normal * across / gyration.powi(2);
    let own = 1.0 + (normal / gyration).powi(2);
    assert!(own - mu * coupling < 0.0, "{own} {coupling}");
    let q = [0.0, -half * phi.sin(), phi];
    let simulation = Fesd::default()
        .simulate(&model, &start(&q, &[3.0, 0.0, 0.0], 1.0), &mut |_| true)
        .unwrap();
    assert_eq!(simulation.status.name(), "ambiguous_contact");
    let message = &simulation.status.diagnosis().unwrap().message;
    assert!(message.contains("jamming"), "{message}");
    assert!(message.contains("friction"), "{message}");
}

#[test]
fn scene_without_friction_records_none() {
    let model = crate::common::scenes::ball();
    let simulation = Fesd::default()
        .simulate(&model, &start(&[0.0, 1.0], &[1.0, 0.0], 1.0), &mut |_| true)
        .unwrap();
    assert!(simulation.trajectory.friction_force.is_empty());
}
