//! Exploration on a coarse grid: motions from several starts side by side, until several agree on the best.
//!
//! Programs on a coarse grid are small, so that many starts cost less than one program of the grid asked for. Starts are
//! solved in batches of a fixed size, each start by itself: what comes out does not depend on the number of threads. A
//! start ends where one of an earlier batch was before, which makes those cheap that bring nothing new; after the first
//! batch every second one begins at the best motion so far, bent out of shape, which finds what random motions seldom do. Where that
//! batch has no motion at all, the next one begins with those that simulated controls lead nearest to the goals. One start of the second
//! batch takes its contact sequence from the program of the time-freezing system, which ends at other motions than the contact-implicit ones.
//! Beside the first batch simulated motions are tried, one of each order of impacts, and gaits. Where others come through their sequences
//! they do not end, as these are many; and of the starts near the best every second one is near the best of the others, so that these do not
//! decide alone where is looked.

use std::ops::Range;

use hangtime_solver::nlp;
use rayon::prelude::*;

use super::one_grid::{Known, Trace};
use super::optima::{Found, ends_at_no_time, rank};
use super::run::Task;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::problem::has_free_start;
use crate::ocp::settings::{EulerStep, Formulation, Guess, Settings, TimeFreezingSettings};
use crate::ocp::solution::{Counts, Solution, Source, Status};
use crate::ocp::tuning::equal::MOTION;
use crate::ocp::tuning::grids::{
    AGREEING, BATCH, BENDS, FREEZES, FROM_A_DISTANCE, ITERATIONS, NEAR_THE_BEST, SAMPLES,
};
use crate::simulation::InputError;

/// What an exploration ends at.
pub(super) struct Explored {
    /// What the starts end at, in their order, and then what simulated motions and gaits lead to.
    pub(super) found: Vec<Found>,
    /// The first starts that were enough, where more were asked for.
    pub(super) enough: Option<usize>,
}

/// What that many starts end at; fewer where the caller leaves their number open and the best motion is
/// found again. A `single` one is solved with all its programs.
pub(super) fn explore(task: &Task, starts: usize, single: Effort) -> Result<Explored, InputError> {
    if starts == 1 {
        let found = vec![task.solve_from(0, task.settings, single)?];
        let enough = None;
        return Ok(Explored { found, enough });
    }
    let mut exploration = Exploration::of(task);
    let mut enough = None;
    while exploration.all.len() < starts {
        let solved = exploration.all.len();
        // The first start alone: where it leads to is what others need not look for.
        let end = match solved {
            0 => 1,
            _ => (solved / BATCH + 1) * BATCH,
        };
        exploration.solve(solved..starts.min(end));
        if enough.is_none() && exploration.agrees() {
            enough = Some(exploration.all.len());
        }
        let ends = enough.is_some() && task.settings.starts.is_none();
        if task.observer.stopped() || ends || exploration.ends_at_no_time() {
            break;
        }
    }
    exploration.into_found(enough)
}

/// Starts that are solved batch by batch.
struct Exploration<'t, 'a, 's> {
    task: &'t Task<'a, 's>,
    /// What the starts so far ended at, in their order.
    all: Vec<Found>,
    /// What simulated motions and gaits lead to.
    beside: Vec<Found>,
    known: Known,
    /// Why starts could not be solved.
    refusals: Vec<InputError>,
}

impl<'t, 'a, 's> Exploration<'t, 'a, 's> {
    fn of(task: &'t Task<'a, 's>) -> Self {
        Self {
            task,
            all: Vec::new(),
            beside: Vec::new(),
            known: Known::default(),
            refusals: Vec::new(),
        }
    }

