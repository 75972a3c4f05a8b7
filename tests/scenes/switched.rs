//! What the cases of switched systems cannot say: a motion of many pieces, and plans by time-freezing.

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

use EventKind::Switch;

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

/// The plan of a scene by time-freezing.
fn frozen(scene: &TextScene, intervals: usize) -> Result<hangtime::ocp::Solution, InputError> {
    use hangtime::ocp::{Formulation, Settings, TimeFreezingSettings};
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    solve(scene).settings(settings).intervals(intervals).run()
}

#[test]
fn plans_by_time_freezing_pass_switches_slide_along_them_and_end_at_the_same_optima() {
    // The closed forms of the cases: the effort of a relay that holds one state, and of one that has to be passed.
    let optima = [
        (gallery!("slide-to-target"), 10, 0.5),
        (gallery!("passing-relay"), 6, 4.0),
    ];
    for (scene, intervals, best) in optima {
        let solution = frozen(&scene, intervals).expect("accepted");
        assert!(solution.status.is_solved(), "{solution}");
        assert!((solution.objective - best).abs() < 1e-7, "{solution}");
        // The program itself led there, and its own optimum is that, too: rates are constant, or linear in time.
        let report = solution.time_freezing.expect("a report");
        assert!(report.relaxed.led_to_motion);
        assert!(
            (report.objective - best).abs() < 1e-6,
            "{}",
            report.objective
        );
    }
    // 5 m/s^2 up to 10 m/s, 15 m/s^2 up to 25 m/s, and backwards: a grid of seconds holds all of it.
    let mut car = gallery!("turbo-car");
    let names = car.declaration().parameters;
    let way = names.iter().position(|known| known.name == "way");
    car.set_parameter(way.expect("declared"), 55.0);
    let solution = frozen(&car, 6).expect("accepted");
    assert!((solution.objective - 6.0).abs() < 1e-7, "{solution}");
    assert!(
        solution
            .time_freezing
            .expect("a report")
            .relaxed
            .led_to_motion
    );
}

#[test]
fn states_that_conditions_set_are_refused_by_name_in_time_freezing() {
    let refused = frozen(&gallery!("hysteresis-car"), 6);
    let why = refused.expect_err("refused").to_string();
    assert!(
        why.contains("`when v >= engaged`, by optimal control"),
        "{why}"
    );
}
