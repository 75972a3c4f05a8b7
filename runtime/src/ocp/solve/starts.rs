//! Starts without an exploration: variants of the time-freezing formulation, and a known motion.

use rayon::prelude::*;

use super::optima::{Found, result, sort};
use super::run::Task;
use super::shared_observer::SharedObserver;
use crate::Observer;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::problem::Problem;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Solution, Status};
use crate::simulation::InputError;

/// Elements an interval of the refined programs of the starts. Motions differ in their discretizations more than in
/// their guesses.
const REFINED_ELEMENTS: [usize; 5] = [4, 3, 6, 2, 5];

/// Changes of the time-freezing formulation: elements added, and a factor of the auxiliary acceleration.
const FREEZING: [(usize, f64); 4] = [(0, 1.0), (0, 0.5), (1, 1.0), (0, 2.0)];

/// Starts of the time-freezing formulation, one after the other until one leads to a certified motion, where their number
/// is left open.
const ATTEMPTS: usize = 6;

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
    let run = |start| task.solve_from(start, &variant(settings, start), Effort::Conclude);
    let freezes = matches!(settings.formulation, Formulation::TimeFreezing(_));
    let seen = if freezes && settings.starts.is_none() {
        let mut seen: Vec<Found> = Vec::new();
        let certified = |found: &Found| found.solution.status == Status::Solved;
        while seen.len() < ATTEMPTS && !observer.stopped() && !seen.iter().any(certified) {
            seen.push(run(seen.len())?);
        }
        seen
    } else {
        let runs = (0..settings.starts()).into_par_iter().map(run);
        runs.collect::<Result<Vec<Found>, _>>()?
    };
    let mut found = seen.clone();
    sort(&mut found);
    Ok(result(found, seen, observer.stopped()))
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
            let (elements, factor) = FREEZING[start / 2 % FREEZING.len()];
            freezing.elements += elements + start / 2 / FREEZING.len();
            freezing.auxiliary_acceleration *= factor;
        }
    }
    variant
}
