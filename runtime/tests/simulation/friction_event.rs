//! Coulomb friction in the event-driven simulator, against closed forms.

use crate::common::assembled::Assembled;
use crate::common::event::{accurate, run, sequence};
use crate::common::gold;
use crate::common::laws::{Bowl, CrankBrake, Disc, Ground};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, energies, index_at, last, start};
use hangtime::simulation::{
    ControlSignal, EventDriven, EventKind, InitialValueProblem, SimulationStatus,
};

#[test]
fn block_on_an_incline_stops_and_stays_as_certified() {
    for gold in &gold::BLOCKS {
        for (mass, scale) in [(1.0, 1.0), (10.0, 1.0), (2.0, 2.0)] {
            let slope = gold.slope_degrees.to_radians();
            let (sin, cos) = slope.sin_cos();
            let model = Ground {
                mass,
                slope,
                scale,
                mu: gold.mu,
                ..Ground::default()
            };
            let problem = start(&[0.0; 2], &[gold.speed * cos, -gold.speed * sin], 3.0);
            let simulator = EventDriven {
                output_times: 6,
                ..accurate()
            };
            let simulation = run(&simulator, &model, &problem);
            assert_eq!(simulation.status, SimulationStatus::Solved);
            assert_eq!(sequence(&simulation), [(EventKind::Stick, 0)]);
            let event = &simulation.events[0];
            // Parabolas of some metres: rounding error.
            assert!((event.time - gold.stop.0).abs() < 1e-14);
            assert!(distance(&event.q, &gold.stop_position) < 1e-14);
            let trajectory = &simulation.trajectory;
            for (time, way, speed) in gold.states {
                let k = index_at(trajectory, time);
                assert!((trajectory.time[k] - time).abs() < 1e-15);
                assert!(distance(&trajectory.q[k], &[way * cos, -way * sin]) < 1e-14);
                assert!(distance(&trajectory.v[k], &[speed * cos, -speed * sin]) < 1e-14);
                let force = if time < gold.stop.0 {
                    gold.force.0
                } else {
                    gold.force.1
                };
                // The gap is `scale` times a length, so that a unit of its force is `scale` newtons.
                let found = trajectory.friction_force[k][0] * scale / mass;
                assert!((found - force).abs() < 1e-13, "{found} {force}");
                let normal = trajectory.contact_force[k][0] * scale / mass;
                assert!((normal - GRAVITY * cos).abs() < 1e-13);
            }
            let energies = energies(&model, &simulation);
            let lost = (energies[0] - energies[energies.len() - 1]) / mass;
            assert!((lost - gold.dissipated).abs() < 1e-13);
            assert!(simulation.residuals.primal < 1e-14);
            assert!(simulation.residuals.dual < 1e-14);
        }
    }
}

#[test]
fn block_on_a_steep_incline_turns_round_and_slides_back() {
    let (slope, mu) = (0.6_f64, 0.4);
    let (sin, cos) = slope.sin_cos();
    let model = Ground {
        slope,
        mu,
        ..Ground::default()
    };
    // Up the slope with 3 m/s: tan 0.6 = 0.68 > mu.
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0; 2], &[-3.0 * cos, 3.0 * sin], 2.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(sequence(&simulation), [(EventKind::Slip, 0)]);
    let up = GRAVITY * (sin + mu * cos);
    let down = GRAVITY * (sin - mu * cos);
    let time = 3.0 / up;
    assert!((simulation.events[0].time - time).abs() < 1e-14);
    let speed = down * (2.0 - time);
    let way = speed * (2.0 - time) / 2.0 - 9.0 / (2.0 * up);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[way * cos, -way * sin]) < 1e-13);
    assert!(distance(v, &[speed * cos, -speed * sin]) < 1e-13);
}

#[test]
fn friction_of_zero_is_no_friction() {
    let with = |friction| {
        let model = Ground {
            height: 0.3,
            number: 2.0,
            mu: friction,
            ..Ground::default()
        };
        run(
            &EventDriven::default(),
            &model,
            &start(&[0.0, 0.8], &[1.0, 0.0], 2.0),
        )
    };
    let zero = with(0.0);
    assert!(
        zero.trajectory
            .friction_force
            .iter()
            .all(|force| force == &[0.0])
    );
    assert_eq!(
        zero.trajectory.friction_force.len(),
        zero.trajectory.time.len()
    );
    // A coefficient of rounding error changes nothing but rounding error.
    let least = with(1e-300);
    assert_eq!(zero.trajectory.time.len(), least.trajectory.time.len());
    for (a, b) in zero.trajectory.q.iter().zip(&least.trajectory.q) {
        assert!(distance(a, b) < 1e-12);
    }
    assert_eq!(sequence(&zero), sequence(&least));
}

