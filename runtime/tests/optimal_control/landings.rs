//! Elastic contacts that come to rest: a plan says that they close, the motion bounces on for a moment.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::root::root;
use crate::support::{DIGITS, attempt, one_start, solve};
use hangtime::ocp::{Problem, Settings, Status, solve as solve_with};
use hangtime::simulation::EventKind;

hangtime::model! {
    /// A platform takes up an egg that falls, and both come to rest 0.3 m high.
    Egg {
        parameters { m: kg = 0.1, p: kg = 0.5, g: m/s^2 = 9.81, e = 0.2 }
        coordinates { z: m, y: m in -1..=1 }
        controls { u: N in -20..=20 }
        lagrangian m/2*dot(z)^2 + p/2*dot(y)^2 - m*g*z - p*g*y
        forces { y: u + p*g }
        surface plate: z >= y
        impact plate: restitution e
        outputs { given: N s = impulse(plate) }
        minimize integral(u^2)
        finally { z == 0.3[m], y == 0.3[m], dot(z) == 0[m/s], dot(y) == 0[m/s] }
        start { z: 1 [m] }
        horizon 2 [s]
    }
}

#[test]
fn landing_that_bounces_for_a_moment_is_confirmed() {
    let egg = Egg::default();
    let problem = Problem::of(&egg, 9);
    let solution = solve_with(&egg, &problem, &Default::default(), &mut |_| true).unwrap();
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    // The controls cost what the plan says, and the motion under them reaches the goals.
    let cost: f64 = solution
        .controls
        .iter()
        .map(|u| u[0] * u[0] * 2.0 / 9.0)
        .sum();
    assert!((cost - solution.objective).abs() < 1e-9 * cost, "{cost}");
    assert!(
        solution.resimulation_error < 1e-6,
        "{}",
        solution.resimulation_error
    );
    let motion = solution.motion.unwrap();
    let end = motion.at(solution.horizon).unwrap();
    for (name, goal) in [("z", 0.3), ("y", 0.3)] {
        assert!((end[name] - goal).abs() < 1e-6, "{name} {}", end[name]);
    }
    // It bounces, until the plate holds it.
    let impacts = motion
        .events
        .iter()
        .filter(|event| event.kind == EventKind::Impact);
    let impacts: Vec<_> = impacts.collect();
    assert!(impacts.len() > 3, "{:?}", motion.events);
    // Each impulse is the change of the momentum of the egg, and they add up.
    let mut sum = 0.0;
    for event in impacts {
        let jump = 0.1 * (event.v_after[0] - event.v_before[0]);
        assert!((event.contact_impulse[0] - jump).abs() < 1e-12, "{event:?}");
        sum += jump;
    }
    let given = motion["given"].last().unwrap();
    assert!((given - sum).abs() < 1e-11, "{given} {sum}");
    // To throw it up again costs more; so does to catch it slowly enough that it could not be pulled.
    assert!(solution.objective < 2.6144, "{}", solution.objective);
}

hangtime::model! {
    /// A ball that is to come to rest on the floor in time.
    Settling {
        parameters { g: m/s^2 = 10, e = 0.6, height: m = 0.3, within: s = 1 }
        coordinates { z: m }
        controls { u: N in -9..=9 }
        lagrangian 1[kg]/2*dot(z)^2 - 1[kg]*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: restitution e
        minimize integral(u^2)
        finally { z == 0, dot(z) == 0 }
        start { z: height }
        horizon within
    }
}

#[test]
fn ball_has_as_much_time_to_come_to_rest_as_its_bounces_take() {
    let solve = |ball: &Settling| {
        let problem = Problem::of(ball, 1);
        solve_with(ball, &problem, &Default::default(), &mut |_| true).unwrap()
    };
    // A fall of 0.245 s and bounces of 2 e/(1 - e) = 3 times that: by itself it rests after 0.98 s.
    let ball = Settling::default();
    let solution = solve(&ball);
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    assert!(solution.objective < 1e-9, "{}", solution.objective);
    // In 0.9 s it has to fall faster, with g + u = 2 h/(0.9 s/4)^2.
    let hasty = Settling {
        within: 0.9,
        ..Settling::default()
    };
    let solution = solve(&hasty);
    let force = 0.6 / 0.225_f64.powi(2) - 10.0;
    let effort = 0.9 * force * force;
    assert!(
        (solution.objective - effort).abs() < 1e-6 * effort,
        "{}",
        solution.objective
    );
    // It is the goal that it rests by then, and no plan may let it bounce on.
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
}

