//! The switched systems of the gallery: motions against closed forms by both methods that locate switches, optima against theirs.

use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_scene_files::{TextScene, of_text};

macro_rules! gallery {
    ($name:literal) => {
        of_text(
            $name,
            include_str!(concat!("../../models/gallery/", $name, ".hang")),
        )
        .expect("no mistakes")
    };
}

/// What a default run promises, of the largest values; the event-driven method is held to it as well.
const PROMISED: f64 = 1e-6;

fn motions(scene: &TextScene) -> [Simulation; 2] {
    let located = simulate(scene).run().expect("a run");
    let event = simulate(scene).method(EventDriven::default()).run();
    [located, event.expect("a run")]
}

/// Compares both motions of a scene with its end and its events; times are known to the accuracy of the values that tell them.
fn compare(scene: &TextScene, ends: &[(&str, f64)], events: &[(EventKind, f64)]) {
    for motion in motions(scene) {
        assert!(motion.status.is_solved(), "{}", motion.status);
        let time = *motion.trajectory.time.last().expect("a motion");
        let end = motion.at(time).expect("its end");
        for &(name, value) in ends {
            let error = (end[name] - value).abs();
            assert!(
                error < PROMISED * value.abs().max(1.0),
                "{name}: {} for {value}",
                end[name]
            );
        }
        let kinds: Vec<EventKind> = motion.events.iter().map(|event| event.kind).collect();
        let wanted: Vec<EventKind> = events.iter().map(|event| event.0).collect();
        assert_eq!(kinds, wanted);
        for (event, &(_, time)) in motion.events.iter().zip(events) {
            assert!(
                (event.time - time).abs() < PROMISED * time.max(1.0),
                "{event} for {time}"
            );
        }
    }
}

use EventKind::{Slide, Switch, When};

#[test]
fn branches_have_values_where_they_do_not_act() {
    // An orifice both ways, into which one unit flows a second: with w the root of |x|, t = 2 (1 - ln 2) from w = 1 to 0, and
    // 2 ln 2 - 1 from there to 1/2.
    for flow in [
        "if x >= 0 { sqrt(x) } else { -sqrt(-x) }",
        "sign(x)*sqrt(|x|)",
    ] {
        let text = format!(
            "states {{ x }} rates {{ x: (1 - ({flow}))*1[1/s] }} start {{ x: -1 }} horizon 1 [s]"
        );
        let scene = of_text("orifice.hang", &text).expect("no mistakes");
        let turn = 2.0 * (1.0 - std::f64::consts::LN_2);
        compare(&scene, &[("x", 0.25)], &[(Switch, turn)]);
    }
}

#[test]
fn choices_follow_parameters_in_either_order() {
    let text = "parameters { t1: s = 0.5, t2: s = 1.25 } states { x }
        rates { x: (if t >= t2 { 3 } else if t >= t1 { 2 } else { 1 })*1[1/s] } horizon 2 [s]";
    let mut scene = of_text("choices.hang", text).expect("no mistakes");
    compare(&scene, &[("x", 4.25)], &[(Switch, 0.5), (Switch, 1.25)]);
    scene.set_parameter(0, 1.5);
    scene.set_parameter(1, 1.0);
    compare(&scene, &[("x", 4.0)], &[(Switch, 1.0), (Switch, 1.5)]);
}

#[test]
fn jump_of_a_rate_is_crossed() {
    compare(&gallery!("crossing"), &[("x", 3.0)], &[(Switch, 1.0)]);
}

#[test]
fn sliding_motion_has_the_part_of_the_jump_that_holds_it() {
    // It arrives after 1/0.5 s, and slides with the sign 1/2.
    let ends = [("x", 0.0), ("y", 2.0 + 0.5 * 2.0)];
    compare(&gallery!("sliding"), &ends, &[(Slide, 2.0)]);
}

#[test]
fn sliding_is_left_where_one_side_is_stronger() {
    let arrives = 1.0 - 0.4_f64.sqrt();
    let events = [(Slide, arrives), (Switch, 1.0)];
    compare(&gallery!("leaving-sliding"), &[("x", 0.5)], &events);
}

#[test]
fn motion_that_may_leave_to_both_sides_is_said() {
    for motion in motions(&gallery!("unstable-sliding")) {
        let why = motion.status.to_string();
        assert!(
            !motion.status.is_solved() && why.contains("not unique"),
            "{why}"
        );
    }
}

#[test]
fn spiral_turns_round_on_the_unit_circle() {
    // r' = r, so that it is there at t = 1, after a whole turn.
    let end = std::f64::consts::FRAC_PI_2 - 1.0;
    let (r, angle) = (end.exp(), std::f64::consts::TAU * end);
    let ends = [("x", r * angle.cos()), ("y", r * angle.sin())];
    compare(&gallery!("spiral"), &ends, &[(Switch, 1.0)]);
}

