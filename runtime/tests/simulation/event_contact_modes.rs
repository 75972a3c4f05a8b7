//! The event-driven simulator where contacts meet: corners, bars, dependent normals, controls.

use crate::common::event::{accurate, check_consistency, run};
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, last, start};
use hangtime::simulation::{EventDriven, SimulationStatus};

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
