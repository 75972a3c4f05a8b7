//! Optimal control with Coulomb friction, against closed forms and brute force.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::model::Model;
use hangtime::ocp::{self, Problem, Settings, Solution, Status};
use hangtime::simulation::EventKind;

/// The solver's tolerance is 1e-9, that of the re-simulation 1e-12.
const DIGITS: f64 = 1e-7;

fn attempt(model: &dyn Model, intervals: usize, settings: &Settings) -> Solution {
    let problem = Problem::of(model, intervals);
    let solution = ocp::solve(model, &problem, settings, &mut |_| true).unwrap();
    if std::env::var("OCP_VERBOSE").is_ok() {
        eprintln!(
            "{} {:?} {:?} {:.12} {} {:e} {:?} {:?} {:?} {:?} {}",
            model.declaration().name,
            solution.status,
            solution.stationarity,
            solution.objective,
            solution.horizon,
            solution.resimulation_error,
            solution.planned_events,
            solution.counts,
            solution.controls,
            solution.diagnosis(),
            solution.seconds,
        );
    }
    solution
}

fn solve(model: &dyn Model, intervals: usize, settings: &Settings) -> Solution {
    let solution = attempt(model, intervals, settings);
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    assert!(solution.resimulation_error < DIGITS);
    solution
}

fn kinds(solution: &Solution) -> Vec<EventKind> {
    solution
        .planned_events
        .iter()
        .map(|event| event.1)
        .collect()
}

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
    let solution = solve(&Block::default(), 8, &Settings::default());
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
fn friction_that_holds_against_the_largest_force_is_named_infeasible() {
    let mut block = Block::default();
    block.mu = 0.6;
    let solution = attempt(&block, 4, &Settings::default());
    assert_eq!(solution.status, Status::Infeasible);
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
    let solution = solve(&Returning::default(), 5, &Settings::default());
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

#[test]
fn block_with_time_to_spare_sticks_for_a_while() {
    let intervals = 10;
    let h = 2.5 / intervals as f64;
    let best = (2..=intervals)
        .flat_map(|count| (1..=1000).map(move |i| (count, f64::from(i) / 1000.0)))
        .map(|(count, share)| sliding_effort(count, share, h))
        .fold(f64::INFINITY, f64::min);
    let solution = solve(&Patient::default(), intervals, &Settings::default());
    // The grid of the search is fine enough for a millionth of the effort near a minimum.
    assert!(
        (solution.objective - best).abs() < 1e-5 * best,
        "{} against {best}",
        solution.objective
    );
    assert!(kinds(&solution).contains(&EventKind::Slip));
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

#[test]
fn puck_that_lands_sliding_loses_speed_to_the_friction_of_the_impact() {
    let solution = solve(&Puck::default(), 6, &Settings::default());
    // Flight over 0.2 s with 5 m/s^2; the impact of 2 m/s takes 0.5 m/s off; then 2.5 m/s^2.
    let (way, speed): (f64, f64) = (0.2 + 0.1, 2.0 - 0.5);
    let rest = 3.0 - way;
    let time = 0.2 + (-speed + (speed * speed + 2.0 * 2.5 * rest).sqrt()) / 2.5;
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
    assert_eq!(kinds(&solution), [EventKind::Impact]);
}

hangtime::model! {
    /// A puck that is thrown onto a rough floor and is to lie still there.
    Dropped {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.8, d: m = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon 0.4 [s]
        start { z: 0.2 [m], dot(y): 2 [m/s] }
    }
}

#[test]
fn puck_that_lands_slowly_enough_sticks_in_the_impact() {
    let solution = solve(&Dropped::default(), 2, &Settings::default());
    // One interval is the flight of 0.2 s: at 0.5 m it must arrive with u = 2 m (0.5 - 0.4) / 0.04 = 10 N, 3 m/s, of
    // which the impact of 2 m/s takes 1.6 m/s off; the puck would slide on. It lands before, and stops by sliding.
    assert_eq!(kinds(&solution)[0], EventKind::Impact);
}

hangtime::model! {
    /// A bar on two feet with friction, pushed from rest to rest.
    Bar {
        parameters { m: kg = 2, j: kg*m^2 = 0.1, g: m/s^2 = 10, mu = 0.25, d: m = 1, a: m = 0.3 }
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
    }
}

#[test]
fn bar_on_two_feet_slides_like_a_block() {
    let solution = solve(&Bar::default(), 8, &Settings::default());
    let time = (2.0_f64 * (1.0 / 2.5 + 1.0 / 7.5)).sqrt();
    assert!(
        (solution.horizon - time).abs() < DIGITS,
        "{}",
        solution.horizon
    );
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
    let solution = solve(&PatientBar::default(), 10, &Settings::default());
    let block = solve(&Patient::default(), 10, &Settings::default());
    assert!((solution.objective - block.objective).abs() < DIGITS * block.objective);
}
