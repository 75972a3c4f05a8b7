//! The example that README walks through, against its closed form.

use hangtime::simulation::{EventKind, SimulationStatus};

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/ball_on_slope.rs"]
pub(crate) mod example;

#[test]
fn ball_on_slope_lands_slides_and_stops_where_the_closed_form_says() {
    let (g, tilt, wall) = (9.81_f64, 0.4_f64, 3.0_f64);
    let model = example::BallOnSlope {
        g,
        tilt,
        wall_x: wall,
        ..example::BallOnSlope::default()
    };
    let simulation = hangtime::simulate(&model).run().unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);

    // Free fall over 1 m; the impact leaves the velocity along the slope (1, -tilt); then the ball
    // slides with constant acceleration to the wall and stops in the corner.
    let landing = (2.0 / g).sqrt();
    let share = tilt / (1.0 + tilt * tilt);
    let (speed, acceleration) = (share * g * landing, share * g);
    let sliding = ((speed * speed + 2.0 * acceleration * wall).sqrt() - speed) / acceleration;
    let impact = |contact: usize| {
        simulation
            .events
            .iter()
            .find(|event| event.kind == EventKind::Impact && event.contact == contact)
            .unwrap()
    };
    let (first, second) = (impact(0), impact(1));
    // All motion is of constant acceleration, which collocation reproduces exactly; what remains is
    // the tolerance of the switch times.
    let close = |found: f64, expected: f64| (found - expected).abs() < 1e-10;
    assert!(close(first.time, landing), "{first:?}");
    assert!(close(first.v_after[0], speed), "{first:?}");
    assert!(close(second.time, landing + sliding), "{second:?}");
    assert!(close(second.q[0], wall), "{second:?}");

    let trajectory = &simulation.trajectory;
    let (q, v) = (trajectory.q.last().unwrap(), trajectory.v.last().unwrap());
    assert!(close(q[0], wall) && close(q[1], -tilt * wall), "{q:?}");
    assert!(close(v[0], 0.0) && close(v[1], 0.0), "{v:?}");
}
