//! Conditions at times inside of a motion, given and to be found, against closed forms.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::of_text;

use super::both::motions;

fn solved(text: &str, intervals: usize, controls: ControlShape) -> Solution {
    let scene = of_text("scene.hang", text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let solution = solve(&scene)
        .intervals(intervals)
        .controls(controls)
        .run()
        .expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

/// What the solver lets pass of values of the order of one.
const DIGITS: f64 = 1e-8;

fn close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < DIGITS, "{found} for {wanted}");
}

fn mass(conditions: &str) -> String {
    format!(
        "coordinates {{ x: m }} controls {{ u: m/s^2 }} lagrangian dot(x)^2/2*1 [kg] forces {{ x: u*1 [kg] }}
        minimize integral(u^2) {conditions} horizon 3 [s]"
    )
}

/// `c' G^-1 c` of two conditions.
fn least(g: [[f64; 2]; 2], c: [f64; 2]) -> f64 {
    let determinant = g[0][0] * g[1][1] - g[0][1] * g[1][0];
    (c[0] * c[0] * g[1][1] - 2.0 * c[0] * c[1] * g[0][1] + c[1] * c[1] * g[0][0]) / determinant
}

#[test]
fn way_through_a_place_at_a_time_is_a_cubic_spline() {
    // x(t) is the integral of (t - s) u(s): of these two functions for t = 1 and t = 3 the products are integrated. The best u is linear with a
    // kink at 1, where a node is.
    let text = mass("at 1 [s] { x == 0.8 [m] } finally { x == -0.5 [m] }");
    let solution = solved(&text, 3, ControlShape::Linear);
    let g = [[1.0 / 3.0, 8.0 / 6.0], [8.0 / 6.0, 9.0]];
    close(solution.objective, least(g, [0.8, -0.5]));
    let motion = solution.motion.expect("a motion");
    close(motion.at(1.0).expect("inside")["x"], 0.8);
    assert_eq!(motion.events.len(), 1);
}

#[test]
fn time_need_not_be_that_of_a_node() {
    // Constant controls on intervals of 1 s: the same with the integrals over these.
    let text = mass("at 1.3 [s] { x == 0.8 [m] } finally { x == -0.5 [m] }");
    let until = |t: f64, k: f64| {
        let (from, to) = ((t - k).max(0.0), (t - k - 1.0).max(0.0));
        (from * from - to * to) / 2.0
    };
    let rows = [1.3, 3.0].map(|t| [0.0, 1.0, 2.0].map(|k| until(t, k)));
    let product = |a: [f64; 3], b: [f64; 3]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let g = [0, 1].map(|i| [0, 1].map(|j| product(rows[i], rows[j])));
    let solution = solved(&text, 3, ControlShape::Constant);
    close(solution.objective, least(g, [0.8, -0.5]));
}

#[test]
fn time_that_is_free_is_found_in_the_middle() {
    // From rest to rest through p, and by symmetry at rest there: controls 2 a, -a, -a, 2 a at the nodes, with 5 a/8 = p, and the
    // integral of their squares over half of the time is (3 a^2)/3 + a^2/2.
    let text =
        mass("at gate in 0.4..=2.9 [s] { x == 0.8 [m] } finally { x == 0 [m], dot(x) == 0 }");
    let solution = solved(&text, 3, ControlShape::Linear);
    let a = 8.0 / 5.0 * 0.8_f64;
    close(solution.objective, 3.0 * a * a);
    let gate = &solution.parameters[0];
    assert_eq!(gate.name, "gate");
    assert!((gate.value - 1.5).abs() < 1e-5, "{}", gate.value);
}

#[test]
fn inequalities_and_several_conditions_hold_at_one_time() {
    // At rest at 0.3 after 1 s, by two pushes of half a second, u and -u with u/4 = 0.3; nothing is asked for after it.
    let text = mass("at 1 [s] { x >= 0.3 [m], dot(x) == 0 [m/s], x <= 2 [m] }");
    let solution = solved(&text, 6, ControlShape::Constant);
    close(solution.objective, 1.2 * 1.2);
}