#[test]
fn relay_swings_with_four_parabolas_a_period() {
    let quarter = 2.0_f64.sqrt();
    let events: Vec<_> = [1.0, 3.0, 5.0, 7.0].map(|k| (Switch, k * quarter)).to_vec();
    // 10 s are 7 quarters and a bit: on its way out from zero.
    let t = 10.0 - 7.0 * quarter;
    let ends = [("x", quarter * t - t * t / 2.0), ("v", quarter - t)];
    compare(&gallery!("relay"), &ends, &events);
}

#[test]
fn two_relays_slide_at_once() {
    // y' = -1/2 until the first one slides, and -1 then.
    let events = [(Slide, 0.3), (Slide, 0.3 + 0.35)];
    compare(&gallery!("two-relays"), &[("x", 0.0), ("y", 0.0)], &events);
}

#[test]
fn genes_read_each_other_along_exponentials() {
    // Within a quadrant x and y tend to 0 or 1 as exp(-t); the first threshold that is met ends it.
    let (much, little) = (0.4, 0.6);
    let (mut x, mut y, mut time) = (0.1_f64, 0.2_f64, 0.0_f64);
    let mut events = Vec::new();
    loop {
        let focus = (
            if y < little { 1.0 } else { 0.0 },
            if x > much { 1.0 } else { 0.0 },
        );
        let meets = |value: f64, focus: f64, threshold: f64| {
            let share: f64 = (focus - threshold) / (focus - value);
            let time = -share.ln();
            if share > 0.0 && time > 1e-12 {
                time
            } else {
                f64::INFINITY
            }
        };
        let first = meets(x, focus.0, much).min(meets(y, focus.1, little));
        let last = time + first > 3.0;
        let step = if last { 3.0 - time } else { first };
        x = focus.0 + (x - focus.0) * (-step).exp();
        y = focus.1 + (y - focus.1) * (-step).exp();
        time += step;
        if last {
            break;
        }
        // On the threshold itself the other side is next.
        if (x - much).abs() < 1e-12 {
            x = much + 1e-13 * (focus.0 - much).signum();
        }
        if (y - little).abs() < 1e-12 {
            y = little + 1e-13 * (focus.1 - little).signum();
        }
        events.push((Switch, time));
    }
    assert!(events.len() > 3);
    compare(&gallery!("two-genes"), &[("x", x), ("y", y)], &events);
}

#[test]
fn tanks_run_over_one_after_the_other() {
    let (inflow, weir) = (0.5_f64, 2.0_f64);
    let first = 1.0 / inflow;
    // What runs over is inflow (1 - exp(-weir t)), and fills the second tank to its rim.
    let filled = |t: f64| inflow * (t - (1.0 - (-weir * t).exp()) / weir);
    let mut fills = 2.0;
    for _ in 0..50 {
        fills -= (filled(fills) - 1.0) / (inflow * (1.0 - (-weir * fills).exp()));
    }
    let t = 6.0 - first;
    // Above its rim y' + weir y = inflow (1 - exp(-weir t)).
    let constant = (inflow * fills * (-weir * fills).exp() - inflow / weir) * (weir * fills).exp();
    let above = inflow / weir + (constant - inflow * t) * (-weir * t).exp();
    let ends = [
        ("first", 1.0 + inflow / weir * (1.0 - (-weir * t).exp())),
        ("second", 1.0 + above),
    ];
    let events = [(Switch, first), (Switch, first + fills)];
    compare(&gallery!("tank-cascade"), &ends, &events);
}

#[test]
fn thermostat_switches_at_two_temperatures() {
    let (power, loss) = (1.0_f64, 0.03_f64);
    let full = power / loss;
    let heats = |from: f64, to: f64| ((full - from) / (full - to)).ln() / loss;
    let cools = |from: f64, to: f64| (from / to).ln() / loss;
    let mut time = heats(15.0, 21.0);
    let (mut events, mut on) = (vec![(When, time)], false);
    loop {
        let next = if on {
            heats(19.0, 21.0)
        } else {
            cools(21.0, 19.0)
        };
        if time + next > 40.0 {
            break;
        }
        time += next;
        on = !on;
        events.push((When, time));
    }
    let rest = 40.0 - time;
    let x = match on {
        true => full + (19.0 - full) * (-loss * rest).exp(),
        false => 21.0 * (-loss * rest).exp(),
    };
    assert!(events.len() > 4);
    let ends = [("x", x), ("on", if on { 1.0 } else { 0.0 })];
    compare(&gallery!("thermostat"), &ends, &events);
}

