//! The search over words, and what it finds on the grid of the problem.

use hangtime_solver::clock::ThreadTime;
use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nlp;

use super::optima::{Found, costs_the_same, is_confirmed, rank, result, sort};
use super::placing::{Begun, grids, on_grid};
use super::relaxed;
use super::run::{Begin, Task, demoted, failed, tableaus};
use super::shared_observer::SharedObserver;
use crate::Observer;
use crate::model::Model;
use crate::ocp::collocation::discretization::{Lengths, Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::global::guess::guess;
use crate::ocp::judge::confirm::{confirm, report};
use crate::ocp::judge::gradient::gradient;
use crate::ocp::judge::incumbent::incumbent;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::Local;
use crate::ocp::search::readings::Readings;
use crate::ocp::search::sampled::drawing_range;
use crate::ocp::search::throw::{End, Throw, ends};
use crate::ocp::settings::{ControlNodes, Guess, Settings};
use crate::ocp::solution::{Solution, Source, Status, WordCounts};
use crate::ocp::tuning::beginnings::TURNS;
use crate::ocp::tuning::equal::{COST, MOTION, OPTIMUM};
use crate::ocp::tuning::grids::{ELEMENTS_OF_ONE, FINER, KEPT};
use crate::ocp::tuning::off_grid::STAGES;
use crate::ocp::tuning::on_grid::{BEYOND, FINEST, NEAR, PLACED, SIMULATED};
use crate::ocp::words::aligned::{Aligned, followed};
use crate::ocp::words::beginnings::beginnings;
use crate::ocp::words::off_grid::{Goals, Timed};
use crate::ocp::words::on_grid::Grid;
use crate::ocp::words::search::Words;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// Said of a plan whose contacts do not change within equal intervals.
const ALIGNED: &str =
    "no motion on equal intervals was found: those of this one are aligned with its phases";

/// Solves by way of words. Without controls there is nothing to be constant on intervals, and yet each switch would have to stay in one of
/// them: so there is one, in which switches may be at any time.
pub(super) fn solve(
    model: &dyn Model,
    problem: &Problem,
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Solution, InputError> {
    let driven = !model.declaration().controls.is_empty() || problem.intervals == 1;
    let whole = Problem {
        intervals: if driven { problem.intervals } else { 1 },
        ..problem.clone()
    };
    let elements = if driven { 1 } else { ELEMENTS_OF_ONE };
    let settings = &Settings {
        elements: elements * settings.elements,
        ..settings.clone()
    };
    let observer = SharedObserver::new(observer);
    let task = Task::new((model, &whole, settings), &observer);
    let mut search = Search::new();
    let (failed, work) = task.run(Effort::Quick, |runner| {
        search.on_grids(&task, runner)?;
        match search.found.is_empty() {
            true => Ok(Some(failed(runner)?)),
            false => Ok(None),
        }
    })?;
    if let Some(failed) = failed {
        // Words without a motion end as they may; only where functions are not finite that says why.
        let status = match failed.status {
            Status::Failed(status) if status != nlp::Status::NotFinite => Status::NotFound,
            status => status,
        };
        search.keep(Solution {
            status,
            final_times: search.final_times,
            ..failed
        });
    }
    sort(&mut search.found);
    let mut solution = Solution {
        starts: search.starts,
        bound: search.bound,
        words: search.words,
        ..result(search.found, search.seen, work, observer.stopped())
    };
    if !driven {
        state_on(&mut solution, problem.intervals);
    }
    Ok(solution)
}

/// States a motion on one interval on that many.
fn state_on(solution: &mut Solution, intervals: usize) {
    for optimum in &mut solution.optima {
        optimum.intervals = intervals;
    }
    if let Some(previous) = &solution.previous {
        let resampled = previous.resampled(intervals);
        solution.controls = resampled.controls();
        solution.control_times = resampled.control_times();
        solution.previous = Some(resampled);
        let elements = solution.elements.iter().sum::<usize>();
        solution.elements = vec![elements.div_ceil(intervals); intervals];
    }
}

/// Words off the grid, with the units of their motions, and the grid that they are put on.
struct OffGrid<'a> {
    words: &'a [Timed],
    units: &'a [Units],
    setting: Setting<'a>,
    tableau: &'a ButcherTableau,
    goals: &'a Goals,
}

impl OffGrid<'_> {
    /// The grid of each word with so many elements of each interval.
    fn grids<'g>(&'g self, elements: &'g [usize]) -> Vec<Grid<'g, 'g>> {
        let grid = |units| Grid {
            setting: Setting {
                units,
                ..self.setting
            },
            tableau: self.tableau,
            goals: self.goals,
            elements,
        };
        self.units.iter().map(grid).collect()
    }
}

