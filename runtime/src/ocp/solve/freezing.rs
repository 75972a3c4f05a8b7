//! The time-freezing formulation: its complementarity problem gives the contact sequence, from several variants of it.

use hangtime_solver::Seconds;

use super::optima::{Found, Work, is_as_good, is_confirmed, result, sort};
use super::relaxed::relaxed;
use super::run::{Begin, Task, failed};
use super::shared_observer::SharedObserver;
use super::{known, words};
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::global::time_freezing_search::solve_exactly;
use crate::ocp::problem::Problem;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::readings::Readings;
use crate::ocp::settings::{Formulation, Guess, Settings, TimeFreezingSettings};
use crate::ocp::solution::{Counts, Solution, Source, Status, TimeFreezingReport};
use crate::ocp::tuning::freezing::{NEAR, VARIANTS};
use crate::simulation::InputError;
use crate::{Observer, Progress};
use rayon::prelude::*;

/// What variants lead to, and the work of all of them.
#[derive(Default)]
struct Runs {
    all: Vec<Found>,
    work: Work,
}

impl Runs {
    /// Adds a run behind those before it.
    fn add(&mut self, source: Source, (solution, (counts, seconds)): (Solution, Work)) -> usize {
        self.work.0.add(&counts);
        self.work.1 += seconds;
        self.all.push(Found {
            source,
            cpu: self.work.1.total,
            solution,
        });
        self.all.len() - 1
    }
}

/// Solves from all variants that are asked for side by side, or else from a few, and by the search over words where none leads to a motion;
/// the best of them, with the exact solution of its complementarity problem.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    formulation: &TimeFreezingSettings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let observer = SharedObserver::new(observer);
    let task = Task::new((model, problem, settings), &observer);
    let mut runs = Runs::default();
    let chosen = if settings.starts.is_none() && !matches!(settings.guess, Guess::Previous(_)) {
        few(&task, &mut runs)?
    } else {
        let starts = (0..settings.starts()).into_par_iter();
        let solved = starts.map(|start| from_start(&task, start));
        let solved = solved.collect::<Result<Vec<(Solution, Work)>, _>>()?;
        let solved = solved.into_iter().enumerate();
        let mut chosen: Vec<usize> = solved
            .map(|(start, run)| runs.add(Source::Start(start), run))
            .collect();
        or_by_words(&task, &mut runs, &mut chosen)?;
        chosen
    };
    let mut found: Vec<Found> = chosen
        .iter()
        .map(|&index| runs.all[index].clone())
        .collect();
    sort(&mut found);
    if let Some(best) = found.first_mut() {
        let work = exactly(&task, formulation, &mut best.solution)?;
        runs.work.0.add(&work.0);
        runs.work.1 += work.1;
    }
    Ok(result(found, runs.all, runs.work, observer.stopped()))
}

/// Variants where their number is left open: one on the grid asked for, one on a coarse grid, which is carried to this one where it comes to
/// more, the search over words where neither leads to a motion, and others until one leads to a certified motion. The indices of those that
/// are on this grid.
fn few(task: &Task, runs: &mut Runs) -> Result<Vec<usize>, InputError> {
    let intervals = task.problem.intervals;
    let factor = (intervals as f64 / NEAR as f64).round().max(1.0) as usize;
    let problem = Problem {
        intervals: intervals.div_ceil(factor),
        ..task.problem.clone()
    };
    let coarse = Task {
        problem: &problem,
        ..*task
    };
    let (first, second) = rayon::join(|| from_start(task, 0), || from_start(&coarse, 1));
    let first = runs.add(Source::Start(0), first?);
    let second = runs.add(Source::Start(1), second?);
    let mut chosen = vec![first];
    if factor == 1 {
        chosen.push(second);
    } else if !is_as_good(&runs.all[first].solution, &runs.all[second].solution) {
        let relaxed = runs.all[second].solution.clone();
        let carried = task.run(Effort::Conclude, |runner| {
            let mut carried = task.carry(runner, &relaxed)?;
            carried.time_freezing = relaxed.time_freezing.clone();
            Ok(carried)
        })?;
        chosen.push(runs.add(Source::Start(1), carried));
    }
    or_by_words(task, runs, &mut chosen)?;
    for start in 2..task.settings.starts() {
        let certified = |index: &usize| runs.all[*index].solution.status == Status::Solved;
        if task.observer.stopped() || chosen.iter().any(certified) {
            break;
        }
        chosen.push(runs.add(Source::Start(start), from_start(task, start)?));
    }
    by_its_word(task, runs, &mut chosen)?;
    Ok(chosen)
}

/// Adds what edits of the word of the best of the chosen runs lead to: the program has put its switches into intervals of the grid, where
/// they stay.
fn by_its_word(task: &Task, runs: &mut Runs, chosen: &mut Vec<usize>) -> Result<(), InputError> {
    let mut found: Vec<Found> = chosen.iter().map(|&run| runs.all[run].clone()).collect();
    sort(&mut found);
    let best = found.into_iter().next().map(|found| found.solution);
    let known = best.and_then(|best| Some((best.previous?, best.time_freezing?)));
    let driven = !task.model.declaration().controls.is_empty();
    if let Some((previous, report)) = known.filter(|_| driven && !task.observer.stopped()) {
        let (solution, work) = by_words(task, Guess::Previous(Box::new(previous)), None)?;
        let solution = Solution {
            time_freezing: Some(report),
            ..solution
        };
        chosen.push(runs.add(Source::Words, (solution, work)));
    }
    Ok(())
}

