//! Optimal control with Coulomb friction, against closed forms and brute force.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{
    DIGITS, assert_program, attempt, kinds, linear, one_start, solve, time_freezing,
};
use hangtime::ocp::{Guess, Status};
use hangtime::simulation::EventKind;

hangtime::model! {
    /// A block that is pushed over a floor with friction, as fast as possible from rest to rest.
    Block {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d, dot(y) == 0 }
    }
}

#[test]
fn block_from_rest_to_rest_accelerates_and_brakes_with_the_help_of_friction() {
    let solution = solve(&Block::default(), 8, &one_start());
    // The speed grows with a = F/m - mu g = 2.5 m/s^2 and falls with b = F/m + mu g = 7.5 m/s^2, from rest to rest over
    // 1 m in sqrt(2 d (1/a + 1/b)), and the force turns round after three quarters of the time: on the grid.
    let time = (2.0_f64 * (1.0 / 2.5 + 1.0 / 7.5)).sqrt();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
    assert!(solution.planned_events.is_empty());
}

#[test]
fn previous_motion_of_the_block_is_a_start_for_less_friction_on_another_grid() {
    let mut block = Block::default();
    let before = solve(&block, 8, &one_start());
    block.mu = 0.2;
    let mut settings = one_start();
    settings.guess = Guess::Previous(Box::new(before.previous.unwrap()));
    let solution = solve(&block, 10, &settings);
    // The force turns round after seven tenths of the time.
    let time = (2.0_f64 * (1.0 / 3.0 + 1.0 / 7.0)).sqrt();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
}

#[test]
fn friction_that_holds_against_the_largest_force_leaves_no_motion_to_be_found() {
    let block = Block {
        mu: 0.6,
        ..Block::default()
    };
    let solution = attempt(&block, 2, &one_start());
    assert_eq!(solution.status, Status::NotFound);
    assert!(solution.motion.is_none() && solution.diagnosis().is_some());
}

hangtime::model! {
    /// A block that comes back: it starts against the direction in which it is to go.
    Returning {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d }
        start { dot(y): -1.5 [m/s] }
    }
}

#[test]
fn block_that_comes_back_turns_round_where_friction_turns_round() {
    let solution = solve(&Returning::default(), 5, &one_start());
    let (speed, a, b) = (1.5_f64, 2.5, 7.5);
    let time = speed / b + (2.0 * (1.0 + speed * speed / (2.0 * b)) / a).sqrt();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
    assert_eq!(kinds(&solution), [EventKind::Slip]);
    assert!((solution.planned_events[0].0 - speed / b).abs() < DIGITS);
}

hangtime::model! {
    /// A block that is moved with little effort in more time than that takes.
    Patient {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon 2.5 [s]
    }
}

/// Least effort of a block that slides over `count` intervals of length `h`, the last of which it ends at the share
/// `share`, from rest to rest: accelerations a_k with sum a_k l_k = 0 and sum a_k l_k (T - m_k) = d for the lengths l_k
/// of the parts and their middles m_k cost sum h (m (a_k + mu g))^2.
fn sliding_effort(count: usize, share: f64, h: f64) -> f64 {
    let (mass, friction, distance) = (2.0, 2.5, 1.0);
    let total = h * (count as f64 - 1.0 + share);
    let parts: Vec<(f64, f64)> = (0..count)
        .map(|k| {
            let length = if k + 1 == count { share * h } else { h };
            (length, (total - k as f64 * h - 0.5 * length) * length)
        })
        .collect();
    // Minimize sum (a + f)^2 with two linear conditions: a + f = x l + y w.
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| parts.iter().map(f).sum::<f64>();
    let (ll, lw, ww) = (
        sum(&|p| p.0 * p.0),
        sum(&|p| p.0 * p.1),
        sum(&|p| p.1 * p.1),
    );
    let (l, w) = (
        friction * sum(&|p| p.0),
        distance + friction * sum(&|p| p.1),
    );
    let determinant = ll * ww - lw * lw;
    let (x, y) = (
        (l * ww - w * lw) / determinant,
        (ll * w - lw * l) / determinant,
    );
    let square = parts
        .iter()
        .map(|p| (x * p.0 + y * p.1).powi(2))
        .sum::<f64>();
    // The force after the block has stopped must not move it again.
    let last = parts.last().map_or(0.0, |p| x * p.0 + y * p.1);
    if last.abs() > friction {
        return f64::INFINITY;
    }
    mass * mass * h * square
}

