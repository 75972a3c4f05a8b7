//! What ways of optimal control make of problems on which they fail.

use hangtime::ocp::{self, Formulation, Problem, Settings, Solution, Status, TimeFreezingSettings};

use super::side_by_side::{side_by_side, workers};
use super::verdict::{Row, Verdict};
use crate::bounds::Bounds;
use crate::failure::BadInput;
use crate::scene::about;
use crate::scene_file::load_text;
use crate::settings::ChosenScene;
use crate::timing::patience;
use crate::{HardOptimum, RightOptimum};

/// Control intervals: a number for which the switches of all optima lie between intervals.
const INTERVALS: usize = 12;
/// Distance from the least objective that the tolerances of the programs explain, relative, or absolute below one.
const NEAR: f64 = 1e-6;
/// CPU time after which a solve counts as one that does not end [s], where those that run beside it take as much.
const PATIENCE: f64 = 60.0;

/// A way to solve a problem: its name, and its settings.
type Way = (&'static str, fn() -> Settings);

const WAYS: [Way; 3] = [
    ("phases (default)", Settings::default),
    ("phases, one start", || {
        let mut settings = Settings::default();
        settings.starts = Some(1);
        settings
    }),
    ("time-freezing", || {
        let mut settings = Settings::default();
        settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
        settings
    }),
];

pub(super) const INTRODUCTION: &str = "\
    What ways of optimal control make of problems with a known answer, on 12 control intervals. Right: solved, within 1e-6 of the \
    least objective, which is the number, or stopped with the right name. WRONG: solved, and farther off, or solved where there \
    is no optimum.";

pub(super) fn names() -> impl Iterator<Item = &'static str> {
    WAYS.iter().map(|(name, _)| *name)
}

pub(super) fn header() -> Vec<String> {
    let all = ["problem"].into_iter().chain(names());
    all.map(str::to_owned).collect()
}

/// A line for each problem.
pub(super) fn rows(problems: &[HardOptimum], bounds: &Bounds) -> Result<Vec<Row>, BadInput> {
    side_by_side(
        "hard optima",
        problems,
        bounds,
        |problem| problem.name.to_owned(),
        |problem| row(problem, bounds),
    )
}

fn row(problem: &HardOptimum, bounds: &Bounds) -> Result<Row, BadInput> {
    let scene = load_text(problem.name, problem.text)?;
    let chosen = ChosenScene::new(scene, &[])?;
    let model = chosen.model.as_ref();
    let verdicts = WAYS.iter().map(|(_, settings)| {
        // The clock is that of the whole program.
        let patient = patience(PATIENCE * workers() as f64);
        let on_grid = Problem::of(model, INTERVALS);
        let ended = ocp::solve(model, &on_grid, &settings(), &mut |_| {
            bounds.asked().is_none() && patient()
        });
        match ended {
            Err(error) if error.is_unsupported() => Verdict::NotApplicable,
            Err(_) => stopped("refused", problem.right),
            Ok(solution) => judged(&solution, problem.right),
        }
    });
    Ok(Row {
        name: problem.name.to_owned(),
        phenomenon: scene.title.to_owned(),
        why: about(problem.text),
        verdicts: verdicts.collect(),
    })
}

fn stopped(name: &'static str, right: RightOptimum) -> Verdict {
    match right {
        RightOptimum::None(names) if names.contains(&name) => Verdict::RightlyStopped(name),
        _ => Verdict::Stopped(name),
    }
}

fn judged(solution: &Solution, right: RightOptimum) -> Verdict {
    match (solution.status, right) {
        (Status::Interrupted, _) => Verdict::NoEnd,
        (Status::Solved, RightOptimum::Least(least)) => {
            let error = (solution.objective - least).abs() / least.abs().max(1.0);
            if error <= NEAR {
                Verdict::Right(error)
            } else {
                Verdict::Wrong(Some(error))
            }
        }
        (Status::Solved, RightOptimum::None(_)) => Verdict::Wrong(None),
        (status, right) => stopped(status.name(), right),
    }
}
