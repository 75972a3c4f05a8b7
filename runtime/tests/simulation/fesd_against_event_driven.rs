//! Finite elements with switch detection against the event-driven simulator on the same scenes: two
//! methods that share nothing but the model's functions.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, last, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus,
    Simulator, StepFormulation,
};

/// Order 9 with elements of about a hundredth of a motion's time scale: errors near rounding.
fn accurate() -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, 5)
        .with_grid(40, 2)
}

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted")
}

/// Same events at the same times, same end, contact forces and gaps of the right sign, in physical and numerical time.
fn agree(model: &dyn Model, problem: &InitialValueProblem, tolerance: f64) -> Simulation {
    let frozen = accurate().with_formulation(StepFormulation::TimeFreezing);
    agree_by(&frozen, model, problem, tolerance);
    agree_by(&accurate(), model, problem, tolerance)
}

fn agree_by(
    simulator: &Fesd,
    model: &dyn Model,
    problem: &InitialValueProblem,
    tolerance: f64,
) -> Simulation {
    let fesd = run(simulator, model, problem);
    let event = run(
        &EventDriven {
            tolerance: 1e-13,
            ..EventDriven::default()
        },
        model,
        problem,
    );
    assert_eq!(fesd.status, SimulationStatus::Solved);
    assert_eq!(event.status, SimulationStatus::Solved);
    let kinds = |simulation: &Simulation| -> Vec<(EventKind, usize)> {
        simulation
            .events
            .iter()
            .map(|event| (event.kind, event.contact))
            .collect()
    };
    assert_eq!(kinds(&fesd), kinds(&event));
    for (a, b) in fesd.events.iter().zip(&event.events) {
        assert!(
            (a.time - b.time).abs() <= tolerance,
            "{:?} of contact {}: {} and {}",
            a.kind,
            a.contact,
            a.time,
            b.time
        );
        assert!(distance(&a.v_after, &b.v_after) <= 100.0 * tolerance);
    }
    let ((q, v), (q_event, v_event)) = (last(&fesd.trajectory), last(&event.trajectory));
    assert!(
        distance(q, q_event) <= tolerance,
        "{q:?} {q_event:?} {:e}",
        distance(q, q_event)
    );
    assert!(
        distance(v, v_event) <= 10.0 * tolerance,
        "{v:?} {v_event:?}"
    );
    let (numerical, numerical_event) = (
        fesd.trajectory.numerical_time.last().unwrap(),
        event.trajectory.numerical_time.last().unwrap(),
    );
    assert!(
        (numerical - numerical_event).abs() <= tolerance.max(1e-9),
        "numerical time {numerical} {numerical_event}"
    );
    assert!(fesd.residuals.dual <= 1e-10, "{:?}", fesd.residuals);
    assert!(fesd.residuals.complementarity <= 1e-10);
    for force in fesd.trajectory.contact_force.iter().flatten() {
        assert!(*force >= -1e-10, "force {force:e}");
    }
    fesd
}

#[test]
fn starts_on_the_surface_are_told_apart() {
    let model = scenes::ball();
    assert!(
        agree(&model, &start(&[0.0; 2], &[2.0, 0.0], 1.0), 1e-13)
            .events
            .is_empty()
    );
    let struck = agree(&model, &start(&[0.0; 2], &[2.0, -3.0], 1.0), 1e-13);
    assert_eq!(struck.events[0].time, 0.0);
    let flies = agree(&model, &start(&[0.0; 2], &[0.0, 3.0], 1.0), 1e-13);
    assert!((flies.events[0].time - 6.0 / GRAVITY).abs() < 1e-15);
}

#[test]
fn flights_that_graze_a_crest_are_told_from_those_that_hit() {
    let model = scenes::waves(1.0, 1.0);
    let crest = 2.0 * std::f64::consts::PI;
    let (speed, time) = (4.0, 0.5);
    let problem = |miss: f64| {
        start(
            &[
                crest - speed * time,
                1.0 + miss - 0.5 * GRAVITY * time * time,
            ],
            &[speed, GRAVITY * time],
            2.0 * time,
        )
    };
    for miss in [1e-3, 1e-6, 1e-9] {
        let simulation = agree(&model, &problem(miss), 1e-13);
        assert!(simulation.events.is_empty(), "miss {miss:e}");
    }
    for dip in [1e-3_f64, 1e-6, 1e-9] {
        // The impact time depends on the depth as its square root: rounding 1e-15 / sqrt(dip).
        let simulation = agree(&model, &problem(-dip), 1e-13 / dip.sqrt());
        assert_eq!(simulation.events[0].kind, EventKind::Impact, "dip {dip:e}");
    }
}