#[test]
fn condition_of_a_time_after_the_end_is_not_kept() {
    // The motion must last until then, and its last phase a little: way and bound alone would take 2 s.
    let text = "coordinates { x: m } controls { u: m/s^2 in -1..=1 } lagrangian dot(x)^2/2*1 [kg] forces { x: u*1 [kg] }
        minimize time at 2.5 [s] { x <= 1 [m] } finally { x == 1 [m], dot(x) == 0 } horizon 3 [s]";
    let scene = of_text("scene.hang", text).expect("a scene");
    let solution = solve(&scene).intervals(4).run().expect("accepted");
    assert!((2.5..2.502).contains(&solution.objective), "{solution}");
}

#[test]
fn simulation_records_what_is_asked_for() {
    let text = "coordinates { x: m } lagrangian dot(x)^2/2*1 [kg] start { dot(x): 2 } at 0.75 [s] { x >= 1 [m] } horizon 2 [s]";
    for motion in motions(text) {
        let end = motion.at(2.0).expect("its end");
        assert!((end["x >= 1 [m] at 0.75 [s]"] - 0.5).abs() < 1e-9);
    }
}

#[test]
fn thrust_ends_at_a_gate_that_is_found() {
    // The thrust 2 until the gate g, then nothing: 2 (g T - g^2/2) = 1.3 with T = 2; the control, which costs, has nothing to add.
    let text = "coordinates { x: m } controls { u: m/s^2 } lagrangian dot(x)^2/2*1 [kg]
        forces { x: (u + if t >= gate { 0 [m/s^2] } else { 2 [m/s^2] })*1 [kg] }
        minimize integral(u^2) at gate in 0.1..=1.9 [s] { dot(x) >= 0.1 [m/s] } finally { x == 1.3 [m] } horizon 2 [s]";
    let solution = solved(text, 3, ControlShape::Constant);
    close(solution.objective, 0.0);
    let gate = 2.0 - (4.0_f64 - 1.3).sqrt();
    let found = solution.parameters[0].value;
    // A cost that vanishes to 1e-8 leaves controls of 1e-4 and as much of the gate.
    assert!((found - gate).abs() < 1e-3, "{found} for {gate}");
    let motion = solution.motion.expect("a motion");
    let switched = motion.events.iter().filter(|e| e.kind == EventKind::Switch);
    assert!(
        switched.count() == 1 && motion.events.len() == 2,
        "{motion}"
    );
}

