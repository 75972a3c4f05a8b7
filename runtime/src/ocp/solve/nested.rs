//! Nested grids: what is found on a grid is a candidate on every grid that contains it.
//!
//! Contact sequences are looked for where programs are small, on the coarsest grids whose intervals are made up of those
//! of the grid asked for. A motion goes from there to all multiples of its grid that divide the one asked for, and is kept
//! where a finer grid ends at a worse one. On each of them the neighbours of the best motion are decided, as a call for that
//! grid alone would do it. So the result is not worse than that of such a call, unless that one looks from more starts: the grid with all
//! starts is the finest of the coarsest ones, which differs between 10 and 30 intervals, but not between 10, 20 and 40. A single start,
//! which is asked for to be quick, decides neighbours on the grid asked for only; it solves the coarsest grids with all programs. Where
//! several are asked for, what it ends at is among the candidates, and so is what as many as are usually enough do.
//! The motion that is returned is polished at last; the search goes on from those that are not.

use super::one_grid::{Known, Trace};
use super::optima::{
    Found, costs_the_same, ends_at_no_time, is_better, is_same, rank, result, sort,
};
use super::portfolio::{Explored, explore};
use super::run::{Task, is_as_good, on_grid};
use super::shared_observer::SharedObserver;
use crate::Observer;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::problem::Problem;
use crate::ocp::search::candidates::Proved;
use crate::ocp::settings::{Guess, Settings};
use crate::ocp::solution::{Solution, Source, Status};
use crate::ocp::tuning::equal::{COST, MOTION};
use crate::ocp::tuning::grids::{
    BESIDE, COARSE, COARSEST, FINER, FINEST, KEPT, NEAR, NO_MOTION, PROGRAMS, STARTS_OF_ONE_TRIED,
    TRIED, WORTH,
};
use crate::simulation::InputError;

/// Solves on the grid of the problem by way of coarser ones, with finer elements where most plans are none.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let observer = SharedObserver::new(observer);
    let scene = (model, problem);
    let mut tried = settings.clone();
    let mut asks = true;
    let mut seen = Vec::new();
    // Least objective of the motions among plans most of which were none, and what finer elements have led to.
    let mut left = f64::INFINITY;
    let mut finer: Option<Solution> = None;
    loop {
        let asks_for_finer = asks && FINER * tried.elements <= FINEST;
        let with = (&tried, asks_for_finer);
        let solution = match solve_in_elements(scene, with, &observer, &mut seen)? {
            Ended::AtAResult(solution) => *solution,
            Ended::TooCoarse { least } => {
                left = left.min(least);
                tried.elements *= FINER;
                continue;
            }
        };
        if let Some(finer) = finer {
            return Ok(better_of(finer, solution));
        }
        let poorer = solution.objective > left + solution.tolerated(MOTION);
        let found = rank(&solution).0 <= 1 && !poorer;
        if found || tried.elements == settings.elements || observer.stopped() {
            return Ok(solution);
        }
        // Finer elements have led to no motion, or to a poorer one than coarse ones, which may still lead to more.
        let mut failed = Found {
            start: 0,
            source: Source::Start(0),
            solution: solution.clone(),
        };
        leave_its_work(&mut failed);
        seen.push(failed);
        finer = Some(solution);
        (tried, asks) = (settings.clone(), false);
    }
}

/// What finer elements have led to, or coarse ones, with the work of all, which the last has done.
fn better_of(finer: Solution, last: Solution) -> Solution {
    if is_as_good(&last, &finer) {
        return last;
    }
    let status = match last.status {
        Status::Interrupted => Status::Interrupted,
        _ => finer.status,
    };
    Solution {
        status,
        counts: last.counts,
        seconds: last.seconds,
        ..finer
    }
}

/// Where the search with some number of elements ends.
enum Ended {
    AtAResult(Box<Solution>),
    /// The plans of most starts are no motions; with the least objective of those that are.
    TooCoarse {
        least: f64,
    },
}

