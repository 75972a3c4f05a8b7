//! Largest values in objectives and goals: `max`, `min`, `|x|` and `peak`, against closed forms.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

fn solved(text: &str, intervals: usize, controls: ControlShape) -> Solution {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let solution = solve(&scene)
        .intervals(intervals)
        .controls(controls)
        .run()
        .expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    // What the language adds is no part of the result.
    let controls = scene.declaration().controls.len();
    assert!(solution.controls.iter().all(|u| u.len() == controls));
    let motion = &solution.motion.as_ref().expect("a motion").trajectory;
    let n = scene.declaration().coordinates.len();
    assert!(motion.q.iter().all(|q| q.len() == n));
    solution
}

fn optimum(text: &str, intervals: usize) -> f64 {
    solved(text, intervals, ControlShape::Constant).objective
}

/// What the solver lets pass of values of the order of one.
const DIGITS: f64 = 1e-8;

fn close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < DIGITS, "{found} for {wanted}");
}

/// A mass that is brought from rest to rest over a way in a time.
fn moved(way: f64, time: f64, bounds: &str, judged: &str) -> String {
    format!(
        "parameters {{ m: kg = 1.3, way: m = {way} }} coordinates {{ x: m }} controls {{ u: N {bounds} }}
        lagrangian m/2*dot(x)^2 forces {{ x: u }} {judged} horizon {time} [s]"
    )
}

const AT_REST: &str = "finally { x == way, dot(x) == 0 }";

hangtime::model! {
    /// A cart that is brought past a place at a time with least fuel.
    Cart {
        coordinates { x: m }
        controls { u: N in -2..=2 }
        lagrangian dot(x)^2/2*1 [kg]
        forces { x: u }
        minimize integral(|u|) + peak(|u|)*2 [s]
        at 1 [s] { x >= 0.5 [m] }
        horizon 2 [s]
    }
}

#[test]
fn compiled_scene_has_largest_values_as_unknowns() {
    let cart = Cart::default();
    // 3/8 u_1 + u_2/8 = 1/2 on the two intervals before the time, and (u_1 + u_2)/2 + 2 max(u_1, u_2) is least where both are 1.
    let solution = solve(&cart).intervals(4).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    close(solution.objective, 3.0);
    // What the scene itself says of it is the value with its kink.
    let mut values = [0.0];
    hangtime::model::Model::path_functions(&cart, &[0.0, 0.0, 0.0, 0.0, -1.5, 0.0], &mut values);
    assert_eq!(values, [1.5]);
}

#[test]
fn least_fuel_is_bang_off_bang() {
    // Full force for t1 at both ends, m way = F t1 (T - t1): with t1 a quarter of T no grid of four costs anything.
    let (force, time) = (1.5, 2.0);
    let way = force * 0.5 * 1.5 / 1.3;
    for size in ["|u|", "max(u, -u)", "-min(u, -u)", "abs(2*u)/2"] {
        let judged = format!("minimize integral({size}) {AT_REST}");
        let text = moved(way, time, "in -1.5..=1.5", &judged);
        close(optimum(&text, 4), 2.0 * force * 0.5);
    }
}

#[test]
fn sizes_of_linear_controls_are_those_at_the_stages() {
    // Without a bound less fuel is spent by shorter pushes: on nodes at distance h by hats at the ends, 2 F (h/2), with
    // m way = F h/2 (T - 2 h/3).
    let (way, time, h) = (0.4, 2.0, 0.5);
    let judged = format!("minimize integral(|u|) {AT_REST}");
    let solution = solved(&moved(way, time, "", &judged), 4, ControlShape::Linear);
    close(solution.objective, 2.0 * 1.3 * way / (time - 2.0 * h / 3.0));
}

#[test]
fn least_peak_force_is_that_of_two_halves() {
    // 4 m d/T^2.
    let text = moved(0.7, 3.0, "", &format!("minimize peak(|u|) {AT_REST}"));
    let found = optimum(&text, 6);
    assert!((found - 4.0 * 1.3 * 0.7 / 9.0).abs() < 1e-9, "{found}");
    // A weight by a parameter, beside another term of no weight.
    let text = moved(
        0.7,
        3.0,
        "",
        &format!("minimize m*peak(max(u, -u))/1 [kg] + 2*(x - way)*1 [N/m] {AT_REST}"),
    );
    close(optimum(&text, 6), 1.3 * 4.0 * 1.3 * 0.7 / 9.0);
}

#[test]
fn peak_in_a_goal_bounds_the_whole_motion() {
    // 2 sqrt(m d/F), in two halves.
    let goals = "finally { x == way, dot(x) == 0, peak(|u|) <= 2 [N] }";
    let text = moved(0.7, 3.0, "", &format!("minimize time {goals}"));
    close(optimum(&text, 4), 2.0 * (1.3_f64 * 0.7 / 2.0).sqrt());
}

#[test]
fn largest_height_of_a_throw_lies_between_the_nodes_and_counts_from_the_start_on() {
    // Up and down again in T: g T^2/8, in the middle of one of three intervals.
    let throw = |judged: &str, start: &str| {
        format!(
            "parameters {{ g: m/s^2 = 9.81 }} coordinates {{ z: m }} lagrangian (dot(z)^2/2 - g*z)*1 [kg]
            {judged} {start} horizon 0.8 [s]"
        )
    };
    let up = throw(
        "minimize peak(z) finally { z == 0 [m] } free { dot(z) in 0..=9 }",
        "start { dot(z): 3 }",
    );
    // Limits between the stages hold up to the millionth of what the motion is large.
    let found = optimum(&up, 3);
    assert!((found - 9.81 * 0.64 / 8.0).abs() < 1e-5, "{found}");
    // Thrown down from a height the start is the largest.
    let down = throw(
        "minimize peak(z) + dot(z)^2*0 [s^2/m] free { dot(z) in -3..=-1 }",
        "start { z: 2.5, dot(z): -2 }",
    );
    close(optimum(&down, 2), 2.5);
}

#[test]
fn largest_and_smallest_of_two_at_the_end_are_shared_evenly() {
    // Both masses together get the force F: each F T^2/(4 m).
    for (cost, sign) in [
        ("max(x, y)", 1.0),
        ("-min(x, y)", -1.0),
        ("|x - y| + x + y", 2.0),
    ] {
        let text = format!(
            "parameters {{ m: kg = 1.7, f: N = 2.2 }} coordinates {{ x: m, y: m }} controls {{ u: N in -9..=9 }}
            lagrangian m/2*dot(x)^2 + m/2*dot(y)^2 forces {{ x: u, y: f - u }} minimize {cost} horizon 1.4 [s]"
        );
        close(optimum(&text, 3), sign * 2.2 * 1.4 * 1.4 / (4.0 * 1.7));
    }
}

#[test]
fn size_of_a_state_is_one_unknown_at_each_stage() {
    // A place that passes 0 in the middle: the integral of |x_0 + t| over 2 s is least, 1, where x_0 = -1 or so.
    let text = "states { x } rates { x: 1 [1/s] } minimize integral(|x|) free { x in -5..=5 } start { x: -0.3 } horizon 2 [s]";
    close(optimum(text, 2), 1.0);
}