#[test]
fn dear_gate_lies_where_the_control_takes_over() {
    // x(2) = 2 (2 g - g^2/2) + 2 u = 1.3 with constant u: the least of u^2 2 + w (g - 1)^2 over g.
    let text = "coordinates { x: m } controls { u: m/s^2 } lagrangian dot(x)^2/2*1 [kg]
        forces { x: (u + if t >= gate { 0 [m/s^2] } else { 2 [m/s^2] })*1 [kg] }
        minimize integral(u^2) + 3 [m^2/s^5]*(gate - 1 [s])^2 at gate in 0.1..=1.9 [s] { x >= 0 [m] }
        finally { x == 1.3 [m] } horizon 2 [s]";
    let push = |g: f64| (1.3 - 4.0 * g + g * g) / 2.0;
    let cost = |g: f64| 2.0 * push(g).powi(2) + 3.0 * (g - 1.0).powi(2);
    let (mut low, mut high) = (0.1, 1.0);
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if cost(a) < cost(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let solution = solved(text, 1, ControlShape::Constant);
    close(solution.objective, cost(low));
    let found = solution.parameters[0].value;
    assert!((found - low).abs() < 1e-5, "{found} for {low}");
}

#[test]
fn value_at_a_time_may_stand_in_a_cost_and_in_conditions_between_times() {
    // x(1.5) = 0.3 and x(3) = -0.5 for nothing but effort, the first of which may be missed at a price: with Gram matrix G of both functions
    // `c' G^-1 c` over c = (0.3 + d, -0.5), and `w d^2`.
    let (weight, asked, end) = (40.0, 0.3, -0.5);
    let text = format!(
        "coordinates {{ x: m }} controls {{ u: m/s^2 }} lagrangian dot(x)^2/2*1 [kg] forces {{ x: u*1 [kg] }}
        minimize integral(u^2) + {weight} [1/s^3]*(at(1 [s], x) - {asked} [m])^2 finally {{ x == {end} [m] }} horizon 3 [s]"
    );
    let g = [[1.0 / 3.0, 8.0 / 6.0], [8.0 / 6.0, 9.0]];
    let cost = |at: f64| least(g, [at, end]) + weight * (at - asked).powi(2);
    // A parabola in the place at 1 s.
    let (low, middle, high) = (cost(-1.0), cost(0.0), cost(1.0));
    let (slope, bend) = ((high - low) / 2.0, high - 2.0 * middle + low);
    let solution = solved(&text, 3, ControlShape::Linear);
    close(solution.objective, cost(-slope / bend));
    let motion = solution.motion.expect("a motion");
    assert!((motion.at(1.0).expect("inside")["x"] + slope / bend).abs() < 1e-7);
}

#[test]
fn condition_between_two_times_is_one_of_what_both_are() {
    // x(3) = 2 x(1) + 1: one condition with the function of the second time less twice that of the first.
    let text = mass("finally { x == 2*at(1 [s], x) + 1 [m] }");
    let solution = solved(&text, 3, ControlShape::Linear);
    let norm = 9.0 - 4.0 * 8.0 / 6.0 + 4.0 / 3.0;
    close(solution.objective, 1.0 / norm);
    // The same asked for at the later of two times inside.
    let text = mass("at 2 [s] { x == 2*at(1 [s], x) + 1 [m] }");
    let solution = solved(&text, 3, ControlShape::Linear);
    // With t = 1, 2: the integrals of (1 - s)^2, (1 - s)(2 - s) and (2 - s)^2.
    let norm = 8.0 / 3.0 - 4.0 * 5.0 / 6.0 + 4.0 / 3.0;
    close(solution.objective, 1.0 / norm);
}

#[test]
fn motion_with_a_free_end_lasts_until_the_time_of_which_it_is_asked() {
    // At full force it is there after 2 s, and at 0.5 after 1 s; the last place is asked for at 2.5 s.
    let text = "coordinates { x: m } controls { u: m/s^2 in -1..=1 } lagrangian dot(x)^2/2*1 [kg] forces { x: u*1 [kg] }
        minimize time + 0.1 [s/m]*at(2.5 [s], x) finally { x == 1 [m], dot(x) == 0 } horizon 3 [s]";
    let scene = of_text("scene.hang", text).expect("a scene");
    let solution = solve(&scene).intervals(4).run().expect("accepted");
    assert!(solution.horizon >= 2.5, "{solution}");
}

#[test]
fn value_of_a_velocity_at_a_time_is_part_of_a_simulation() {
    let text = "coordinates { x: m } lagrangian dot(x)^2/2*1 [kg] - x*1 [N] start { dot(x): 2 } controls { u: N } forces { x: u }
        minimize at(0.75 [s], dot(x)*x) finally { at(0.75 [s], x) <= at(1.5 [s], x) + 1 [m] } horizon 2 [s]";
    for motion in motions(text) {
        let end = motion.at(2.0).expect("its end");
        let place = |t: f64| 2.0 * t - t * t / 2.0;
        for (name, value) in [
            ("at(0.75 [s], dot(x)*x)", 1.25 * place(0.75)),
            ("at(0.75 [s], x)", place(0.75)),
            ("at(1.5 [s], x)", place(1.5)),
        ] {
            assert!((end[name] - value).abs() < 1e-9, "{name}: {}", end[name]);
        }
    }
}