impl Ended {
    fn of(found: Vec<Found>, seen: Vec<Found>, stopped: bool) -> Self {
        Self::AtAResult(Box::new(result(found, seen, stopped)))
    }

    fn of_too_coarse(found: &[Found]) -> Self {
        let motions = found.iter().filter(|found| rank(&found.solution).0 == 0);
        let objectives = motions.map(|found| found.solution.objective);
        Self::TooCoarse {
            least: objectives.fold(f64::INFINITY, f64::min),
        }
    }
}

/// The same with the elements of the settings. What is run is added to `seen`; without a result if these are too coarse, where that is
/// asked.
fn solve_in_elements<'o>(
    (model, problem): (&dyn Model, &Problem),
    (settings, asks): (&Settings, bool),
    observer: &SharedObserver<'o, 'o>,
    seen: &mut Vec<Found>,
) -> Result<Ended, InputError> {
    let most = if settings.starts() == 1 {
        settings.maximum_programs
    } else {
        PROGRAMS
    };
    let proves = settings.starts() > 1;
    let tried = TRIED.max(settings.starts() / STARTS_OF_ONE_TRIED);
    let kept = if proves { KEPT + 1 } else { KEPT };
    let quick = Settings {
        maximum_programs: settings.maximum_programs.min(most),
        ..settings.clone()
    };
    let mut known: Vec<(usize, Vec<Found>)> = Vec::new();
    let grids = grids(problem.intervals);
    // One start on this grid alone is solved with all programs at once.
    let complete = settings.starts() == 1 && grids.len() == 1 && problem.intervals <= COARSE;
    let single = if complete {
        Effort::Conclude
    } else {
        Effort::Certify
    };
    for &intervals in &grids {
        let grid = with_intervals(problem, intervals);
        let task = Task {
            model,
            problem: &grid,
            settings: &quick,
            observer,
        };
        let coarser = known.iter().filter(|known| is_next(known.0, intervals));
        let from: Vec<Found> = coarser.flat_map(|(_, found)| found.clone()).collect();
        let explores = from.is_empty();
        let from = best_of(from, kept);
        let found = if explores {
            let starts = starts(&grids, intervals, settings);
            let found = look(&task, (starts, single), settings, seen)?;
            let asks = asks && starts == settings.starts() && !observer.stopped();
            if asks && is_too_coarse(settings, &found) {
                seen.iter_mut().for_each(leave_its_work);
                return Ok(Ended::of_too_coarse(&found));
            }
            found
        } else if from.iter().any(|found| found.solution.motion.is_some()) {
            carry(&task, &from, seen)?
        } else {
            from
        };
        if let Some(endless) = endless(&task, &found, problem.intervals) {
            let seen = std::mem::take(seen);
            return Ok(Ended::of(vec![endless], seen, observer.stopped()));
        }
        let mut found = best_of(found, tried);
        if intervals < problem.intervals {
            let task = Task { settings, ..task };
            if proves {
                found = proven(&task, found, seen)?;
            }
            found = looked_again(&task, found, seen)?;
        }
        known.push((intervals, found));
    }
    let mut found = known.pop().map_or(Vec::new(), |(_, found)| found);
    let task = Task {
        model,
        problem,
        settings,
        observer,
    };
    if !complete {
        conclude(&task, &mut found, seen)?;
    }
    let seen = std::mem::take(seen);
    Ok(Ended::of(found, seen, observer.stopped()))
}

/// Whether more plans that starts led to are none than are motions: an element holds more of the motion than its polynomials follow.
fn is_too_coarse(settings: &Settings, found: &[Found]) -> bool {
    let solutions = || found.iter().map(|found| &found.solution);
    let far = |solution: &&Solution| {
        solution.status == Status::Unconfirmed && solution.departure > NO_MOTION
    };
    let confirmed = |solution: &&Solution| rank(solution).0 == 0;
    settings.starts() > 1 && solutions().filter(far).count() > solutions().filter(confirmed).count()
}

