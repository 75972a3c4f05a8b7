//! Starts without an exploration: variants of the time-freezing formulation, and a known motion.

use rayon::prelude::*;

use super::nested;
use super::one_grid::Known;
use super::optima::{Found, rank, result, sort};
use super::run::{Task, is_as_good};
use super::shared_observer::SharedObserver;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::problem::Problem;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Solution, Source, Status, TimeFreezingReport};
use crate::ocp::tuning::freezing::VARIANTS;
use crate::ocp::tuning::grids::{NEAR, REFINED_ELEMENTS};
use crate::simulation::InputError;
use crate::{Observer, Progress};

/// Solves from all starts side by side; the first result among the best, and the distinct local optima.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let observer = SharedObserver::new(observer);
    let task = Task {
        model,
        problem,
        settings,
        observer: &observer,
    };
    let freezes = matches!(settings.formulation, Formulation::TimeFreezing(_));
    let known = matches!(settings.guess, Guess::Previous(_));
    let (mut found, mut seen) = if freezes && settings.starts.is_none() && !known {
        freeze(&task)?
    } else {
        let runs = (0..settings.starts()).into_par_iter();
        let runs = runs.map(|start| from_start(&task, start));
        (runs.collect::<Result<Vec<Found>, _>>()?, Vec::new())
    };
    sort(&mut found);
    if let Some(best) = found.first_mut().filter(|_| freezes) {
        task.solve_exactly(&mut best.solution)?;
    }
    seen.extend(found.iter().cloned());
    Ok(result(found, seen, observer.stopped()))
}

/// Starts of the time-freezing formulation where their number is left open: one on the grid asked for, one on a coarse grid,
/// which is carried to this one where it comes to more, the contact-implicit search where neither leads to a motion, and others until
/// one leads to a certified motion. What they end at on this grid, and on the coarse one.
fn freeze(task: &Task) -> Result<(Vec<Found>, Vec<Found>), InputError> {
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
    let (mut found, second) = (vec![first?], second?);
    let mut seen = Vec::new();
    if factor == 1 {
        found.push(second);
    } else {
        if !is_as_good(&found[0].solution, &second.solution) {
            let (mut carried, _) = task.carry(&second, Effort::Conclude, Known::default())?;
            let relaxed = second.solution.time_freezing.clone();
            carried.solution.time_freezing = carried.solution.time_freezing.or(relaxed);
            found.push(carried);
        }
        seen.push(second);
    }
    let moves = |found: &Found| rank(&found.solution).0 == 0;
    if !task.observer.stopped() && !found.iter().any(moves) {
        let mut reports = found.iter().map(|found| &found.solution.time_freezing);
        let report = reports.find_map(Clone::clone);
        found.push(in_phases(task, report)?);
    }
    let certified = |found: &Found| found.solution.status == Status::Solved;
    for start in 2..task.settings.starts() {
        if task.observer.stopped() || found.iter().any(certified) {
            break;
        }
        found.push(from_start(task, start)?);
    }
    Ok((found, seen))
}

/// The motion that the contact-implicit search leads to, with the report of a relaxed program that led to none.
fn in_phases(task: &Task, report: Option<TimeFreezingReport>) -> Result<Found, InputError> {
    let run = task.observer.begin();
    let mut observer = |progress: &Progress| task.observer.goes_on(run, progress);
    let settings = Settings {
        formulation: Formulation::Phases,
        ..task.settings.clone()
    };
    let mut solution = nested::solve(task.model, task.problem, &settings, &mut observer)?;
    solution.time_freezing = report.map(|mut report| {
        report.relaxed.led_to_motion = false;
        report
    });
    let start = task.settings.starts();
    Ok(Found {
        start,
        source: Source::Start(start),
        solution,
    })
}

/// Solves from a start.
fn from_start(task: &Task, start: usize) -> Result<Found, InputError> {
    task.solve_from(start, &variant(task.settings, start), Effort::Conclude)
}

/// The settings of a start; those of the first one are the caller's.
fn variant(settings: &Settings, start: usize) -> Settings {
    let mut variant = Settings { ..settings.clone() };
    if start == 0 {
        return variant;
    }
    let guess = match start % 4 {
        0 => Guess::Straight,
        1 => Guess::Ride,
        2 => Guess::Perturbed(start as u64),
        _ => Guess::Rest,
    };
    match &mut variant.formulation {
        Formulation::Phases => {
            variant.guess = guess;
            variant.refined_elements = REFINED_ELEMENTS[start % REFINED_ELEMENTS.len()];
        }
        Formulation::TimeFreezing(freezing) => {
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
    }
    variant
}