    /// Solves starts side by side, each by itself.
    fn solve(&mut self, batch: Range<usize>) {
        let samples = batch.contains(&SAMPLES) && has_surfaces(self.task.model);
        let of_starts = best(self.all.iter());
        let best = best(self.all.iter().chain(&self.beside));
        let runs = batch.into_par_iter().map(|start| {
            let near = if start % (2 * NEAR_THE_BEST) == 1 {
                best
            } else {
                of_starts.or(best)
            };
            let near = near.filter(|_| looks_near_the_best(start));
            let near = near.and_then(|best| best.solution.previous.clone());
            let known = Known {
                near: near.map(|near| (near, BENDS[start / 2 % BENDS.len()])),
                ..self.known.from(start)
            };
            let mut settings = member(self.task.settings, start, best.is_some());
            if start == FREEZES && can_freeze(self.task.model) {
                settings.formulation = Formulation::TimeFreezing(TimeFreezingSettings::default());
                settings.guess = Guess::Straight;
            }
            let run = self.task.solve_after(&settings, Effort::Explore, known);
            (start, run)
        });
        let guesses = [Guess::Sampled, Guess::Stepping];
        let guesses = guesses.into_par_iter().filter(|_| samples);
        let others = guesses.filter_map(|guess| with_guess(self.task, guess, &self.known));
        let (runs, others) =
            rayon::join(|| runs.collect::<Vec<_>>(), || others.collect::<Vec<_>>());
        self.beside.extend(others);
        for (start, run) in runs {
            self.add(start, run);
        }
    }

    /// Adds what a start ended at.
    fn add(&mut self, start: usize, run: Result<(Found, Trace), InputError>) {
        let (mut found, trace) = match run {
            Ok(run) => run,
            Err(refusal) => {
                self.refusals.push(refusal);
                self.all.push(refused(start));
                return;
            }
        };
        // What is asked for is the motion.
        found.solution.time_freezing = None;
        if let Some(start) = trace.repeats {
            found = again(found, &self.all[start]);
        }
        self.known.extend(trace.known);
        self.known.ended_at(&found.solution);
        self.all.push(found);
    }

    /// Whether enough starts lead to the best motion. Where initial values are free as well, those of the first batch agree on what is
    /// nearest too often.
    fn agrees(&self) -> bool {
        let seen = self.all.len() > BATCH || !has_free_start(self.task.model);
        seen && best_was_found_again(&self.all, &self.beside)
    }

    /// Whether a motion in no time was found, which no other start betters.
    fn ends_at_no_time(&self) -> bool {
        let mut all = self.all.iter();
        all.any(|found| ends_at_no_time(self.task.model, &found.solution))
    }

    /// What all of it ends at; an error where no start could be solved.
    fn into_found(self, enough: Option<usize>) -> Result<Explored, InputError> {
        let refused = self.refusals.len();
        match self.refusals.into_iter().next() {
            Some(refusal) if refused == self.all.len() => Err(refusal),
            _ => Ok(Explored {
                enough: enough.filter(|&enough| enough < self.all.len()),
                found: self.all.into_iter().chain(self.beside).collect(),
            }),
        }
    }
}

/// The best that a guess which is none of the starts leads to, beside what is known.
fn with_guess(task: &Task, guess: Guess, known: &Known) -> Option<Found> {
    let settings = Settings {
        guess,
        ..member(task.settings, SAMPLES, false)
    };
    let run = task.solve_after(&settings, Effort::Explore, known.from(SAMPLES));
    let (found, _) = run.ok()?;
    Some(found)
}

/// A start at which the functions of the model are not finite: others may lead to a motion.
fn refused(start: usize) -> Found {
    let status = Status::Failed(nlp::Status::NotFinite);
    Found {
        start,
        source: Source::Start(start),
        solution: Solution::without_motion(status, Vec::new(), Counts::default()),
    }
}

/// A run that came to where another one was before: its result is that of the other one.
fn again(run: Found, other: &Found) -> Found {
    Found {
        start: run.start,
        source: run.source,
        solution: Solution {
            counts: run.solution.counts,
            seconds: run.solution.seconds,
            ..other.solution.clone()
        },
    }
}

