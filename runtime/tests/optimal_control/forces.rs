//! Forces and impulses of contacts in objectives and conditions, against closed forms.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{DIGITS, attempt, most_exceeded, one_start, solve, time_freezing};
use hangtime::model::Model;
use hangtime::ocp::{Settings, Status};
use hangtime::simulation::EventKind;

fn close(found: f64, wanted: f64) {
    assert!(
        (found - wanted).abs() < DIGITS * wanted.abs().max(1.0),
        "{found} against {wanted}"
    );
}

hangtime::model! {
    /// A passenger stands in a lift; the floor may press neither more nor less than this.
    Lift {
        parameters { m: kg = 70, cabin: kg = 200, g: m/s^2 = 10, most: N = 910, least: N = 490, far: m = 12 }
        coordinates { h: m, y: m }
        controls { u: kN in 0..=20 }
        lagrangian cabin/2*dot(h)^2 + m/2*dot(y)^2 - (cabin*h + m*y)*g
        forces { h: u }
        surface floor: y >= h
        impact floor: inelastic
        outputs { press: N = force(floor) }
        minimize time
        constraint strong: press <= most
        constraint weak: force(floor) >= least
        finally { h == far, dot(h) == 0 }
    }
}

#[test]
fn least_time_of_a_lift_whose_floor_presses_within_bounds_is_that_of_its_largest_accelerations() {
    // `force = m (g + a)`, so that `|a| <= 3 m/s^2`: half of the way up at that, half down.
    let solution = solve(&Lift::default(), 4, &Settings::default());
    assert_eq!(solution.status, Status::Solved);
    close(solution.horizon, 2.0 * (12.0_f64 / 3.0).sqrt());
    let motion = solution.motion.as_ref().unwrap();
    for force in &motion.trajectory.contact_force {
        assert!((489.999..=910.001).contains(&force[0]), "{force:?}");
    }
    let excess = most_exceeded(&solution);
    assert!(excess < 1e-6, "{excess}");
    // Who bears more is lifted by up to 11 m/s^2 and braked by 3, over times as 3 to 11.
    let lift = Lift {
        most: 1470.0,
        ..Lift::default()
    };
    let solution = solve(&lift, 14, &Settings::default());
    let (up, down) = (11.0_f64, 3.0);
    close(
        solution.horizon,
        (2.0 * 12.0 * (up + down) / (up * down)).sqrt(),
    );
}

hangtime::model! {
    /// A passenger whom the floor is to press little.
    Comfort {
        parameters { m: kg = 3, cabin: kg = 5, g: m/s^2 = 10, far: m = 2 }
        coordinates { h: m, y: m }
        controls { u: N in 0..=200 }
        lagrangian cabin/2*dot(h)^2 + m/2*dot(y)^2 - (cabin*h + m*y)*g
        forces { h: u }
        surface floor: y >= h
        impact floor: inelastic
        minimize integral(force(floor)^2)
        finally { h == far, dot(h) == 0 }
        horizon 2 [s]
    }
}

#[test]
fn integral_of_the_squared_force_on_a_passenger_is_that_of_the_closed_form() {
    // A cabin that is not pulled down never leaves its passenger. One that may be throws the passenger up and catches by an impact, which
    // has no force: then there is no least value but zero, to which no motion leads.
    let intervals = 6;
    let solution = solve(&Comfort::default(), intervals, &Settings::default());
    // `force = m (g + a)`; the integral of `a` vanishes, that of `a^2` is `12 d^2 / T^3 / (1 - 1/N^2)` with accelerations that
    // are constant on intervals.
    let (d, t) = (2.0_f64, 2.0_f64);
    let accelerations = 12.0 * d * d / t.powi(3) / (1.0 - 1.0 / (intervals * intervals) as f64);
    close(solution.objective, 9.0 * (accelerations + 100.0 * t));
}

hangtime::model! {
    /// A box on a cart, held by friction, whose force is to be small; the cart is as light as a feather or not.
    Carried {
        parameters { m: kg = 2, cart: kg = 1, g: m/s^2 = 10, mu = 0.9, far: m = 1 }
        coordinates { x: m, y: m, z: m }
        controls { u: N }
        lagrangian cart/2*dot(x)^2 + m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { x: u }
        surface deck: z >= 0
        impact deck: inelastic, friction mu, sliding dot(y) - dot(x)
        minimize integral(friction_force(deck)^2)
        finally { x == far, dot(x) == 0 , y == far }
        horizon 1 [s]
    }
}

#[test]
fn integral_of_the_squared_friction_that_carries_a_box_is_that_of_the_closed_form() {
    let intervals = 5;
    let solution = solve(&Carried::default(), intervals, &Settings::default());
    assert_eq!(solution.status, Status::Solved);
    // The friction is `m a` of the box; from rest to rest, as in the test above.
    let sticks = 4.0 * 12.0 / (1.0 - 1.0 / (intervals * intervals) as f64);
    assert!(
        solution.objective < sticks * (1.0 + DIGITS),
        "{} {sticks}",
        solution.objective
    );
    close(solution.objective, sticks);
}

