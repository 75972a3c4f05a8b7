//! The search over words, and what it finds on the grid of the problem.

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Stationarity;

use super::nested::{self, decided};
use super::one_grid::tableaus;
use super::optima::{Found, result, sort};
use super::run::Task;
use super::shared_observer::SharedObserver;
use crate::model::Model;
use crate::ocp::collocation::discretization::{Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::global::guess::guess;
use crate::ocp::judge::confirm::judge;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::progress::Watch;
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::{Attempt, Attempts, Local, Purpose};
use crate::ocp::settings::{Guess, Settings};
use crate::ocp::solution::{Counts, Solution};
use crate::ocp::words::beginnings::beginnings;
use crate::ocp::words::on_grid::{Grid, Placed};
use crate::ocp::words::search::Words;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;
use crate::{Observer, Progress};

/// Stages of the programs of words.
const STAGES: usize = 3;
/// Excess of the objective off the grid over the best on it beyond which a word is not put on it.
const BEYOND: f64 = 1e-2;
/// Words that are put on the grid, where one of them has a motion there.
const PLACED: usize = 6;
/// Words whose switches are moved on the grid, the best first, and the excess over the best up to which they are.
const MOVED: usize = 2;
const MOVED_WITHIN: f64 = 2e-2;
/// Motions that go on to the judge.
const JUDGED: usize = 3;

/// Solves on the grid of the problem by way of words.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let found = {
        let observer = SharedObserver::new(observer);
        let task = Task {
            model,
            problem,
            settings,
            observer: &observer,
        };
        let mut seen = found_by_words(&task)?;
        let mut found = seen.clone();
        sort(&mut found);
        let best = decided(&task, found, Effort::Conclude, &mut seen)?;
        best.map(|best| result(vec![best], seen, observer.stopped()))
    };
    match found {
        Some(found) if found.motion.is_some() => Ok(found),
        _ => nested::solve(model, problem, settings, observer),
    }
}

/// The motions on the grid that the best words lead to, judged.
fn found_by_words(task: &Task) -> Result<Vec<Found>, InputError> {
    let Task {
        model,
        problem,
        settings,
        observer,
    } = *task;
    let run = observer.begin();
    let mut watch = |progress: &Progress| observer.goes_on(run, progress);
    let mut runner = Runner::new(
        settings,
        Watch::new(&mut watch),
        (Counts::default(), Seconds::default()),
        Effort::Carry,
    );
    let (lower, upper) = bounds(model);
    let bounds = (&lower[..], &upper[..]);
    let straight = guess(model, problem, &Guess::Straight, bounds)?;
    let scale = Scale::of(model, problem);
    let units = Units::new(model, &scale, &straight, bounds);
    let tableaus = tableaus(settings.stages);
    let (tableau, finer) = tableaus
        .split_first()
        .ok_or_else(|| settings.refuse_stages())?;
    let coarse =
        ButcherTableau::new(Scheme::RadauIia, STAGES).ok_or_else(|| settings.refuse_stages())?;
    let parabolas = parabolas(model, &problem.start());
    let setting = Setting::new(
        (model, problem),
        settings,
        (tableau, &units),
        (bounds, &parabolas),
    );
    let (beginnings, library) = beginnings(&mut runner, setting)?;
    let (words, goals) = Words::new(setting, &coarse, library).run(&mut runner, &beginnings);
    let units: Vec<Units> = words
        .iter()
        .map(|word| units.of_motion(model, &scale, word.trajectory(), bounds))
        .collect();
    let elements = vec![settings.elements; problem.intervals];
    let mut placed: Vec<(Placed, &Units)> = Vec::new();
    for (word, units) in words.iter().zip(&units) {
        let reached = placed.iter().find(|(best, _)| best.reaches());
        let least = reached.map_or(f64::INFINITY, |(best, _)| best.merit);
        let enough = placed.len() >= PLACED && least.is_finite();
        if enough || runner.stopped() || word.merit() > least + BEYOND * least.abs() {
            continue;
        }
        let grid = Grid {
            setting: Setting { units, ..setting },
            tableau: &coarse,
            goals: &goals,
            elements: &elements,
        };
        let Some(best) = grid.rounded(&mut runner, word) else {
            continue;
        };
        let place = placed.partition_point(|(other, _)| other.rank() < best.rank());
        placed.insert(place, (best, units));
    }
    let least = placed.first().map_or(f64::INFINITY, |(best, _)| best.merit);
    let mut moved: Vec<(Placed, &Units)> = Vec::new();
    for (index, (best, units)) in placed.into_iter().enumerate() {
        let near = !best.reaches() || best.merit <= least + MOVED_WITHIN * least.abs();
        let moves = index < MOVED && near;
        let grid = Grid {
            setting: Setting { units, ..setting },
            tableau: &coarse,
            goals: &goals,
            elements: &elements,
        };
        let best = if moves {
            grid.moved(&mut runner, best)
        } else {
            best
        };
        let place = moved.partition_point(|(other, _)| other.rank() < best.rank());
        moved.insert(place, (best, units));
    }
    let mut locals: Vec<(Local, &Units)> = Vec::new();
    for effort in [Effort::Carry, Effort::Certify] {
        runner.effort = effort;
        for (placed, units) in moved.iter().filter(|(placed, _)| placed.reaches()) {
            let enough = locals.len() >= if effort == Effort::Carry { JUDGED } else { 1 };
            if enough || runner.stopped() {
                break;
            }
            let mut attempts = Attempts::new(Setting { units, ..setting }, &elements);
            let attempt = Attempt {
                sequence: &placed.candidate.sequence,
                guess: &placed.candidate.trajectory,
                cuts: &[],
                purpose: Purpose::Explore,
            };
            attempts.attempt(&mut runner, attempt)?;
            if let Some(best) = attempts.best.take() {
                let objective = best.solution.objective;
                let place =
                    locals.partition_point(|(other, _)| other.solution.objective < objective);
                locals.insert(place, (best, *units));
            }
        }
    }
    let mut found = Vec::new();
    let mut known = f64::INFINITY;
    for (start, (local, units)) in locals.into_iter().enumerate().take(JUDGED) {
        let setting = Setting { units, ..setting };
        let solution = judge(
            &mut runner,
            setting,
            finer,
            (local, Stationarity::None),
            known,
        )?;
        known = known.min(solution.objective);
        found.push(Found { start, solution });
    }
    let (counts, seconds) = (runner.counts, runner.seconds);
    match found.first_mut() {
        Some(first) => (first.solution.counts, first.solution.seconds) = (counts, seconds),
        None => return Ok(found),
    }
    for other in found.iter_mut().skip(1) {
        (other.solution.counts, other.solution.seconds) = (Counts::default(), Seconds::default());
    }
    Ok(found)
}