#[test]
fn flight_over_short_waves_hits_the_crest_it_meets_first() {
    let problem = start(&[0.0, 1.0], &[5.0, 0.0], 0.44);
    agree(&scenes::waves(0.05, 20.0), &problem, 1e-11);
}

#[test]
fn pendulum_stops_at_the_wall() {
    agree(&scenes::pendulum(0.25), &start(&[-0.5], &[0.0], 4.0), 1e-10);
    agree(
        &scenes::pendulum(-0.25),
        &start(&[-0.5], &[0.0], 3.0),
        1e-10,
    );
}

#[test]
fn sliding_off_a_disc_takes_off_at_two_thirds_of_its_height() {
    let speed: f64 = 0.7;
    let problem = start(&[0.0, 1.0], &[speed, 0.0], 0.9);
    let simulation = agree(&scenes::disc(), &problem, 1e-10);
    let height = (speed * speed + 2.0 * GRAVITY) / (3.0 * GRAVITY);
    assert!((simulation.events[0].q[1] - height).abs() < 1e-11);
}

#[test]
fn sliding_over_waves_conserves_energy_and_stays_on_the_ground() {
    let model = scenes::waves(0.5, 1.0);
    let problem = start(&[0.0, 0.5], &[4.0, 0.0], 3.0);
    let simulation = agree(&model, &problem, 1e-9);
    let energies = crate::common::energies(&model, &simulation);
    for energy in &energies {
        assert!((energy - energies[0]).abs() < 1e-9);
    }
    assert!(simulation.residuals.primal < 1e-10);
}

#[test]
fn corners_close_one_gap_or_both() {
    let model = scenes::corner();
    agree(&model, &start(&[0.0, 0.0], &[2.0, 0.0], 1.0), 1e-13);
    let time = (2.0 / GRAVITY).sqrt();
    let both = agree(&model, &start(&[0.0, 1.0], &[1.0 / time, 0.0], 1.0), 1e-12);
    assert_eq!(both.events.len(), 2);
}

#[test]
fn dependent_normals_carry_the_weight_once() {
    let model = scenes::corner_with_double_floor();
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.5], &[2.0, 0.0], 1.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(distance(last(&simulation.trajectory).0, &[1.0, 0.0]) < 1e-13);
    let force = simulation.trajectory.contact_force.last().unwrap();
    assert!((force[0] + force[2] - 2.0 * GRAVITY).abs() < 1e-12);
    assert!((force[0] - force[2]).abs() < 1e-8);
}

#[test]
fn bar_landing_on_both_tips_stops_whatever_the_sign_of_the_coupling() {
    for radius in [0.5_f64.sqrt(), 1.0, 2.0] {
        let model = scenes::bar(1.0, 1.0, radius);
        let problem = start(&[0.0, 0.3, 0.0], &[1.0, 0.0, 0.0], 0.5);
        let simulation = agree(&model, &problem, 1e-12);
        assert_eq!(simulation.events.len(), 2);
        assert!(simulation.notes.iter().any(|note| note.contains("Moreau")));
    }
}

#[test]
fn tip_impact_on_a_resting_tip_follows_the_sign_of_the_coupling() {
    for radius in [0.5_f64.sqrt(), 2.0] {
        let model = scenes::bar(1.0, 1.0, radius);
        agree(&model, &start(&[0.0; 3], &[0.0, -2.0, -2.0], 0.02), 1e-12);
    }
}

#[test]
fn rocking_bar_comes_to_rest_after_ever_faster_impacts() {
    let model = scenes::bar(1.0, 1.0, 2.0);
    let problem = start(&[0.0, 0.1, 0.1_f64.asin()], &[0.0; 3], 3.0);
    let simulation = run(&accurate(), &model, &problem);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[0.0; 3]) < 1e-8 && distance(v, &[0.0; 3]) < 1e-8);
    for pair in crate::common::energies(&model, &simulation).windows(2) {
        assert!(pair[1] <= pair[0] + 1e-9);
    }
}

#[test]
fn control_jumps_lift_the_foot_and_let_it_fall() {
    let model = scenes::hopper();
    let weight = 3.0 * GRAVITY;
    let rest = 0.5 - 2.0 * GRAVITY / scenes::STIFFNESS;
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.2, 0.5],
            values: vec![vec![0.0], vec![1.5 * weight], vec![0.0]],
        },
        ..start(&[0.0, rest], &[0.0, 0.0], 1.5)
    };
    // Sixteen oscillations of the spring: relative errors of 1e-13 a step add up.
    agree(&model, &problem, 1e-9);
}

