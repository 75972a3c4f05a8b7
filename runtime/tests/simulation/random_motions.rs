//! Random motions: every run reaches its horizon, penetrates no more than its tolerance explains, pulls nowhere and gains no energy;
//! and the impact of a rod against both laws.

use crate::common::event::{accurate, run};
use crate::common::laws::{Disc, Ground, Rod, Room, RoughCrate, Table};
use crate::common::scenes::{self, GRAVITY};
use crate::common::{check_energy, gap_at, pushed, same_in_every_run, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventDriven, Fesd, InitialValueProblem, Simulation, SimulationStatus,
};
use proptest::prelude::*;
use proptest::sample::select;

/// The tolerance of the event-driven method, and stages and tolerance of finite elements.
fn settings() -> impl Strategy<Value = (f64, (usize, f64))> {
    let tolerance = select(vec![1e-4, 1e-6, 1e-9, 1e-12]);
    (tolerance, (3..6_usize, select(vec![1e-6, 1e-9])))
}

/// No gap of a motion is below a number, and without controls it gains no energy.
fn check(
    (model, problem): (&dyn Model, &InitialValueProblem),
    simulation: &Simulation,
    (least, tolerance): (f64, f64),
) -> Result<(), TestCaseError> {
    let trajectory = &simulation.trajectory;
    for k in 0..trajectory.time.len() {
        for contact in 0..model.declaration().contacts.len() {
            let gap = gap_at(model, trajectory, contact, k);
            prop_assert!(gap >= least, "gap {} at {}", gap, trajectory.time[k]);
        }
    }
    match problem.controls {
        ControlSignal::Zero => check_energy(model, simulation, tolerance),
        _ => Ok(()),
    }
}

fn by_events(
    model: &dyn Model,
    problem: &InitialValueProblem,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let simulator = EventDriven {
        tolerance,
        ..EventDriven::default()
    };
    let simulation = run(&simulator, model, problem);
    prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
    // Rounding error of gaps and velocities of order one.
    prop_assert!(simulation.residuals.primal <= 1e-11);
    // Forces up to some hundreds vanish to rounding error at a take-off.
    prop_assert!(simulation.residuals.dual <= 1e-9);
    // Closed gaps are known to 1e-12, and dips of a few times that are no crossings.
    check((model, problem), &simulation, (-1e-11, tolerance))
}

/// `accelerations` are what carries the contacts.
fn by_elements(
    model: &dyn Model,
    problem: &InitialValueProblem,
    (stages, tolerance): (usize, f64),
    accelerations: f64,
) -> Result<(), TestCaseError> {
    let elements = Fesd::default().with_scheme(Scheme::RadauIia, stages);
    let elements = elements.with_grid(1, 1).with_tolerance(tolerance);
    let simulation = run(&elements, model, problem);
    // Where impacts follow too fast to be told apart the event-driven method confirms the usual promise only.
    let joined = matches!(&simulation.status, SimulationStatus::Inaccurate(diagnosis)
        if diagnosis.message.starts_with("impacts follow too fast"));
    let estimate = simulation.error_estimate.unwrap_or(f64::INFINITY);
    prop_assert!(
        simulation.status.is_solved() || joined && estimate <= 1e-6,
        "{:?}, estimate {}",
        simulation.status,
        estimate
    );
    // Contacts count as touching at gaps up to 1e-9 of the largest coordinate, at least 1.
    let positions = simulation.trajectory.q.iter().flatten();
    let largest = positions.fold(1.0_f64, |largest, q| largest.max(q.abs()));
    let residual = simulation.residuals.complementarity;
    prop_assert!(residual <= 1e-9 * largest * accelerations, "{:e}", residual);
    // A contact that was just released may be violated by the local error of its element.
    check(
        (model, problem),
        &simulation,
        (-100.0 * tolerance, tolerance),
    )
}

fn by_both(
    model: &dyn Model,
    problem: &InitialValueProblem,
    (tolerance, elements): (f64, (usize, f64)),
) -> Result<(), TestCaseError> {
    by_events(model, problem, tolerance)?;
    by_elements(model, problem, elements, 10.0)
}