/// The same for the best number and share of intervals of this `length` together.
pub(crate) fn least_sliding_effort(intervals: usize, length: f64) -> f64 {
    (2..=intervals)
        .flat_map(|count| (1..=1000).map(move |i| (count, f64::from(i) / 1000.0)))
        .map(|(count, share)| sliding_effort(count, share, length / intervals as f64))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn block_with_time_to_spare_sticks_for_a_while() {
    let intervals = 10;
    let best = least_sliding_effort(intervals, 2.5);
    let solution = solve(&Patient::default(), intervals, &one_start());
    // The grid of the search is fine enough for a millionth of the effort near a minimum.
    assert!(
        (solution.objective - best).abs() < 1e-5 * best,
        "{} against {best}",
        solution.objective
    );
    // Whether it rests before it slides, or after, costs the same.
    let kinds = kinds(&solution);
    let rests = |kind: &EventKind| matches!(kind, EventKind::Slip | EventKind::Stick);
    assert!(!kinds.is_empty() && kinds.iter().all(rests), "{kinds:?}");
}

hangtime::model! {
    /// A puck that falls onto a floor with friction and is pushed on.
    Puck {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 3 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d }
        start { z: 0.2 [m], dot(y): 1 [m/s] }
    }
}

/// Flight over 0.2 s with 5 m/s^2; the impact of 2 m/s takes 0.5 m/s off; then 2.5 m/s^2.
fn landing_time() -> f64 {
    let (way, speed): (f64, f64) = (0.2 + 0.1, 2.0 - 0.5);
    let rest = 3.0 - way;
    0.2 + (-speed + (speed * speed + 2.0 * 2.5 * rest).sqrt()) / 2.5
}

#[test]
fn puck_that_lands_sliding_loses_speed_to_the_friction_of_the_impact() {
    let solution = solve(&Puck::default(), 6, &one_start());
    let time = landing_time();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
    assert_eq!(kinds(&solution), [EventKind::Impact]);
}

#[test]
fn puck_is_found_by_the_time_freezing_formulation_and_with_linear_controls_too() {
    let time = landing_time();
    let solution = solve(&Puck::default(), 6, &time_freezing());
    assert!((solution.horizon - time).abs() < DIGITS);
    // Accelerations are constant, which the scheme integrates exactly.
    assert_program(&solution, DIGITS);
    let solution = solve(&Puck::default(), 6, &linear());
    assert!((solution.horizon - time).abs() < DIGITS);
}

hangtime::model! {
    /// A puck that is thrown onto a rough floor and is to lie still there.
    Dropped {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.8, d: m = 0.2 }
        coordinates { y: m, z: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon 0.5 [s]
        start { z: 0.2 [m], dot(y): 0.5 [m/s] }
    }
}

#[test]
fn puck_that_lands_slowly_enough_sticks_in_the_impact() {
    let solution = solve(&Dropped::default(), 2, &one_start());
    // Flight over 0.2 s and 0.5 * 0.2 + u / m * 0.02 metres: u = 10 N, for one interval of 0.25 s. The puck lands with
    // 1.5 m/s, of which the impact of 2 m/s could take 1.6 m/s off; 10 N do not overcome the friction of 16 N.
    assert!(
        (solution.objective - 25.0).abs() < 25.0 * DIGITS,
        "{}",
        solution.objective
    );
    assert_eq!(kinds(&solution), [EventKind::Impact]);
    let motion = solution.motion.unwrap();
    assert!(motion.events[0].v_before[0] > 1.4 && motion.events[0].v_after[0].abs() < 1e-12);
}

#[test]
fn puck_that_comes_to_rest_in_the_impact_does_so_while_the_clock_stands() {
    // The jump has two parts: until the puck stops sliding, and until it has stopped falling.
    let solution = solve(&Dropped::default(), 2, &time_freezing());
    assert!((solution.objective - 25.0).abs() < 25.0 * DIGITS);
    assert_program(&solution, DIGITS);
    let report = solution.time_freezing.unwrap();
    assert!(
        (report.objective - 25.0).abs() < 25.0 * DIGITS,
        "{report:?}"
    );
}

#[test]
fn puck_that_lands_too_fast_to_stick_slides_on_to_its_place() {
    let puck = Dropped {
        d: 0.35,
        ..Dropped::default()
    };
    let solution = solve(&puck, 2, &one_start());
    assert_eq!(kinds(&solution), [EventKind::Impact, EventKind::Stick]);
    let best = dropped_effort(0.35);
    assert!(
        (solution.objective - best).abs() < 1e-5 * best,
        "{} against {best}",
        solution.objective
    );
}