/// Leaves no more of a run than its work.
fn leave_its_work(found: &mut Found) {
    let Solution {
        status,
        counts,
        seconds,
        ..
    } = found.solution;
    found.solution = Solution {
        seconds,
        ..Solution::without_motion(status, Vec::new(), counts)
    };
}

/// A motion in no time, which a finer grid makes no longer, on the grid that was asked for.
fn endless(task: &Task, found: &[Found], intervals: usize) -> Option<Found> {
    let mut found = found.iter();
    let endless = found.find(|found| ends_at_no_time(task.model, &found.solution))?;
    Some(Found {
        start: endless.start,
        source: endless.source,
        solution: on_grid(&endless.solution, intervals)?,
    })
}

pub(super) fn with_intervals(problem: &Problem, intervals: usize) -> Problem {
    Problem {
        intervals,
        ..problem.clone()
    }
}

/// The grids on the way to one with that many intervals, which is the last of them.
fn grids(intervals: usize) -> Vec<usize> {
    let divides = |coarser: &usize| intervals.is_multiple_of(*coarser);
    let mut grids: Vec<usize> = (COARSEST..intervals).filter(divides).collect();
    grids.push(intervals);
    grids
}

/// Whether a grid is contained in another one with no grid between them.
fn is_next(coarser: usize, finer: usize) -> bool {
    let factor = finer / coarser;
    finer.is_multiple_of(coarser) && factor > 1 && (2..factor).all(|p| !factor.is_multiple_of(p))
}

/// Starts on a grid that contains none of the others: all on the finest of those, a few on the others.
fn starts(grids: &[usize], intervals: usize, settings: &Settings) -> usize {
    let contains_none = |grid: &&usize| !grids.iter().any(|&other| is_next(other, **grid));
    if grids.iter().rfind(contains_none) == Some(&intervals) {
        settings.starts()
    } else {
        settings.starts().min(BESIDE)
    }
}

/// Looks for motions from nothing; on a fine grid by way of one that is coarser, but not contained in it. What is run is
/// added to `seen`.
fn look(
    task: &Task,
    (starts, single): (usize, Effort),
    settings: &Settings,
    seen: &mut Vec<Found>,
) -> Result<Vec<Found>, InputError> {
    let intervals = task.problem.intervals;
    let on_this_grid = intervals <= COARSE;
    let factor = if on_this_grid {
        1
    } else {
        (intervals as f64 / NEAR as f64).round() as usize
    };
    let coarse = with_intervals(task.problem, intervals.div_ceil(factor));
    let problem = &coarse;
    let there = Task { problem, ..*task };
    let Explored { mut found, enough } = explore(&there, starts, single)?;
    seen.extend(found.iter().cloned());
    if starts > 1 && task.settings.starts.is_some() {
        let enough = enough.unwrap_or(starts);
        let fewer = fewer_end_at(&Task { settings, ..there }, (&found, starts, enough), seen)?;
        found.extend(fewer);
    }
    if on_this_grid {
        Ok(found)
    } else {
        carry(task, &best_of(found, KEPT), seen)
    }
}

/// What a single start ends at, and, where more are asked for than are `enough`, what these do, with the neighbours decided: of many
/// starts the best motion may be one whose neighbours lead to a poorer one. What is run is added to `seen`.
fn fewer_end_at(
    task: &Task,
    (found, starts, enough): (&[Found], usize, usize),
    seen: &mut Vec<Found>,
) -> Result<Vec<Found>, InputError> {
    let single = task.solve_from(0, task.settings, Effort::Certify)?;
    seen.push(single.clone());
    let enough = enough.min(Settings::default().starts());
    let mut all = vec![single];
    if enough < starts && !task.observer.stopped() {
        let (first, others) = found.split_at(starts.min(found.len()));
        let beside = others.iter();
        let first = first.iter().take(enough).chain(beside).cloned().collect();
        all.extend(decided(task, best_of(first, TRIED), Effort::Certify, seen)?);
    }
    Ok(all)
}

