//! Coulomb friction against closed forms, by every simulator that locates events.

use crate::common::assembled::Assembled;
use crate::common::event::sequence;
use crate::common::gold;
use crate::common::laws::{Bowl, CrankBrake, Disc, Ground, Pulled};
use crate::common::located::motions;
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, energies, last, root, start};
use hangtime::baselines::Moreau;
use hangtime::simulation::{ControlSignal, EventKind, InitialValueProblem, Simulator, Trajectory};
use std::f64::consts::PI;

/// Friction force of the first contact at the end.
fn last_friction(trajectory: &Trajectory) -> f64 {
    trajectory
        .friction_force
        .last()
        .expect("a trajectory has a start")[0]
}

fn jumps(times: &[f64], values: &[f64]) -> ControlSignal {
    ControlSignal::PiecewiseConstant {
        times: times.to_vec(),
        values: values.iter().map(|&value| vec![value]).collect(),
    }
}

/// Largest differences to the closed form at all instants of a block: of the state, and of both forces per mass `from` a time on.
fn block_errors(
    gold: &gold::BlockGold,
    mass: f64,
    scale: f64,
    (trajectory, from): (&Trajectory, f64),
) -> [f64; 2] {
    let (sin, cos) = gold.slope_degrees.to_radians().sin_cos();
    let acceleration = GRAVITY * sin + gold.force.0;
    let mut errors = [0.0_f64; 2];
    for k in 0..trajectory.time.len() {
        let time = trajectory.time[k];
        let slides = time.min(gold.stop.0);
        let speed = gold.speed + acceleration * slides;
        let way = (gold.speed + 0.5 * acceleration * slides) * slides;
        let state = distance(&trajectory.q[k], &[way * cos, -way * sin])
            .max(distance(&trajectory.v[k], &[speed * cos, -speed * sin]));
        errors[0] = errors[0].max(state);
        // At the stop itself both forces are right.
        if time >= from && (time - gold.stop.0).abs() > 1e-2 {
            let stuck = time > gold.stop.0;
            let force = if stuck { gold.force.1 } else { gold.force.0 };
            // The gap is `scale` times a length, so that a unit of its force is `scale` newtons.
            let found = trajectory.friction_force[k][0] * scale / mass;
            let normal = trajectory.contact_force[k][0] * scale / mass;
            let difference = (found - force).abs().max((normal - GRAVITY * cos).abs());
            errors[1] = errors[1].max(difference);
        }
    }
    errors
}

/// Time stepping: the midpoint rule is exact along the slope, but rounding may leave the contact open in the
/// first step of 1 ms: 5e-3 m/s without friction, over some 1.5 s, and the stop 1 ms late.
fn stops_by_time_steps(gold: &gold::BlockGold, model: &Ground, problem: &InitialValueProblem) {
    let moreau = Moreau {
        steps: 3000,
        ..Moreau::default()
    };
    let simulation = moreau.simulate(model, problem, &mut |_| true);
    let simulation = simulation.expect("the problem is accepted");
    let trajectory = &simulation.trajectory;
    let [state, force] = block_errors(gold, model.mass, 1.0, (trajectory, 1e-2));
    assert!(state < 2e-2 && force < 1e-9, "{state:e} {force:e}");
    assert!(distance(last(trajectory).1, &[0.0; 2]) < 1e-14);
}

