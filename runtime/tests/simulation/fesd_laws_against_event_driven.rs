//! Restitution and friction in the finite element simulator against the event-driven one on random scenes:
//! two implementations of the laws that share nothing but the model's functions.

use crate::common::event::run;
use crate::common::laws::{Feet, Ground, Rod};
use crate::common::{check_energy, distance, last, pushed, same_in_every_run, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, Event, EventDriven, EventKind, Fesd, InitialValueProblem, Simulation,
    SimulationStatus, StepFormulation,
};
use proptest::prelude::*;

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

/// Bounces end here in both simulators [m/s]: high enough for both to tell a bounce from rounding.
const REST: f64 = 1e-3;

/// Number of events before those that follow each other ever faster: where an infinite sequence of impacts
/// without restitution ends depends on the rounding of a gap.
fn distinct_events(simulation: &Simulation) -> usize {
    let crowded = |pair: &[Event]| {
        let elapsed = pair[1].time - pair[0].time;
        elapsed > 1e-12 && elapsed < 1e-4
    };
    let events = &simulation.events;
    let first = events.windows(2).position(crowded);
    first.map_or(events.len(), |first| first + 1)
}

/// Same events at the same times and the same end, up to `tolerance` relative to the growth of small
/// differences from impact to impact.
pub(crate) fn agree(
    model: &dyn Model,
    problem: &InitialValueProblem,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    for formulation in [StepFormulation::ActiveSet, StepFormulation::TimeFreezing] {
        let fesd = Fesd {
            rest_velocity: Some(REST),
            ..Fesd::default()
        };
        let fesd = fesd
            .with_scheme(Scheme::RadauIia, 5)
            .with_grid(1, 1)
            .with_tolerance(1e-13)
            .with_formulation(formulation);
        agree_by(&fesd, model, problem, tolerance)?;
    }
    Ok(())
}

/// Whether a run is solved, or runs that are much more accurate than what is asked differ by rounding errors.
fn as_far_as_rounding_allows(run: &Simulation) -> bool {
    let differs = matches!(run.status, SimulationStatus::Inaccurate(_));
    run.status.is_solved() || differs && run.error_estimate.is_some_and(|error| error < 1e-10)
}

fn agree_by(
    simulator: &Fesd,
    model: &dyn Model,
    problem: &InitialValueProblem,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let fesd = run(simulator, model, problem);
    let event = EventDriven {
        tolerance: 1e-13,
        rest_velocity: Some(REST),
        ..EventDriven::default()
    };
    let event = run(&event, model, problem);
    prop_assert!(as_far_as_rounding_allows(&fesd), "{}", fesd.status);
    prop_assert_eq!(&event.status, &SimulationStatus::Solved);
    let list = |simulation: &Simulation| -> Vec<(EventKind, usize)> {
        let events = simulation.events.iter();
        events.map(|event| (event.kind, event.contact)).collect()
    };
    let (listed, expected) = (list(&fesd), list(&event));
    let distinct = distinct_events(&fesd).min(distinct_events(&event));
    prop_assert_eq!(&listed[..distinct], &expected[..distinct]);
    if distinct == listed.len() {
        prop_assert_eq!(distinct, expected.len());
    }
    for (a, b) in fesd.events[..distinct].iter().zip(&event.events) {
        let difference = (a.time - b.time).abs();
        prop_assert!(difference <= tolerance, "{:?} {:e}", a.kind, difference);
    }
    let ((q, v), (q_event, v_event)) = (last(&fesd.trajectory), last(&event.trajectory));
    prop_assert!(distance(q, q_event) <= tolerance, "{:?} {:?}", q, q_event);
    prop_assert!(
        distance(v, v_event) <= 10.0 * tolerance,
        "{:?} {:?}",
        v,
        v_event
    );
    // Signs along the run: penetration, adhesion, friction beyond its bound.
    prop_assert!(fesd.residuals.dual <= 1e-9, "{:?}", fesd.residuals);
    if matches!(problem.controls, ControlSignal::Zero) {
        check_energy(model, &fesd, 1e-13)?;
    }
    Ok(())
}