/// Adds what the search over words leads to where none of the chosen runs leads to a motion.
fn or_by_words(task: &Task, runs: &mut Runs, chosen: &mut Vec<usize>) -> Result<(), InputError> {
    let moves = |index: &usize| is_confirmed(&runs.all[*index].solution);
    if !task.observer.stopped() && !chosen.iter().any(moves) {
        let mut reports = runs.all.iter().map(|run| &run.solution.time_freezing);
        let report = reports.find_map(Clone::clone);
        let run = by_words(task, task.settings.guess.clone(), report)?;
        chosen.push(runs.add(Source::Words, run));
    }
    Ok(())
}

/// The motion that the search over words leads to, with the report of a relaxed program that led to none.
fn by_words(
    task: &Task,
    guess: Guess,
    report: Option<TimeFreezingReport>,
) -> Result<(Solution, Work), InputError> {
    let run = task.observer.begin();
    let mut observer = |progress: &Progress| task.observer.goes_on(run, progress);
    let settings = Settings {
        formulation: Formulation::Phases,
        starts: None,
        guess,
        ..task.settings.clone()
    };
    let mut solution = words::solve(task.model, task.problem, &settings, &mut observer)?;
    solution.time_freezing = report.map(|mut report| {
        report.relaxed.led_to_motion = false;
        report
    });
    let work = (solution.counts, solution.seconds);
    Ok((solution, work))
}

/// Solves from a variant.
fn from_start(task: &Task, start: usize) -> Result<(Solution, Work), InputError> {
    let settings = variant(task.settings, start);
    let task = Task {
        settings: &settings,
        ..*task
    };
    task.run(Effort::Conclude, |runner| match &settings.formulation {
        Formulation::TimeFreezing(formulation) => frozen(&task, runner, formulation),
        Formulation::Phases => failed(runner),
    })
}

/// The motion with the contact sequence of the relaxed program from the guess of the settings, and else from the ride without controls.
fn frozen(
    task: &Task,
    runner: &mut Runner,
    formulation: &TimeFreezingSettings,
) -> Result<Solution, InputError> {
    let settings = task.settings;
    if let Guess::Previous(previous) = &settings.guess {
        let solution = known::from_previous(task, runner, previous)?;
        if solution.motion.is_some() {
            return Ok(solution);
        }
    }
    let ride = (settings.guess != Guess::Ride).then_some(Guess::Ride);
    let (mut report, mut last) = (None, None);
    for kind in std::iter::once(settings.guess.clone()).chain(ride) {
        if runner.stopped() {
            break;
        }
        let (own, found) = relaxed(task, runner, formulation, &kind)?;
        report = own.or(report);
        let Some(candidate) = found else {
            continue;
        };
        let begin = Begin {
            candidate,
            readings: Readings::All,
            elements: settings.elements,
        };
        let solution = task.conclude(runner, begin)?;
        let moves = solution.motion.is_some();
        last = Some(solution);
        if moves {
            break;
        }
    }
    let solution = match last {
        Some(solution) => solution,
        None => failed(runner)?,
    };
    Ok(Solution {
        time_freezing: report,
        ..solution
    })
}

/// Solves the complementarity problem with the contact sequence of the motion that it has led to.
fn exactly(
    task: &Task,
    formulation: &TimeFreezingSettings,
    solution: &mut Solution,
) -> Result<Work, InputError> {
    let (Some(report), Some(previous)) = (&mut solution.time_freezing, &solution.previous) else {
        return Ok((Counts::default(), Seconds::default()));
    };
    let trajectory = previous.trajectory(task.model, task.problem)?;
    let motion = previous.candidate(&trajectory, task.problem.intervals);
    let scene = (task.model, task.problem);
    let ((), work) = task.run(Effort::Conclude, |runner| {
        solve_exactly(runner, scene, formulation, &motion, report)
    })?;
    Ok(work)
}

/// The settings of a variant; those of the first one are the caller's.
fn variant(settings: &Settings, start: usize) -> Settings {
    let mut variant = settings.clone();
    let Formulation::TimeFreezing(freezing) = &mut variant.formulation else {
        return variant;
    };
    if start > 0 {
        variant.guess = match start % 4 {
            0 => Guess::Random(start as u64),
            2 => Guess::Straight,
            _ => Guess::Ride,
        };
        let (elements, factor) = VARIANTS[start / 2 % VARIANTS.len()];
        freezing.elements += elements + start / 2 / VARIANTS.len();
        freezing.auxiliary_acceleration *= factor;
        if start > 1 && (start / 2).is_multiple_of(2) {
            // Of the rules that are good at contact sequences, now one, now the other leads to the better motion.
            freezing.rules.swap(0, 1);
        }
    }
    variant
}
