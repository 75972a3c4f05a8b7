//! The event-driven simulator where contacts meet: corners, bars, dependent normals, controls.

use crate::common::event::{accurate, check_consistency, run, sequence};
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, energies, last, start};
use hangtime::simulation::{
    ControlSignal, EventDriven, EventKind, InitialValueProblem, Simulation, SimulationStatus,
};

#[test]
fn pendulum_meets_the_wall_and_stays() {
    let model = scenes::pendulum(0.25);
    let simulation = run(&accurate(), &model, &start(&[-0.5], &[0.0], 4.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation)[0], (EventKind::Impact, 0));
    let event = &simulation.events[0];
    // Energy: v^2 / 2 = g (cos 0.25 - cos 0.5).
    let speed = (2.0 * GRAVITY * (0.25_f64.cos() - 0.5_f64.cos())).sqrt();
    assert!(distance(&event.q, &[0.25]) < 1e-12);
    assert!(distance(&event.v_before, &[speed]) < 1e-11);
    assert!(event.v_after[0].abs() < 1e-15);
    // Gravity pulls away from the wall: an impact, then a swing back that no longer reaches it, and
    // grazes it again at full period.
    let energies = energies(&model, &simulation);
    for pair in energies.windows(2) {
        assert!(pair[1] <= pair[0] + 1e-11, "energy grows: {pair:?}");
    }
}

#[test]
fn pendulum_leaning_on_the_wall_rests() {
    let model = scenes::pendulum(-0.25);
    let simulation = run(&accurate(), &model, &start(&[-0.5], &[0.0], 3.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[0] + 0.25).abs() < 1e-12);
    assert!(v[0].abs() < 1e-14);
    let force = simulation.trajectory.contact_force.last().unwrap()[0];
    // Torque balance about the pivot: force times lever cos(0.25) against g sin(0.25).
    assert!((force - GRAVITY * 0.25_f64.tan()).abs() < 1e-11);
}

#[test]
fn block_in_a_corner_stops_at_the_wall_and_rests_on_both() {
    let model = scenes::corner();
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.0], &[2.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 1)]);
    assert!((simulation.events[0].time - 0.5).abs() < 1e-15);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-15);
    assert_eq!(v, [0.0, 0.0]);
}

#[test]
fn flight_into_a_corner_closes_both_gaps_at_once() {
    let model = scenes::corner();
    let time = (2.0 / GRAVITY).sqrt();
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, 1.0], &[1.0 / time, 0.0], 1.0),
    );
    check_consistency(&model, &simulation);
    let mut kinds = sequence(&simulation);
    kinds.sort_by_key(|&(_, contact)| contact);
    assert_eq!(kinds, [(EventKind::Impact, 0), (EventKind::Impact, 1)]);
    assert!((simulation.events[0].time - time).abs() < 1e-14);
    assert!((simulation.events[1].time - time).abs() < 1e-14);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-14);
    assert_eq!(v, [0.0, 0.0]);
}

#[test]
fn dependent_normals_carry_the_weight_once() {
    let model = scenes::corner_with_double_floor();
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.5], &[2.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-14);
    assert!(distance(v, &[0.0, 0.0]) < 1e-14);
    let force = simulation.trajectory.contact_force.last().unwrap();
    // The floor stands twice: of the forces that carry the weight 2 g the smallest are equal, to what the proximal point
    // method leaves, 1e-16 by 1e-6.
    assert!((force[0] + force[2] - 2.0 * GRAVITY).abs() < 1e-13);
    assert!((force[0] - force[2]).abs() < 1e-8);
}

/// Velocities after a level bar of unit mass hits the ground with both tips at speed `speed`.
fn level_bar(front: f64, rear: f64, radius: f64) -> (Simulation, f64) {
    let model = scenes::bar(front, rear, radius);
    let height: f64 = 0.3;
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, height, 0.0], &[1.0, 0.0, 0.0], 0.5),
    );
    check_consistency(&model, &simulation);
    (simulation, (2.0 * height / GRAVITY).sqrt())
}

#[test]
fn level_bar_landing_on_both_tips_stops_whatever_the_sign_of_the_coupling() {
    // D_12 = 1 - front rear / radius^2: -1, 0 and 0.75.
    for radius in [0.5_f64.sqrt(), 1.0, 2.0] {
        let (simulation, time) = level_bar(1.0, 1.0, radius);
        let kinds: Vec<_> = sequence(&simulation);
        assert_eq!(kinds, [(EventKind::Impact, 0), (EventKind::Impact, 1)]);
        assert!((simulation.events[0].time - time).abs() < 1e-14);
        assert!(distance(&simulation.events[0].v_after, &[1.0, 0.0, 0.0]) < 1e-14);
        let (q, v) = last(&simulation.trajectory);
        assert!(distance(q, &[0.5, 0.0, 0.0]) < 1e-13);
        assert!(distance(v, &[1.0, 0.0, 0.0]) < 1e-13);
        assert!(simulation.notes.iter().any(|note| note.contains("Moreau")));
    }
}