/// What was found so far.
struct Search {
    clock: Option<ThreadTime>,
    /// On the present grid.
    found: Vec<Found>,
    /// On all of them.
    seen: Vec<Found>,
    /// Guesses of the best word, and the words that were tried.
    starts: usize,
    words: WordCounts,
    /// The least merit of a word that meets its goals, or of a plan on the grid, which is one off it as well.
    bound: Option<f64>,
    /// A simulated motion that meets the goals, on the grid asked for.
    simulated: Option<Solution>,
    /// Final times that were looked at.
    final_times: (f64, f64),
}

impl Search {
    fn new() -> Self {
        Self {
            clock: ThreadTime::try_now().ok(),
            found: Vec::new(),
            seen: Vec::new(),
            starts: 0,
            words: WordCounts::default(),
            bound: None,
            simulated: None,
            final_times: (f64::NAN, f64::NAN),
        }
    }

    /// Adds what was found; beside an incumbent, as that where it is better.
    fn add(&mut self, runner: &mut Runner, solution: Solution) {
        if is_confirmed(&solution) {
            runner.ledger.plan(solution.objective);
        }
        self.keep(solution);
    }

    fn keep(&mut self, solution: Solution) {
        let elapsed = self.clock.as_ref().map(ThreadTime::try_elapsed);
        let elapsed = elapsed.and_then(Result::ok);
        let found = Found {
            source: Source::Words,
            cpu: elapsed.map_or(0.0, |elapsed| elapsed.as_secs_f64()),
            solution,
        };
        self.seen.push(found.clone());
        self.found.push(found);
    }

    /// Whether a motion is confirmed.
    fn is_confirmed(&self) -> bool {
        self.found.iter().any(|found| is_confirmed(&found.solution))
    }

    /// The least objective of a motion that is confirmed.
    fn least(&self) -> Option<f64> {
        let found = self.found.iter().map(|found| &found.solution);
        let confirmed = found.filter(|solution| is_confirmed(solution));
        confirmed
            .map(|solution| solution.objective)
            .min_by(f64::total_cmp)
    }

    /// Whether a plan was followed beyond all final times that were looked at.
    fn is_endless(&self) -> bool {
        let mut found = self.found.iter();
        found.any(|found| found.solution.status == Status::Unbounded)
    }

    /// On the grids that words are put on, and on the one asked for.
    fn on_grids(&mut self, task: &Task, runner: &mut Runner) -> Result<(), InputError> {
        let intervals = task.problem.intervals;
        let grids = match task.settings.grid {
            ControlNodes::Equal => grids(intervals),
            ControlNodes::Aligned => vec![intervals],
        };
        let problem = |intervals| Problem {
            intervals,
            ..task.problem.clone()
        };
        let problems: Vec<Problem> = grids.into_iter().map(problem).collect();
        let on = |problem| Task { problem, ..*task };
        let tasks: Vec<Task> = problems.iter().map(on).collect();
        let first = tasks.last().and_then(|task| relaxed::first(task, runner));
        let (proved, open) = match first {
            Some(plan) if plan.status == Status::Solved => (Some(plan), None),
            open => (None, open),
        };
        if let Some(plan) = &proved {
            runner.ledger.lead(plan.objective);
            self.keep(plan.clone());
        }
        self.by_words(&tasks, runner, proved.as_ref())?;
        // What is not proved is concluded where it is another plan, and a better one; what was simulated is no plan, but no result is worse.
        let least = self.least().unwrap_or(f64::INFINITY);
        self.bound = self.bound.map(|bound| bound.min(least));
        let simulated = self.simulated.take().filter(|_| !self.is_endless());
        let open = open.map(|plan| (plan, MOTION));
        for (plan, share) in open.into_iter().chain(simulated.map(|found| (found, COST))) {
            let least = self.least().unwrap_or(f64::INFINITY);
            let better = plan.objective + plan.tolerated(share) < least;
            if let Some(task) = tasks.last().filter(|_| better) {
                let leads = is_confirmed(&plan) && !runner.stopped();
                let carried = leads.then(|| task.carry(runner, &plan)).transpose()?;
                self.keep(carried.unwrap_or(plan));
            }
        }
        if problems
            .last()
            .is_some_and(|last| last.intervals < intervals)
        {
            let coarse = self.coarse();
            self.carried(task, runner, coarse.into_iter().take(KEPT))?;
        }
        Ok(())
    }