hangtime::model! {
    /// The same ball, which may still bounce a little in the end.
    NearlySettling {
        parameters { g: m/s^2 = 10, e = 0.6, height: m = 0.3, low: m = 0.001, slow: m/s = 0.001 }
        coordinates { z: m }
        controls { u: N in -9..=9 }
        lagrangian 1[kg]/2*dot(z)^2 - 1[kg]*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: restitution e
        minimize integral(u^2)
        finally { z <= low, dot(z) <= slow, -dot(z) <= slow }
        start { z: height }
        horizon 0.9 [s]
    }
}

#[test]
fn ball_that_may_bounce_on_a_little_needs_less_than_one_that_has_to_rest() {
    let solution = solve(&NearlySettling::default(), 1, &one_start());
    // Rest within 0.9 s takes the force of `ball_has_as_much_time_to_come_to_rest_as_its_bounces_take`.
    let force = 0.6 / 0.225_f64.powi(2) - 10.0;
    let resting = 0.9 * force * force;
    assert!(solution.objective < resting / 5.0, "{}", solution.objective);
}

hangtime::model! {
    /// A cart has to stop at a wall that returns a part of its speed, in least time.
    AtTheWall {
        parameters { e = 0.3, m: kg = 1 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        surface wall: y <= 3 [m]
        impact wall: restitution e
        minimize time
        finally { y == 3[m], dot(y) == 0 }
        horizon 3 [s]
    }
}

#[test]
fn cart_that_stops_at_an_elastic_wall_bounces_once_instead_of_coming_to_rest_by_its_bounces() {
    // From a transcription with the impact in a known interval: one bounce, after which it comes back with no speed. To rest by all
    // bounces together takes 3.4483 s, and to stop before the wall 3.4641 s.
    let cart = AtTheWall::default();
    let solution = solve(&cart, 20, &Settings::default());
    let known = 3.429_971_565_7;
    let off = (solution.objective - known).abs();
    assert!(off < DIGITS * known, "{}", solution.objective);
}

#[test]
fn egg_that_bounces_well_is_caught_with_its_first_bounces_by_themselves() {
    // To strike it three times costs 41.01, and to catch it with all of its bounces within an interval 15.70.
    let egg = Egg {
        e: 0.4,
        ..Egg::default()
    };
    let problem = Problem::of(&egg, 10);
    let solution = solve_with(&egg, &problem, &Default::default(), &mut |_| true).unwrap();
    assert!(solution.objective < 1.9345, "{}", solution.objective);
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.resimulation_error < DIGITS);
    let motion = solution.motion.unwrap();
    let impacts = motion.events.iter();
    let impacts = impacts.filter(|event| event.kind == EventKind::Impact);
    assert!(impacts.count() > 3);
}

hangtime::model! {
    /// A ball is dribbled: a hand presses it down, and it must be back at hand height in the end.
    Dribble {
        parameters { g: m/s^2 = 9.81, e = 0.75, height: m = 1 }
        coordinates { z: m }
        controls { press: m/s^2 in 0..=30 }
        lagrangian 1[kg]/2*dot(z)^2 - 1[kg]*g*z
        forces { z: -1[kg]*press }
        surface floor: z >= 0
        impact floor: restitution e
        minimize integral(press^2)
        finally { z == height, dot(z) == 0 [m/s] }
        start { z: height }
        horizon 3 [s]
    }
}

impl Dribble {
    /// Height and velocity at the end, and the number of impacts, by parabolas from control to control.
    fn end(&self, presses: &[f64]) -> (f64, f64, usize) {
        let (mut z, mut v, mut impacts) = (self.height, 0.0, 0);
        for press in presses {
            let (a, mut left) = (-self.g - press, 3.0 / presses.len() as f64);
            loop {
                let falls = (-v - f64::sqrt(v * v - 2.0 * a * z)) / a;
                if falls > left {
                    break;
                }
                (v, z) = (-self.e * (v + a * falls), 0.0);
                left -= falls;
                impacts += 1;
            }
            z += left * (v + 0.5 * a * left);
            v += a * left;
        }
        (z, v, impacts)
    }
}

