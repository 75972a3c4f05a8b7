//! Motions whose best order of impacts no single guess leads to, against brute force over what is free.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::root::root;
use crate::support::{attempt, one_start, solve};
use hangtime::ocp::{Settings, Status};

hangtime::model! {
    /// A ball on a lift: how high it is dropped is free, and it should rise as fast as can be where it is caught.
    Dropped {
        parameters { g = 9.81, e = 0.8, caught = 0.4, soonest = 1.5, latest = 3 }
        coordinates { z }
        lagrangian dot(z)^2/2 - g*z
        surface floor: z >= 0
        impact floor: restitution e
        minimize -dot(z)
        finally { z == caught, time >= soonest, time <= latest }
        free { z in 0.3..=2 }
        start { z: 1 }
        horizon 2
    }
}

/// Speed with which the ball rises through its place after so many bounces, if that is in time.
fn rising(model: &Dropped, height: f64, bounces: i32) -> Option<f64> {
    let struck = (2.0 * model.g * height).sqrt();
    let flights: f64 = (1..bounces)
        .map(|k| 2.0 * struck * model.e.powi(k) / model.g)
        .sum();
    let up = struck * model.e.powi(bounces);
    let speed = (up * up - 2.0 * model.g * model.caught).sqrt();
    let time = struck / model.g + flights + (up - speed) / model.g;
    (speed >= 0.0 && (model.soonest..=model.latest).contains(&time)).then_some(speed)
}

#[test]
fn ball_rises_fastest_after_two_bounces_from_the_greatest_height() {
    let model = Dropped::default();
    let heights = (0..=100_000).map(|k| 0.3 + 1.7e-5 * f64::from(k));
    let speeds =
        heights.flat_map(|z| (1..8).filter_map(move |n| rising(&Dropped::default(), z, n)));
    let best = speeds.fold(0.0, f64::max);
    let intervals = 10;
    let solution = solve(&model, intervals, &Settings::default());
    assert!(
        (solution.objective + best).abs() < 1e-6,
        "{}: {best}",
        solution.objective
    );
    assert_eq!(solution.planned_events.len(), 2);
}

hangtime::model! {
    /// A ball is hit against an elastic wall and has to come back with the least energy, by way of the floor or not.
    Hit {
        parameters { g = 9.81, e = 0.8, far = 3, latest = 2 }
        coordinates { y, z }
        lagrangian |dot((y, z))|^2/2 - g*z
        surface wall: y <= far
        surface floor: z >= 0
        impact wall: restitution 1
        impact floor: restitution e
        minimize (dot(y)^2 + dot(z)^2)/2
        finally { y == 0, z == 1, dot(y) <= 0, time <= latest }
        free { dot(y) in 1..=12, dot(z) in -6..=12 }
        start { z: 1, dot(y): 5, dot(z): 4 }
        horizon 1.3
    }
}

/// Least energy of a ball that is back at its height after so many bounces on the floor, where it is hit with `up`.
fn back(model: &Hit, up: f64, bounces: i32) -> Option<f64> {
    let g = model.g;
    if bounces == 0 {
        let time = 2.0 * up / g;
        return energy(model, time, up);
    }
    let struck = (up * up + 2.0 * g).sqrt();
    let flights: f64 = (1..bounces)
        .map(|k| 2.0 * struck * model.e.powi(k) / g)
        .sum();
    let rise = struck * model.e.powi(bounces);
    let speed = (rise * rise - 2.0 * g).sqrt();
    let so_far = (up + struck) / g + flights;
    let on_the_way = [(rise - speed) / g, (rise + speed) / g];
    let found = on_the_way
        .into_iter()
        .filter_map(|more| energy(model, so_far + more, speed));
    found.reduce(f64::min)
}

/// Energy of a ball that takes that time for the way to the wall and back.
fn energy(model: &Hit, time: f64, rate: f64) -> Option<f64> {
    let along = 2.0 * model.far / time;
    let allowed = time > 0.0 && time <= model.latest && (1.0..=12.0).contains(&along);
    (allowed && rate.is_finite()).then_some((along * along + rate * rate) / 2.0)
}