proptest! {
    #![proptest_config(same_in_every_run(120))]

    #[test]
    fn bar_thrown_onto_the_ground_loses_energy_and_comes_to_its_horizon(
        (front, rear, radius) in (0.2..2.0, 0.2..2.0, 0.1..2.5),
        (angle, height) in (-0.6..0.6_f64, 0.0..0.5),
        (fall, spin) in (-3.0..3.0, -3.0..3.0),
        settings in settings(),
    ) {
        let z = f64::max(front, rear) * angle.abs().sin() + height;
        let problem = start(&[0.0, z, angle], &[1.0, fall, spin], 2.0);
        by_both(&scenes::bar(front, rear, radius), &problem, settings)?;
    }

    #[test]
    fn mass_on_waves_flies_lands_and_slides_without_gaining_energy(
        (height, number) in (0.02..1.0, 0.3..8.0),
        (y, above) in (-3.0..3.0, select(vec![0.0, 0.1, 0.8])),
        (along, up) in (-6.0..6.0, -3.0..3.0),
        settings in settings(),
    ) {
        let z = height * f64::cos(number * y) + above;
        by_both(&scenes::waves(height, number), &start(&[y, z], &[along, up], 2.0), settings)?;
    }

    #[test]
    fn crate_tumbling_between_walls_comes_to_its_horizon(
        (half_width, half_height) in (0.1..0.5, 0.1..0.5),
        (y, z, angle) in (-0.2..0.2, 0.75..1.5, -3.0..3.0),
        (along, up, spin) in (-4.0..4.0, -3.0..3.0, -3.0..3.0),
        friction in select(vec![0.1, 0.3, 0.6]),
        settings in settings(),
    ) {
        let problem = start(&[y, z, angle], &[along, up, spin], 2.0);
        let smooth = RoughCrate { half_width, half_height, ..RoughCrate::default() };
        by_both(&smooth, &problem, settings)?;
        // A crate wedged between floor and wall presses with several times its weight.
        let rough = RoughCrate { mu: friction, ..smooth };
        by_elements(&rough, &problem, settings.1, 100.0)?;
    }

    #[test]
    fn hopper_with_random_controls_comes_to_its_horizon(
        (foot, stretch) in (select(vec![0.0, 0.05, 0.2]), 0.2..0.8),
        (foot_speed, body_speed) in (-2.0..2.0, -3.0..3.0),
        forces in prop::collection::vec(-100.0..60.0_f64, 10),
        settings in settings(),
    ) {
        let problem = start(&[foot, foot + stretch], &[foot_speed, body_speed], 2.0);
        let problem = pushed(&forces, problem);
        by_both(&scenes::hopper(), &problem, settings)?;
    }

    #[test]
    fn rough_mass_on_waves_bounces_slides_and_sticks_without_gaining_energy(
        (height, number) in (0.02..0.4, 0.3..8.0),
        (y, above) in (-3.0..3.0, select(vec![0.0, 0.1, 0.8])),
        (along, up) in (-6.0..6.0, -3.0..3.0),
        (mu, e, any) in (0.0..1.2, select(vec![0.0, 0.4, 0.8]), 0.0..1.0),
        settings in settings(),
    ) {
        let model = Ground { height, number, mu, e, ..Ground::default() };
        let problem = start(&[y, model.height_at(y) + above], &[along, up], 2.0);
        by_elements(&model, &problem, settings.1, 10.0)?;
        by_events(&Ground { mu: 0.0, e: any, ..model }, &problem, 1e-9)?;
    }

    #[test]
    fn spinning_disc_with_any_laws_bounces_without_gaining_energy(
        (e, mu) in (0.0..1.0_f64, 0.0..1.5_f64),
        (slope, shape) in (-0.5..0.5_f64, 0.2..1.0),
        (height, along, up, spin) in (0.0..1.0, -4.0..4.0, -3.0..3.0, -20.0..20.0),
    ) {
        let model = Disc { radius: 0.3, shape, slope, e, mu, ..Disc::default() };
        let problem = start(&[0.0, 0.3 / slope.cos() + height, 0.0], &[along, up, spin], 2.0);
        by_events(&model, &problem, 1e-9)?;
    }

    #[test]
    fn table_that_bounces_or_rubs_on_both_feet_gains_no_energy(
        (mu, e, height) in (0.0..1.0_f64, 0.0..1.0_f64, 0.1..1.0_f64),
        (angle, above) in (-0.5..0.5_f64, 0.0..0.5),
        (along, up, spin) in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
        stiffness in select(vec![0.0, 20.0]),
    ) {
        let z = angle.sin().abs() + height * angle.cos() + above;
        let problem = start(&[0.0, z, angle], &[along, up, spin], 2.0);
        let bouncing = Table { height, e, ..Table::default() };
        by_events(&bouncing, &problem, 1e-9)?;
        by_events(&Table { stiffness, mu, e: 0.0, ..bouncing }, &problem, 1e-9)?;
    }

    #[test]
    fn rod_with_friction_falls_without_gaining_energy(
        mu in 0.0..1.3_f64,
        angle in 0.2..1.5_f64,
        (above, along, up, spin) in (0.0..0.5, -3.0..3.0, -3.0..3.0, -3.0..3.0),
    ) {
        let problem = start(&[0.0, angle.sin() + above, angle], &[along, up, spin], 1.0);
        by_events(&Rod { mu, ..Rod::default() }, &problem, 1e-9)?;
    }

    #[test]
    fn ball_in_a_room_with_all_laws_comes_to_its_horizon(
        (e, mu) in (0.0..1.0_f64, 0.0..1.0_f64),
        (y, z, along, up) in (0.0..1.0, 0.0..1.0, -5.0..5.0, -5.0..5.0),
    ) {
        let model = Room { gravity: GRAVITY, e, mu, ..Room::default() };
        by_events(&model, &start(&[y, z], &[along, up], 5.0), 1e-9)?;
    }

    #[test]
    fn single_impact_of_a_rod_follows_both_laws(
        (e, mu) in (0.0..1.0_f64, 0.0..1.2_f64),
        angle in 0.1..1.5_f64,
        (along, down, spin) in (-3.0..3.0_f64, 0.1..3.0_f64, -3.0..3.0_f64),
    ) {
        let model = Rod { e, mu, ..Rod::default() };
        let (sin, cos) = angle.sin_cos();
        // Tip velocities; the rod must fall with its tip.
        let (v_n, v_t) = (-down - cos * spin, along + sin * spin);
        prop_assume!(v_n < -0.01);
        let problem = start(&[0.0, sin, angle], &[along, -down, spin], 1e-4);
        let simulation = run(&accurate(), &model, &problem);
        prop_assert_eq!(&simulation.status, &SimulationStatus::Solved);
        let event = &simulation.events[0];
        // Impulses (P, S) in N s, by cases, with the Delassus matrix of a slender rod.
        let (d_nn, d_nt, d_tt) = (1.0 + 3.0 * cos * cos, -3.0 * sin * cos, 1.0 + 3.0 * sin * sin);
        let determinant = d_nn * d_tt - d_nt * d_nt;
        let target = -(1.0 + e) * v_n;
        let stick = (
            (d_tt * target + d_nt * v_t) / determinant,
            (-d_nt * target - d_nn * v_t) / determinant,
        );
        let slip = |sign: f64| {
            let p = target / (d_nn - sign * mu * d_nt);
            (p, -sign * mu * p)
        };
        let slides = |(p, s): (f64, f64)| v_t + d_nt * p + d_tt * s;
        let (p, s) = if stick.0 >= 0.0 && stick.1.abs() <= mu * stick.0 {
            stick
        } else if slides(slip(1.0)) > 0.0 {
            slip(1.0)
        } else {
            prop_assert!(slides(slip(-1.0)) <= 0.0);
            slip(-1.0)
        };
        let expected = [along + s, -down + p, spin + 3.0 * (-cos * p + sin * s)];
        for (found, expected) in event.v_after.iter().zip(expected) {
            // Condition number of the matrix below 16.
            prop_assert!((found - expected).abs() < 1e-13, "{:?} {:?}", event.v_after, expected);
        }
    }
}
