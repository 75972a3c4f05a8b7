//! What the tests share.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::model::Model;
use hangtime::ocp::{self, Problem, Settings, Solution, Status};

/// Digits of an objective or a final time: the solver's tolerance is 1e-9, that of the re-simulation 1e-12.
pub(crate) const DIGITS: f64 = 1e-7;

/// The settings of a search from one start, where a test is about what comes after the exploration.
pub(crate) fn one_start() -> Settings {
    let mut settings = Settings::default();
    settings.starts = Some(1);
    settings
}

/// A result, whatever it is.
pub(crate) fn attempt(model: &dyn Model, intervals: usize, settings: &Settings) -> Solution {
    let problem = Problem::of(model, intervals);
    ocp::solve(model, &problem, settings, &mut |_| true).unwrap()
}

/// A certified result that its re-simulation confirms.
pub(crate) fn solve(model: &dyn Model, intervals: usize, settings: &Settings) -> Solution {
    let solution = attempt(model, intervals, settings);
    assert_eq!(
        solution.status,
        Status::Solved,
        "{:?}",
        solution.diagnosis()
    );
    assert!(solution.resimulation_error < DIGITS);
    solution
}

/// The time-freezing program of a result was solved exactly, as near to its objective as that.
pub(crate) fn assert_program(solution: &Solution, near: f64) {
    let report = solution.time_freezing.as_ref().unwrap();
    assert_eq!(report.residuals.complementarity, 0.0, "{report:?}");
    assert!(report.residuals.primal < 1e-9, "{report:?}");
    let size = solution.objective.abs().max(1.0);
    let apart = (report.objective - solution.objective).abs() / size;
    assert!(apart < near, "{apart:e}: {report:?} {}", solution.objective);
}