fn ground() -> impl Strategy<Value = Ground> {
    prop_oneof![
        (-0.6..0.6_f64, 0.5..2.0_f64).prop_map(|(angle, scale)| Ground {
            slope: angle,
            scale,
            ..Ground::default()
        }),
        (0.2..2.0_f64).prop_map(|curvature| Ground {
            curvature,
            ..Ground::default()
        }),
        (0.02..0.4_f64, 0.5..4.0_f64).prop_map(|(height, number)| Ground {
            height,
            number,
            ..Ground::default()
        }),
    ]
}

fn restitution() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, 0.0, 0.3, 0.6])
}

proptest! {
    #![proptest_config(same_in_every_run(120))]

    #[test]
    fn mass_that_bounces_and_rubs_moves_alike(
        ground in ground(),
        (friction, restitution) in (prop::sample::select(vec![0.0, 0.1, 0.3, 0.9]), restitution()),
        (y, above) in (-1.0..1.0_f64, prop::sample::select(vec![0.0, 0.05, 0.3])),
        (along, up) in (-3.0..3.0_f64, -1.0..1.0_f64),
    ) {
        let model = Ground { mu: friction, e: restitution, ..ground.clone() };
        let z = ground.height_at(y) + above;
        // Distances between neighbouring motions grow a few times from bounce to bounce on curved ground.
        agree(&model, &start(&[y, z], &[along, up], 1.5), 1e-9)?;
    }

    #[test]
    fn pushed_mass_sticks_and_slips_alike(
        ground in ground(),
        friction in 0.1..1.0_f64,
        y in -0.5..0.5_f64,
        forces in prop::collection::vec(-12.0..12.0, 6),
    ) {
        let model = Ground { mu: friction, ..ground.clone() };
        let problem = pushed(&forces, start(&[y, ground.height_at(y)], &[0.0, 0.0], 1.5));
        agree(&model, &problem, 1e-9)?;
    }

    #[test]
    fn rod_that_falls_on_its_tip_moves_alike(
        (friction, restitution) in (0.0..0.6_f64, restitution()),
        (phi, above) in (-1.4..-0.5_f64, 0.0..0.3_f64),
        (along, up, spin) in (-2.0..2.0_f64, -1.0..0.0_f64, -2.0..2.0_f64),
    ) {
        let body = Rod { inertia: 0.577 * 0.577, arm: 1.0, mu: friction, e: restitution, ..Rod::default() };
        let q = [0.0, -phi.sin() + above, phi];
        agree(&body, &start(&q, &[along, up, spin], 0.4), 1e-9)?;
    }

    #[test]
    fn bar_that_lands_on_two_feet_moves_alike(
        friction in prop::sample::select(vec![0.1, 0.4]),
        (front, rear, gyration) in (0.3..1.0_f64, 0.3..1.0_f64, 0.3..1.0_f64),
        (phi, above) in (-0.3..0.3_f64, 0.0..0.1_f64),
        (along, spin) in (-2.0..2.0_f64, -0.5..0.5_f64),
    ) {
        let body = Feet { gyration, front, rear, mu: friction, ..Feet::default() };
        let q = [0.0, f64::max(front, rear) * phi.abs().sin() + above, phi];
        // The last impacts of a rocking bar are left out, at speeds of about 1e-7.
        agree(&body, &start(&q, &[along, 0.0, spin], 0.3), 1e-8)?;
    }

    #[test]
    fn wagon_that_ramps_push_and_lift_moves_alike(
        values in prop::collection::vec((-15.0..15.0_f64, 0.0..27.5_f64), 6),
    ) {
        let problem = InitialValueProblem {
            controls: ControlSignal::PiecewiseLinear {
                times: (0..6).map(|k| 0.37 * f64::from(k)).collect(),
                values: values.iter().map(|&(push, lift)| vec![push, lift]).collect(),
            },
            ..start(&[0.0, 0.0], &[0.0, 0.0], 1.8)
        };
        agree(&Wagon::default(), &problem, 1e-7)?;
    }
}
