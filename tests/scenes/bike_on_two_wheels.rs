//! The example with two contacts: its optimum against free flight, and the geometry of its picture.

use hangtime::model::{Model, Shape};
use hangtime::ocp::{self, Problem, Settings, Stationarity};

#[expect(
    dead_code,
    unreachable_pub,
    reason = "the example is a program with a main function"
)]
#[path = "../../examples/bike_on_two_wheels.rs"]
pub(crate) mod example;

#[test]
fn bike_lands_on_a_downhill_slope_and_is_faster_than_in_flight() {
    let model = example::Bike::default();
    let problem = Problem::of(&model, 16);
    let solution = ocp::solve(&model, &problem, &Settings::default(), &mut |_| true).unwrap();
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    assert_ne!(solution.stationarity, Stationarity::None);
    assert!(solution.resimulation_error < 1e-6);
    // In flight all the way, 5 m at 3 m/s with 5 m/s^2 of push.
    let flight = (-3.0 + (9.0_f64 + 2.0 * 5.0 * 5.0).sqrt()) / 5.0;
    assert!(
        solution.horizon < flight - 1e-3,
        "{} against {flight}",
        solution.horizon
    );
    assert!(!solution.planned_events.is_empty());
}

#[test]
fn wheels_in_the_picture_touch_the_ground_where_the_gaps_vanish() {
    let model = example::Bike::default();
    let picture = model.picture().unwrap();
    let q = [0.7, 0.4, 0.3];
    let mut x = q.to_vec();
    x.resize(model.declaration().inputs(), 0.0);
    // The time stands behind states and controls in every scene.
    let mut at = x.clone();
    at.push(0.0);
    let drawn = |along: f64| {
        let mut values = vec![0.0; picture.values()];
        model.picture_values(&at, along, &mut values);
        values
    };
    assert_eq!(picture.shapes[3], Shape::Curve("track"));
    for contact in 0..2 {
        // Place and angle of two points, both ends of the link, a place on the track.
        let [y, z] = [0, 1].map(|axis| drawn(0.0)[3 * contact + axis]);
        let [along, ground] = [10, 11].map(|place| drawn(y)[place]);
        assert_eq!(along, y);
        assert!((model.gap(contact, &x) - (z - ground)).abs() < 1e-15);
    }
}
