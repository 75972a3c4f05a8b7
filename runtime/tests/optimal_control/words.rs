//! The search over words: optima that depend on when impacts happen, which no control interval tells beforehand.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::ocp::{Problem, Settings, Solution, Status, solve};

hangtime::model! {
    /// A ball that bounces is helped by an upward force, weaker than its weight, until it reaches a height in least time.
    Driven {
        parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.75, h: m = 0.8, goal: m = 1.5, most: N = 11 }
        coordinates { z: m }
        controls { u: N in 0..=most }
        lagrangian m/2*dot(z)^2 - m*g*z
        forces { z: u }
        surface floor: z >= 0
        impact floor: restitution e
        minimize time
        finally { z == goal }
        start { z: h }
        horizon 3 [s]
    }
}

hangtime::model! {
    /// A ram that is too weak to push a pile drives it in by blows.
    Ram {
        parameters { m: kg = 1.5, pile: kg = 2.5, tight: N = 55, depth: m = 0.03 }
        coordinates { a: m in -0.2..=1, b: m }
        controls { u: N in -14..=14 }
        lagrangian m/2*dot(a)^2 + pile/2*dot(b)^2
        forces { a: u }
        surface head: b >= a
        impact head: inelastic
        dry friction soil: bound tight, sliding dot(b)
        minimize time
        finally { b == depth }
        horizon 2 [s]
    }
}

fn by_words(model: &dyn hangtime::model::Model, intervals: usize) -> Solution {
    let problem = Problem::of(model, intervals);
    solve(model, &problem, &Settings::default(), &mut |_| true).unwrap()
}

/// Time in which the ball reaches its goal if it is helped whenever it rises: each bounce adds the work of the force over the rise, and
/// no help while it falls keeps the blow strong. Controls that switch at any time can do it, so that their best takes no longer.
fn helped_while_rising(ball: &Driven) -> f64 {
    let lifted = ball.g - ball.most / ball.m;
    let mut time = (2.0 * ball.h / ball.g).sqrt();
    let mut speed = ball.e * ball.g * time;
    for _ in 0..100 {
        let reach = speed * speed - 2.0 * lifted * ball.goal;
        if reach >= 0.0 {
            return time + (speed - reach.sqrt()) / lifted;
        }
        let height = speed * speed / (2.0 * lifted);
        let fall = (2.0 * height / ball.g).sqrt();
        time += speed / lifted + fall;
        speed = ball.e * ball.g * fall;
    }
    f64::NAN
}

#[test]
fn ball_is_driven_to_its_height_by_as_many_bounces_as_the_closed_form_takes() {
    let ball = Driven::default();
    let solution = by_words(&ball, 40);
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    let bound = helped_while_rising(&ball);
    // Controls that are constant on 40 equal intervals switch at most half an interval from where the closed form does, a few times.
    let interval = solution.horizon / 40.0;
    assert!(
        solution.objective < bound + interval,
        "{} {bound}",
        solution.objective
    );
    assert!(solution.resimulation_error < 1e-6);
    // A plan that does with one bounce less would have to be helped by more than the force can.
    let impacts = solution.planned_events.len();
    assert!(impacts >= 2, "{impacts}");
}

#[test]
fn pile_is_driven_in_by_blows_and_the_plan_is_confirmed() {
    let ram = Ram::default();
    let coarse = by_words(&ram, 12);
    assert_eq!(coarse.status, Status::Solved, "{:?}", coarse.diagnosis());
    assert!(coarse.resimulation_error < 1e-6);
    // The work of the force over two strokes of the ram is less than the pile takes: the blows lose most of it.
    let strokes = 2.0 * ram.tight * ram.depth / (14.0 * 0.2);
    assert!(strokes > 1.0);
    let end = coarse.motion.unwrap();
    let end = end.at(coarse.horizon).unwrap();
    assert!((end["b"] - ram.depth).abs() < 1e-6, "{}", end["b"]);
}

