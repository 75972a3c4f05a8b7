//! Exploration on a coarse grid: motions from several starts side by side, until they bring nothing new.
//!
//! Programs on a coarse grid are small, so that many starts cost less than one program of the grid asked for. Starts are
//! solved in batches of a fixed size, each start by itself: what comes out does not depend on the number of threads.

use rayon::prelude::*;

use super::optima::{Found, rank};
use super::run::Task;
use crate::ocp::effort::Effort;
use crate::ocp::settings::{Guess, Settings};
use crate::simulation::InputError;

/// Starts that are solved side by side before it is asked whether they are enough: of fewer, two that agree may have
/// fallen into the same trap.
const BATCH: usize = 4;

/// Most iterations of a program of a start: of several, some take few.
const ITERATIONS: usize = 250;

/// First barrier parameter of the contact-implicit programs in which contacts act from a distance.
const FROM_A_DISTANCE: f64 = 10.0;

/// Relative difference of the objective within which two starts found the same motion.
const SAME: f64 = 1e-3;

/// What that many starts end at, in their order; fewer where the caller leaves their number open and the best motion is
/// found again. A single one is solved with all its programs.
pub(super) fn explore(task: &Task, starts: usize) -> Result<Vec<Found>, InputError> {
    if starts == 1 {
        return Ok(vec![task.solve_from(0, task.settings, Effort::Certify)?]);
    }
    let mut all: Vec<Found> = Vec::new();
    while all.len() < starts {
        let batch = all.len()..starts.min(all.len() + BATCH);
        let found = batch
            .into_par_iter()
            .map(|start| task.solve_from(start, &member(task.settings, start), Effort::Explore))
            .collect::<Result<Vec<_>, _>>()?;
        all.extend(found);
        let enough = task.settings.starts.is_none() && best_was_found_again(&all);
        if task.observer.stopped() || enough {
            break;
        }
    }
    Ok(all)
}

/// Whether two starts lead to the best motion.
fn best_was_found_again(all: &[Found]) -> bool {
    let confirmed = all.iter().map(|found| rank(&found.solution));
    let objectives: Vec<f64> = confirmed
        .filter(|rank| rank.0 == 0)
        .map(|rank| rank.1)
        .collect();
    let best = objectives.iter().copied().fold(f64::INFINITY, f64::min);
    let same = objectives
        .iter()
        .filter(|&&o| o - best <= SAME * best.abs());
    same.count() >= 2
}

/// The settings of a start; the guess of the first one is the caller's.
fn member(settings: &Settings, start: usize) -> Settings {
    let seed = start as u64;
    let (guess, barrier) = match start {
        0 => (settings.guess.clone(), settings.first_barrier),
        1 => (Guess::Random(seed), FROM_A_DISTANCE),
        2 => (Guess::Ride, settings.first_barrier),
        3 => (Guess::Random(seed), settings.first_barrier),
        4 => (Guess::Rest, FROM_A_DISTANCE),
        5 => (Guess::Perturbed(seed), FROM_A_DISTANCE),
        _ if start.is_multiple_of(2) => (Guess::Random(seed), settings.first_barrier),
        _ => (Guess::Random(seed), FROM_A_DISTANCE),
    };
    Settings {
        guess,
        first_barrier: barrier,
        maximum_iterations: settings.maximum_iterations.min(ITERATIONS),
        ..settings.clone()
    }
}