#[test]
fn tip_impact_on_a_resting_tip_follows_the_sign_of_the_coupling() {
    // The rear tip rests, the front tip hits with the vertical speed w: v = (w', angular velocity).
    // Moreau: D_12 <= 0 stops both; D_12 > 0 lifts the rear tip with velocity D_12 / D_11 w.
    for (radius, lifts) in [(0.5_f64.sqrt(), false), (2.0, true)] {
        let model = scenes::bar(1.0, 1.0, radius);
        let omega = -2.0;
        // Rear tip at rest: z' + omega (-1) = 0.
        let simulation = run(
            &accurate(),
            &model,
            &start(&[0.0; 3], &[0.0, omega, omega], 0.02),
        );
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let event = &simulation.events[0];
        assert_eq!(
            (event.time, event.kind, event.contact),
            (0.0, EventKind::Impact, 0)
        );
        let (d11, d12) = (1.0 + 1.0 / radius.powi(2), 1.0 - 1.0 / radius.powi(2));
        let front = event.v_after[1] + event.v_after[2];
        let rear = event.v_after[1] - event.v_after[2];
        assert!(front.abs() < 1e-14);
        let expected = if lifts { d12 / d11 * -2.0 * omega } else { 0.0 };
        assert!((rear - expected).abs() < 1e-14, "{rear} {expected}");
    }
}

#[test]
fn rocking_bar_comes_to_rest_after_ever_faster_impacts() {
    // D_12 > 0: each impact of a tip lifts the other one with D_12 / D_11 of the speed: impacts
    // accumulate geometrically until velocities are rounding error, then the bar lies still.
    let model = scenes::bar(1.0, 1.0, 2.0);
    let simulation = run(
        &EventDriven::default(),
        &model,
        &start(&[0.0, 0.1, 0.1_f64.asin()], &[0.0; 3], 3.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[0.0; 3]) < 1e-9);
    assert!(distance(v, &[0.0; 3]) < 1e-9);
    let energies = energies(&model, &simulation);
    for pair in energies.windows(2) {
        // Tolerance 1e-9 and energies of order 1.
        assert!(pair[1] <= pair[0] + 1e-9);
    }
    assert!(simulation.events.len() > 10);
}

#[test]
fn limit_on_events_ends_the_run_with_a_diagnosis() {
    let model = scenes::bar(1.0, 1.0, 2.0);
    let simulator = EventDriven {
        max_events: 8,
        ..EventDriven::default()
    };
    let simulation = run(
        &simulator,
        &model,
        &start(&[0.0, 0.1, 0.1_f64.asin()], &[0.0; 3], 3.0),
    );
    let SimulationStatus::EventLimit(diagnosis) = &simulation.status else {
        panic!("{:?}", simulation.status);
    };
    assert!(
        diagnosis.message.contains("switches"),
        "{}",
        diagnosis.message
    );
    assert!(diagnosis.contact.is_some());
    assert!(diagnosis.time < 3.0);
    assert!(!simulation.trajectory.time.is_empty());
}

#[test]
fn control_jumps_lift_the_foot_and_let_it_fall() {
    // Pulled up with more than the weight from 0.2 s on, let go at 0.5 s.
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
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(
        sequence(&simulation)[..2],
        [(EventKind::LiftOff, 0), (EventKind::Impact, 0)]
    );
    // The body swings as rest + amplitude (1 - cos w (t - 0.2)) with amplitude u / k, w^2 = k / 2; the
    // foot lifts where the spring pulls with its weight: k x = 3 g with x the way above rest.
    let amplitude = 1.5 * weight / scenes::STIFFNESS;
    let omega = (scenes::STIFFNESS / 2.0).sqrt();
    let way = weight / scenes::STIFFNESS;
    let expected = 0.2 + (1.0 - way / amplitude).acos() / omega;
    assert!((simulation.events[0].time - expected).abs() < 1e-12);
    for time in [0.2, 0.5] {
        let points: Vec<_> = (0..simulation.trajectory.time.len())
            .filter(|&k| simulation.trajectory.time[k] == time)
            .collect();
        assert_eq!(points.len(), 2, "both sides of the jump at {time}");
        assert_ne!(
            simulation.trajectory.u[points[0]],
            simulation.trajectory.u[points[1]]
        );
    }
}