/// Least effort of the puck that lands sliding and comes to rest by itself: for the force u on the first interval, 0.2 s
/// of flight, 0.05 s of sliding, and the rest under the force w that stops it in its place.
fn dropped_effort(distance: f64) -> f64 {
    let effort = |u: f64| {
        let (mut way, mut speed) = (0.5 * 0.2 + u * 0.01, 0.5 + u * 0.1);
        speed -= 0.8 * 2.0;
        if speed <= 0.0 {
            return f64::INFINITY;
        }
        let a = u / 2.0 - 8.0;
        // It may come to rest before the interval ends; the brute force leaves that to others.
        if speed + a * 0.05 <= 0.0 {
            return f64::INFINITY;
        }
        way += speed * 0.05 + 0.5 * a * 0.0025;
        speed += a * 0.05;
        let rest = distance - way;
        if rest <= 0.0 {
            return f64::INFINITY;
        }
        let w = 2.0 * (8.0 - speed * speed / (2.0 * rest));
        let time = 2.0 * rest / speed;
        if time > 0.25 || w.abs() > 16.0 {
            return f64::INFINITY;
        }
        0.25 * (u * u + w * w)
    };
    (0..=3_000_000)
        .map(|i| effort(f64::from(i) * 1e-5))
        .fold(f64::INFINITY, f64::min)
}

hangtime::model! {
    /// A rough ball that bounces on.
    Bouncing {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0.3, e = 0.6, d: m = 2 }
        coordinates { y: m, z: m }
        controls { u: N in -8..=8 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: restitution e, friction mu
        minimize time
        finally { y == d }
        start { z: 0.3 [m], dot(y): 1 [m/s] }
    }
}

#[test]
fn ball_that_bounces_on_loses_speed_to_friction_at_every_bounce() {
    let (mut way, mut speed, mut time): (f64, f64, f64) = (0.0, 1.0, 0.0);
    let mut flight = (2.0_f64 * 0.3 / 10.0).sqrt();
    let mut fall = 10.0 * flight;
    for _ in 0..2 {
        way += speed * flight + 4.0 * flight * flight;
        speed += 8.0 * flight - 0.3 * 1.6 * fall;
        time += flight;
        fall *= 0.6;
        flight = 2.0 * fall / 10.0;
    }
    time += (-speed + (speed * speed + 16.0 * (2.0 - way)).sqrt()) / 8.0;
    let solution = solve(&Bouncing::default(), 3, &one_start());
    let horizon = solution.horizon;
    assert!((horizon - time).abs() < DIGITS, "{horizon}");
    assert_eq!(kinds(&solution), [EventKind::Impact; 2]);
}

hangtime::model! {
    /// A sledge that is pushed over rough hills from rest to rest.
    Hills {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 2, b: m = 0.1, k: 1/m = 3 }
        coordinates { y: m, z: m }
        controls { u: N in -15..=15 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= b*sin(k*y)
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d, dot(y) == 0 }
    }
}

#[test]
fn sliding_over_hills_is_as_accurate_as_the_scheme() {
    // Two stages are of order 3. The largest distance is there to keep the grid as it is.
    let error = |elements: usize| {
        let mut settings = one_start();
        settings.stages = 2;
        settings.elements = elements;
        settings.largest_distance = 1.0;
        let solution = attempt(&Hills::default(), 8, &settings);
        assert_eq!(
            solution.status,
            Status::Solved,
            "{:?}",
            solution.diagnosis()
        );
        solution.resimulation_error
    };
    let errors = [error(2), error(4), error(8)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((2.5..3.7).contains(&order), "{errors:?}");
    }
}

hangtime::model! {
    /// A bar on two feet with friction, pushed from rest to rest; or thrown onto the floor, tilted.
    Bar {
        parameters {
            m: kg = 2, j: kg*m^2 = 0.1, g: m/s^2 = 10, mu = 0.25, d: m = 1, a: m = 0.3,
            height: m = 0, tilt = 0, speed: m/s = 0
        }
        coordinates { y: m, z: m, phi }
        controls { u: N in -10..=10 }
        let left = (y - a*cos(phi), z - a*sin(phi))
        let right = (y + a*cos(phi), z + a*sin(phi))
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + j/2*dot(phi)^2 - m*g*z
        forces { y: u }
        surface left_foot: left.z >= 0
        surface right_foot: right.z >= 0
        impact left_foot: inelastic, friction mu, sliding dot(left.y)
        impact right_foot: inelastic, friction mu, sliding dot(right.y)
        minimize time
        finally { y == d, dot(y) == 0 }
        start { z: height, phi: tilt, dot(y): speed }
    }
}

