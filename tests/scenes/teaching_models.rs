//! The teaching models in `examples/`, each against its closed form.

use hangtime::model::Model;
use hangtime::simulation::{
    Event, EventDriven, EventKind, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/block_on_incline.rs"]
pub(crate) mod block_on_incline;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/bouncing_ball.rs"]
pub(crate) mod bouncing_ball;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/double_pendulum_with_stop.rs"]
pub(crate) mod double_pendulum_with_stop;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/elastic_ball_in_box.rs"]
pub(crate) mod elastic_ball_in_box;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/pendulum_against_wall.rs"]
pub(crate) mod pendulum_against_wall;

/// Kinetic and potential energy together, without controls.
fn energy(model: &dyn Model, q: &[f64], v: &[f64]) -> f64 {
    let mut parts = [0.0; 2];
    model.energy(&[q, v].concat(), &mut parts);
    parts.iter().sum()
}

fn impacts(simulation: &Simulation) -> impl DoubleEndedIterator<Item = &Event> {
    let events = simulation.events.iter();
    events.filter(|event| event.kind == EventKind::Impact)
}

#[test]
fn bouncing_ball_times_follow_the_geometric_series() {
    let model = bouncing_ball::BouncingBall::default();
    let simulation = hangtime::simulate(&model)
        .method(EventDriven::default())
        .run()
        .unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);

    let fall = (2.0 * model.height / model.g).sqrt();
    let mut expected = fall;
    let mut flight = 2.0 * fall;
    for (bounce, event) in impacts(&simulation).enumerate() {
        flight *= model.e;
        // Each time is found to rounding error; the errors of a cascade add up.
        let error = (event.time - expected).abs();
        assert!(error < 1e-12, "bounce {bounce}: {error:e}");
        expected += flight;
    }
    // The flights that the cut-off leaves out are a geometric series as well.
    let last = impacts(&simulation).next_back().unwrap();
    let speed = -last.v_before[0];
    let rest = fall * (1.0 + model.e) / (1.0 - model.e);
    let left_out = 2.0 * model.e * speed / (model.g * (1.0 - model.e));
    assert!((last.time + left_out - rest).abs() < 1e-11);
    assert!(left_out > 0.0 && left_out < 1e-3, "{left_out:e}");
    assert_eq!(simulation.notes.len(), 1);
    assert_eq!(simulation.trajectory.v.last().unwrap(), &[0.0]);
}

#[test]
fn block_stops_where_friction_has_taken_its_energy_and_stays() {
    let model = block_on_incline::BlockOnIncline::default();
    let simulation = hangtime::simulate(&model).run().unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);

    let slope = model.incline.to_radians();
    let deceleration = model.g * (model.mu * slope.cos() - slope.sin());
    let (time, distance) = (
        model.speed / deceleration,
        model.speed.powi(2) / (2.0 * deceleration),
    );
    let [stick] = simulation.events.as_slice() else {
        panic!("one event: {:?}", simulation.events)
    };
    assert_eq!(stick.kind, EventKind::Stick);
    // Collocation reproduces constant acceleration; what remains is the tolerance of the switch.
    assert!((stick.time - time).abs() < 1e-10, "{}", stick.time);
    assert!((stick.q[0] - distance * slope.cos()).abs() < 1e-10);
    assert!((stick.q[1] + distance * slope.sin()).abs() < 1e-10);

    let trajectory = &simulation.trajectory;
    let weight = model.m * model.g;
    for (k, &time) in trajectory.time.iter().enumerate() {
        assert!((trajectory.contact_force[k][0] - weight * slope.cos()).abs() < 1e-9);
        let friction = trajectory.friction_force[k][0].abs();
        let expected = if time < stick.time {
            model.mu * weight * slope.cos()
        } else if time > stick.time {
            weight * slope.sin()
        } else {
            continue; // both sides of the switch are listed
        };
        assert!((friction - expected).abs() < 1e-8, "{time} s: {friction} N");
    }
    assert_eq!(trajectory.q.last().unwrap().len(), 2);
    let moved = (trajectory.q.last().unwrap()[0] - stick.q[0]).abs();
    assert!(moved < 1e-12, "{moved:e}");
}