    /// Takes what was found on a grid, the best first.
    fn coarse(&mut self) -> Vec<Found> {
        let mut coarse = std::mem::take(&mut self.found);
        sort(&mut coarse);
        coarse.retain(|found| found.solution.motion.is_some());
        coarse
    }

    /// Adds what motions on a coarser grid lead to on that of a task.
    fn carried(
        &mut self,
        task: &Task,
        runner: &mut Runner,
        coarse: impl Iterator<Item = Found>,
    ) -> Result<(), InputError> {
        for found in coarse {
            let solution = task.carry(runner, &found.solution)?;
            self.add(runner, solution);
        }
        Ok(())
    }

    /// What the best words lead to on the grids of tasks, one after the other; they are looked for on the first. Beside a proved plan on the last
    /// one, the incumbent, that is the only grid.
    fn by_words(
        &mut self,
        tasks: &[Task],
        runner: &mut Runner,
        incumbent: Option<&Solution>,
    ) -> Result<(), InputError> {
        let Some(first) = tasks.first() else {
            return Ok(());
        };
        let (model, problem, settings) = (first.model, first.problem, first.settings);
        let (lower, upper) = bounds(model);
        let bounds = (&lower[..], &upper[..]);
        let guessed = guess(model, problem, &settings.guess, bounds)?;
        let scale = Scale::of(model, problem);
        let declared = Units::new(model, &scale, &guessed, bounds);
        let tableaus = tableaus(settings.stages);
        let tableau = tableaus.first().ok_or_else(|| settings.refuse_stages())?;
        let coarse = ButcherTableau::new(Scheme::RadauIia, STAGES)
            .ok_or_else(|| settings.refuse_stages())?;
        let parabolas = parabolas(model, &problem.start());
        let scene = (model, problem);
        let setting = |units| Setting::new(scene, settings, (tableau, units), (bounds, &parabolas));
        let range = drawing_range(setting(&declared))?;
        let units = declared.clone().driven_within((&range.0, &range.1));
        let setting = setting(&units);
        let allowed = setting.final_times().allowed(model);
        self.final_times = (allowed.shortest, allowed.longest);
        let plan = incumbent.and_then(|plan| plan.previous.as_ref());
        let mut turn = 0;
        let (words, goals, motions) = loop {
            let (begun, goals) = beginnings(runner, (setting, &guessed), (plan, &range, turn))?;
            if let (Some(motion), Some(task)) = (&begun.meeting, tasks.last()) {
                self.simulate(task, runner, (setting, motion))?;
            }
            let with = (begun.library, goals);
            let words = Words::new(setting, (&coarse, settings), &guessed, with);
            let (words, goals, counts, starts) = words.run(runner, &begun.words);
            self.starts += starts;
            self.words.tried += counts.tried;
            self.words.failed += counts.failed;
            turn += 1;
            let known = matches!(settings.guess, Guess::Previous(_));
            let draws = !known && turn < TURNS && settings.uses("redraw") && !runner.stopped();
            if !draws || words.first().is_some_and(Timed::meets) {
                break (words, goals, begun.motions);
            }
        };
        let reached = words.iter().filter(|word| word.meets());
        self.bound = reached.map(|timed| timed.merit).reduce(f64::min);
        let own = |word: &Timed| units.of_motion(model, &scale, word.trajectory(), bounds);
        let units: Vec<Units> = words.iter().map(own).collect();
        let skipped = incumbent.map_or(0, |_| tasks.len() - 1);
        for (index, task) in tasks.iter().enumerate().skip(skipped) {
            let before = incumbent.map_or_else(|| self.coarse(), |_| Vec::new());
            let setting = Setting {
                problem: task.problem,
                ..setting
            };
            let found = OffGrid {
                words: &words,
                units: &units,
                setting,
                tableau: &coarse,
                goals: &goals,
            };
            self.mapped(task, runner, &found)?;
            if index > 0 && !runner.stopped() {
                // So that a finer grid ends at nothing worse.
                let least = self.least().unwrap_or(f64::INFINITY);
                let better = before.into_iter().take(1);
                let better = better.filter(|coarse| coarse.solution.objective < least);
                self.carried(task, runner, better)?;
            } else if settings.grid == ControlNodes::Equal {
                self.simulated(task, runner, &motions)?;
            }
        }
        Ok(())
    }