#[test]
fn bar_on_two_feet_slides_like_a_block() {
    let solution = solve(&Bar::default(), 8, &one_start());
    let time = (2.0_f64 * (1.0 / 2.5 + 1.0 / 7.5)).sqrt();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
}

#[test]
fn bar_that_lands_tilted_strikes_the_floor_with_both_feet() {
    // Until the first foot strikes, the bar falls freely: 0.3 - 0.3 sin 0.3 metres.
    let fall = (0.3 - 0.3 * 0.3_f64.sin()) / 5.0;
    for mu in [0.25, 0.2] {
        let bar = Bar {
            mu,
            height: 0.3,
            tilt: 0.3,
            speed: 0.5,
            ..Bar::default()
        };
        let solution = solve(&bar, 6, &one_start());
        assert_eq!(kinds(&solution), [EventKind::Impact; 2]);
        assert!((solution.planned_events[0].0 - fall.sqrt()).abs() < DIGITS);
        // The second foot strikes while the first one slides on, and is struck once more.
        let contacts: Vec<usize> = solution.planned_events.iter().map(|e| e.2).collect();
        assert_eq!(contacts, [0, 1]);
    }
}

hangtime::model! {
    /// A stone that is let go with the speed at which it stops in its place.
    Curling {
        parameters { m: kg = 20, g: m/s^2 = 10, mu = 0.02, d: m = 28 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ice: z >= 0
        impact ice: inelastic, friction mu
        minimize time
        finally { y == d, dot(y) == 0 }
        free { dot(y) in 0..=10 }
        start { dot(y): 1 [m/s] }
    }
}

#[test]
fn free_initial_speed_of_a_curling_stone_is_what_friction_takes() {
    let solution = solve(&Curling::default(), 4, &one_start());
    let speed = (2.0_f64 * 0.2 * 28.0).sqrt();
    assert!((solution.horizon - speed / 0.2).abs() < DIGITS * solution.horizon);
    let motion = solution.motion.unwrap();
    assert!((motion.trajectory.v[0][0] - speed).abs() < DIGITS);
}

hangtime::model! {
    /// A hop from a floor and back to it; the floor may have friction.
    Hop {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0, d: m = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10, p: N in 0..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: p }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2 + p^2)
        finally { y == d, dot(y) == 0 }
        horizon 1 [s]
        start { z: 0.3 [m] }
    }
}

hangtime::model! {
    /// The same without a word of friction.
    SmoothHop {
        parameters { m: kg = 1, g: m/s^2 = 10, d: m = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10, p: N in 0..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: p }
        surface floor: z >= 0
        impact floor: inelastic
        minimize integral(u^2 + p^2)
        finally { y == d, dot(y) == 0 }
        horizon 1 [s]
        start { z: 0.3 [m] }
    }
}

#[test]
fn friction_of_zero_is_no_friction_and_costs_nothing() {
    let zero = solve(&Hop::default(), 4, &one_start());
    let none = solve(&SmoothHop::default(), 4, &one_start());
    assert_eq!(zero.size, none.size);
    assert_eq!(zero.planned_events, none.planned_events);
    assert_eq!(zero.counts, none.counts);
    assert_eq!(zero.objective, none.objective);
}

hangtime::model! {
    /// The bar, moved with little effort in more time than that takes.
    PatientBar {
        parameters { m: kg = 2, j: kg*m^2 = 0.1, g: m/s^2 = 10, mu = 0.25, d: m = 1, a: m = 0.3 }
        coordinates { y: m, z: m, phi }
        controls { u: N in -30..=30 }
        let left = (y - a*cos(phi), z - a*sin(phi))
        let right = (y + a*cos(phi), z + a*sin(phi))
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + j/2*dot(phi)^2 - m*g*z
        forces { y: u }
        surface left_foot: left.z >= 0
        surface right_foot: right.z >= 0
        impact left_foot: inelastic, friction mu, sliding dot(left.y)
        impact right_foot: inelastic, friction mu, sliding dot(right.y)
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon 2.5 [s]
    }
}

#[test]
fn bar_with_time_to_spare_sticks_on_both_feet() {
    let solution = solve(&PatientBar::default(), 10, &one_start());
    let block = solve(&Patient::default(), 10, &one_start());
    assert!((solution.objective - block.objective).abs() < DIGITS * block.objective);
}