/// The motions on this grid that those on coarser grids lead to, which are added to `seen`; one that comes to where another
/// one does ends there.
pub(super) fn carry(
    task: &Task,
    from: &[Found],
    seen: &mut Vec<Found>,
) -> Result<Vec<Found>, InputError> {
    let mut known = Known::default();
    let mut found = Vec::new();
    for (index, from) in from.iter().enumerate() {
        let (carried, trace) = task.carry(from, Effort::Carry, known.from(index))?;
        known.extend(trace.known);
        known.ended_at(&carried.solution);
        found.push(carried);
    }
    seen.extend(found.iter().cloned());
    Ok(found)
}

/// The motions that go on from a grid, the best of them as a call for that grid alone ends at it: so a finer grid begins no worse.
fn proven(task: &Task, found: Vec<Found>, seen: &mut Vec<Found>) -> Result<Vec<Found>, InputError> {
    let best = decided(task, found.clone(), Effort::Certify, seen)?;
    let mut all: Vec<Found> = best.into_iter().collect();
    all.extend(found.into_iter().take(KEPT));
    Ok(best_of(all, KEPT + 1))
}

/// Decides the neighbours of the best motion, and of the next one where it is not confirmed; without one that is, looks once
/// more on the grid asked for, with all programs. The result is what is left of `found`.
fn conclude(task: &Task, found: &mut Vec<Found>, seen: &mut Vec<Found>) -> Result<(), InputError> {
    let Some(best) = decided(task, std::mem::take(found), Effort::Conclude, seen)? else {
        return Ok(());
    };
    *found = looked_again(task, vec![best], seen)?;
    Ok(())
}

/// Without a motion that is confirmed, the best of what a further search on this grid comes to, with all programs.
fn looked_again(
    task: &Task,
    mut found: Vec<Found>,
    seen: &mut Vec<Found>,
) -> Result<Vec<Found>, InputError> {
    // States that controls can lead to were looked for on coarse grids already, unless there was a single start.
    let reaches = task.problem.intervals > COARSE && task.settings.starts() > 1;
    let guesses = [task.settings.guess.clone(), Guess::Reachable];
    for guess in guesses.into_iter().take(1 + usize::from(reaches)) {
        let failed = found.first().is_none_or(|best| {
            !matches!(rank(&best.solution).0, 0 | 1) && best.solution.status != Status::Unbounded
        });
        if !failed || task.observer.stopped() {
            break;
        }
        let settings = Settings {
            guess,
            ..task.settings.clone()
        };
        let other = task.solve_from(0, &settings, Effort::Conclude)?;
        seen.push(other.clone());
        if found.first().is_none_or(|best| is_better(&other, best)) {
            found.insert(0, other);
        }
    }
    Ok(found)
}

/// The best motion with its neighbours decided; those after it where it is not confirmed, or not proved and the next one costs the same, or
/// where neighbours have led to a better motion:
/// then those that starts came to are not optima yet, and a poorer one may lead further. One that comes through what was passed on the
/// way to a motion that is proved leads there as well, and ends.
pub(super) fn decided(
    task: &Task,
    found: Vec<Found>,
    effort: Effort,
    seen: &mut Vec<Found>,
) -> Result<Option<Found>, InputError> {
    let mut best: Option<Found> = None;
    let mut improved = false;
    let mut passed = Known::default();
    for (index, one) in found.into_iter().enumerate() {
        let enough = |best: &Found| {
            let unproved = best.solution.status == Status::Uncertified;
            is_as_good(&best.solution, &one.solution)
                && !(unproved && costs_the_same(&best.solution, &one.solution))
        };
        if !improved && best.as_ref().is_some_and(enough) {
            break;
        }
        let before = one.solution.objective;
        let (one, trace) = judged(task, one, (effort, passed.from(index)), seen)?;
        if one.solution.status == Status::Solved {
            passed.extend(trace.known);
        }
        improved = one.solution.objective < before - one.solution.tolerated(MOTION);
        if best.as_ref().is_none_or(|best| is_better(&one, best)) {
            best = Some(one);
        }
    }
    Ok(best)
}