#[test]
fn block_on_an_incline_stops_and_stays_as_certified() {
    for gold in &gold::BLOCKS {
        let slope = gold.slope_degrees.to_radians();
        let (sin, cos) = slope.sin_cos();
        for (mass, scale) in [(1.0, 1.0), (10.0, 1.0), (2.0, 2.0), (3.0, 2.0)] {
            let model = Ground {
                mass,
                slope,
                scale,
                mu: gold.mu,
                ..Ground::default()
            };
            let v = [gold.speed * cos, -gold.speed * sin];
            let problem = start(&[0.0; 2], &v, 3.0);
            for (name, simulation) in motions(&model, &problem) {
                assert_eq!(sequence(&simulation), [(EventKind::Stick, 0)], "{name}");
                let event = &simulation.events[0];
                // Parabolas of some metres: rounding error.
                assert!((event.time - gold.stop.0).abs() < 2e-14, "{name}");
                assert!(distance(&event.q, &gold.stop_position) < 2e-14, "{name}");
                let [state, force] = block_errors(gold, mass, scale, (&simulation.trajectory, 0.0));
                assert!(
                    state < 2e-14 && force < 1e-12,
                    "{name}: {state:e} {force:e}"
                );
                let energies = energies(&model, &simulation);
                let lost = (energies[0] - energies[energies.len() - 1]) / mass;
                assert!((lost - gold.dissipated).abs() < 1e-13, "{name}");
                // Rounding of places of some metres, divided by the shares of an element, and of forces as large as the mass.
                let (residuals, rounding) = (&simulation.residuals, 1e-12 * mass);
                let small = residuals.primal < rounding && residuals.dual < rounding;
                assert!(small, "{name}: {residuals:?}");
            }
            if scale == 1.0 {
                stops_by_time_steps(gold, &model, &problem);
            }
        }
        for (time, way, speed) in gold.states {
            let mut exact = Trajectory::default();
            exact.time = vec![time];
            exact.q = vec![vec![way * cos, -way * sin]];
            exact.v = vec![vec![speed * cos, -speed * sin]];
            let stuck = time > gold.stop.0;
            let force = if stuck { gold.force.1 } else { gold.force.0 };
            exact.friction_force = vec![vec![force]];
            exact.contact_force = vec![vec![GRAVITY * cos]];
            let [state, force] = block_errors(gold, 1.0, 1.0, (&exact, 0.0));
            assert!(state < 1e-14 && force < 1e-14, "{time}");
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
    let problem = start(&[0.0; 2], &[-3.0 * cos, 3.0 * sin], 2.0);
    let up = GRAVITY * (sin + mu * cos);
    let down = GRAVITY * (sin - mu * cos);
    let time = 3.0 / up;
    let speed = down * (2.0 - time);
    let way = speed * (2.0 - time) / 2.0 - 9.0 / (2.0 * up);
    for (name, simulation) in motions(&model, &problem) {
        assert_eq!(sequence(&simulation), [(EventKind::Slip, 0)], "{name}");
        assert!((simulation.events[0].time - time).abs() < 2e-14, "{name}");
        let (q, v) = last(&simulation.trajectory);
        assert!(distance(q, &[way * cos, -way * sin]) < 1e-13, "{name}");
        assert!(distance(v, &[speed * cos, -speed * sin]) < 1e-13, "{name}");
    }
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
        motions(&model, &start(&[0.0, 0.8], &[1.0, 0.0], 2.0))
    };
    // A coefficient of rounding error changes nothing but rounding error.
    for ((name, zero), (_, least)) in with(0.0).iter().zip(&with(1e-300)) {
        let trajectory = &zero.trajectory;
        assert!(
            trajectory
                .friction_force
                .iter()
                .all(|force| force == &[0.0]),
            "{name}"
        );
        assert_eq!(
            trajectory.friction_force.len(),
            trajectory.time.len(),
            "{name}"
        );
        assert_eq!(trajectory.time.len(), least.trajectory.time.len(), "{name}");
        for (a, b) in trajectory.q.iter().zip(&least.trajectory.q) {
            assert!(distance(a, b) < 1e-12, "{name}");
        }
        assert_eq!(sequence(zero), sequence(least), "{name}");
    }
    for (name, simulation) in motions(&scenes::ball(), &start(&[0.0, 1.0], &[1.0, 0.0], 1.0)) {
        assert!(simulation.trajectory.friction_force.is_empty(), "{name}");
    }
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
        for (name, simulation) in motions(&model, &start(&[0.0; 2], &v, 5.0)) {
            assert!(
                simulation.events.is_empty(),
                "{name}: {:?}",
                simulation.events
            );
            // The forces balance to rounding error, which acts for 5 s.
            assert!(
                distance(last(&simulation.trajectory).1, &v) < 1e-13,
                "{name}"
            );
        }
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
    for (name, simulation) in motions(&model, &problem) {
        let (mut angle, mut w, mut sign) = (from, speed * speed, 1.0);
        for (k, event) in simulation.events.iter().enumerate() {
            // The next turn is where w falls to zero.
            let first = angle + sign * 1e-3;
            angle = root(|a| after(w, angle, a, sign), first, sign * 1.5);
            w = 0.0;
            // Some hundred steps of error 1e-13.
            let place = [angle.sin(), -angle.cos()];
            assert!(distance(&event.q, &place) < 1e-11, "{name} {k}");
            let stops = angle.tan().abs() < mu;
            let kind = if stops {
                EventKind::Stick
            } else {
                EventKind::Slip
            };
            assert_eq!(event.kind, kind, "{name} {k}");
            assert_eq!(stops, k + 1 == simulation.events.len(), "{name} {k}");
            sign = -sign;
        }
        assert!(simulation.events.len() >= 5, "{name}");
        // At rest the ground carries the weight along the slope.
        let force = last_friction(&simulation.trajectory);
        assert!((force - GRAVITY * angle.sin()).abs() < 1e-10, "{name}");
        let primal = simulation.residuals.primal;
        // Between the stages an element is of a lower order than at its end.
        assert!(primal < 1e-11, "{name}: {primal:e}");
    }
}

#[test]
fn control_jumps_decide_between_sticking_and_slipping() {
    // mu g = 4.905: held below that, pushed with 7 from 0.5 s to 1 s, braked, and pulled back with 5.5 from 2 s on.
    let (mu, bound) = (0.5, 0.5 * GRAVITY);
    let model = Ground {
        mu,
        ..Ground::default()
    };
    let problem = InitialValueProblem {
        controls: jumps(&[0.0, 0.25, 0.5, 1.0, 2.0], &[3.0, -4.9, 7.0, 1.0, -5.5]),
        ..start(&[0.0; 2], &[0.0; 2], 2.5)
    };
    let speed = 0.5 * (7.0 - bound);
    let brake = bound - 1.0;
    let stop = 1.0 + speed / brake;
    let back = (5.5 - bound) * 0.5;
    let way = 0.25 * speed + speed * speed / (2.0 * brake) - 0.25 * back;
    let events = [
        (0.5, EventKind::Slip),
        (stop, EventKind::Stick),
        (2.0, EventKind::Slip),
    ];
    for (name, simulation) in motions(&model, &problem) {
        assert_eq!(simulation.events.len(), events.len(), "{name}");
        for (event, (time, kind)) in simulation.events.iter().zip(events) {
            assert_eq!(event.kind, kind, "{name}");
            assert!((event.time - time).abs() < 1e-14, "{name}");
        }
        let (q, v) = last(&simulation.trajectory);
        assert!(
            (q[0] - way).abs() < 1e-14 && (v[0] + back).abs() < 1e-14,
            "{name}"
        );
        // Friction balances the control while the block sticks.
        let trajectory = &simulation.trajectory;
        for (time, force) in [
            (0.1, -3.0),
            (0.3, 4.9),
            (0.7, -bound),
            (1.9, -1.0),
            (2.3, bound),
        ] {
            let k = trajectory.time.partition_point(|&t| t <= time) - 1;
            let found = trajectory.friction_force[k][0];
            assert!((found - force).abs() < 1e-13, "{name}: {found} at {time}");
        }
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
    let centre = mu * GRAVITY / stiffness;
    for (name, simulation) in motions(&model, &start(&[1.0, 0.0], &[0.0; 2], 6.0)) {
        let mut turn: f64 = 1.0;
        for (k, event) in simulation.events.iter().enumerate() {
            turn = -(turn.abs() - 2.0 * centre) * turn.signum();
            let time = PI / stiffness.sqrt() * (k + 1) as f64;
            // Order 9 with elements of a quarter of 1 / w: 1e-14 each.
            assert!((event.time - time).abs() < 1e-11, "{name} {k}");
            assert!((event.q[0] - turn).abs() < 1e-11, "{name} {k}");
            let slips = turn.abs() > centre;
            let kind = if slips {
                EventKind::Slip
            } else {
                EventKind::Stick
            };
            assert_eq!(event.kind, kind, "{name} {k}");
            assert_eq!(slips, k + 1 < simulation.events.len(), "{name} {k}");
        }
        assert_eq!(simulation.events.len(), 6, "{name}");
        let (q, v) = last(&simulation.trajectory);
        let force = last_friction(&simulation.trajectory);
        assert!((force - stiffness * q[0]).abs() < 1e-12, "{name}");
        assert!(v[0].abs() < 1e-15, "{name}");
    }
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
    let angle = (belt / (amplitude * omega)).asin();
    let (caught, way) = (angle / omega, amplitude * angle.cos());
    let slips = caught + way / belt;
    let swing = |time: f64| rest + belt / omega * (omega * (time - slips)).sin();
    let problem = |horizon| start(&[rest - amplitude, 0.0], &[0.0; 2], horizon);
    for (name, simulation) in motions(&model, &problem(1.4)) {
        let kinds = [(EventKind::Stick, 0), (EventKind::Slip, 0)];
        assert_eq!(sequence(&simulation), kinds, "{name}");
        let [first, second] = &simulation.events[..] else {
            unreachable!()
        };
        assert!((first.time - caught).abs() < 1e-12, "{name}");
        assert!((first.q[0] - (rest - way)).abs() < 1e-12, "{name}");
        assert!((second.time - slips).abs() < 1e-12, "{name}");
        assert!((second.q[0] - rest).abs() < 1e-12, "{name}");
        assert!(1.4 - slips > 0.5);
        let (q, v) = last(&simulation.trajectory);
        assert!((q[0] - swing(1.4)).abs() < 1e-12, "{name}");
        let speed = belt * (omega * (1.4 - slips)).cos();
        assert!((v[0] - speed).abs() < 1e-12, "{name}");
    }
    // A period later sliding velocity and force reserve vanish together: the mass passes or sticks for
    // nothing, and its motion stays the swing with the belt's speed. At such an instant rounding error decides when it
    // slips, and 1e-8 s are 1e-16 m.
    for (name, simulation) in motions(&model, &problem(12.0)) {
        let (q, _) = last(&simulation.trajectory);
        assert!((q[0] - swing(12.0)).abs() < 1e-6, "{name}");
    }
}

#[test]
fn pulled_block_sticks_until_the_spring_reaches_the_bound() {
    // Linear spring: slip from t = mu g / (k V), then y = V s - V / w sin(w s).
    let (mu, stiffness, speed) = (0.4, 16.0_f64, 2.0);
    let omega = stiffness.sqrt();
    let model = Pulled {
        mu,
        stiffness,
        ..Pulled::default()
    };
    let slip = mu * GRAVITY / (stiffness * speed);
    let problem = start(&[0.0; 3], &[0.0, 0.0, speed], slip + 1.0);
    for (name, simulation) in motions(&model, &problem) {
        assert_eq!(sequence(&simulation), [(EventKind::Slip, 0)], "{name}");
        assert!((simulation.events[0].time - slip).abs() < 1e-14, "{name}");
        let (q, v) = last(&simulation.trajectory);
        // The start of the slip is of third order in time, far below the error of the schemes.
        let y = speed - speed / omega * omega.sin();
        assert!((q[0] - y).abs() < 1e-12, "{name}: {:e}", q[0] - y);
        assert!((v[0] - speed * (1.0 - omega.cos())).abs() < 1e-12, "{name}");
    }
}

#[test]
fn spinning_disc_slips_or_rolls_after_its_impact() {
    // s = -v_t / (1 + 1/c) would roll; p = (1 + e) |v_n| allows mu p.
    for (radius, shape, mu) in [(0.3, 0.5, 0.2), (0.5, 0.64, 1.0)] {
        for (e, spin) in [(0.0, 3.0), (0.0, 60.0), (0.6, 3.0), (0.6, -60.0)] {
            let model = Disc {
                radius,
                shape,
                e,
                mu,
                ..Disc::default()
            };
            let problem = start(&[0.0, radius, 0.0], &[0.1, -2.0, spin], 0.1);
            let sliding = 0.1 + radius * spin;
            let (p, gain): (f64, f64) = ((1.0 + e) * 2.0, 1.0 + 1.0 / shape);
            let rolls = (sliding / gain).abs() < mu * p;
            let s = -(sliding / gain).clamp(-mu * p, mu * p);
            let after = [0.1 + s, 2.0 * e, spin + s / (shape * radius)];
            for (name, simulation) in motions(&model, &problem) {
                let event = &simulation.events[0];
                assert_eq!((event.kind, event.time), (EventKind::Impact, 0.0), "{name}");
                assert!(distance(&event.v_after, &after) < 2e-14, "{name}");
                // What rolls on the ground needs no force.
                if e == 0.0 {
                    let force = if rolls {
                        0.0
                    } else {
                        -mu * GRAVITY * sliding.signum()
                    };
                    let found = last_friction(&simulation.trajectory);
                    assert!((found - force).abs() < 1e-12, "{name}: {found}");
                }
            }
        }
    }
}

#[test]
fn sliding_disc_begins_to_roll_at_the_time_of_the_closed_form() {
    // v = v0 - mu g t, and the sliding velocity falls at mu g (1 + 1/c).
    for (radius, shape, mu, e, spin) in [(0.3, 0.4, 0.2, 0.7, 0.0), (0.5, 0.64, 0.3, 0.0, 6.0)] {
        let model = Disc {
            radius,
            shape,
            e,
            mu,
            ..Disc::default()
        };
        let time = (3.0 + radius * spin) / (mu * GRAVITY * (1.0 + 1.0 / shape));
        let speed = 3.0 - mu * GRAVITY * time;
        let problem = start(&[0.0, radius, 0.0], &[3.0, 0.0, spin], 2.0);
        for (name, simulation) in motions(&model, &problem) {
            assert_eq!(sequence(&simulation), [(EventKind::Stick, 0)], "{name}");
            assert!((simulation.events[0].time - time).abs() < 1e-14, "{name}");
            let (_, v) = last(&simulation.trajectory);
            assert!(
                distance(v, &[speed, 0.0, -speed / radius]) < 1e-13,
                "{name}"
            );
            assert!(
                last_friction(&simulation.trajectory).abs() < 1e-13,
                "{name}"
            );
        }
    }
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
        let (acceleration, turning) = if slope.tan() < mu * (1.0 + 1.0 / shape) {
            let a = GRAVITY * sin / (1.0 + shape);
            (a, -a / radius)
        } else {
            let braked = -mu * GRAVITY * cos;
            (GRAVITY * sin + braked, braked / (shape * radius))
        };
        let exact = [acceleration * cos, -acceleration * sin, turning];
        let problem = start(&[0.0, radius / cos, 0.0], &[0.0; 3], 1.0);
        for (name, simulation) in motions(&model, &problem) {
            assert!(simulation.events.is_empty(), "{name}");
            assert!(
                distance(last(&simulation.trajectory).1, &exact) < 1e-12,
                "{name}"
            );
        }
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
    for (name, simulation) in motions(&model, &start(&[0.0; 2], &[4.0, 0.0], 10.0)) {
        // v^2 = 16 - 2 mu g int |cos y| dy: 1 to the first dead point, 2 from each to the next.
        let (stop, turns) = simulation.events.split_last().unwrap();
        for (k, event) in turns.iter().enumerate() {
            let (y, v) = (event.q[0], event.v_after[0]);
            assert_eq!(event.kind, EventKind::Slip, "{name}");
            assert!((y - (k as f64 + 0.5) * PI).abs() < 1e-11, "{name}: {y}");
            let lost = 2.0 * mu * GRAVITY * (2.0 * k as f64 + 1.0);
            assert!((v * v - (16.0 - lost)).abs() < 1e-11, "{name}: {v}");
        }
        let way = 16.0 / (2.0 * mu * GRAVITY);
        assert_eq!(turns.len() as f64, ((way + 1.0) / 2.0).floor(), "{name}");
        assert_eq!(stop.kind, EventKind::Stick, "{name}");
        // In the last half turn |sin| goes from -1 to what is left.
        let left = way - (2.0 * turns.len() as f64 - 1.0) - 1.0;
        let found = stop.q[0].sin().abs();
        assert!((found - left.abs()).abs() < 1e-10, "{name}: {found} {left}");
    }
}
