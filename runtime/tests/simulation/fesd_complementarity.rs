//! Friction and restitution in the complementarity problem of the time-freezing system: every step of a
//! motion solved by it, against closed forms.

use crate::common::laws::{Disc, Ground};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, last, start};
use hangtime::model::{Model, contact_point};
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator, StepFormulation,
};

fn time_freezing(steps: usize) -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, 3)
        .with_grid(steps, 3)
        .with_formulation(StepFormulation::Complementarity)
}

fn solve(simulator: &Fesd, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    let simulation = simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted");
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(simulation.counts.fallbacks > 0 && simulation.counts.newton == 0);
    simulation
}

fn kinds(simulation: &Simulation) -> Vec<EventKind> {
    simulation.events.iter().map(|event| event.kind).collect()
}

/// Residual up to which the solver's exact points are accepted; speeds and times are of order one.
const SOLVED: f64 = 1e-9;

#[test]
fn block_on_incline_stops_where_the_closed_form_does() {
    let (angle, mu, speed) = (15.0_f64.to_radians(), 0.5, 3.0);
    let ground = Ground {
        slope: angle,
        ..Ground::default()
    };
    let model = Ground {
        mu,
        ..ground.clone()
    };
    let along = [angle.cos(), -angle.sin()];
    let problem = start(&[0.0, 0.0], &along.map(|c| speed * c), 2.0);
    let simulation = solve(&time_freezing(10), &model, &problem);
    assert_eq!(kinds(&simulation), [EventKind::Stick]);
    let late = simulation.events[0].time - 1.364_348_711_498_973_1;
    assert!(late.abs() < SOLVED, "{late:e}");
    let (q, v) = last(&simulation.trajectory);
    let stop = along.map(|c| 2.046_523_067_248_46 * c);
    assert!(distance(q, &stop) < SOLVED && distance(v, &[0.0; 2]) < SOLVED);
}

#[test]
fn restitution_is_that_of_the_law_whatever_mass_ground_and_scale() {
    let grounds = [
        Ground::default(),
        Ground {
            offset: 0.2,
            ..Ground::default()
        },
        Ground {
            slope: 0.4,
            offset: -0.3,
            scale: 2.0,
            ..Ground::default()
        },
        Ground {
            curvature: 0.7,
            ..Ground::default()
        },
    ];
    for e in [0.3, 0.5, 0.9, 1.0] {
        for (k, ground) in grounds.iter().enumerate() {
            let mut model = Ground {
                e,
                ..ground.clone()
            };
            model.mass = [1.0, 2.0, 10.0, 10.0][k];
            let q = [0.3, ground.height_at(0.3) + 0.1];
            let simulation = solve(&time_freezing(1), &model, &start(&q, &[0.5, -1.0], 0.12));
            assert_eq!(kinds(&simulation), [EventKind::Impact], "{e} {ground:?}");
            let impact = &simulation.events[0];
            let normal = |v: &[f64]| {
                let mut x = impact.q.clone();
                x.extend(v);
                x.push(0.0);
                let mut point = vec![0.0; contact_point::length(2)];
                model.contact(0, &x, &mut point);
                (
                    point[contact_point::GAP],
                    point[contact_point::NORMAL_VELOCITY],
                )
            };
            let ((gap, before), (_, after)) = (normal(&impact.v_before), normal(&impact.v_after));
            assert!(gap.abs() < 1e-6, "{gap:e}");
            let error = after / before + e;
            assert!(error.abs() < SOLVED, "{e} {ground:?}: {error:e}");
        }
    }
}

#[test]
fn bounce_with_friction_slips_or_grips_as_the_impact_law_says() {
    // Impulse p = (1 + e) v; grip: s = -(v_y + r w) / (1 + r^2 / k^2), if |s| <= mu p.
    let (radius, gyration, e) = (0.5_f64, 0.4_f64, 0.5);
    let (v_y, fall, spin, above) = (1.0_f64, 3.0_f64, 4.0_f64, 0.1);
    let speed = (fall * fall + 2.0 * GRAVITY * above).sqrt();
    let full = (v_y + radius * spin) / (1.0 + (radius / gyration).powi(2));
    for mu in [0.1, 0.5] {
        let body = Disc {
            radius,
            shape: (gyration / radius).powi(2),
            mu,
            e,
            ..Disc::default()
        };
        let problem = start(&[0.0, radius + above, 0.0], &[v_y, -fall, spin], 0.06);
        let simulation = solve(&time_freezing(1), &body, &problem);
        assert_eq!(kinds(&simulation), [EventKind::Impact]);
        let s = -full.min(mu * (1.0 + e) * speed);
        let after = [v_y + s, e * speed, spin + radius * s / gyration.powi(2)];
        let found = &simulation.events[0].v_after;
        assert!(
            distance(found, &after) < SOLVED,
            "{mu}: {found:?} {after:?}"
        );
        let time = (speed - fall) / GRAVITY;
        assert!((simulation.events[0].time - time).abs() < SOLVED);
    }
}

#[test]
fn block_on_a_spring_turns_round_as_in_closed_form() {
    let (mu, stiffness) = (0.2, 25.0_f64);
    let mut model = Ground {
        mu,
        ..Ground::default()
    };
    model.stiffness = stiffness;
    let simulation = solve(
        &time_freezing(20),
        &model,
        &start(&[1.0, 0.0], &[0.0, 0.0], 2.0),
    );
    assert_eq!(kinds(&simulation), [EventKind::Slip; 3]);
    let delta = mu * GRAVITY / stiffness;
    for (k, event) in simulation.events.iter().enumerate() {
        let half_periods = (k + 1) as f64;
        let turn = (1.0 - 2.0 * half_periods * delta) * if k % 2 == 0 { -1.0 } else { 1.0 };
        let time = half_periods * std::f64::consts::PI / stiffness.sqrt();
        // Order 5 with elements of a sixth of a time unit of the oscillator: 1e-8 in 20 steps.
        assert!((event.q[0] - turn).abs() < 1e-6, "{:e}", event.q[0] - turn);
        assert!((event.time - time).abs() < 1e-6, "{:e}", event.time - time);
    }
}

#[test]
fn bounces_faster_than_the_steps_end_by_the_rest_velocity_or_with_a_remedy() {
    let model = Ground {
        e: 0.5,
        ..Ground::default()
    };
    let problem = start(&[0.0, 0.1], &[0.0, 0.0], 0.6);
    let stopped = time_freezing(6)
        .simulate(&model, &problem, &mut |_| true)
        .expect("the problem is accepted");
    let diagnosis = stopped.status.diagnosis().expect("bounces every 20 ms");
    assert!(diagnosis.message.contains("rest velocity"), "{diagnosis:?}");
    let simulator = Fesd {
        rest_velocity: Some(0.6),
        ..time_freezing(6)
    };
    let simulation = solve(&simulator, &model, &problem);
    let (q, v) = last(&simulation.trajectory);
    assert!(q[1].abs() < SOLVED && v[1].abs() < SOLVED);
    let said = simulation
        .notes
        .iter()
        .any(|n| n.contains("`ground` stops bouncing"));
    assert!(said, "{:?}", simulation.notes);
}