hangtime::model! {
    /// A lander that is to be down soon, on legs that bear only so much.
    Lander {
        parameters { m: kg = 2, g: m/s^2 = 10, bearable: N s = 10, height: m = 12.5 }
        coordinates { z: m }
        controls { u: N in 0..=30 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface ground: z >= 0
        impact ground: inelastic
        minimize time
        constraint soft: impulse(ground) <= bearable
        finally { z == 0, dot(z) == 0 }
        start { z: height }
        horizon 2 [s]
    }
}

#[test]
fn lander_on_legs_that_bear_an_impulse_lands_with_it_in_least_time() {
    // A second of fall, `v = 10`, and one of the engine, which brakes by 5 m/s^2, to `m v = 10 N s`: 5 m + 7.5 m.
    let solution = solve(&Lander::default(), 2, &Settings::default());
    assert_eq!(solution.status, Status::Solved);
    close(solution.horizon, 2.0);
    close(solution.controls[0][0], 0.0);
    close(solution.controls[1][0], 30.0);
    let motion = solution.motion.unwrap();
    close(motion.events[0].v_before[0], -5.0);
    close(motion.trajectory.v.last().unwrap()[0], 0.0);
    // Legs that bear everything: it falls.
    let lander = Lander {
        bearable: 1e3,
        ..Lander::default()
    };
    let solution = solve(&lander, 2, &Settings::default());
    close(solution.horizon, (2.0 * 12.5_f64 / 10.0).sqrt());
}

hangtime::model! {
    /// A ball that is thrown down so hard that its bounces have this sum of squared impulses.
    Thrown {
        parameters { m: kg = 2, g: m/s^2 = 10, e = 0.5, total: kg^2 m^2/s^2 = 405 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        minimize dot(z)^2
        finally { sum(impulse(floor)^2) == total }
        free { dot(z) in -10..=0 }
        start { z: 1 [m], dot(z): -3 [m/s] }
        horizon 1 [s]
    }
}

#[test]
fn sum_of_the_squared_impulses_of_two_bounces_tells_how_hard_a_ball_was_thrown() {
    // Thrown at 4 m/s it strikes with 6 and 3 m/s, by `(1 + e) m v` each: `9 (36 + 9)`.
    let solution = solve(&Thrown::default(), 3, &Settings::default());
    let motion = solution.motion.unwrap();
    close(motion.trajectory.v[0][0], -4.0);
    assert_eq!(solution.planned_events.len(), 2);
}

hangtime::model! {
    /// A ball whose bounce is to be gentle, and to take it high up.
    Gentle {
        parameters { m: kg = 2, g: m/s^2 = 10, e = 0.5, worth: N^2 s^2/m = 30 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        minimize sum(impulse(floor)^2) - worth*z
        free { dot(z) in -10..=0 }
        start { z: 1 [m], dot(z): -3 [m/s] }
        horizon 0.6 [s]
    }
}

#[test]
fn gentle_bounce_that_takes_a_ball_high_up_is_the_best_of_all_throws() {
    // Of a throw at speed `w`: one bounce, its impulse, and the height after it.
    let cost = |w: f64| {
        let strike = (w * w + 20.0).sqrt();
        let left = 0.6 - (strike - w) / 10.0;
        let height = 0.5 * strike * left - 5.0 * left * left;
        (3.0 * strike).powi(2) - 30.0 * height
    };
    let throws = (0..=1_000_000).map(|k| 1e-5 * k as f64);
    let best = throws.map(cost).fold(f64::INFINITY, f64::min);
    let solution = solve(&Gentle::default(), 2, &Settings::default());
    assert!(
        (solution.objective - best).abs() < 1e-6,
        "{} {best}",
        solution.objective
    );
}

hangtime::model! {
    /// A stamp that is to press on a sheet at the end.
    Stamp {
        parameters { m: kg = 1, g: m/s^2 = 10, wanted: N = 25 }
        coordinates { z: m }
        controls { u: N in -100..=100 }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: -u }
        surface sheet: z >= 0
        impact sheet: inelastic
        minimize integral(u^2)
        finally { force(sheet) == wanted }
        horizon 2 [s]
    }
}

#[test]
fn force_that_is_asked_for_at_the_end_acts_in_the_last_interval_only() {
    let solution = solve(&Stamp::default(), 4, &Settings::default());
    close(solution.objective, 15.0 * 15.0 * 0.5);
    close(solution.controls[3][0], 15.0);
}

hangtime::model! {
    /// A cart on a dry rail, whose wear is the time over which it slips.
    Rail {
        parameters { m: kg = 1, f: N = 2, far: m = 3 }
        coordinates { y: m }
        controls { u: N in -6..=6 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        dry friction rail: bound f, sliding dot(y)
        minimize integral(friction_force(rail)^2)
        finally { y == far, dot(y) == 0 }
        horizon 1.5 [s]
    }
}

#[test]
fn wear_of_a_rail_is_the_square_of_its_friction_over_the_time_of_slip() {
    // Driven by 6 - 2 N for a second and braked by 6 + 2 N for half of one: there is no time to rest.
    let solution = solve(&Rail::default(), 3, &Settings::default());
    close(solution.objective, 4.0 * 1.5);
}

hangtime::model! {
    /// A puck that is thrown far over rough ground, which may only pull so hard at it.
    Puck {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, most: N s = 2.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface ground: z >= 0
        impact ground: inelastic, friction mu, sliding dot(y)
        minimize -y
        constraint scratch: friction_impulse(ground) >= -most
        free { dot(z) in -4..=4 }
        start { z: 0.8, dot(y): 5, dot(z): 1 }
        horizon 1 [s]
    }
}

#[test]
fn friction_impulse_of_a_landing_limits_how_high_a_puck_is_thrown() {
    // It slips, so that friction takes `mu m v = 2.5 N s` of a landing at 5 m/s, after a throw at 3 m/s and 0.8 s.
    let solution = solve(&Puck::default(), 2, &Settings::default());
    close(solution.motion.as_ref().unwrap().trajectory.v[0][1], 3.0);
    let far = 5.0 * 0.8 + (5.0 - 1.25) * 0.2 - 0.25 * 10.0 * 0.2 * 0.2 / 2.0;
    close(solution.objective, -far);
}

hangtime::model! {
    /// A bob slides through a bowl, which bears so much.
    Bowl {
        parameters { m: kg = 1, g: m/s^2 = 10, c: 1/m = 0.5, most: N = 35 }
        coordinates { y: m, z: m }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface bowl: z >= c*y^2
        impact bowl: inelastic
        minimize time
        constraint strong: force(bowl) <= most
        constraint down: force(bowl) >= 1 [N]
        finally { y == 1 [m] }
        free { dot(y) in 0.5..=6, dot(z) in -6..=-0.5 }
        start { y: -1, z: 0.5, dot(y): 2, dot(z): -2 }
    }
}

#[test]
fn force_at_the_bottom_of_a_bowl_between_the_stages_limits_the_speed_of_a_bob() {
    // At the bottom `force = m (g + 2 c v^2)`, so that `v^2 = 25`; half a metre higher `v^2 = 15`, along a slope of one.
    let mut settings = one_start();
    settings.elements = 5;
    let solution = attempt(&Bowl::default(), 5, &settings);
    assert_eq!(solution.status, Status::Solved);
    let motion = solution.motion.unwrap();
    // Between its stages a force is the cubic through them: on 25 elements good to five digits.
    let start = 7.5_f64.sqrt();
    assert!(
        (motion.trajectory.v[0][0] - start).abs() < 1e-5 * start,
        "{:?}",
        motion.trajectory.v[0]
    );
    let forces = motion
        .trajectory
        .contact_force
        .iter()
        .map(|forces| forces[0]);
    let largest = forces.fold(0.0, f64::max);
    assert!((34.9..35.001).contains(&largest), "{largest}");
}

hangtime::model! {
    /// A hammer that strikes a block on the floor, which is to be struck no harder than this.
    Hammer {
        parameters { block: kg = 3, hammer: kg = 2, g: m/s^2 = 10, e = 0.5, most: N s = 15 }
        coordinates { y: m, z: m }
        lagrangian block/2*dot(y)^2 + hammer/2*dot(z)^2 - g*(block*y + hammer*z)
        surface ground: y >= 0
        surface top: z - y >= 0
        impact ground, top: restitution e
        minimize sum(impulse(ground)) - sum(2*impulse(top))
        constraint soft: (impulse(ground) + impulse(top))/2 <= most
        free { dot(z) in -10..=0 }
        start { z: 0.45, dot(z): -1 }
        horizon 0.2 [s]
    }
}

#[test]
fn impulses_of_contacts_that_strike_together_are_told_apart() {
    // The block does not move, so both impulses are `hammer (1 + e) v`, at most 15: 5 m/s after 0.45 m from 4 m/s.
    let solution = solve(&Hammer::default(), 2, &Settings::default());
    close(solution.objective, -15.0);
    close(solution.motion.unwrap().trajectory.v[0][1], -4.0);
}

hangtime::model! {
    /// A motorcycle brakes as hard as the load allows that its rear wheel is to keep.
    Motorcycle {
        parameters { m: kg = 200, inertia: kg m^2 = 40, g: m/s^2 = 10, b: m = 0.7, h: m = 0.6, least: N = 200 }
        coordinates { y: m, z: m, a: rad }
        controls { u: kN in 0..=3 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + inertia/2*dot(a)^2 - m*g*z
        forces { y: -u, a: -u*h }
        surface rear: z - b*sin(a) >= h*cos(a)
        surface front: z + b*sin(a) >= h*cos(a)
        impact rear, front: inelastic
        minimize time
        constraint steered: force(rear) >= least
        finally { dot(y) == 0 }
        start { z: 0.6, dot(y): 14 }
        horizon 2 [s]
    }
}

#[test]
fn motorcycle_brakes_as_hard_as_the_least_load_of_its_rear_wheel_allows() {
    // The moments about the centre of mass: `rear = (m g - u h / b) / 2`, so that `u = 1600 N b / h`.
    let solution = solve(&Motorcycle::default(), 4, &one_start());
    close(solution.horizon, 14.0 * 200.0 / (1600.0 * 0.7 / 0.6));
}

hangtime::model! {
    /// A mass is let down with little effort and softly.
    LetDown {
        parameters { m: kg = 1, g: m/s^2 = 10, w: 1/s = 3 }
        coordinates { z: m }
        controls { u: N }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: inelastic
        minimize integral(u^2) + w*sum(impulse(floor)^2)
        finally { z == 0 }
        start { z: 1 }
        horizon 1 [s]
    }
}

/// Least effort and impulse of a landing after a time `tau`: the control is a line over time, `a + b t`.
fn landing(tau: f64) -> f64 {
    let cost = |b: f64| {
        let a = (5.0 * tau * tau - 1.0 - b * tau.powi(3) / 6.0) * 2.0 / (tau * tau);
        let v = -10.0 * tau + a * tau + b * tau * tau / 2.0;
        a * a * tau + a * b * tau * tau + b * b * tau.powi(3) / 3.0 + 3.0 * v * v
    };
    // A parabola in `b`, through three of its points.
    let (left, middle, right) = (cost(-1.0), cost(0.0), cost(1.0));
    let (slope, bend) = ((right - left) / 2.0, left + right - 2.0 * middle);
    cost(-slope / bend)
}

#[test]
fn effort_and_impulse_of_a_landing_are_weighed_against_each_other() {
    let times = (3000..=10_000).map(|k| 1e-4 * f64::from(k));
    let best = times.map(landing).fold(f64::INFINITY, f64::min);
    // Controls that are constant on intervals can only do worse: a landing inside an interval wastes the rest of its effort,
    // so that each node near the best time is a local optimum.
    let solution = attempt(&LetDown::default(), 20, &Settings::default());
    assert_eq!(solution.status, Status::Solved);
    let excess = solution.objective / best - 1.0;
    assert!((0.0..0.02).contains(&excess), "{excess}");
    // What it says that it costs is what its controls and its landing cost.
    let effort: f64 = solution.controls.iter().map(|u| u[0] * u[0] / 20.0).sum();
    let motion = solution.motion.unwrap();
    let landing = motion
        .events
        .iter()
        .find(|event| event.kind == EventKind::Impact);
    let strike = landing.unwrap().v_before[0];
    close(solution.objective, effort + 3.0 * strike * strike);
}

/// Solves by the time-freezing program and returns by how much the objective of its exact solution differs from the closed form, which
/// that of the motion polished from it has to be.
fn frozen(model: &dyn Model, intervals: usize, closed_form: f64) -> f64 {
    let solution = solve(model, intervals, &time_freezing());
    close(solution.objective, closed_form);
    let report = solution.time_freezing.as_ref().unwrap();
    assert!(report.left_out.is_empty(), "{report:?}");
    assert_eq!(report.residuals.complementarity, 0.0);
    (report.objective - closed_form).abs() / closed_form.abs().max(1.0)
}

/// The exact program has forces in its phases and impulses in its jumps. Accelerations are constant or linear, so that two stages
/// are exact, and what is left is the last barrier parameter.
#[test]
fn time_freezing_has_the_forces_and_impulses_of_the_closed_forms() {
    let comfort = 9.0 * (6.0 / (1.0 - 1.0 / 36.0) + 200.0);
    let motorcycle = 14.0 * 200.0 / (1600.0 * 0.7 / 0.6);
    let differences = [
        frozen(&Lift::default(), 4, 4.0),
        frozen(&Comfort::default(), 6, comfort),
        frozen(&Lander::default(), 2, 2.0),
        frozen(&Stamp::default(), 4, 15.0 * 15.0 * 0.5),
        frozen(&Motorcycle::default(), 4, motorcycle),
        frozen(&Puck::default(), 4, -4.7),
        frozen(&Thrown::default(), 3, 0.25),
    ];
    assert!(differences.iter().all(|d| *d < 1e-8), "{differences:?}");
}
