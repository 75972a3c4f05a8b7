//! Optimal control: goals out of reach and just within it, behind walls and in the ground, optima that graze, objectives without
//! a value and without a least one.

use hangtime::ocp::{self, Formulation, Problem, Settings, Status, TimeFreezingSettings};
use hangtime_cli::{HardOptimum, RightOptimum};
use hangtime_models::hard_optima;
use hangtime_scene_files::of_text;

/// Control intervals for which the optima of the problems are known.
const INTERVALS: usize = 12;

/// The objective of what is called solved, or the status, or `refused`.
fn outcome(hard: &HardOptimum, settings: &Settings) -> Result<f64, &'static str> {
    let name = hard.name;
    let scene = of_text(&format!("{name}.hang"), hard.text)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let problem = Problem::of(&scene, INTERVALS);
    match ocp::solve(&scene, &problem, settings, &mut |_| true) {
        Ok(solution) if solution.status == Status::Solved => Ok(solution.objective),
        Ok(solution) => Err(solution.status.name()),
        Err(error) if error.is_unsupported() => Err("unsupported"),
        Err(_) => Err("refused"),
    }
}

/// Whether an outcome is the right one.
fn is_right(outcome: Result<f64, &'static str>, right: RightOptimum) -> bool {
    match (outcome, right) {
        (Ok(objective), RightOptimum::Least(least)) => {
            (objective - least).abs() <= 1e-6 * least.abs().max(1.0)
        }
        (Err(name), RightOptimum::None(names)) => names.contains(&name),
        _ => false,
    }
}

#[test]
fn optima_with_a_known_answer_are_found_and_goals_out_of_reach_named() {
    let mut settings = Settings::default();
    settings.starts = Some(1);
    for hard in hard_optima() {
        let outcome = outcome(hard, &settings);
        assert!(is_right(outcome, hard.right), "{}: {outcome:?}", hard.name);
    }
}

#[test]
#[ignore = "long"]
fn time_freezing_is_right_or_stops_with_a_name() {
    let mut settings = Settings::default();
    settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
    settings.starts = Some(1);
    for hard in hard_optima() {
        let outcome = outcome(hard, &settings);
        let right = outcome.is_err() || is_right(outcome, hard.right);
        assert!(right, "{}: {outcome:?}", hard.name);
    }
}