hangtime::model! {
    /// A hand shoves a puck towards a line that the hand must not pass; the puck slides on over a rough floor.
    Shove {
        parameters { mu = 0.15, g: m/s^2 = 9.81, most: N = 60 }
        coordinates { hand: m, y: m, z: m }
        controls { u: N in -most..=most }
        lagrangian 1[kg]/2*dot(hand)^2 + 3[kg]*(dot(y)^2 + dot(z)^2) - 6[kg]*g*z
        forces { hand: u }
        surface grip: y - hand >= 0
        surface floor: z >= 0
        surface line: hand <= 0.7[m]
        impact grip: inelastic
        impact floor: inelastic, friction mu, sliding dot(y)
        impact line: inelastic
        minimize integral(u^2)
        finally { y == 2.5[m] }
        start { hand: -0.3 [m] }
        horizon 3 [s]
    }
}

hangtime::model! {
    /// A pole on a cart between two walls is swung up.
    Between {
        parameters { l: m = 0.5, g: m/s^2 = 9.81, wall: m = 0.4 }
        coordinates { y: m, theta }
        controls { u: N in -20..=20 }
        let bob = (y + l*sin(theta), -l*cos(theta))
        lagrangian 1[kg]/2*dot(y)^2 + 0.15[kg]*|dot(bob)|^2 - 0.3[kg]*g*bob.z
        forces { y: u }
        surface left: y >= -wall
        surface right: y <= wall
        impact left, right: inelastic
        minimize integral(u^2)
        finally { y == 0, theta == pi, dot(y) == 0, dot(theta) == 0 }
        horizon 2.4 [s]
    }
}

#[test]
fn bounds_that_no_control_comes_near_do_not_change_the_optimum() {
    let near = by_words(&Shove::default(), 10);
    assert_eq!(near.status, Status::Solved, "{:?}", near.diagnosis());
    for most in [120.0, 300.0, 4000.0] {
        let far = Shove {
            most,
            ..Shove::default()
        };
        let far = by_words(&far, 10);
        assert_eq!(far.status, Status::Solved, "{most}: {:?}", far.diagnosis());
        let largest = far.controls.iter().flatten();
        let largest = largest.fold(0.0_f64, |most, u| most.max(u.abs()));
        assert!(largest < 50.0, "{most}: {largest}");
        let difference = (near.objective - far.objective).abs();
        assert!(
            difference < 1e-6 * near.objective,
            "{most}: {} {}",
            near.objective,
            far.objective
        );
    }
}

#[test]
fn wall_that_is_away_at_the_start_holds_nothing_before_it_is_struck() {
    let cart = Between::default();
    let words = by_words(&cart, 10);
    assert_eq!(words.status, Status::Solved, "{:?}", words.diagnosis());
    let mut single = Settings::default();
    single.starts = Some(1);
    let problem = Problem::of(&cart, 10);
    let single = solve(&cart, &problem, &single, &mut |_| true).unwrap();
    assert!(
        words.objective <= single.objective * (1.0 + 1e-7),
        "{} {}",
        words.objective,
        single.objective
    );
}

hangtime::model! {
    /// A stone on ice whose friction is lessened by sweeping comes to rest in the house.
    Swept {
        parameters { m: kg = 1, f: N = 2.4, v0: m/s = 3.2, d: m = 3.2 }
        coordinates { x: m }
        controls { u: N in 0..=2 }
        lagrangian m/2*dot(x)^2
        forces { x: u }
        dry friction ice: bound f, sliding dot(x)
        minimize integral(u^2)
        finally { x == d, dot(x) == 0 }
        start { dot(x): v0 }
        horizon 4 [s]
    }
}

#[test]
fn stone_that_misses_the_house_at_a_low_price_comes_to_rest_there() {
    let stone = Swept::default();
    let solution = by_words(&stone, 8);
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    // Swept by a constant force it rests after 2 d/v0 = 2 s, the end of the fourth interval.
    let stops = 2.0 * stone.d / stone.v0;
    let force = stone.f - stone.m * stone.v0 / stops;
    let constant = force * force * stops;
    assert!(
        solution.objective < constant * (1.0 + 1e-9),
        "{} {constant}",
        solution.objective
    );
    // With any controls the force falls linearly to none at the end: d = v0 t/3 + f t^2/(6 m), and its slope is 2 (f t - m v0)/t^2.
    let (a, b) = (stone.f / (6.0 * stone.m), stone.v0 / 3.0);
    let time = ((b * b + 4.0 * a * stone.d).sqrt() - b) / (2.0 * a);
    let slope = 2.0 * (stone.f * time - stone.m * stone.v0) / (time * time);
    let least = slope * slope * time.powi(3) / 3.0;
    assert!(solution.objective > least, "{} {least}", solution.objective);
}