#[test]
fn ball_is_dribbled_as_often_as_it_takes() {
    // A ball that nobody presses bounces lower and lower; with two impacts or three it cannot be back in time.
    let ball = Dribble::default();
    let problem = Problem::of(&ball, 20);
    let solution = solve_with(&ball, &problem, &Default::default(), &mut |_| true).unwrap();
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    let presses: Vec<f64> = solution.controls.iter().map(|u| u[0]).collect();
    let (z, v, impacts) = ball.end(&presses);
    assert_eq!(impacts, 4);
    assert!((z - 1.0).abs() < 1e-6 && v.abs() < 1e-5, "{z} {v}");
    let cost: f64 = presses.iter().map(|press| press * press * 0.15).sum();
    assert!((cost - solution.objective).abs() < 1e-9 * cost, "{cost}");
    assert!(cost < 73.951, "{cost}");
}

hangtime::model! {
    /// A boot kicks a ball that lies on a lawn, so that it is at a place and height at a given time.
    Kick {
        parameters { m: kg = 0.45, boot: kg = 3, g: m/s^2 = 9.81, e = 0.6, up: rad = 0.6 }
        coordinates { s: m in -1..=0.6, y: m, z: m }
        controls { u: N in -600..=600 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z + boot/2*dot(s)^2
        forces { s: u }
        surface toe: y*cos(up) + z*sin(up) >= s
        surface lawn: z >= 0
        impact toe: restitution e
        impact lawn: restitution 0.4
        minimize integral(u^2)
        finally { y == 8 [m], z == 0.5 [m] }
        start { s: -0.5 [m] }
        horizon 1.6 [s]
    }
}

#[test]
fn ball_is_kicked_off_the_lawn_when_it_is_time() {
    // It leaves at the angle of the boot: the height that is missing at the end says how long it flies, and with that when and
    // how fast it is kicked. The impact takes the weight off the lawn at the same instant.
    let kick = Kick::default();
    let slope = kick.up.tan();
    let flight = f64::sqrt(2.0 * (8.0 * slope - 0.5) / kick.g);
    let speed = 8.0 / flight / kick.up.cos();
    let solution = solve_with(
        &kick,
        &Problem::of(&kick, 10),
        &Default::default(),
        &mut |_| true,
    );
    let solution = solution.unwrap();
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    let motion = solution.motion.unwrap();
    let impact = |event: &&hangtime::simulation::Event| event.kind == EventKind::Impact;
    let struck = motion.events.iter().find(impact).unwrap();
    assert!(
        (struck.time - (1.6 - flight)).abs() < 1e-6,
        "{}",
        struck.time
    );
    let left = struck.v_after[1].hypot(struck.v_after[2]);
    assert!((left - speed).abs() < 1e-5, "{left} {speed}");
    // Newton's law for the boot, which is that much slower afterwards.
    let boot = speed * (kick.m + kick.boot) / ((1.0 + kick.e) * kick.boot);
    assert!(
        (struck.v_before[0] - boot).abs() < 1e-5,
        "{:?}",
        struck.v_before
    );
}

hangtime::model! {
    /// A ball that is dropped on a table bounces to rest there, over three control intervals, and is pushed off the table.
    Dropped {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 0.8, edge: m = 1, goal: m = 1.4, e = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -20..=20 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface table: max(z - height, y - edge) >= 0
        impact table: restitution e
        minimize integral(u^2)
        finally { y == goal }
        start { z: 1 [m] }
        horizon 1.3 [s]
    }
}

#[test]
fn ball_that_bounces_to_rest_over_several_intervals_is_pushed_with_the_least_effort_of_its_way() {
    let ball = Dropped::default();
    for intervals in [8, 10] {
        let solution = solve(&ball, intervals, &one_start());
        // The table never hinders the push: controls in proportion to the time that is left in the middle of each interval, of
        // which the sum of the squares is T^3 / 3 (1 - 1 / (4 N^2)).
        let squares = 1.3_f64.powi(3) / 3.0 * (1.0 - 0.25 / (intervals * intervals) as f64);
        let effort = (2.0 * 1.4_f64).powi(2) / squares;
        let off = (solution.objective - effort).abs() / effort;
        assert!(off < DIGITS, "{intervals}: {} {effort}", solution.objective);
    }
}

hangtime::model! {
    /// A ball that is dropped on a rough belt bounces to rest on it.
    OnTheBelt {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0.3, e = 0.5, belt: m/s = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -2..=2 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: restitution e, friction mu, sliding dot(y) - belt
        minimize integral(u^2)
        start { z: 0.8 [m] }
        horizon 1.5 [s]
    }
}

#[test]
fn ball_that_bounces_to_rest_sticks_to_the_belt_by_its_bounces_together() {
    let ball = OnTheBelt::default();
    for intervals in [7, 8, 11] {
        let solution = solve(&ball, intervals, &one_start());
        assert!(
            solution.objective < 1e-9,
            "{intervals}: {}",
            solution.objective
        );
        // It has the speed of the belt from the first impact on, at 0.4 s.
        let motion = solution.motion.unwrap();
        let end = motion.trajectory.q.last().unwrap()[0];
        assert!((end - 1.1).abs() < 1e-8, "{intervals}: {end}");
    }
}

hangtime::model! {
    /// A ball that is thrown sideways on a rough floor bounces to rest, slips, and is pulled to the goal.
    Slips {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0.3, e = 0.4 }
        coordinates { y: m, z: m }
        controls { u: N in -20..=20 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: restitution e, friction mu, sliding dot(y)
        minimize integral(u^2)
        finally { y == 2 [m], dot(y) == 0 [m/s] }
        start { z: 0.8 [m], dot(y): 1 [m/s] }
        horizon 2.5 [s]
    }
}

#[test]
fn bounces_before_a_planned_landing_are_not_counted_to_it() {
    // The one at 0.72 s is less than an interval from the rest, and a touch of the plan.
    let solution = solve(&Slips::default(), 10, &Default::default());
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
}

hangtime::model! {
    /// A puck is putted over a low hump, with the speed that it arrives slowest with. Where it starts the ground is level but for
    /// `4e-15`, so that rounding decides whether it strikes there.
    Putt {
        parameters { mu = 0.1, g = 9.81, a = 0.02 }
        coordinates { y, z }
        controls { u in -1e-3..=1e-3 }
        fn hill(y) = a*exp(-((y - 2)/0.35)^2)
        lagrangian |dot((y, z))|^2/2 - g*z
        forces { y: u }
        surface ground: z >= hill(y)
        impact ground: inelastic, friction mu
        minimize dot(y)^2
        finally { y == 4, time <= 4 }
        free { dot(y) in 0.5..=6 }
        start { z: hill(0), dot(y): 2.9 }
        horizon 3.2
    }
}

/// Square of the speed that a puck needs at `y = 0` to come to rest at `y = 4`, from `d(v^2)/dy` along the hump without controls.
fn needed(Putt { mu, g, a, .. }: &Putt) -> f64 {
    let slope = |y: f64, w: f64| {
        let x = (y - 2.0) / 0.35;
        let hill = a * (-x * x).exp();
        let (first, second) = (
            -2.0 * x * hill / 0.35,
            (4.0 * x * x - 2.0) * hill / 0.35 / 0.35,
        );
        let stretch = (1.0 + first * first).sqrt();
        let force = g / stretch + second / stretch.powi(3) * w;
        -2.0 * (mu * force * stretch + g * first)
    };
    let (steps, mut w) = (4000, 0.0);
    let h = -4.0 / f64::from(steps);
    for k in 0..steps {
        let y = 4.0 + h * f64::from(k);
        let a = slope(y, w);
        let b = slope(y + h / 2.0, w + h / 2.0 * a);
        let c = slope(y + h / 2.0, w + h / 2.0 * b);
        let d = slope(y + h, w + h * c);
        w += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    w
}

#[test]
fn puck_that_rounding_lets_strike_at_its_start_slides_from_there() {
    let putt = Putt::default();
    let solution = attempt(&putt, 10, &Settings::default());
    assert!(solution.status.is_solved() || solution.status == Status::Uncertified);
    assert!(solution.resimulation_error < 1e-6);
    // it can come to rest at the goal, and no square is less
    assert!(solution.objective < 1e-9, "{}", solution.objective);
    // the controls change v^2 by 2 u (y(T) - y(0)) at most
    let found = solution.motion.as_ref().unwrap().trajectory.v[0][0].powi(2);
    let needed = needed(&putt);
    assert!(
        (found - needed).abs() < 0.008,
        "{found} instead of {needed}"
    );
}

#[test]
fn start_into_the_ground_with_a_free_velocity_is_refused_with_the_remedy() {
    let putt = Putt::default();
    let falling = Problem {
        v: vec![2.9, -0.1],
        ..Problem::of(&putt, 10)
    };
    let refused = solve_with(&putt, &falling, &one_start(), &mut |_| true).unwrap_err();
    let refused = refused.to_string();
    let remedy =
        "start after the impact, or along the surface with all velocities free that follow it";
    assert!(
        refused.contains("initial normal velocity of `ground` = -0.1") && refused.contains(remedy),
        "{refused}"
    );
}

/// Time to `y = 4` of a frictionless puck with the square `w` of the speed on top of the hump, braked by `u`, by Simpson's rule.
fn duration(&Putt { g, a, .. }: &Putt, u: f64, w: f64) -> f64 {
    let slowness = |y: f64| {
        let x = (y - 2.0) / 0.35;
        let hill = a * (-x * x).exp();
        let stretch = (1.0 + (2.0 * x * hill / 0.35).powi(2)).sqrt();
        stretch / (w + 2.0 * g * (a - hill) - 2.0 * u * (y - 2.0)).sqrt()
    };
    let (steps, h) = (40_000, 1e-4);
    let weight = |k: i32| match k {
        0 => 1.0,
        k if k == steps => 1.0,
        k => f64::from(2 + 2 * (k % 2)),
    };
    let sum: f64 = (0..=steps)
        .map(|k| weight(k) * slowness(h * f64::from(k)))
        .sum();
    h / 3.0 * sum
}

#[test]
fn puck_on_ground_that_is_level_but_for_rounding_may_start_at_any_speed() {
    let putt = Putt {
        mu: 0.0,
        a: 0.2,
        ..Putt::default()
    };
    let solution = solve(&putt, 20, &Settings::default());
    // braked all the way, and just over the hump in the 4 s that it has
    let u = 1e-3;
    let energy = root(|w| duration(&putt, u, w) - 4.0, 1e-6, 1e-2);
    let slowest = energy + 2.0 * putt.g * putt.a - 2.0 * u * 2.0;
    let apart = (solution.objective - slowest).abs();
    assert!(
        apart < 1e-8 * slowest,
        "{} instead of {slowest}",
        solution.objective
    );
}

hangtime::model! {
    /// A lander drops with a side speed; fuel costs, and its legs bear a blow.
    Legged {
        parameters { m: kg = 50, g: m/s^2 = 1.62, bearable: N s = 75, most: N = 100, aside: N = 40, late: 1/s = 0.1 }
        coordinates { y: m, z: m }
        controls { side: N in -40..=40, up: N in 0..=160 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: side, z: up }
        surface ground: z >= 0
        impact ground: inelastic
        minimize integral(up/most + (side/aside)^2) + late*time*1 [s]
        constraint legs: impulse(ground) <= bearable
        finally { y == 0, z == 0, dot(y) == 0, dot(z) == 0 }
        start { y: -30 [m], z: 40 [m], dot(y): 3, dot(z): -2 }
        horizon 12 [s]
    }
}

#[test]
fn landing_after_full_thrust_is_certified_as_one_before_would_be_pulled_off() {
    // From a transcription of each order of contacts. The blow comes where an interval of full thrust ends, which would lift the lander off if it
    // stood already.
    let lander = Legged::default();
    let known = 9.499_475_769;
    let solution = solve(&lander, 10, &Settings::default());
    let off = (solution.objective - known).abs() / known;
    assert!(off < DIGITS, "{}", solution.objective);
}