/// A motion on the grid of the task as what its re-simulation and its neighbours come to. Of one that is proved already only switches
/// at the ends of intervals are looked at, and it is polished where it may be the result; it is left for a better one.
fn judged(
    task: &Task,
    one: Found,
    (effort, passed): (Effort, Known),
    seen: &mut Vec<Found>,
) -> Result<(Found, Trace), InputError> {
    let Solution {
        status,
        stationarity,
        objective,
        ..
    } = one.solution;
    let unpolished = objective + one.solution.tolerated(COST);
    let open = matches!(status, Status::Uncertified | Status::Unconfirmed);
    let solved = status == Status::Solved;
    if !(open || solved) || task.observer.stopped() {
        return Ok((one, Trace::default()));
    }
    let known = Known {
        proved: solved.then_some(Proved {
            stationarity,
            objective,
        }),
        ..passed
    };
    let (carried, trace) = task.carry(&one, effort, known)?;
    let better = rank(&carried.solution).0 == 0
        && carried.solution.objective < objective - carried.solution.tolerated(COST);
    let worse = carried.solution.objective > unpolished;
    if solved && !better && (worse || carried.solution.status != Status::Solved) {
        let mut carried = carried;
        leave_its_work(&mut carried);
        seen.push(carried);
        return Ok((one, trace));
    }
    seen.push(carried.clone());
    Ok((carried, trace))
}

/// At most so many of the best distinct motions, which go on, the best first, after a plan that would be better than these if
/// it were confirmed; without any, one of the failures.
fn best_of(mut found: Vec<Found>, most: usize) -> Vec<Found> {
    sort(&mut found);
    let least = found
        .first()
        .map_or(f64::NAN, |best| best.solution.objective);
    let better = |found: &Found| {
        found.solution.status == Status::Unconfirmed && found.solution.objective < least
    };
    let place = found.iter().position(better);
    let plan = place.map(|place| found.remove(place));
    plan.into_iter().chain(distinct(found, most)).collect()
}

/// At most so many of the best distinct motions of those that are sorted; without any, one of the failures.
fn distinct(found: Vec<Found>, most: usize) -> Vec<Found> {
    let mut best: Vec<Found> = Vec::new();
    for one in found {
        let Some(first) = best.first() else {
            best.push(one);
            continue;
        };
        let worth = first.solution.objective + first.solution.tolerated(WORTH);
        let known = best
            .iter()
            .any(|other| is_same(&other.solution, &one.solution));
        let promising = one.solution.motion.is_some() && one.solution.objective <= worth;
        if promising && !known && best.len() < most {
            best.push(one);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_on_the_way_are_those_that_the_grid_asked_for_contains() {
        assert_eq!(grids(40), [8, 10, 20, 40]);
        assert_eq!(grids(10), [10]);
        assert_eq!(grids(3), [3]);
        assert_eq!(grids(37), [37]);
        let next = |finer: usize| -> Vec<usize> {
            let coarser = grids(60).into_iter();
            coarser.filter(|&coarser| is_next(coarser, finer)).collect()
        };
        assert_eq!(next(60), [12, 20, 30]);
        assert_eq!(next(30), [10, 15]);
        assert!(next(10).is_empty());
    }

    #[test]
    fn all_starts_are_tried_on_one_grid_and_a_few_on_the_others() {
        let settings = Settings {
            starts: Some(9),
            ..Settings::default()
        };
        assert_eq!(starts(&grids(40), 10, &settings), 9);
        assert_eq!(starts(&grids(40), 8, &settings), BESIDE);
        assert_eq!(starts(&grids(5), 5, &settings), 9);
    }
}
