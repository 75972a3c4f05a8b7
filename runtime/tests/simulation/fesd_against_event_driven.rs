//! Finite elements with switch detection against the event-driven simulator on the same scenes: two
//! methods that share nothing but the model's functions.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, last, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
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
fn two_contacts_slow_the_clock_by_the_product_of_their_weights() {
    agree(
        &scenes::pressed_corner(3.0),
        &start(&[1.0, 0.0], &[0.0, 0.0], 1.0),
        1e-12,
    );
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