    /// Keeps a motion that meets its goals, bounds and path constraints with its controls on the grid of a task as well, if it is the cheapest.
    fn simulate(
        &mut self,
        task: &Task,
        runner: &mut Runner,
        (setting, motion): (Setting, &Trajectory),
    ) -> Result<(), InputError> {
        let (problem, settings) = (task.problem, task.settings);
        let setting = Setting { problem, ..setting };
        let controls = &motion.controls;
        let throw = Throw {
            start: motion.states[0].clone(),
            controls: controls.resampled(settings.controls, problem.intervals),
            horizon: motion.horizon,
        };
        let ends = ends(setting, &throw, throw.horizon, usize::MAX);
        let meets = |end: &End| end.missing.iter().all(|missing| *missing == 0.0);
        let Some(end) = ends.last().filter(|end| meets(end)) else {
            return Ok(());
        };
        let exactly = vec![0.0; end.missing.len()];
        let found = incumbent(setting, settings, (&throw.over(throw.horizon), &exactly))?;
        let known = self.simulated.as_ref();
        let least = known.map_or(f64::INFINITY, |known| known.objective);
        if let Some(found) = found.filter(|found| found.objective < least) {
            report(runner, &found);
            self.simulated = Some(found);
        }
        Ok(())
    }

    /// What simulated motions lead to, the first ones of them, where no word leads to a motion.
    fn simulated(
        &mut self,
        task: &Task,
        runner: &mut Runner,
        motions: &[Candidate],
    ) -> Result<(), InputError> {
        for candidate in motions.iter().take(SIMULATED) {
            if runner.stopped() || self.is_confirmed() {
                break;
            }
            let begin = Begin {
                candidate: candidate.clone(),
                readings: Readings::All,
                elements: task.settings.elements,
            };
            let failure = runner.take_failure();
            let solution = task.conclude(runner, begin)?;
            runner.restore_failure(failure, true);
            if solution.motion.is_some() {
                self.add(runner, solution);
            }
        }
        Ok(())
    }

    /// What words lead to on the grid of a task, with more elements where re-simulations contradict all plans.
    fn mapped(
        &mut self,
        task: &Task,
        runner: &mut Runner,
        found: &OffGrid,
    ) -> Result<(), InputError> {
        let settings = task.settings;
        let mut factor = 1;
        let mut before = f64::INFINITY;
        loop {
            let count = factor * settings.elements;
            let elements = vec![count; task.problem.intervals];
            let grids = found.grids(&elements);
            if settings.grid == ControlNodes::Aligned {
                return self.aligned(runner, found.words, &grids, true);
            }
            runner.effort = Effort::Quick;
            let plans = on_grid(runner, found.words, &grids);
            let refuted = self.decided(task, runner, (plans.begun, count))?;
            if task.model.declaration().controls.is_empty() {
                self.by_phases(runner, found)?;
            }
            // What finer elements do not change is not for want of them.
            let best = self.least();
            let coarse =
                plans.cost && FINER * factor <= FINEST && best.is_none_or(|best| best < before);
            before = best.map_or(f64::INFINITY, |best| best - MOTION * best.abs());
            if self.is_confirmed() && !coarse || self.is_endless() || runner.stopped() {
                return Ok(());
            }
            if !(refuted || coarse) || FINER * factor > FINEST {
                return match settings.controls {
                    ControlShape::Constant => self.aligned(runner, found.words, &grids, false),
                    ControlShape::Linear => Ok(()),
                };
            }
            factor *= FINER;
        }
    }

    /// Without controls, where no plan on one interval comes to what the best word does: what that word comes to with intervals for each phase, on
    /// which nothing has to be constant, and with twice as many.
    fn by_phases(&mut self, runner: &mut Runner, found: &OffGrid) -> Result<(), InputError> {
        let reaches = |solution: &Solution, bound: f64| {
            rank(solution).0 == 0 && solution.objective <= bound + solution.tolerated(NEAR)
        };
        let phases = found.words.iter().map(Timed::phases);
        let mut intervals = phases.fold(ELEMENTS_OF_ONE, usize::max);
        let most = FINER * intervals;
        while intervals <= most && !runner.stopped() {
            let mut plans = self.found.iter().map(|found| &found.solution);
            let bound = self.bound;
            if bound.is_none_or(|bound| plans.any(|plan| reaches(plan, bound))) {
                break;
            }
            let problem = Problem {
                intervals,
                ..found.setting.problem.clone()
            };
            let setting = Setting {
                problem: &problem,
                ..found.setting
            };
            let elements = vec![1; intervals];
            let finer = OffGrid { setting, ..*found };
            let best = found.words.get(..1).unwrap_or_default();
            self.aligned(runner, best, &finer.grids(&elements), false)?;
            intervals *= FINER;
        }
        Ok(())
    }

