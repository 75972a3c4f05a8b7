//! Optimal control problems that are declared in the language, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::root::root;
use crate::support::{
    DIGITS, assert_program, attempt, most_exceeded, one_start, solve, time_freezing,
};
use hangtime::model::Model;
use hangtime::ocp::{self, Guess, Horizon, PathPoints, Problem, Status};
use hangtime::simulation::EventKind;

hangtime::model! {
    /// A cart that is to be moved with little effort.
    Cart {
        parameters { m: kg = 2, d: m = 1 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon 1 [s]
    }
}

#[test]
fn running_cost_of_a_cart_from_rest_to_rest_is_that_of_the_closed_form() {
    let cart = Cart::default();
    let intervals = 8;
    let solution = solve(&cart, intervals, &one_start());
    // The force is proportional to the distance of the middle of its interval from T/2; the effort is
    // 12 m^2 d^2 / T^3 of the continuous problem over 1 - 1/N^2.
    let effort = 12.0 * 4.0 / (1.0 - 1.0 / (intervals * intervals) as f64);
    assert!(
        (solution.objective - effort).abs() < DIGITS * effort,
        "{} against {effort}",
        solution.objective
    );
    assert_eq!(solution.horizon, 1.0);
    // The final time may be set free by the program that states the problem; longer is then cheaper.
    let problem = Problem {
        horizon: Horizon::Fixed(2.0),
        ..Problem::of(&cart, intervals)
    };
    let longer = ocp::solve(&cart, &problem, &one_start(), &mut |_| true).unwrap();
    assert!((longer.objective - effort / 8.0).abs() < DIGITS * effort);
}

hangtime::model! {
    /// A stone that is thrown as gently as possible so that it lands at a distance.
    Stone {
        parameters { m: kg = 0.5, g: m/s^2 = 9.81, far: m = 3, late: s = 0.1 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        minimize (dot(y)^2 + dot(z)^2)/1[m^2/s^2]
        finally { y == far, z == 0, time >= late }
        free { dot(y) in 0..=20, dot(z) in 0..=20 }
        start { dot(y): 2 [m/s], dot(z): 1 [m/s] }
    }
}

#[test]
fn free_initial_velocity_of_a_throw_is_at_45_degrees() {
    let solution = solve(&Stone::default(), 3, &one_start());
    // v^2 = g d at 45 degrees, and the stone lands as fast as it was thrown.
    let square = 9.81 * 3.0;
    assert!(
        (solution.objective - square).abs() < DIGITS * square,
        "{}",
        solution.objective
    );
    let motion = solution.motion.unwrap();
    let v = &motion.trajectory.v[0];
    assert!((v[0] - v[1]).abs() < 1e-4 && v[0] > 0.0, "{v:?}");
    assert!((solution.horizon - 2.0 * v[1] / 9.81).abs() < 1e-6);
    assert!(solution.resimulation_error < 1e-8);
}

hangtime::model! {
    /// A cart in a hurry with a speed limit.
    Limited {
        parameters { m: kg = 2, limit: m/s = 0.5 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        /// The speed limit.
        constraint speed: dot(y) <= limit
        finally { y == 1 [m] }
    }
}

#[test]
fn path_constraint_on_the_speed_makes_the_cart_coast() {
    for points in [PathPoints::Ends, PathPoints::Stages, PathPoints::Both] {
        let mut settings = one_start();
        settings.path_points = points;
        let solution = solve(&Limited::default(), 5, &settings);
        // Half a metre per second after 1 s and 0.25 m, then 1.5 s for the rest: five intervals of half a second.
        assert!(
            (solution.horizon - 2.5).abs() < DIGITS,
            "{points:?}: {}",
            solution.horizon
        );
        let excess = most_exceeded(&solution);
        assert!(excess < 1e-7, "{points:?}: {excess}");
    }
}

hangtime::model! {
    /// A mass on a spring whose stop is a path constraint, thrown through the middle as fast as possible.
    Spring {
        parameters { m: kg = 1, c: N/m = 4, stop: m = 0.3 }
        coordinates { y: m }
        controls { u: N in -3..=3 }
        lagrangian m/2*dot(y)^2 - c/2*y^2
        forces { y: u }
        minimize -dot(y)/1[m/s]
        constraint room: stop^2 - y^2 >= 0
        finally { y == 0 }
        horizon 2 [s]
    }
}

#[test]
fn path_constraint_between_its_places_holds_unless_nodes_are_asked_for_and_then_the_excess_is_told()
{
    let spring = Spring::default();
    let mut settings = one_start();
    settings.path_points = PathPoints::Ends;
    let everywhere = solve(&spring, 8, &settings);
    let excess = most_exceeded(&everywhere);
    assert!(excess < 1e-8, "{excess}");
    settings.bounds_at_nodes = true;
    let nodes = solve(&spring, 8, &settings);
    let excess = &nodes.excess[0];
    assert_eq!([&excess.name[..], &excess.unit], ["room", "m^2"]);
    assert!(excess.amount > 1e-5 && (0.0..=2.0).contains(&excess.time));
    // More room cannot be worse. The plan's violation is also that of the re-simulated motion, as far as its
    // points come near the place.
    assert!(nodes.objective < everywhere.objective - 1e-7);
    let motion = nodes.motion.unwrap();
    let farthest = motion
        .trajectory
        .q
        .iter()
        .map(|q| q[0].abs())
        .fold(0.0, f64::max);
    assert!((farthest * farthest - 0.09 - excess.amount).abs() < 0.1 * excess.amount);
}

hangtime::model! {
    /// A point that two engines push, which share the work.
    Engines {
        coordinates { y }
        controls { u, w }
        lagrangian dot(y)^2/2
        forces { y: u + w }
        minimize integral(u^2 + w^2)
        constraint share: u == 3*w
        finally { y == 1, dot(y) == 0 }
        horizon 1
    }
}

#[test]
fn equality_along_the_path_is_kept() {
    let solution = solve(&Engines::default(), 4, &one_start());
    // u + w = 4 w, so that the cost is 10/16 of the square of the sum.
    let effort = 10.0 / 16.0 * 12.0 / (1.0 - 1.0 / 16.0);
    assert!((solution.objective - effort).abs() < DIGITS * effort);
    for u in &solution.controls {
        assert!((u[0] - 3.0 * u[1]).abs() < 1e-8, "{u:?}");
    }
}

hangtime::model! {
    /// A mass with an engine above the ground that is to hover at a height, by least squares.
    Hopper {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        controls { u: N in 0..=40 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(u^2)
        finally { z == 0.3 [m] }
        start { z: 0.2 [m] }
        horizon 1 [s]
    }
}

#[test]
fn hop_that_is_declared_has_the_effort_of_a_search_over_both_thrusts() {
    // Best of a search over the two thrusts in closed form (`brute_force.rs`): land, rest, thrust.
    let known = 74.542_05;
    for guess in [Guess::Straight, Guess::Ride] {
        let mut settings = one_start();
        settings.guess = guess;
        let solution = solve(&Hopper::default(), 2, &settings);
        assert!(
            (solution.objective - known).abs() < 1e-6,
            "{}",
            solution.objective
        );
        let kinds: Vec<EventKind> = solution.planned_events.iter().map(|e| e.1).collect();
        assert_eq!(kinds, [EventKind::Impact, EventKind::LiftOff]);
    }
}

hangtime::model! {
    /// A cart that is to stay near the origin.
    Guided {
        parameters { m: kg = 2 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize integral(y^2)
        start { y: 1 [m] }
        horizon 1 [s]
    }
}

#[test]
fn time_freezing_programs_state_all_that_is_declared_and_end_at_the_optima_of_the_phases() {
    let mut settings = one_start();
    settings.formulation = ocp::Formulation::TimeFreezing(ocp::TimeFreezingSettings::default());
    let (guided, limited, stone) = (Guided::default(), Limited::default(), Stone::default());
    let (engines, spring) = (Engines::default(), Spring::default());
    // A cost of states, a path constraint, free initial values with a quadratic cost, an equality of controls, a
    // quadratic constraint with a linear cost of the last state.
    // Constraints of the program hold at stages only, and its elements are equal: where accelerations change, it is as far off
    // as a scheme of order 3 is.
    let scenes: [(&dyn Model, usize, f64); 5] = [
        (&guided, 4, 1e-5),
        (&limited, 5, 1e-8),
        (&stone, 3, 1e-11),
        (&engines, 4, 1e-11),
        (&spring, 8, 2e-4),
    ];
    for (model, intervals, near) in scenes {
        let name = model.declaration().name;
        let known = solve(model, intervals, &one_start()).objective;
        let solution = solve(model, intervals, &settings);
        let size = known.abs();
        assert!(
            (solution.objective - known).abs() < DIGITS * size,
            "{name}: {known}"
        );
        assert_program(&solution, near);
    }
}

hangtime::model! {
    /// A sledge that is pushed over hills and is to stop at a place on them, stated in both coordinates.
    Sledge {
        parameters { m: kg = 2, g: m/s^2 = 10, d: m = 2, b: m = 0.1, k: 1/m = 3 }
        coordinates { y: m, z: m }
        controls { u: N in -15..=15 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= b*sin(k*y)
        impact floor: inelastic
        minimize integral(u^2)
        finally { y == d, z == b*sin(k*d), dot(y) == 0, dot(z) == 0 }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A mass that is pushed over a shaken floor and ends on it.
    Shaken {
        parameters { m: kg = 2, g: m/s^2 = 10, d: m = 2, b: m = 0.1, k: 1/m = 3, c: m = 0.05, w: 1/s = 3 }
        coordinates { y: m, z: m }
        controls { u: N in -15..=15 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= b*sin(k*y) + c*(1 - cos(w*t))
        impact floor: inelastic
        minimize integral(u^2)
        finally { y == d, z == b*sin(k*d) + c*(1 - cos(w*time)), dot(y) == 0 }
        horizon 2 [s]
    }
}

#[test]
fn time_freezing_programs_end_on_curved_and_moving_floors() {
    // Where coordinates drift off the floor by the error of the scheme, a goal on the floor has no motion, or a poor one.
    let (sledge, shaken) = (Sledge::default(), Shaken::default());
    let cases: [(&dyn Model, usize, f64); 4] = [
        (&sledge, 2, 1e-3),
        (&sledge, 3, 1e-5),
        (&sledge, 4, 1e-7),
        (&shaken, 3, 1e-5),
    ];
    for (model, stages, near) in cases {
        let mut settings = one_start();
        let mut frozen = ocp::TimeFreezingSettings::default();
        frozen.stages = stages;
        settings.formulation = ocp::Formulation::TimeFreezing(frozen);
        let solution = attempt(model, 8, &settings);
        assert_eq!(solution.status, Status::Solved);
        assert_program(&solution, near);
    }
}

hangtime::model! {
    /// A mass with an engine between floor and ceiling.
    Shuttle {
        parameters { m: kg = 1, g: m/s^2 = 9.81, h: m = 1 }
        coordinates { z: m }
        controls { u: N in 0..=40 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface floor: z >= 0
        surface ceiling: h - z >= 0
        impact floor: inelastic
        impact ceiling: inelastic
        minimize integral((u - 9[N])^2)
        finally { z >= 0.99 [m], dot(z) <= 0.1 [m/s] }
        start { z: 0.1 [m], dot(z): -1 [m/s] }
        horizon 1.5 [s]
    }
}

/// The motion under constant thrust for a time, in closed form: the rest after an inelastic impact is a push into the
/// surface or a departure.
fn shuttle((z, v): (f64, f64), u: f64, time: f64) -> (f64, f64) {
    let a = u - 9.81;
    for (surface, outside) in [(0.0, -1.0), (1.0, 1.0)] {
        if z == surface && v * outside >= 0.0 {
            // On a surface: kept there, or leaving it from rest.
            return if a * outside >= 0.0 {
                (surface, 0.0)
            } else {
                free(surface, 0.0, a, time)
            };
        }
    }
    free(z, v, a, time)
}

fn free(z: f64, v: f64, a: f64, time: f64) -> (f64, f64) {
    let mut first = (time, None);
    for surface in [0.0, 1.0] {
        // Roots of z + v t + a t^2 / 2 = surface.
        let square = v * v - 2.0 * a * (z - surface);
        if square < 0.0 || a == 0.0 {
            continue;
        }
        for root in [(-v - square.sqrt()) / a, (-v + square.sqrt()) / a] {
            let leaves = z == surface && root < 1e-12;
            if root > 0.0 && !leaves && root < first.0 {
                first = (root, Some(surface));
            }
        }
    }
    match first {
        (landing, Some(surface)) => shuttle((surface, 0.0), a + 9.81, time - landing),
        _ => (z + v * time + 0.5 * a * time * time, v + a * time),
    }
}

#[test]
fn motion_between_floor_and_ceiling_uses_both_and_is_the_best_of_a_search() {
    let mut settings = one_start();
    settings.starts = Some(4);
    let solution = solve(&Shuttle::default(), 3, &settings);
    // Three thrusts of half a second each: the first two on successively finer grids around the best; of the third as
    // much as brings the mass to the ceiling in time, by bisection: the impact that stops it is the end.
    let third = |u1: f64, u2: f64| {
        let middle = shuttle(shuttle((0.1, -1.0), u1, 0.5), u2, 0.5);
        let there = |u: f64| {
            let (z, v) = shuttle(middle, u, 0.5);
            z >= 0.99 && v <= 0.1
        };
        let (mut low, mut high) = (9.0, 40.0);
        if !there(high) {
            return f64::INFINITY;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if there(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    };
    let (mut best, mut centre, mut width) = (f64::INFINITY, [20.0; 2], 20.0_f64);
    for _ in 0..16 {
        let from = centre;
        for index in 0..41_i32.pow(2) {
            let step = |k: i32| width * f64::from(k - 20) / 20.0;
            let u1 = (from[0] + step(index % 41)).clamp(0.0, 40.0);
            let u2 = (from[1] + step(index / 41)).clamp(0.0, 40.0);
            let all = [u1, u2, third(u1, u2)];
            let value = 0.5 * all.iter().map(|u| (u - 9.0).powi(2)).sum::<f64>();
            if value < best {
                (best, centre) = (value, [u1, u2]);
            }
        }
        width /= 2.0;
    }
    // Second order in the last width of 1e-3 N, and the solver's tolerance.
    assert!(
        (solution.objective - best).abs() < 1e-5,
        "{} against {best} at {centre:?}: {:?} {:?}",
        solution.objective,
        solution.controls,
        solution.planned_events
    );
    let touched = |contact: usize| solution.planned_events.iter().any(|e| e.2 == contact);
    assert!(touched(0) && touched(1), "{:?}", solution.planned_events);
}

#[test]
fn previous_motion_is_a_start_for_a_neighbouring_problem() {
    let cart = Hopper::default();
    let first = solve(&cart, 2, &one_start());
    let heavier = Hopper {
        m: 1.05,
        ..Hopper::default()
    };
    let from_nothing = solve(&heavier, 2, &one_start());
    let mut settings = one_start();
    settings.guess = Guess::Previous(Box::new(first.previous.clone().unwrap()));
    let warm = solve(&heavier, 2, &settings);
    assert!(
        (warm.objective - from_nothing.objective).abs() < DIGITS * warm.objective,
        "{} against {} after {}",
        warm.objective,
        from_nothing.objective,
        first.objective
    );
    assert_eq!(warm.counts.global_iterations, 0);
    let nothing = from_nothing.counts;
    let all = nothing.global_iterations + nothing.iterations;
    assert!(warm.counts.iterations < all, "{:?} {all}", warm.counts);
    // With more intervals the effort falls; the sequence carries over.
    let finer = solve(&heavier, 4, &settings);
    assert!(finer.objective < warm.objective);
    // The motion of another scene is refused.
    let problem = Problem::of(&Engines::default(), 2);
    let error = ocp::solve(&Engines::default(), &problem, &settings, &mut |_| true).unwrap_err();
    insta::assert_snapshot!(error, @"the states of the previous motion, which is of another scene, has 3 components, expected 2");
}

#[test]
fn more_elements_make_up_for_few_stages() {
    let spring = Spring::default();
    let mut settings = one_start();
    settings.stages = 2;
    settings.elements = 2;
    let few = attempt(&spring, 8, &settings);
    let many = solve(&spring, 8, &one_start());
    // Confirmed to 1e-6 at the end; the objective is as good as the plan.
    assert_eq!(few.status, Status::Solved);
    assert!(few.resimulation_error < 1e-6);
    assert!((few.objective - many.objective).abs() < 1e-5);
    assert!(few.size.variables > many.size.variables);
}

hangtime::model! {
    /// A ball with an engine that bounces.
    Bouncer {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e: 1 = 0.8, high: m = 0.3 }
        coordinates { z: m }
        controls { u: N in 0..=40 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: restitution e
        minimize integral(u^2)
        finally { z == high }
        start { z: 0.5 [m] }
        horizon 0.8 [s]
    }
}

#[test]
fn bounce_that_saves_effort_is_found() {
    let mut settings = one_start();
    settings.starts = Some(2);
    let solution = solve(&Bouncer::default(), 1, &settings);
    // Height after 0.8 s under one constant thrust below the weight: fall, bounce, rise.
    let height = |u: f64| {
        let fall = 9.81 - u;
        let landing = (2.0 * 0.5 / fall).sqrt();
        let rest = 0.8 - landing;
        0.8 * fall * landing * rest - 0.5 * fall * rest * rest
    };
    // It rises with the thrust up to 3.81 N, which is beyond the goal; more thrust would only cost more.
    assert!(height(0.0) < 0.3 && height(3.81) > 0.3);
    let thrust = root(|u| 0.3 - height(u), 0.0, 3.81);
    let bounce = 0.8 * thrust * thrust;
    assert!(
        (solution.objective - bounce).abs() < 1e-6,
        "{} against {bounce}, {:?}",
        solution.objective,
        solution.planned_events
    );
}

hangtime::model! {
    /// A ball that is thrown at a rough floor so that it jumps into a basket, with limited blows.
    Basket {
        parameters { m: kg = 1, g: m/s^2 = 10, e = 0.8, mu = 0.2, most: N s = 12 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0
        impact floor: restitution e, friction mu
        minimize time
        constraint mild: impulse(floor) <= most
        finally { y == 3 [m], z == 1 [m], dot(z) <= 0, sum(impulse(floor)) >= 1 [N s] }
        free { dot(y) in 0..=10, dot(z) in -10..=10 }
        start { z: 1 [m], dot(y): 3 }
        horizon 1.5 [s]
    }
}

#[test]
fn free_initial_values_are_looked_for_on_both_sides_of_the_guess() {
    // The throw upwards takes twice as long; no motion lies between both.
    let downwards = 3.0 / 20.0_f64.sqrt();
    for intervals in [8, 10] {
        let solution = solve(&Basket::default(), intervals, &ocp::Settings::default());
        let horizon = solution.horizon;
        assert!((horizon - downwards).abs() < 1e-7, "{intervals}: {horizon}");
    }
}

hangtime::model! {
    /// A ball in free flight, whose speed at the start is free; the floor is far away.
    Falling {
        parameters { m: kg = 1, g: m/s^2 = 9.81 }
        coordinates { z: m }
        controls { u: N in -5..=5 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: inelastic
        minimize integral(u^2) + dot(z)^2/1[m^2/s^2]*1[N^2 s]
        finally { z == 0.1 [m] }
        free { dot(z) in -2..=2 }
        start { z: 0.3 [m] }
        horizon 0.5 [s]
    }
}

#[test]
fn free_start_beside_a_surface_is_solved_by_time_freezing_with_products_of_zero() {
    let mut settings = time_freezing();
    settings.starts = None;
    let solution = solve(&Falling::default(), 6, &settings);
    assert_program(&solution, 1e-8);
    // With the speed free, v(T) = lambda T/2 and u = -lambda t/2 in the middle of each interval; the height at the end gives lambda.
    let (end, g, count) = (0.5_f64, 9.81, 6);
    let h = end / f64::from(count);
    let middles: Vec<f64> = (0..count).map(|k| (f64::from(k) + 0.5) * h).collect();
    let lifted: f64 = middles.iter().map(|t| h * (end - t) * t).sum();
    let lambda =
        (0.1 - 0.3 - g * end * end / 2.0) / (end * end / 2.0 + end.powi(3) / 4.0 - lifted / 2.0);
    let effort: f64 = middles.iter().map(|t| h * (lambda * t / 2.0).powi(2)).sum();
    let least = effort + (lambda * end / 2.0).powi(2);
    let apart = (solution.objective - least).abs();
    assert!(apart < 1e-8, "{} {least}", solution.objective);
}

hangtime::model! {
    /// A cart that starts behind the line that it must not be behind.
    Behind {
        parameters { m: kg = 2, goal: m = 1, line: m = 0.5 }
        coordinates { y: m }
        controls { u: N in -5..=5 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        constraint ahead: y >= line
        finally { y == goal, dot(y) == 0 }
        horizon 2 [s]
    }
}

#[test]
fn start_that_a_constraint_forbids_is_refused_by_its_name() {
    let behind = Behind::default();
    let problem = Problem::of(&behind, 5);
    let refused = ocp::solve(&behind, &problem, &one_start(), &mut |_| true).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "`ahead` at the start = -0.5 m: must be at least 0: start where the constraint holds"
    );
    let ahead = Behind {
        line: 0.0,
        ..behind
    };
    let solution = solve(&ahead, 5, &one_start());
    // Two intervals of full force, one without, two of full brake: 0.6 m/s^2 T^2 = 1 m.
    let least = (1.0_f64 / 0.6).sqrt();
    assert!(
        (solution.horizon - least).abs() < 1e-7,
        "{}",
        solution.horizon
    );
}
