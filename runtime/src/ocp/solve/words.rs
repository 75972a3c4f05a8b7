//! The search over words, and what it finds on the grid of the problem.

use hangtime_solver::Seconds;
use hangtime_solver::clock::ThreadTime;
use hangtime_solver::mpcc::Stationarity;

use super::nested::{self, decided};
use super::one_grid::tableaus;
use super::optima::{Found, add_optima, is_better, is_same, result, sort};
use super::run::Task;
use super::shared_observer::SharedObserver;
use crate::model::Model;
use crate::ocp::collocation::discretization::{Lengths, Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::global::guess::guess;
use crate::ocp::judge::confirm::{confirm, judge, report};
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::progress::Watch;
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::{Attempt, Attempts, Local, Purpose};
use crate::ocp::search::sampled::drawing_range;
use crate::ocp::settings::{ControlNodes, Guess, Settings};
use crate::ocp::solution::{Counts, Solution, Source, Status};
use crate::ocp::tuning::grids::KEPT;
use crate::ocp::tuning::off_grid::STAGES;
use crate::ocp::tuning::on_grid::{
    BEYOND, FINE, FINEST, JUDGED, LEAST, MOVED, MOVED_WITHIN, PLACED,
};
use crate::ocp::words::aligned::{Aligned, followed};
use crate::ocp::words::beginnings::beginnings;
use crate::ocp::words::off_grid::Timed;
use crate::ocp::words::on_grid::{Grid, Placed};
use crate::ocp::words::search::Words;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;
use crate::{Observer, Progress};

/// Solves on the grid of the problem by way of words.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let (best, mut seen, stopped) = {
        let observer = SharedObserver::new(observer);
        let task = Task {
            model,
            problem,
            settings,
            observer: &observer,
        };
        if settings.grid == ControlNodes::Aligned {
            return solve_aligned(&task);
        }
        let first = first_grid(problem.intervals);
        let coarse = nested::with_intervals(problem, first);
        let there = Task {
            problem: &coarse,
            ..task
        };
        let mut seen = found_by_words(&there)?;
        let mut found = seen.clone();
        sort(&mut found);
        if first < problem.intervals {
            found.retain(|found| found.solution.motion.is_some());
            found.truncate(KEPT);
            found = nested::carry(&task, &found, &mut seen)?;
            sort(&mut found);
        }
        let best = decided(&task, found, Effort::Conclude, &mut seen)?;
        (best, seen, observer.stopped())
    };
    let best = best.filter(|best| best.solution.motion.is_some());
    if let Some(best) = &best
        && (stopped || is_enough(&best.solution, settings))
    {
        return Ok(result(vec![best.clone()], seen, stopped));
    }
    if stopped {
        return Ok(result(Vec::new(), seen, stopped));
    }
    // What is not proved among words may be on grids.
    let other = Found {
        start: 0,
        source: Source::Start(0),
        solution: nested::solve(model, problem, settings, observer)?,
    };
    let Some(best) = best else {
        return Ok(with_work(other.solution, &seen));
    };
    let stopped = other.solution.status == Status::Interrupted;
    let (starts, optima) = (other.solution.starts, other.solution.optima.clone());
    seen.push(other.clone());
    let proves = other.solution.status == Status::Solved && best.solution.status != Status::Solved;
    let better = is_better(&other, &best) || proves && is_same(&other.solution, &best.solution);
    let found = if better { other } else { best };
    let mut solution = Solution {
        starts,
        ..result(vec![found], seen, stopped)
    };
    add_optima(&mut solution, optima);
    Ok(solution)
}

/// Whether what words led to needs no starts on grids: where none are asked for, as it is proved, or as the rule is left out.
fn is_enough(solution: &Solution, settings: &Settings) -> bool {
    settings.starts.is_none() && (solution.status == Status::Solved || !settings.uses("grids"))
}

/// The same with control intervals that are aligned with phases.
fn solve_aligned(task: &Task) -> Result<Solution, InputError> {
    let mut found = found_by_words(task)?;
    let seen = found.clone();
    sort(&mut found);
    found.truncate(1);
    Ok(result(found, seen, task.observer.stopped()))
}

/// What was found on grids, with the work of what was looked at before.
fn with_work(mut solution: Solution, before: &[Found]) -> Solution {
    for Found { solution: run, .. } in before {
        solution.counts.add(&run.counts);
        solution.seconds += run.seconds;
    }
    solution
}

/// The grid that words are put on, on the way to one with that many intervals: the finest that it contains, or one that is near.
fn first_grid(intervals: usize) -> usize {
    let divides = |coarser: &usize| intervals.is_multiple_of(*coarser);
    let contained = (LEAST..=FINE.min(intervals)).rev().find(divides);
    contained.unwrap_or(intervals.div_ceil(intervals.div_ceil(FINE)))
}