#[test]
fn control_jumps_decide_contact_at_once() {
    let model = scenes::lifted_ball();
    let with = |times: &[f64], values: &[f64], q: f64, v: f64| InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: times.to_vec(),
            values: values.iter().map(|&u| vec![u]).collect(),
        },
        ..start(&[q], &[v], 2.0)
    };
    let lifted = with(&[0.0, 0.25, 0.5], &[0.0, 2.0 * GRAVITY, 0.0], 0.0, 0.0);
    assert_eq!(agree(&model, &lifted, 1e-12).events[0].time, 0.25);
    let weightless = with(&[0.0, 0.5, 1.0], &[0.0, GRAVITY, 0.0], 0.0, 0.0);
    assert!(agree(&model, &weightless, 1e-13).events.is_empty());
    let soft = with(&[0.0, 1.0], &[GRAVITY + 1.0, 0.0], 0.5, -1.0);
    assert_eq!(
        agree(&model, &soft, 1e-12).events[0].kind,
        EventKind::Contact
    );
}

#[test]
fn custom_impulse_direction_carries_impulse_and_force() {
    agree(
        &scenes::track_scene(),
        &start(&[0.3, 0.2], &[1.0, 0.0], 1.0),
        1e-10,
    );
}

#[test]
fn two_contacts_slow_the_clock_by_the_product_of_their_weights() {
    agree(
        &scenes::pressed_corner(3.0),
        &start(&[1.0, 0.0], &[0.0, 0.0], 1.0),
        1e-12,
    );
}

#[test]
fn field_that_ends_stops_the_run_with_a_diagnosis() {
    let model = scenes::edge();
    let simulation = run(&accurate(), &model, &start(&[0.0], &[1.0], 5.0));
    let diagnosis = simulation.status.diagnosis().expect("stopped early");
    assert!(
        matches!(
            simulation.status,
            SimulationStatus::NotFinite(_) | SimulationStatus::StepFailed(_)
        ),
        "{:?}",
        simulation.status
    );
    assert!(
        diagnosis.time > 0.5 && diagnosis.time < 1.0,
        "{diagnosis:?}"
    );
    assert!(last(&simulation.trajectory).0[0] <= 1.0);
    let at_once = run(&accurate(), &model, &start(&[2.0], &[1.0], 5.0));
    assert!(matches!(at_once.status, SimulationStatus::NotFinite(_)));
}

hangtime::model! {
    /// A bead in a trough whose height is given by terms that cancel near its lowest point.
    pub Trough {
        parameters { depth: m = 0.4, k: 1/m = 2, g: m/s^2 = 9.81 }
        coordinates { y: m, z: m }
        lagrangian |dot((y, z))|^2/2*1[kg] - 1[kg]*g*z
        surface ground: z >= depth*(1 - cos(k*y))
        impact ground: inelastic
        horizon 0.1 [s]
    }
}

#[test]
fn start_on_a_surface_whose_gap_is_a_rounding_error_of_cancelling_terms_is_in_contact() {
    let trough = Trough::default();
    let declared = InitialValueProblem::of(&trough, None).unwrap();
    let (depth, k) = (trough.depth, trough.k);
    let mut above = 0;
    for i in 0..60 {
        // The same height by another formula, which does not cancel.
        let y = 1e-6 * 1.2_f64.powi(i);
        let z = 2.0 * depth * (0.5 * k * y).sin().powi(2);
        above += usize::from(z > depth * (1.0 - (k * y).cos()));
        let v = vec![-0.3, -0.3 * depth * k * (k * y).sin()];
        let problem = InitialValueProblem {
            q: vec![y, z],
            v,
            ..declared.clone()
        };
        let methods: [&dyn Simulator; 4] = [
            &EventDriven::default(),
            &EventDriven {
                tolerance: 1e-6,
                ..EventDriven::default()
            },
            &Fesd::default().with_tolerance(1e-12),
            &Fesd::default(),
        ];
        let ends = methods.map(|method| {
            let motion = run(method, &trough, &problem);
            assert_eq!(motion.status, SimulationStatus::Solved, "{y}");
            let events: Vec<_> = motion.events.iter().map(|event| event.kind).collect();
            assert_eq!(events, [], "{y}");
            let trajectory = &motion.trajectory;
            [&trajectory.q[..], &trajectory.v].map(|values| values.last().unwrap().clone())
        });
        // So short beside a swing that all methods come to rounding error.
        for end in &ends[1..] {
            let far = distance(&end.concat(), &ends[0].concat());
            assert!(far < 1e-13, "{y}: {far}");
        }
    }
    assert!(above > 20, "{above}");
}