/// The best motion so far, if there is one.
fn best<'f>(all: impl Iterator<Item = &'f Found>) -> Option<&'f Found> {
    let found = all.filter(|found| rank(&found.solution).0 == 0);
    found.min_by(|a, b| a.solution.objective.total_cmp(&b.solution.objective))
}

/// Whether enough starts lead to the best motion; those that began near it do not count, nor do simulated motions, of which the best
/// of many is taken.
fn best_was_found_again(all: &[Found], beside: &[Found]) -> bool {
    let Some(best) = best(all.iter().chain(beside)) else {
        return false;
    };
    let most = best.solution.objective + best.solution.tolerated(MOTION);
    let independent = all.iter().filter(|found| !looks_near_the_best(found.start));
    let same = independent.map(|found| rank(&found.solution));
    let same = same.filter(|rank| rank.0 == 0 && rank.1 <= most);
    same.count() >= AGREEING
}

/// Whether a start looks near the best motion so far, if there is one.
fn looks_near_the_best(start: usize) -> bool {
    start >= BATCH && start % NEAR_THE_BEST == 1
}

/// Whether the program of the time-freezing system differs from a program without contacts.
fn can_freeze(model: &dyn Model) -> bool {
    let contacts = model.declaration().contacts;
    !contacts.is_empty() && contacts.iter().all(|known| known.switch.is_none())
}

/// Whether there is anything to be struck.
fn has_surfaces(model: &dyn Model) -> bool {
    let mut contacts = model.declaration().contacts.iter();
    contacts.any(|contact| !contact.dry)
}

/// The settings of a start; the guess of the first one is the caller's. Those near the best have a guess as well: there may be
/// none yet. Where the first batch has not `found` a motion, one looks for states that controls can lead to.
fn member(settings: &Settings, start: usize, found: bool) -> Settings {
    let guess = match start {
        0 => settings.guess.clone(),
        2 => Guess::Ride,
        4 if !found => Guess::Reachable,
        4 => Guess::Rest,
        5 => Guess::Perturbed(start as u64),
        _ => Guess::Random(start as u64),
    };
    let from_a_distance = start == 1 || start == 4 || looks_near_the_best(start);
    let symplectic = if start < BATCH {
        !start.is_multiple_of(2)
    } else {
        !(start / 2).is_multiple_of(2)
    };
    Settings {
        guess,
        first_barrier: if from_a_distance {
            FROM_A_DISTANCE
        } else {
            settings.first_barrier
        },
        step: if symplectic {
            EulerStep::Symplectic
        } else {
            EulerStep::Implicit
        },
        maximum_iterations: settings.maximum_iterations.min(ITERATIONS),
        ..settings.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ended_at(start: usize, objective: f64) -> Found {
        let nothing = Solution::without_motion(Status::Solved, Vec::new(), Counts::default());
        Found {
            start,
            source: Source::Start(start),
            solution: Solution {
                objective,
                ..nothing
            },
        }
    }

    #[test]
    fn starts_near_the_best_say_nothing_of_how_often_it_is_found() {
        let near = [5, 7, 9, 11];
        assert!(near.iter().all(|&start| looks_near_the_best(start)));
        let mut all: Vec<Found> = [0, 2, 4].map(|start| ended_at(start, 1.0)).into();
        all.extend(near.map(|start| ended_at(start, 1.0)));
        assert!(!best_was_found_again(&all, &[]));
        all.push(ended_at(6, 2.0));
        assert!(!best_was_found_again(&all, &[]));
        all.push(ended_at(8, 1.0));
        assert!(best_was_found_again(&all, &[]));
    }

    #[test]
    fn better_motion_near_the_best_has_to_be_found_by_others_as_well() {
        let mut all: Vec<Found> = [0, 1, 2, 4].map(|start| ended_at(start, 2.0)).into();
        assert!(best_was_found_again(&all, &[]));
        all.push(ended_at(5, 1.0));
        assert!(!best_was_found_again(&all, &[]));
    }
}