#[test]
fn block_at_the_angle_of_friction_rests_or_keeps_its_speed() {
    let slope = 0.5_f64;
    let model = Ground {
        slope,
        mu: slope.tan(),
        ..Ground::default()
    };
    for speed in [0.0, 1.0] {
        let v = [speed * slope.cos(), -speed * slope.sin()];
        let simulation = run(&accurate(), &model, &start(&[0.0; 2], &v, 5.0));
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert!(simulation.events.is_empty(), "{:?}", simulation.events);
        // The forces balance to rounding error, which acts for 5 s.
        assert!(distance(last(&simulation.trajectory).1, &v) < 1e-13);
    }
}

#[test]
fn block_in_a_bowl_slides_turns_and_stops_as_in_the_closed_form() {
    // In a round bowl at the angle a from its bottom, with w = a'^2 and radius 1, sliding to growing a:
    // w' = -2 mu w - 2 g (sin a + mu cos a), linear in w.
    let mu = 0.08;
    let model = Bowl {
        mu,
        ..Bowl::default()
    };
    let after = |w: f64, from: f64, to: f64, sign: f64| {
        // Sliding to falling a is the mirror image.
        let (from, to) = (sign * from, sign * to);
        let particular = |a: f64| {
            2.0 * GRAVITY * ((1.0 - 2.0 * mu * mu) * a.cos() - 3.0 * mu * a.sin())
                / (1.0 + 4.0 * mu * mu)
        };
        (w - particular(from)) * (-2.0 * mu * (to - from)).exp() + particular(to)
    };
    let (from, speed): (f64, f64) = (-1.2, 1.0);
    let problem = start(
        &[from.sin(), -from.cos()],
        &[speed * from.cos(), speed * from.sin()],
        12.0,
    );
    let simulation = run(&accurate(), &model, &problem);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let (mut angle, mut w, mut sign) = (from, speed * speed, 1.0);
    for (k, event) in simulation.events.iter().enumerate() {
        // The next turn, by bisection of w > 0.
        let (mut low, mut high) = (angle + sign * 1e-3, sign * 1.5);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if after(w, angle, middle, sign) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        (angle, w) = (low, 0.0);
        // Some hundred steps of error 1e-13.
        assert!(
            distance(&event.q, &[angle.sin(), -angle.cos()]) < 1e-11,
            "{k}"
        );
        let stops = angle.tan().abs() < mu;
        assert_eq!(
            event.kind,
            if stops {
                EventKind::Stick
            } else {
                EventKind::Slip
            }
        );
        assert_eq!(stops, k + 1 == simulation.events.len());
        sign = -sign;
    }
    assert!(simulation.events.len() >= 5);
    // At rest the ground carries the weight along the slope.
    let force = simulation.trajectory.friction_force.last().unwrap()[0];
    assert!((force - GRAVITY * angle.sin()).abs() < 1e-10);
    assert!(simulation.residuals.primal < 1e-13);
}

#[test]
fn control_jumps_make_a_sticking_block_slip_and_stop() {
    // mu g = 4.905: held below that, pushed with 7 from 0.5 s to 1 s, then braked.
    let mu = 0.5;
    let model = Ground {
        mu,
        ..Ground::default()
    };
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.25, 0.5, 1.0],
            values: vec![vec![3.0], vec![-4.9], vec![7.0], vec![1.0]],
        },
        ..start(&[0.0; 2], &[0.0; 2], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(
        sequence(&simulation),
        [(EventKind::Slip, 0), (EventKind::Stick, 0)]
    );
    assert_eq!(simulation.events[0].time, 0.5);
    let speed = 0.5 * (7.0 - mu * GRAVITY);
    let brake = mu * GRAVITY - 1.0;
    let time = 1.0 + speed / brake;
    assert!((simulation.events[1].time - time).abs() < 1e-14);
    let (q, v) = last(&simulation.trajectory);
    let way = 0.25 * speed + speed * speed / (2.0 * brake);
    assert!((q[0] - way).abs() < 1e-14);
    assert_eq!(v, [0.0, 0.0]);
    // Friction balances the control while the block sticks.
    let trajectory = &simulation.trajectory;
    for (time, force) in [(0.1, -3.0), (0.3, 4.9), (0.7, -mu * GRAVITY), (1.9, -1.0)] {
        let k = trajectory.time.partition_point(|&t| t <= time) - 1;
        assert!(
            (trajectory.friction_force[k][0] - force).abs() < 1e-13,
            "{time}"
        );
    }
}

