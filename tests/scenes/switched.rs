//! Plans of switched systems by time-freezing.

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

/// The plan of a scene by time-freezing.
fn frozen(scene: &TextScene, intervals: usize) -> Result<hangtime::ocp::Solution, InputError> {
    solve(scene).settings(freezing()).intervals(intervals).run()
}

/// The time-freezing formulation.
fn freezing() -> hangtime::ocp::Settings {
    use hangtime::ocp::{Formulation, Settings, TimeFreezingSettings};
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    settings
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

/// The optimum of a plan by time-freezing that is certified, and whose own program ends exactly at the same.
fn frozen_optimum(scene: &TextScene, settings: hangtime::ocp::Settings, intervals: usize) -> f64 {
    let solution = solve(scene).settings(settings).intervals(intervals).run();
    let solution = solution.expect("accepted");
    assert!(solution.status.is_solved(), "{solution}");
    let report = solution.time_freezing.as_ref().expect("a report");
    assert_eq!(report.residuals.complementarity, 0.0, "{report:?}");
    let apart = (report.objective - solution.objective).abs();
    assert!(apart < 1e-6, "{report:?} {solution}");
    solution.objective
}

#[test]
fn plans_by_time_freezing_set_states_where_conditions_come_true() {
    // Up to 10 m/s in 2 s, to 25 m/s with the turbo in 1 s, down to 2.5 m/s in 1.5 s, to rest in 0.5 s: a grid of half seconds holds all
    // of it.
    let mut car = gallery!("hysteresis-car");
    for (name, value) in [("way", 48.75), ("engaged", 10.0), ("disengaged", 2.5)] {
        let names = car.declaration().parameters;
        let index = names.iter().position(|known| known.name == name);
        car.set_parameter(index.expect("declared"), value);
    }
    let best = frozen_optimum(&car, freezing(), 10);
    assert!((best - 5.0).abs() < 1e-7, "{best}");
    // A heater of 3 with losses of 1 goes on at 0, where it is false again at once, as it warms: an effort cools to that first.
    let heater = "
        states { x, on }
        controls { u: 1/s }
        rates { x: u + 3 [1/s]*on - 1 [1/s], on: 0 [1/s] }
        when x <= 0 { on = 1 }
        minimize integral(u^2)
        finally { x == 1.5 }
        start { x: 0.5 }
        horizon 1 [s]
    ";
    let heater = of_text("heater", heater).expect("no mistakes");
    let best = frozen_optimum(&heater, freezing(), 8);
    let phases = solve(&heater)
        .intervals(8)
        .run()
        .expect("accepted")
        .objective;
    assert!((best - phases).abs() < 1e-7, "{best} {phases}");
}

#[test]
fn plans_by_time_freezing_keep_conditions_at_times() {
    // Through 0.8 at 1 s to -0.5 at 3 s: the integrals of products of `t - s` for both times, and `c' G^-1 c`.
    let scene = |conditions: &str| {
        let text = format!(
            "coordinates {{ x: m }}
            controls {{ u: m/s^2 }}
            lagrangian dot(x)^2/2*1 [kg]
            forces {{ x: u*1 [kg] }}
            minimize integral(u^2)
            {conditions}
            horizon 3 [s]"
        );
        of_text("way", &text).expect("no mistakes")
    };
    let linear = || {
        let mut settings = freezing();
        settings.controls = hangtime::ocp::ControlShape::Linear;
        settings
    };
    let way = scene("at 1 [s] { x == 0.8 [m] } finally { x == -0.5 [m] }");
    let (a, b, c) = (1.0 / 3.0, 8.0 / 6.0, 9.0);
    let exact = (0.64 * c + 0.8 * b + 0.25 * a) / (a * c - b * b);
    let best = frozen_optimum(&way, linear(), 3);
    assert!((best - exact).abs() < 1e-8, "{best} {exact}");
    // x(3) = 2 x(1) + 1.
    let way = scene("finally { x == 2*at(1 [s], x) + 1 [m] }");
    let best = frozen_optimum(&way, linear(), 3);
    assert!(
        (best - 1.0 / (c - 4.0 * b + 4.0 * a)).abs() < 1e-8,
        "{best}"
    );
    // There and back through 0.8 at a time that is found, in the middle.
    let way =
        scene("at gate in 0.4..=2.9 [s] { x == 0.8 [m] } finally { x == 0 [m], dot(x) == 0 }");
    let best = frozen_optimum(&way, linear(), 3);
    assert!(
        (best - 3.0 * (8.0 / 5.0 * 0.8_f64).powi(2)).abs() < 1e-8,
        "{best}"
    );
}

#[test]
fn conditions_that_set_what_switches_read_are_refused_by_name_in_time_freezing() {
    let counter = "
        states { x, n }
        controls { u: 1/s }
        rates { x: u*sign(n - 1.5), n: 0 [1/s] }
        when x >= 1 { n = n + 1 }
        minimize integral(u^2)
        finally { x == 2 }
        horizon 1 [s]
    ";
    let counter = of_text("counter", counter).expect("no mistakes");
    let why = frozen(&counter, 4).expect_err("refused").to_string();
    assert!(why.contains("`when x >= 1`, which sets what"), "{why}");
}
