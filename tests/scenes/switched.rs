//! What the cases of switched systems cannot say: a motion of many pieces, and a formulation that knows no switches.

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

#[test]
fn what_optimal_control_does_not_know_of_switches_is_refused_by_name() {
    use hangtime::ocp::{Formulation, Settings, TimeFreezingSettings};
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    let refused = solve(&gallery!("passing-relay")).settings(settings).run();
    let why = refused.expect_err("refused").to_string();
    assert!(why.contains("the switch `x >= 0`"), "{why}");
}
