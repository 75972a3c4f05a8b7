//! Several starts side by side, and the local optima that they end at.

use std::sync::Mutex;

use rayon::prelude::*;

use super::levels::solve_once;
use crate::Observer;
use crate::model::Model;
use crate::ocp::problem::Problem;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Optimum, Solution, Status};
use crate::simulation::InputError;

/// Elements an interval of the refined programs of the starts. Motions differ in their discretizations more than in
/// their guesses.
const REFINED_ELEMENTS: [usize; 5] = [4, 3, 6, 2, 5];

/// Changes of the time-freezing formulation: elements added, and a factor of the auxiliary acceleration.
const FREEZING: [(usize, f64); 4] = [(0, 1.0), (0, 0.5), (1, 1.0), (0, 2.0)];

/// Relative difference of the objective within which two local optima count as the same.
const SAME: f64 = 1e-6;

/// Solves from all starts; the first result among the best, and the distinct local optima.
pub(in crate::ocp) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let shared = Mutex::new((observer, false));
    let solutions = (0..settings.starts)
        .into_par_iter()
        .map(|start| {
            let settings = variant(settings, start);
            solve_once(model, problem, &settings, &mut |progress| {
                // A poisoned lock means that another start's observer panicked: stop.
                let Ok(mut shared) = shared.lock() else {
                    return false;
                };
                let (observer, stopped) = &mut *shared;
                *stopped = *stopped || !observer(progress);
                !*stopped
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let optima = optima(&solutions);
    let seconds = solutions.iter().map(|solution| solution.seconds).sum();
    let best = solutions.into_iter().reduce(|best, other| {
        let (a, b) = (rank(&other), rank(&best));
        if a.0 < b.0 || a.0 == b.0 && a.1 < b.1 {
            other
        } else {
            best
        }
    });
    match best {
        Some(best) => Ok(Solution {
            seconds,
            optima,
            ..best
        }),
        None => Err(settings.refuse_starts()),
    }
}

/// The settings of a start; those of the first one are the caller's.
fn variant(settings: &Settings, start: usize) -> Settings {
    let mut variant = Settings {
        starts: 1,
        ..settings.clone()
    };
    if start == 0 {
        return variant;
    }
    let guess = match start % 4 {
        0 => Guess::Straight,
        1 => Guess::Ride,
        2 => Guess::Perturbed { seed: start as u64 },
        _ => Guess::Rest,
    };
    match &mut variant.formulation {
        Formulation::Phases => {
            variant.guess = guess;
            variant.refined_elements = REFINED_ELEMENTS[start % REFINED_ELEMENTS.len()];
        }
        Formulation::TimeFreezing(freezing) => {
            variant.guess = if start.is_multiple_of(2) {
                Guess::Straight
            } else {
                Guess::Ride
            };
            let (elements, factor) = FREEZING[start / 2 % FREEZING.len()];
            freezing.elements += elements + start / 2 / FREEZING.len();
            freezing.auxiliary_acceleration *= factor;
        }
    }
    variant
}

/// The smaller the better: confirmed motions first; among equals the objective.
fn rank(solution: &Solution) -> (usize, f64) {
    let class = match solution.status {
        Status::Solved | Status::Uncertified => 0,
        Status::Interrupted if solution.motion.is_some() => 1,
        Status::Unconfirmed | Status::Unbounded => 2,
        _ => 3,
    };
    let objective = if solution.objective.is_nan() {
        f64::INFINITY
    } else {
        solution.objective
    };
    (class, objective)
}

/// The distinct local optima, the best first.
fn optima(solutions: &[Solution]) -> Vec<Optimum> {
    let mut optima: Vec<Optimum> = Vec::new();
    let mut sorted: Vec<(usize, &Solution)> = solutions.iter().enumerate().collect();
    sorted.sort_by(|a, b| rank(a.1).1.total_cmp(&rank(b.1).1));
    for (start, solution) in sorted {
        if solution.motion.is_none() || rank(solution).0 == 2 {
            continue;
        }
        let switches = solution.planned_events.len();
        let tolerance = SAME * solution.objective.abs().max(f64::MIN_POSITIVE);
        let same = |other: &&mut Optimum| {
            other.switches == switches && (other.objective - solution.objective).abs() <= tolerance
        };
        if let Some(known) = optima.iter_mut().find(same) {
            known.starts.push(start);
            known.starts.sort_unstable();
            continue;
        }
        optima.push(Optimum {
            objective: solution.objective,
            horizon: solution.horizon,
            status: solution.status,
            stationarity: solution.stationarity,
            switches,
            starts: vec![start],
        });
    }
    optima
}