/// The motions on the grid that the best words lead to, judged; without any the work alone. There is none where the best is as long as
/// plans may be, or as short: their final times have to be looked for, which is done on grids.
fn found_by_words(task: &Task) -> Result<Vec<Found>, InputError> {
    let Task {
        model,
        problem,
        settings,
        observer,
    } = *task;
    let clock = ThreadTime::try_now();
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
    let declared = Units::new(model, &scale, &straight, bounds);
    let tableaus = tableaus(settings.stages);
    let first = tableaus.split_first();
    let (tableau, finer) = first.ok_or_else(|| settings.refuse_stages())?;
    let coarse =
        ButcherTableau::new(Scheme::RadauIia, STAGES).ok_or_else(|| settings.refuse_stages())?;
    let parabolas = parabolas(model, &problem.start());
    let setting = |units| {
        Setting::new(
            (model, problem),
            settings,
            (tableau, units),
            (bounds, &parabolas),
        )
    };
    let range = drawing_range(setting(&declared))?;
    let units = declared.clone().driven_within((&range.0, &range.1));
    let setting = setting(&units);
    let (beginnings, library) = beginnings(&mut runner, setting, &range)?;
    let (words, goals) =
        Words::new(setting, (&coarse, settings), library).run(&mut runner, &beginnings);
    let own = |word: &Timed| units.of_motion(model, &scale, word.trajectory(), bounds);
    let units: Vec<Units> = words.iter().map(own).collect();
    let elements = vec![settings.elements; problem.intervals];
    let grids: Vec<Grid> = units
        .iter()
        .map(|units| Grid {
            setting: Setting { units, ..setting },
            tableau: &coarse,
            goals: &goals,
            elements: &elements,
        })
        .collect();
    let mut found = match settings.grid {
        ControlNodes::Equal => judged(&mut runner, &words, &grids, finer)?,
        ControlNodes::Aligned => aligned(&mut runner, &words, &grids, finer)?,
    };
    let (counts, mut seconds) = (runner.counts, runner.seconds);
    if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
        seconds.total = elapsed.as_secs_f64();
    }
    // The first one carries the work of all.
    for (index, one) in found.iter_mut().enumerate() {
        let work = if index == 0 {
            (counts, seconds)
        } else {
            Default::default()
        };
        (one.solution.counts, one.solution.seconds) = work;
    }
    Ok(found)
}

/// What the best words come to with the intervals divided among their phases, and the words that these lead to, or else what they come to
/// on equal intervals does; at least one, which may be without a motion.
fn aligned<'a>(
    runner: &mut Runner,
    words: &[Timed],
    grids: &[Grid<'a, 'a>],
    finer: &'a [ButcherTableau],
) -> Result<Vec<Found>, InputError> {
    let mut found: Vec<Found> = Vec::new();
    let mut least = f64::INFINITY;
    for (start, (word, grid)) in words.iter().zip(grids).enumerate() {
        let enough = start >= PLACED && least.is_finite();
        if enough || runner.stopped() || word.merit() > least + BEYOND * least.abs() {
            continue;
        }
        let Some(aligned) = Aligned::of(word, grid.setting.problem.intervals) else {
            continue;
        };
        let Some(solution) = confirmed(runner, grid, aligned)? else {
            continue;
        };
        if matches!(solution.status, Status::Solved | Status::Uncertified) {
            least = least.min(solution.objective);
        }
        found.push(Found {
            start,
            source: Source::Words,
            solution,
        });
    }
    let equal = match found.is_empty() {
        true => judged(runner, words, grids, finer)?,
        false => Vec::new(),
    };
    for plan in &equal {
        if let (Some(previous), Some(grid)) = (&plan.solution.previous, grids.first())
            && let Some(aligned) = Aligned::of_plan(previous.as_candidate())
            && let Some(solution) = confirmed(runner, grid, aligned)?
        {
            found.push(Found { solution, ..*plan });
        }
    }
    if found.is_empty() {
        let mut none = nothing();
        let times = grids.first().map(|grid| grid.setting.final_times());
        none.solution.final_times = times.map_or((f64::NAN, f64::NAN), |t| (t.shortest, t.longest));
        found.push(none);
    }
    Ok(found)
}

/// No motion.
fn nothing() -> Found {
    Found {
        start: 0,
        source: Source::Words,
        solution: Solution::without_motion(Status::NotFound, Vec::new(), Counts::default()),
    }
}

/// The best of the words that a word leads to, with so many elements that its re-simulation confirms it, as far as they become more.
fn confirmed(
    runner: &mut Runner,
    grid: &Grid,
    aligned: Aligned,
) -> Result<Option<Solution>, InputError> {
    let mut elements = runner.settings.elements;
    let first = (aligned, elements, grid.goals);
    let judge = |runner: &mut Runner, setting: Setting, local: Local, stationarity| {
        replayed(runner, setting, (local, stationarity), elements)
    };
    let found = followed(runner, grid.setting, first, judge)?;
    let Some((aligned, stationarity, mut best)) = found else {
        return Ok(None);
    };
    while best.status == Status::Unconfirmed && !runner.stopped() {
        elements *= 2;
        if elements > FINEST * runner.settings.elements {
            break;
        }
        let spans = aligned.spans(grid.setting, elements);
        let Ok(local) = aligned.solved(runner, grid.setting, &spans)? else {
            break;
        };
        let setting = Setting {
            lengths: Lengths::Phases(&spans),
            ..grid.setting
        };
        best = replayed(runner, setting, (local, stationarity), elements)?;
    }
    Ok(Some(best))
}