/// The wall is struck half-way, which is a node of every even number of intervals.
#[test]
fn ball_comes_back_from_a_wall_by_way_of_the_floor() {
    let model = Hit::default();
    let speeds = (0..=180_000).map(|k| -6.0 + 1e-4 * f64::from(k));
    let energies = speeds.flat_map(|up| (0..6).filter_map(move |n| back(&Hit::default(), up, n)));
    let best = energies.fold(f64::INFINITY, f64::min);
    let intervals = 10;
    let solution = solve(&model, intervals, &Settings::default());
    // The brute force is coarser than the optimum: an error of its first order in steps of 1e-4.
    let excess = solution.objective - best;
    assert!(
        (-1e-3..1e-6).contains(&excess),
        "{}: {best}",
        solution.objective
    );
    assert_eq!(solution.planned_events.len(), 3);
    // The motion is that on one interval, stated on those asked for.
    assert_eq!(solution.controls.len(), intervals);
    assert_eq!(solution.elements.len(), intervals);
}

hangtime::model! {
    /// A ball is served against a wall and met on its way back; nobody serves faster than this.
    Served {
        parameters { g = 9.81, e = 0.7, far = 4, near = 0.5, most = 12 }
        coordinates { y, z }
        lagrangian |dot((y, z))|^2/2 - g*z
        surface wall: y <= far
        surface floor: z >= 0
        impact wall, floor: restitution e
        minimize time
        constraint speed: dot(y)^2 + dot(z)^2 <= most^2
        finally { y == near, z == 1, dot(y) <= 0 }
        free { dot(y) in 2..=12, dot(z) in -4..=10 }
        start { z: 1, dot(y): 8, dot(z): 3 }
        horizon 1.5
    }
}