#[test]
fn control_jump_on_the_foot_itself_releases_and_closes_the_contact_at_that_time() {
    // A ball whose control is its vertical force, at rest on the ground: jumps decide at once.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.25, 0.5],
            values: vec![vec![0.0], vec![2.0 * GRAVITY], vec![0.0]],
        },
        ..start(&[0.0], &[0.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(
        sequence(&simulation),
        [(EventKind::LiftOff, 0), (EventKind::Impact, 0)]
    );
    assert_eq!(simulation.events[0].time, 0.25);
    // Up with g for 0.25 s, then down with g: from height g/32 at speed g/4 upwards.
    let fall = 0.25 + (0.0625_f64 + 2.0 * 0.03125).sqrt();
    assert!((simulation.events[1].time - (0.5 + fall)).abs() < 1e-14);
}

#[test]
fn force_that_just_reaches_zero_and_returns_keeps_the_contact() {
    // The control force on the ball rises to exactly its weight and stays: contact without force.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.5, 1.0],
            values: vec![vec![0.0], vec![GRAVITY], vec![0.0]],
        },
        ..start(&[0.0], &[0.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert!(simulation.events.is_empty(), "{:?}", simulation.events);
    assert_eq!(last(&simulation.trajectory), (&[0.0][..], &[0.0][..]));
}

#[test]
fn soft_landing_is_a_contact_without_impact() {
    // Thrust against gravity such that the ball arrives with velocity zero: z = (t - 1)^2 / 2.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 1.0],
            values: vec![vec![GRAVITY + 1.0], vec![0.0]],
        },
        ..start(&[0.5], &[-1.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Contact, 0)]);
    assert!((simulation.events[0].time - 1.0).abs() < 1e-12);
    let (q, v) = last(&simulation.trajectory);
    assert!(q[0].abs() < 1e-12 && v[0].abs() < 1e-12);
}

#[test]
fn custom_impulse_direction_carries_impulse_and_force() {
    // The pump track's law with one mass: in contact v_y' = -h' (g + h'' v_y^2), and the impact adds
    // h' v_s- to v_y.
    let model = scenes::track_scene();
    let simulation = run(&accurate(), &model, &start(&[0.3, 0.2], &[1.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let event = &simulation.events[0];
    assert_eq!(event.kind, EventKind::Impact);
    let slope = 0.4 * (2.0 * event.q[0]).sin();
    let expected = event.v_before[0] + slope * event.v_before[1];
    assert!((event.v_after[0] - expected).abs() < 1e-14);
    assert_eq!(event.v_after[1], 0.0);
    assert!(simulation.residuals.primal <= 1e-14);
}

#[test]
fn two_contacts_slow_the_clock_by_the_product_of_their_weights() {
    // A block pressed into the corner: p = prod (1 - s_i p) with s = (g, 3) / a_bar.
    let model = scenes::pressed_corner(3.0);
    let simulator = EventDriven {
        auxiliary_acceleration: 20.0,
        ..accurate()
    };
    let simulation = run(&simulator, &model, &start(&[1.0, 0.0], &[0.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let (a, b) = (GRAVITY / 20.0, 3.0 / 20.0);
    // p (1 + a + b) - 1 = a b p^2: the root that tends to 1.
    let sum = 1.0 + a + b;
    let p = (sum - (sum * sum - 4.0 * a * b).sqrt()) / (2.0 * a * b);
    let end = simulation.trajectory.numerical_time.last().unwrap();
    assert!((end - 1.0 / p).abs() < 1e-13);
}

#[test]
fn directions_that_jam_end_the_run_with_a_diagnosis() {
    let model = scenes::jamming_corner();
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[-1.0, -1.0], 1.0));
    let SimulationStatus::AmbiguousContact(diagnosis) = &simulation.status else {
        panic!("{:?}", simulation.status);
    };
    assert!(
        diagnosis.message.contains("no solution"),
        "{}",
        diagnosis.message
    );
    assert_eq!((diagnosis.time, diagnosis.contact), (0.0, Some(0)));
}

#[test]
fn thirteen_floors_are_one() {
    let model = scenes::thirteen_floors();
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[0.0; 2], 1.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!((simulation.events[0].time - (2.0 / GRAVITY).sqrt()).abs() < 1e-14);
    assert!(distance(last(&simulation.trajectory).0, &[0.0, 0.0]) < 1e-14);
    // The wall is contact 1; the floors share the weight of 2 kg equally.
    let force = simulation.trajectory.contact_force.last().expect("forces");
    for (contact, force) in force
        .iter()
        .enumerate()
        .filter(|(contact, _)| *contact != 1)
    {
        // The proximal point method leaves 1e-16 by 1e-6 of what does nothing.
        assert!(
            (force - 2.0 * GRAVITY / 13.0).abs() < 1e-7,
            "{contact}: {force}"
        );
    }
    assert!(
        simulation
            .notes
            .iter()
            .any(|note| note.contains("the smallest are recorded"))
    );
}