/// A plan of which that is proved, with so many elements an interval, polished and re-simulated.
fn replayed(
    runner: &mut Runner,
    setting: Setting,
    (local, stationarity): (Local, Stationarity),
    elements: usize,
) -> Result<Solution, InputError> {
    let local = local.polished(runner);
    let elements = vec![elements; setting.problem.intervals];
    let solution = confirm(runner, setting, &elements, &local, stationarity)?;
    report(runner, &solution);
    Ok(solution)
}

/// What the best words come to on the grid, judged; at least one, which may be without a motion.
fn judged<'a>(
    runner: &mut Runner,
    words: &[Timed],
    grids: &[Grid<'a, 'a>],
    finer: &'a [ButcherTableau],
) -> Result<Vec<Found>, InputError> {
    let placed = placed(runner, words, grids);
    let moved = moved(runner, placed, grids);
    let mut locals = solved(runner, &moved, grids)?;
    let ends = |(local, index): &(Local, usize)| {
        let range = grids[*index].setting.final_times();
        range.end_at(local.trajectory.horizon).is_some()
    };
    if locals.first().is_some_and(ends) {
        locals.clear();
    }
    let source = Source::Words;
    let mut found = Vec::new();
    let mut known = f64::INFINITY;
    for (start, (local, index)) in locals.into_iter().enumerate().take(JUDGED) {
        let local = (local, Stationarity::None);
        let solution = judge(runner, grids[index].setting, finer, local, known)?;
        known = known.min(solution.objective);
        found.push(Found {
            start,
            source,
            solution,
        });
    }
    if found.is_empty() {
        found.push(nothing());
    }
    Ok(found)
}

/// A word on the grid, and the index of the word, whose units it has.
type OnGrid = (Placed, usize);

/// Adds a word behind those that are better.
fn insert(all: &mut Vec<OnGrid>, one: OnGrid) {
    let place = all.partition_point(|(other, _)| other.rank() < one.0.rank());
    all.insert(place, one);
}

/// The words with their switches rounded to the grid, the best first.
fn placed(runner: &mut Runner, words: &[Timed], grids: &[Grid]) -> Vec<OnGrid> {
    let mut placed: Vec<OnGrid> = Vec::new();
    for (index, (word, grid)) in words.iter().zip(grids).enumerate() {
        let reached = placed.iter().find(|(best, _)| best.reaches());
        let least = reached.map_or(f64::INFINITY, |(best, _)| best.merit);
        let enough = index >= PLACED && least.is_finite();
        if enough || runner.stopped() || word.merit() > least + BEYOND * least.abs() {
            continue;
        }
        if let Some(best) = grid.rounded(runner, word) {
            insert(&mut placed, (best, index));
        }
    }
    placed
}

/// The same with the switches of the best ones moved through the ends of their intervals.
fn moved(runner: &mut Runner, placed: Vec<OnGrid>, grids: &[Grid]) -> Vec<OnGrid> {
    let least = placed.first().map_or(f64::INFINITY, |(best, _)| best.merit);
    let mut moved: Vec<OnGrid> = Vec::new();
    for (rank, (best, index)) in placed.into_iter().enumerate() {
        let near = !best.reaches() || best.merit <= least + MOVED_WITHIN * least.abs();
        let best = if rank < MOVED && near && runner.settings.uses("through") {
            grids[index].moved(runner, best)
        } else {
            best
        };
        insert(&mut moved, (best, index));
    }
    moved
}

/// The best ones that reach the goals, solved exactly, the best first; with all that can be done for one where quick programs solve none.
fn solved<'a>(
    runner: &mut Runner,
    moved: &[OnGrid],
    grids: &[Grid<'a, 'a>],
) -> Result<Vec<(Local<'a>, usize)>, InputError> {
    let mut locals: Vec<(Local, usize)> = Vec::new();
    for (effort, most) in [(Effort::Carry, JUDGED), (Effort::Certify, 1)] {
        runner.effort = effort;
        for (placed, index) in moved.iter().filter(|(placed, _)| placed.reaches()) {
            if locals.len() >= most || runner.stopped() {
                break;
            }
            let grid = &grids[*index];
            let mut attempts = Attempts::new(grid.setting, grid.elements);
            let attempt = Attempt {
                sequence: &placed.candidate.sequence,
                guess: &placed.candidate.trajectory,
                cuts: &[],
                purpose: Purpose::Explore,
            };
            attempts.attempt(runner, attempt)?;
            if let Some(best) = attempts.best.take() {
                let objective = best.solution.objective;
                let place =
                    locals.partition_point(|(other, _)| other.solution.objective < objective);
                locals.insert(place, (best, *index));
            }
        }
    }
    Ok(locals)
}