/// Quarter period of a mathematical pendulum in units of `sqrt(l / g)`: the complete elliptic integral
/// `K(sin(amplitude / 2))`, by the arithmetic-geometric mean.
fn quarter_period(amplitude: f64) -> f64 {
    let (mut a, mut b) = (1.0, (amplitude / 2.0).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

#[test]
fn pendulum_strikes_the_wall_after_quarter_periods_of_shrinking_swings() {
    let model = pendulum_against_wall::PendulumAgainstWall::default();
    let simulation = hangtime::simulate(&model).run().unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);

    // The wall is at the lowest point: a swing of amplitude A strikes with
    // (l phi')^2 = 2 g l (1 - cos A), and leaves with e times that.
    let unit = (model.l / model.g).sqrt();
    let mut amplitude = model.release.to_radians();
    let mut time = unit * quarter_period(amplitude);
    assert!(impacts(&simulation).count() >= 3);
    for event in impacts(&simulation) {
        // Default steps, order 5: errors of the swing far below this.
        assert!((event.time - time).abs() < 1e-6, "{} {time}", event.time);
        let speed = (2.0 * (1.0 - amplitude.cos())).sqrt() / unit;
        assert!((event.v_before[0] + speed).abs() < 1e-6);
        assert!((event.v_after[0] + model.e * event.v_before[0]).abs() < 1e-12);
        amplitude = (1.0 - model.e.powi(2) * (1.0 - amplitude.cos())).acos();
        time += 2.0 * unit * quarter_period(amplitude);
    }
}

#[test]
fn knee_stop_is_an_inner_impact_that_keeps_the_angular_momentum() {
    let model = double_pendulum_with_stop::Knee::default();
    let simulation = hangtime::simulate(&model).run().unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(impacts(&simulation).count() >= 1);

    // The stop acts between the links, so the sum of the generalized momenta, which is the angular
    // momentum about the pivot, passes the impact unchanged; the links move on as one.
    for event in impacts(&simulation) {
        let momentum = |v: &[f64]| {
            let mut mass = [0.0; 4];
            model.mass_matrix(&[&event.q, v].concat(), &mut mass);
            (mass[0] + mass[2]) * v[0] + (mass[1] + mass[3]) * v[1]
        };
        let change = momentum(&event.v_after) - momentum(&event.v_before);
        assert!(change.abs() < 1e-12, "{change:e}");
        assert!((event.v_after[0] - event.v_after[1]).abs() < 1e-12);
        let (before, after) = (
            energy(&model, &event.q, &event.v_before),
            energy(&model, &event.q, &event.v_after),
        );
        assert!(after < before);
    }

    // An independent method finds the same motion.
    let problem = InitialValueProblem::of(&model, None).unwrap();
    let reference = EventDriven {
        tolerance: 1e-12,
        ..EventDriven::default()
    };
    let reference = reference.simulate(&model, &problem, &mut |_| true).unwrap();
    assert_eq!(reference.events.len(), simulation.events.len());
    for (found, expected) in simulation.events.iter().zip(&reference.events) {
        assert_eq!(found.kind, expected.kind);
        assert!((found.time - expected.time).abs() < 1e-6);
    }
}

/// Position at which a point with coordinate `x` in an endless row of mirrored boxes is in the first.
fn folded(x: f64, width: f64) -> f64 {
    let x = x.rem_euclid(2.0 * width);
    x.min(2.0 * width - x)
}

#[test]
fn ball_in_a_box_follows_the_unfolded_straight_line_and_keeps_its_energy() {
    let model = elastic_ball_in_box::ElasticBallInBox::default();
    let simulation = hangtime::simulate(&model)
        .method(EventDriven::default())
        .run()
        .unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(impacts(&simulation).count() > 70);

    // Height: a parabola between impacts on the floor, periodic; the ball stays below the ceiling.
    let (z_0, g, v) = (model.height / 2.0, model.g, model.speed);
    let strike = (v * v + 2.0 * g * z_0).sqrt();
    let (first, period) = ((v + strike) / g, 2.0 * strike / g);
    let trajectory = &simulation.trajectory;
    for (k, &time) in trajectory.time.iter().enumerate() {
        let x = folded(model.width / 4.0 + v * time, model.width);
        let since = (time - first).rem_euclid(period);
        let z = strike * since - 0.5 * g * since * since;
        // Exact motions, located impacts: rounding errors of some seventy impacts add up, and z
        // loses some at the instants of impact.
        assert!((trajectory.q[k][0] - x).abs() < 1e-9, "{time}");
        assert!((trajectory.q[k][1] - z).abs() < 1e-9, "{time}");
        let change = energy(&model, &trajectory.q[k], &trajectory.v[k])
            - energy(&model, &trajectory.q[0], &trajectory.v[0]);
        assert!(change.abs() < 1e-10, "{change:e}");
    }
}
