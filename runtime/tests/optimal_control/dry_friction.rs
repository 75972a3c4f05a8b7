//! Optimal control with dry friction without a surface: a mass on a rail is the block on a rough floor with
//! `mu m g` for the bound, and has its closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::friction::least_sliding_effort;
use crate::support::{
    DIGITS, assert_program, attempt, kinds, linear, one_start, solve, time_freezing,
};
use hangtime::model::Model;
use hangtime::ocp::{Problem, Settings, program_sizes};
use hangtime::simulation::EventKind;

fn assert_close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < DIGITS * expected,
        "{found} instead of {expected}"
    );
}

hangtime::model! {
    /// A mass that is pushed along a dry rail, as fast as possible from rest to rest.
    Hasty {
        parameters { m: kg = 2, f: N = 5, d: m = 1 }
        coordinates { y: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        dry friction rail: bound f, sliding dot(y)
        minimize time
        finally { y == d, dot(y) == 0 }
    }
}

hangtime::model! {
    /// A mass that starts against the direction in which it is to go.
    Returning {
        parameters { m: kg = 2, f: N = 5, d: m = 1 }
        coordinates { y: m }
        controls { u: N in -10..=10 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        dry friction rail: bound f, sliding dot(y)
        minimize time
        finally { y == d }
        start { dot(y): -1.5 [m/s] }
    }
}

hangtime::model! {
    /// A mass that is pushed along a dry rail with little effort.
    Rail {
        parameters { m: kg = 2, f: N = 5, d: m = 1, length: s = 1.2 }
        coordinates { y: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        dry friction rail: bound f, sliding dot(y)
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon length
    }
}

hangtime::model! {
    /// The same as a block on a rough floor, of which `m g mu` is the bound.
    Block {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 1, length: s = 1.2 }
        coordinates { y: m, z: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon length
    }
}

#[test]
fn mass_from_rest_to_rest_brakes_with_the_help_of_friction() {
    // It gains speed with a = (10 - 5)/2 and loses it with b = (10 + 5)/2.
    let time = (2.0_f64 * (1.0 / 2.5 + 1.0 / 7.5)).sqrt();
    for settings in [one_start(), time_freezing()] {
        let solution = solve(&Hasty::default(), 8, &settings);
        assert_close(solution.horizon, time);
        assert!(solution.planned_events.is_empty());
    }
}

#[test]
fn mass_that_starts_the_other_way_turns_round_where_friction_turns_round() {
    for settings in [one_start(), time_freezing()] {
        let solution = solve(&Returning::default(), 5, &settings);
        if solution.time_freezing.is_some() {
            assert_program(&solution, DIGITS);
        }
        // It stops after 1.5/7.5 s, and goes from rest with 2.5 m/s^2 from there on.
        let stop = 1.5 / 7.5;
        let way = 1.0 + 1.5 * 1.5 / (2.0 * 7.5);
        assert_close(solution.horizon, stop + f64::sqrt(2.0 * way / 2.5));
        assert_eq!(kinds(&solution), [EventKind::Slip]);
        assert!((solution.planned_events[0].0 - stop).abs() < DIGITS);
    }
}

#[test]
fn least_effort_against_a_constant_force_has_its_closed_form() {
    // While it slides, u = f + m a with a linear in time: f^2 T + 12 m^2 d^2/T^3.
    let (mass, force, way, length) = (2.0_f64, 5.0_f64, 1.0_f64, 1.2_f64);
    let effort = force * force * length + 12.0 * (mass * way).powi(2) / length.powi(3);
    let solution = solve(&Rail::default(), 4, &linear());
    assert_close(solution.objective, effort);
    assert!(solution.planned_events.is_empty());
}

#[test]
fn least_effort_is_that_of_a_block_on_a_rough_floor() {
    let rail = solve(&Rail::default(), 4, &linear());
    // Whatever is proved of the neighbours of its sequence, which are more.
    let solution = attempt(&Block::default(), 4, &linear());
    assert_close(solution.objective, rail.objective);
}

#[test]
fn mass_with_time_to_spare_sticks_for_a_while() {
    let rail = Rail {
        length: 2.5,
        ..Rail::default()
    };
    let solution = solve(&rail, 10, &one_start());
    // The grid of this search is fine enough for a millionth of the effort near a minimum.
    let best = least_sliding_effort(10, 2.5);
    assert!(
        (solution.objective - best).abs() < 1e-5 * best,
        "{} against {best}",
        solution.objective
    );
    // Whether it rests before it slides, or after, costs the same.
    let kinds = kinds(&solution);
    let rests = |kind: &EventKind| matches!(kind, EventKind::Slip | EventKind::Stick);
    assert!(!kinds.is_empty() && kinds.iter().all(rests), "{kinds:?}");
    let best = least_sliding_effort(5, 2.5);
    let frozen = solve(&rail, 5, &time_freezing());
    assert_program(&frozen, DIGITS);
    assert!(
        (frozen.objective - best).abs() < 1e-5 * best,
        "{} against {best}",
        frozen.objective
    );
}

#[test]
fn rail_has_neither_height_nor_gap() {
    let sizes = |model: &dyn Model| {
        let problem = Problem::of(model, 4);
        let sizes = program_sizes(model, &problem, &one_start()).unwrap();
        sizes
            .iter()
            .map(|size| {
                let all = size.groups.iter();
                all.map(|group| group.size.variables).sum::<usize>()
            })
            .collect::<Vec<_>>()
    };
    let (rail, block) = (sizes(&Rail::default()), sizes(&Block::default()));
    assert!(!rail.is_empty() && rail.iter().zip(&block).all(|(own, its)| own < its));
    let gaps = program_sizes(
        &Rail::default(),
        &Problem::of(&Rail::default(), 4),
        &one_start(),
    );
    for size in gaps.unwrap() {
        let gap = size.groups.iter().find(|group| group.name == "gap");
        assert!(gap.is_none(), "{}", size.formulation);
    }
}

hangtime::model! {
    /// Swing-up of a pole on a cart whose rail is dry.
    DryRail {
        parameters { cart: kg = 0.8, bob: kg = 0.2, l: m = 0.4, g: m/s^2 = 9.81, rub: N = 1.5 }
        coordinates { x: m in -0.6..=0.6, theta: rad }
        controls { u: N in -10..=10 }
        let tip = (x + l*sin(theta), -l*cos(theta))
        lagrangian cart/2*dot(x)^2 + bob/2*|dot(tip)|^2 - bob*g*tip.z
        forces { x: u }
        dry friction rail: bound rub, sliding dot(x)
        minimize integral(u^2)
        finally { x == 0, dot(x) == 0, theta == 180 [deg], dot(theta) == 0 }
        horizon 1.8 [s]
    }
}

#[test]
fn cart_that_waits_sticks_and_is_not_held_at_the_edge_of_its_friction() {
    // Best of 128 starts. A slip in which nothing moves would cost 1.5 N over the first interval, and one after which the cart turns round
    // where the force jumps 0.4 % for 20 intervals.
    let rail = DryRail::default();
    for (intervals, known) in [(20, 47.554_137_57), (40, 45.932_331_53)] {
        let solution = attempt(&rail, intervals, &Settings::default());
        // An upright pole makes more of errors.
        assert!(solution.resimulation_error < 1e-6);
        let excess = solution.objective / known - 1.0;
        assert!(excess < 1e-7, "{intervals}: {}", solution.objective);
        assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    }
}