#[test]
fn car_shifts_at_two_speeds() {
    let shifts = [10.0 / 4.0, 10.0 / 4.0 + 10.0 / 2.0];
    let ends = [("v", 20.0 + (12.0 - shifts[1]) * 4.0 / 3.0), ("gear", 3.0)];
    let events = shifts.map(|time| (When, time));
    compare(&gallery!("gear-shift"), &ends, &events);
}

fn optimum(scene: &TextScene, intervals: usize) -> Solution {
    let solution = solve(scene).intervals(intervals).run().expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

#[test]
fn turbo_car_changes_at_ten_metres_a_second_and_takes_the_least_time() {
    // 5 m/s^2 up to 10 m/s, 15 m/s^2 up to 25 m/s: 2 s and 1 s, on 10 m and 17.5 m; the same backwards: a grid of seconds
    // holds all of it.
    let mut scene = gallery!("turbo-car");
    scene.set_parameter(0, 2.0 * 27.5);
    let solution = optimum(&scene, 6);
    assert!(
        (solution.horizon - 6.0).abs() < 1e-7,
        "{}",
        solution.horizon
    );
    let times: Vec<f64> = solution
        .planned_events
        .iter()
        .map(|event| event.0)
        .collect();
    assert!(
        times.len() == 2 && (times[0] - 2.0).abs() < 1e-6 && (times[1] - 4.0).abs() < 1e-6,
        "{times:?}"
    );
    assert!(
        solution
            .planned_events
            .iter()
            .all(|event| event.1 == Switch)
    );
}

#[test]
fn turbo_car_with_a_limit_of_speed_takes_thirteen_seconds_and_a_third() {
    // To 10 m/s in 2 s, to 20 m/s in 2/3 s, 160 m at that speed, and the same backwards: on nodes of 2/3 s.
    let text = include_str!("../../models/gallery/turbo-car.hang");
    let limited = changed(text, &[("in -25..=25", "in -20..=20")]);
    let solution = optimum(&limited, 20);
    assert!((solution.horizon - 40.0 / 3.0).abs() < 1e-7, "{solution}");
}

#[test]
fn car_whose_force_doubles_comes_to_its_goal_in_seven_seconds_from_any_guess() {
    // To 8 m/s in 2 s on 8 m, to 16 m/s in 1 s on 12 m, 1 s at that speed, and the same backwards: 56 m on a grid of seconds. On the way to it
    // words have several phases of no length at once.
    for guess in [4.0, 7.0, 12.0] {
        let text = format!(
            "states {{ q: m, v: m/s in -20..=20 }} controls {{ u: m/s^2 in -4..=4 }}
            rates {{ q: v, v: u*(if v >= 8 [m/s] {{ 2 }} else {{ 1 }}) }} minimize time
            finally {{ q == 56 [m], v == 0 [m/s] }} horizon {guess} [s]"
        );
        let solution = optimum(&of_text("car.hang", &text).expect("a scene"), 7);
        assert!((solution.objective - 7.0).abs() < 1e-7, "{solution}");
    }
}

#[test]
fn sliding_plan_ends_on_its_target() {
    // y goes from 0 to 1 in 2 s with u = 1/2, and the relay holds x at 0 from 0.5/0.75 s on; the effort is least where u is constant.
    let solution = optimum(&gallery!("slide-to-target"), 10);
    assert!(
        (solution.objective - 0.5).abs() < 1e-8,
        "{}",
        solution.objective
    );
    let (time, kind, _) = solution.planned_events[0];
    assert!(kind == Slide && (time - 2.0 / 3.0).abs() < 1e-7, "{time}");
    let end = solution.motion.expect("a motion").trajectory;
    let last = end.v.last().expect("its end");
    assert!(
        last[0].abs() < 1e-9 && (last[1] - 1.0).abs() < 1e-9,
        "{last:?}"
    );
}

#[test]
fn plan_rests_in_the_relay_that_it_has_to_pass() {
    // Without effort it is at 0 after 1 s, and rests. From there x' = u - 1 over a time w costs (1 + 1/w)^2 w, least with w = 1: 4.
    let solution = optimum(&gallery!("passing-relay"), 6);
    assert!(
        (solution.objective - 4.0).abs() < 1e-7,
        "{}",
        solution.objective
    );
    let events: Vec<_> = solution.planned_events.iter().map(|e| (e.1, e.0)).collect();
    for ((kind, time), (wanted, when)) in events.iter().zip([(Slide, 1.0), (Switch, 2.0)]) {
        assert!(*kind == wanted && (time - when).abs() < 1e-6, "{events:?}");
    }
    assert_eq!(events.len(), 2);
}

/// A scene of the gallery with other numbers in its text.
fn changed(text: &str, changes: &[(&str, &str)]) -> TextScene {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    of_text("changed.hang", &text).expect("no mistakes")
}

#[test]
fn voice_coil_moves_its_load_against_friction_with_the_least_voltage() {
    // A half longer than in the gallery, on few intervals. nosnoc with four elements of three stages on each ends at 0.290891
    // (tools/peers/switched_plans.py), of which its grid makes the last digits.
    let text = include_str!("../../models/gallery/voice-coil.hang");
    let solution = optimum(&changed(text, &[("horizon 80", "horizon 120")]), 8);
    assert!((solution.objective - 0.290_876).abs() < 1e-5, "{solution}");
    assert!(solution.resimulation_error < 1e-6, "{solution}");
    // It sticks until the current is strong enough, and does not turn round.
    let kinds = solution.planned_events.iter().map(|event| event.1);
    assert!(kinds.eq([EventKind::Slip]), "{solution}");
}

#[test]
fn race_car_drifts_along_its_track_in_the_least_time() {
    // nosnoc comes to 1.78664 s (tools/peers/switched_plans.py), where the track holds it at ends of elements only.
    let text = include_str!("../../models/gallery/race-car.hang");
    let near = [("x == 5 [m]", "x == 3 [m]"), ("horizon 4", "horizon 2")];
    let solution = optimum(&changed(text, &near), 6);
    let over = solution.objective / 1.786_638 - 1.0;
    assert!((0.0..2e-3).contains(&over), "{solution}");
    let drifts = |event: &&(f64, EventKind, usize)| event.1 == Switch;
    assert!(
        solution.planned_events.iter().filter(drifts).count() >= 1,
        "{solution}"
    );
}

#[test]
fn switch_by_the_clock_is_a_phase_of_a_plan() {
    // A wind of 1 from t = 1 on: x'' = u + step(t - 1). From rest to rest over 1 in 2 s the least effort without a grid is that of the
    // double integrator with the drift of the wind taken off; constant controls on n intervals have a closed form of their own.
    let text = "coordinates { x: m } controls { u: m/s^2 } lagrangian dot(x)^2/2*1 [kg]
        forces { x: (u + step(t - 1 [s])*1 [m/s^2])*1 [kg] }
        minimize integral(u^2) finally { x == 1 [m], dot(x) == 0 [m/s] } horizon 2 [s]";
    let solution = optimum(&of_text("wind.hang", text).expect("no mistakes"), 8);
    // sum u_k h = -1 and sum u_k h (2 - t_k) = 1 - 1/2 with the midpoints t_k.
    let h = 0.25;
    let weights: Vec<f64> = (0..8).map(|k| 2.0 - h * (f64::from(k) + 0.5)).collect();
    let (s0, s1, s2) = weights.iter().fold((0.0, 0.0, 0.0), |s, w| {
        (s.0 + h, s.1 + h * w, s.2 + h * w * w)
    });
    let (b0, b1) = (-1.0, 0.5);
    let determinant = s0 * s2 - s1 * s1;
    let effort = (b0 * b0 * s2 - 2.0 * b0 * b1 * s1 + b1 * b1 * s0) / determinant;
    assert!(
        (solution.objective - effort).abs() < 1e-8 * effort,
        "{} for {effort}",
        solution.objective
    );
}

#[test]
fn what_optimal_control_does_not_know_of_switches_is_refused_by_name() {
    use hangtime::ocp::{Formulation, Settings, TimeFreezingSettings};
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    let refused = solve(&gallery!("passing-relay")).settings(settings).run();
    let why = refused.expect_err("refused").to_string();
    assert!(why.contains("the switch `x >= 0`"), "{why}");
}

#[test]
fn conditions_with_sizes_are_rows() {
    // From rest to rest over 1 with a speed of at most 1.2: a trapezoid of slopes that cost least, at |v| <= 1.2 and so at v <= 1.2.
    let text = |limit: &str| {
        format!(
            "coordinates {{ x: m }} controls {{ u: N }} lagrangian dot(x)^2/2*1 [kg] forces {{ x: u }} minimize integral(u^2)
            constraint speed: {limit} finally {{ max(x, 2*x) <= 2 [m], x >= 1 [m], dot(x) == 0 [m/s] }} horizon 1 [s]"
        )
    };
    let found = [
        "|dot(x)| <= 1.2 [m/s]",
        "min(1.2 [m/s], 2 [m/s]) >= dot(x)",
        "dot(x) <= 1.2 [m/s]",
    ]
    .map(|limit| {
        optimum(
            &of_text("speed.hang", &text(limit)).expect("no mistakes"),
            8,
        )
        .objective
    });
    assert!(
        (found[0] - found[2]).abs() < 1e-8 && (found[1] - found[2]).abs() < 1e-8,
        "{found:?}"
    );
    // Without a limit it is 12, on a grid a little more.
    assert!(found[2] > 12.5, "{found:?}");
}