    /// The best candidate with its neighbours decided; those after it where it is not confirmed, or not proved and the next one costs the
    /// same, or where neighbours have led to a better motion: then a poorer one may lead further. Whether re-simulations contradict all.
    fn decided(
        &mut self,
        task: &Task,
        runner: &mut Runner,
        (candidates, elements): (Vec<Begun>, usize),
    ) -> Result<bool, InputError> {
        let mut best: Option<Solution> = None;
        let mut improved = false;
        let mut refuted = false;
        for (candidate, readings) in candidates {
            let before = candidate.objective;
            if runner.ledger.is_outdone(before) {
                continue;
            }
            let enough = |best: &Solution| {
                let same = (best.objective - before).abs() <= best.tolerated(OPTIMUM);
                let open = best.status == Status::Uncertified && same;
                is_confirmed(best) && best.objective <= before + best.tolerated(OPTIMUM) && !open
            };
            if runner.stopped() || !improved && best.as_ref().is_some_and(enough) {
                break;
            }
            let begin = Begin {
                candidate,
                readings,
                elements,
            };
            let solution = task.conclude(runner, begin)?;
            if solution.motion.is_none() {
                continue;
            }
            improved = solution.objective < before - solution.tolerated(MOTION);
            refuted |= solution.status == Status::Unconfirmed;
            let better = best.as_ref().is_none_or(|best| {
                let proves = solution.status == Status::Solved && best.status != Status::Solved;
                rank(&solution) < rank(best) || costs_the_same(&solution, best) && proves
            });
            self.add(runner, solution.clone());
            if better {
                best = Some(solution);
            }
        }
        Ok(refuted)
    }

    /// What the best words come to with the intervals divided among their phases, and the words that these lead to, or else, where that is
    /// asked, what they come to on equal intervals does.
    fn aligned(
        &mut self,
        runner: &mut Runner,
        words: &[Timed],
        grids: &[Grid],
        only: bool,
    ) -> Result<(), InputError> {
        runner.effort = Effort::Quick;
        let before = self.found.len();
        let mut least = f64::INFINITY;
        for (start, (word, grid)) in words.iter().zip(grids).enumerate() {
            let enough = start >= PLACED && least.is_finite();
            if enough || runner.stopped() || word.merit > least + BEYOND * least.abs() {
                continue;
            }
            let Some(aligned) = Aligned::of(word, grid.setting.problem.intervals) else {
                continue;
            };
            let Some(mut solution) = confirmed(runner, grid, aligned)? else {
                continue;
            };
            if is_confirmed(&solution) {
                least = least.min(solution.objective);
            }
            let driven = !grid.setting.model.declaration().controls.is_empty();
            let named = driven && !only && solution.is_aligned();
            if let Some(motion) = solution.motion.as_mut().filter(|_| named) {
                motion.notes.push(ALIGNED.to_owned());
            }
            self.add(runner, solution);
        }
        if !only || self.found.len() > before {
            return Ok(());
        }
        for (plan, _) in on_grid(runner, words, grids).begun {
            if let Some(grid) = grids.first()
                && let Some(aligned) = Aligned::of_plan(plan)
                && let Some(solution) = confirmed(runner, grid, aligned)?
            {
                self.add(runner, solution);
            }
        }
        Ok(())
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
    for _ in 0..FINEST {
        let mesh = best.finer.take();
        if mesh.is_none() {
            elements *= 2;
        }
        let enough = mesh.is_none() && best.status != Status::Unconfirmed;
        if enough || runner.stopped() || elements > FINEST * runner.settings.elements {
            break;
        }
        let spans = aligned.spans(grid.setting, elements);
        let setting = Setting {
            mesh: mesh.as_deref(),
            ..grid.setting
        };
        let Ok(local) = aligned.solved(runner, setting, &spans) else {
            break;
        };
        let setting = Setting {
            lengths: Lengths::Phases(&spans),
            ..setting
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
    let mut local = local.polished(runner);
    let intervals = 0..setting.problem.intervals;
    let elements: Vec<usize> = intervals.map(|k| setting.ends(k, elements).len()).collect();
    let mut solution = confirm(runner, setting, &elements, &local, stationarity)?;
    solution.gradient = gradient(&mut local);
    // At an end of the final times that its program looks at a plan is no optimum: others lie beyond it.
    if setting.final_times().end_at(solution.horizon).is_some() {
        let status = solution.status;
        return Ok(demoted(solution, status, Status::Unbounded));
    }
    report(runner, &solution);
    Ok(solution)
}