/// What is free at the start is limited there, before the first stage.
#[test]
fn speed_of_a_serve_is_limited_at_its_very_start() {
    let model = Served::default();
    // `T = way/v` with `v^2 + (g T/2)^2 = most^2`.
    let way = model.far + (model.far - model.near) / model.e;
    let (a, b, c) = (model.g.powi(2) / 4.0, model.most.powi(2), way.powi(2));
    let time = ((b - (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)).sqrt();
    let intervals = 4;
    let solution = solve(&model, intervals, &Settings::default());
    assert!(
        (solution.objective - time).abs() < 1e-7,
        "{}: {time}",
        solution.objective
    );
}

hangtime::model! {
    /// A table throws a ball as high as it can.
    Thrower {
        parameters { m = 0.1, table = 1, g = 9.81, e = 0.8 }
        coordinates { h in -0.3..=0.3, z }
        controls { u in -20..=40 }
        lagrangian table/2*dot(h)^2 + m/2*dot(z)^2 - m*g*z - table*g*h
        forces { h: u }
        surface top: z >= h
        impact top: restitution e
        minimize -z
        start { z: 0.5 }
        horizon 2
    }
}

/// Random orders of impacts, each solved by itself with bounds at nine places of a phase (CasADi and IPOPT, 150 s), come to 5.5692 m.
/// Starts here end at 3.6 m and less, whose neighbours lead to 5.22 m first.
#[test]
fn table_throws_a_ball_as_high_as_random_orders_of_impacts_do() {
    let solution = attempt(&Thrower::default(), 8, &Settings::default());
    assert_eq!(solution.status, Status::Solved);
    let height = -solution.objective;
    assert!((5.5595..5.5692).contains(&height), "{height}");
}

hangtime::model! {
    /// A hammer drives a nail into wood in least time, from which the guess of the time is far.
    Nail {
        parameters { hammer: kg = 0.5, nail: kg = 0.02, hold: N = 600, strength: N = 30, depth: m = 0.008 }
        coordinates { h: m in 0..=0.3, n: m }
        controls { u: N in -strength..=strength }
        lagrangian hammer/2*dot(h)^2 + nail/2*dot(n)^2
        forces { h: u }
        dry friction wood: bound hold, sliding dot(n)
        surface head: h >= n + 0.05[m]
        impact head: inelastic
        minimize time
        finally { n <= -depth, dot(n) == 0 }
        start { h: 0.1[m] }
        horizon 0.8[s]
    }
}

/// Least time of one blow: up with all force, with some on the interval in which the hammer has to be turned, and down with all of it.
fn blow(model: &Nail, intervals: f64) -> f64 {
    let both = model.hammer + model.nail;
    let slows = (model.hold - model.strength) / both;
    let after = (2.0 * slows * model.depth).sqrt();
    let (before, stops) = (after * both / model.hammer, after / slows);
    let most = model.strength / model.hammer;
    // Excess of the energy above the nail, with two intervals of that length before the one in which the hammer is turned.
    let excess = |length: f64| {
        let turned = most * ((intervals - 3.0) * length - stops) - before;
        let up = 2.0 * most * length;
        let height = 0.1 + up * length + (up + turned) / 2.0 * length;
        turned.powi(2) + 2.0 * most * (height - 0.05) - before.powi(2)
    };
    intervals * root(|length| -excess(length), 0.01, 0.02)
}

#[test]
fn nail_is_driven_by_one_blow_in_a_fifth_of_the_guessed_time() {
    let model = Nail::default();
    let mut settings = Settings::default();
    settings.starts = Some(1);
    let solution = solve(&model, 10, &settings);
    let best = blow(&model, 10.0);
    assert!(
        (solution.objective - best).abs() < 1e-8 * best,
        "{}: {best}",
        solution.objective
    );
}

hangtime::model! {
    /// A small ball falls behind a big one, which throws it up from the floor.
    Stack {
        parameters { big: kg = 0.6, small: kg = 0.06, g: m/s^2 = 9.81, e = 0.9 }
        coordinates { a: m, b: m }
        lagrangian big/2*dot(a)^2 + small/2*dot(b)^2 - g*(big*a + small*b)
        surface floor: a >= 0
        surface touch: b >= a
        impact floor: restitution e
        impact touch: restitution e
        minimize -b
        finally { time <= 2 [s] }
        start { a: 1 [m], b: 1.2 [m] }
        horizon 1.2 [s]
    }
}

/// Height to which the small ball rises: the big one strikes the floor, and comes towards the small one with 1.9 times that speed.
fn thrown(model: &Stack) -> f64 {
    let (g, e) = (model.g, model.e);
    let struck = (2.0 * g).sqrt();
    let closing = (1.0 + e) * struck;
    let later = 0.2 / closing;
    let height = e * struck * later - 0.5 * g * later * later;
    let (up, down) = (e * struck - g * later, -struck - g * later);
    let mass = model.big / (model.big + model.small);
    let speed = down + mass * (1.0 + e) * (up - down);
    height + speed * speed / (2.0 * g)
}

/// The big ball strikes the floor twice more on the way: what ends right before such a blow, and would rise on after it, is no optimum.
#[test]
fn motion_goes_on_after_blows_that_do_not_concern_what_is_thrown() {
    let model = Stack::default();
    let best = thrown(&model);
    for intervals in [4, 10] {
        let solution = solve(&model, intervals, &one_start());
        assert!(
            (solution.objective + best).abs() < 1e-8 * best,
            "{intervals}: {} instead of {}",
            solution.objective,
            -best
        );
        assert_eq!(solution.planned_events.len(), 4);
    }
}

hangtime::model! {
    /// A puck in a round rink with a post in the middle, to be on the other side of the post in least time.
    Rink {
        parameters { m: kg = 0.17, e = 0.8, r: m = 1, post: m = 0.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2
        surface board: r >= |(y, z)|
        surface post: |(y, z)| >= post
        impact board: restitution e
        impact post: restitution e
        minimize time
        finally { y == 0.5 [m], z == 0 }
        constraint fast: |dot((y, z))|^2 <= 1 [m^2/s^2]
        free { dot(y) in -1..=1, dot(z) in -1..=1 }
        start { y: -0.5 [m], dot(y): 0.4, dot(z): 0.7 }
        horizon 2.5 [s]
    }
}

/// By how much a puck at 1 m/s in this direction misses the goal after the board, and when it is nearest.
fn off_the_board(direction: f64) -> (f64, f64) {
    let (sin, cos) = direction.sin_cos();
    let until = 0.5 * cos + (0.25 * cos * cos + 0.75).sqrt();
    let (y, z) = (until * cos - 0.5, until * sin);
    let outwards = 1.8 * (cos * y + sin * z);
    let (u, w) = (cos - outwards * y, sin - outwards * z);
    let speed = u.hypot(w);
    let along = ((0.5 - y) * u - z * w) / speed;
    (((0.5 - y) * w + z * u) / speed, until + along / speed)
}

/// On ten intervals some neighbours are not decided; on one, which is enough as nothing is controlled, all are.
#[test]
fn puck_without_controls_is_certified_by_what_one_interval_proves() {
    let solution = solve(&Rink::default(), 10, &Settings::default());
    let direction = root(|direction| -off_the_board(direction).0, 0.8, 1.1);
    let (_, time) = off_the_board(direction);
    assert!(
        (solution.objective - time).abs() < 1e-8,
        "{} instead of {time}",
        solution.objective
    );
}