#[test]
fn oscillator_with_dry_friction_loses_the_same_at_every_turn() {
    // y'' = -w^2 y -+ mu g: half swings of the time pi / w about +- mu g / w^2.
    let (stiffness, mu) = (25.0_f64, 0.2);
    let model = Ground {
        stiffness,
        mu,
        ..Ground::default()
    };
    let simulation = run(&accurate(), &model, &start(&[1.0, 0.0], &[0.0; 2], 6.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let centre = mu * GRAVITY / stiffness;
    let mut amplitude: f64 = 1.0;
    let mut turns = 0;
    while amplitude > centre {
        amplitude -= 2.0 * centre;
        turns += 1;
        let event = &simulation.events[turns - 1];
        let side = if turns % 2 == 1 { -1.0 } else { 1.0 };
        let time = std::f64::consts::PI / stiffness.sqrt() * turns as f64;
        // Errors of 1e-13 per step at a frequency of 5 / s.
        assert!((event.time - time).abs() < 1e-12, "{turns}");
        assert!((event.q[0] - side * amplitude).abs() < 1e-12, "{turns}");
        let kind = if amplitude.abs() > centre {
            EventKind::Slip
        } else {
            EventKind::Stick
        };
        assert_eq!(event.kind, kind);
    }
    assert_eq!(simulation.events.len(), turns);
    assert!(turns > 5);
    let force = simulation.trajectory.friction_force.last().unwrap()[0];
    let (q, v) = last(&simulation.trajectory);
    assert!((force - stiffness * q[0]).abs() < 1e-12);
    assert_eq!(v[0], 0.0);
}

#[test]
fn mass_on_a_belt_sticks_and_slips_as_in_the_closed_form() {
    // Slides about y* = mu g / w^2 with the amplitude a until its speed is the belt's, at
    // y* - sqrt(a^2 - V^2 / w^2); sticks to y*; slips again without a jump of the force.
    let (stiffness, mu, belt) = (16.0_f64, 0.4, 0.5);
    let omega = stiffness.sqrt();
    let rest = mu * GRAVITY / stiffness;
    let model = Assembled::on_belt(
        &Ground {
            stiffness,
            mu,
            ..Ground::default()
        },
        belt,
    );
    let amplitude = 0.3;
    let simulation = run(
        &accurate(),
        &model,
        &start(&[rest - amplitude, 0.0], &[0.0; 2], 1.4),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(
        sequence(&simulation),
        [(EventKind::Stick, 0), (EventKind::Slip, 0)]
    );
    let angle = (belt / (amplitude * omega)).asin();
    let (caught, way) = (angle / omega, amplitude * angle.cos());
    assert!((simulation.events[0].time - caught).abs() < 1e-13);
    assert!((simulation.events[0].q[0] - (rest - way)).abs() < 1e-13);
    let slips = caught + way / belt;
    assert!((simulation.events[1].time - slips).abs() < 1e-12);
    assert!((simulation.events[1].q[0] - rest).abs() < 1e-12);
    let time = 1.4 - slips;
    assert!(time > 0.5);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[0] - rest - belt / omega * (omega * time).sin()).abs() < 1e-12);
    assert!((v[0] - belt * (omega * time).cos()).abs() < 1e-12);
    // A period later sliding velocity and force reserve vanish together: the mass passes or sticks for
    // nothing, and its motion stays the swing with the belt's speed.
    let simulation = run(
        &accurate(),
        &model,
        &start(&[rest - amplitude, 0.0], &[0.0; 2], 12.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let time = 12.0 - slips;
    let (q, _) = last(&simulation.trajectory);
    // At such an instant rounding error decides when it slips, and 1e-8 s are 1e-16 m.
    assert!((q[0] - rest - belt / omega * (omega * time).sin()).abs() < 1e-6);
}

#[test]
fn spinning_disc_slips_or_rolls_after_its_impact() {
    // s = -v_t / (1 + 1/c) would roll; p = (1 + e) |v_n| allows mu p.
    let (radius, shape, mu) = (0.3, 0.5, 0.2);
    for (e, spin, rolls) in [
        (0.0, 3.0, true),
        (0.0, 60.0, false),
        (0.6, 3.0, true),
        (0.6, -60.0, false),
    ] {
        let model = Disc {
            radius,
            shape,
            slope: 0.0,
            e,
            mu,
            ..Disc::default()
        };
        let problem = start(&[0.0, radius, 0.0], &[0.1, -2.0, spin], 0.1);
        let simulation = run(&accurate(), &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let event = &simulation.events[0];
        assert_eq!((event.kind, event.time), (EventKind::Impact, 0.0));
        let sliding = 0.1 + radius * spin;
        let (p, gain): (f64, f64) = ((1.0 + e) * 2.0, 1.0 + 1.0 / shape);
        let s = -(sliding / gain).clamp(-mu * p, mu * p);
        assert_eq!((sliding / gain).abs() < mu * p, rolls);
        let expected = [0.1 + s, 2.0 * e, spin + s / (shape * radius)];
        assert!(distance(&event.v_after, &expected) < 1e-13);
        if rolls {
            let (q, v) = (&event.q, &event.v_after);
            assert_eq!(q.len(), 3);
            assert!((v[0] + radius * v[2]).abs() < 1e-14);
        }
    }
}

#[test]
fn sliding_disc_begins_to_roll_at_the_time_of_the_closed_form() {
    // v = v0 - mu g t, and the sliding velocity falls at mu g (1 + 1/c).
    let (radius, shape, mu) = (0.3, 0.4, 0.2);
    let model = Disc {
        radius,
        shape,
        slope: 0.0,
        e: 0.7,
        mu,
        ..Disc::default()
    };
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, radius, 0.0], &[3.0, 0.0, 0.0], 2.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert_eq!(sequence(&simulation), [(EventKind::Stick, 0)]);
    let time = 3.0 / (mu * GRAVITY * (1.0 + 1.0 / shape));
    assert!((simulation.events[0].time - time).abs() < 1e-14);
    let speed = 3.0 / (1.0 + shape);
    let (_, v) = last(&simulation.trajectory);
    assert!(distance(v, &[speed, 0.0, -speed / radius]) < 1e-13);
    let force = simulation.trajectory.friction_force.last().unwrap()[0];
    assert!(force.abs() < 1e-13);
}

#[test]
fn disc_on_an_incline_rolls_or_slips_by_the_angle() {
    let (radius, shape, mu) = (0.25, 0.5, 0.3);
    // It slips where tan slope > mu (1 + 1/c) = 0.9.
    for slope in [0.5_f64, 0.9] {
        let (sin, cos) = slope.sin_cos();
        let model = Disc {
            radius,
            shape,
            slope,
            mu,
            ..Disc::default()
        };
        let rolls = slope.tan() < mu * (1.0 + 1.0 / shape);
        let problem = start(&[0.0, radius / cos, 0.0], &[0.0; 3], 1.0);
        let simulation = run(&accurate(), &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert!(simulation.events.is_empty());
        let (acceleration, turning) = if rolls {
            let a = GRAVITY * sin / (1.0 + shape);
            (a, -a / radius)
        } else {
            (
                GRAVITY * (sin - mu * cos),
                -mu * GRAVITY * cos / (shape * radius),
            )
        };
        let (_, v) = last(&simulation.trajectory);
        assert!(distance(v, &[acceleration * cos, -acceleration * sin, turning]) < 1e-12);
    }
}

#[test]
fn brake_turns_round_at_the_dead_points_of_its_crank() {
    // The brake's velocity vanishes with its lever arm: friction cannot hold it, and turns round with it.
    let mu = 0.1;
    let model = CrankBrake {
        mu,
        ..CrankBrake::default()
    };
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[4.0, 0.0], 10.0));
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // v^2 = 16 - 2 mu g int |cos y| dy: 1 to the first dead point, 2 from each to the next.
    let (stop, turns) = simulation.events.split_last().unwrap();
    for (k, event) in turns.iter().enumerate() {
        let (y, v) = (event.q[0], event.v_after[0]);
        assert_eq!(event.kind, EventKind::Slip);
        assert!((y - (k as f64 + 0.5) * std::f64::consts::PI).abs() < 1e-11);
        let lost = 2.0 * mu * GRAVITY * (2.0 * k as f64 + 1.0);
        assert!((v * v - (16.0 - lost)).abs() < 1e-11);
    }
    let way = 16.0 / (2.0 * mu * GRAVITY);
    assert_eq!(turns.len() as f64, ((way + 1.0) / 2.0).floor());
    assert_eq!(stop.kind, EventKind::Stick);
    // In the last half turn |sin| goes from -1 to what is left.
    let left = way - (2.0 * turns.len() as f64 - 1.0) - 1.0;
    assert!(
        (stop.q[0].sin().abs() - left.abs()).abs() < 1e-10,
        "{stop:?} {left}"
    );
}
