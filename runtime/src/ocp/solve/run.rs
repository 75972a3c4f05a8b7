//! Runs on one grid: from a motion that may be near an optimum to a judged one.
//!
//! Programs look at final times within a factor of the motion that they start from, since a plan that is far from it is of another size than
//! the units that the program is measured in. That is no bound of the problem: where a plan lies at an end of the range, the run starts again
//! from it; so it does where controls without bounds come out of another size than they were measured in.

use hangtime_solver::clock::ThreadTime;
use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nlp;

use super::optima::{Work, is_as_good};
use super::shared_observer::SharedObserver;
use crate::Progress;
use crate::model::Model;
use crate::ocp::collocation::discretization::{Setting, parabolas};
use crate::ocp::effort::Effort;
use crate::ocp::judge::confirm::judge;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::runner::Runner;
use crate::ocp::program::units::Units;
use crate::ocp::progress::Watch;
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::{Attempts, Local};
use crate::ocp::search::proof::certificate;
use crate::ocp::search::readings::{Readings, attempt_readings};
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Solution, Status};
use crate::ocp::tuning::grids::{MORE_STAGES, MOVES, OFF_CENTRE};
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// A problem on one grid.
#[derive(Clone, Copy)]
pub(super) struct Task<'a, 's> {
    pub(super) model: &'a dyn Model,
    pub(super) problem: &'a Problem,
    pub(super) settings: &'a Settings,
    pub(super) observer: &'a SharedObserver<'s, 's>,
}

/// A motion to begin with, and how it is read.
pub(super) struct Begin {
    pub(super) candidate: Candidate,
    pub(super) readings: Readings,
    /// Finite elements of a phase in each interval.
    pub(super) elements: usize,
}

impl<'a, 's> Task<'a, 's> {
    pub(super) fn new(
        (model, problem, settings): (&'a dyn Model, &'a Problem, &'a Settings),
        observer: &'a SharedObserver<'s, 's>,
    ) -> Self {
        Self {
            model,
            problem,
            settings,
            observer,
        }
    }
}

impl Task<'_, '_> {
    /// Runs with a runner of its own, and says what that took.
    pub(super) fn run<T>(
        &self,
        effort: Effort,
        work: impl FnOnce(&mut Runner) -> Result<T, InputError>,
    ) -> Result<(T, Work), InputError> {
        let clock = ThreadTime::try_now();
        let run = self.observer.begin();
        let mut observer = |progress: &Progress| self.observer.goes_on(run, progress);
        let mut runner = Runner::new(self.settings, Watch::new(&mut observer), effort);
        let result = work(&mut runner)?;
        let (counts, mut seconds) = (runner.counts, runner.seconds);
        if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
            seconds.total = elapsed.as_secs_f64();
        }
        Ok((result, (counts, seconds)))
    }

    /// The optimum that a motion leads to: its sequence solved exactly, better neighbours followed and the others decided, re-simulated.
    /// Without one why there is none.
    pub(super) fn conclude(
        &self,
        runner: &mut Runner,
        begin: Begin,
    ) -> Result<Solution, InputError> {
        runner.effort = Effort::Conclude;
        self.followed(runner, begin)
    }

    /// The same, where nothing is to be proved without the neighbours.
    pub(super) fn followed(
        &self,
        runner: &mut Runner,
        begin: Begin,
    ) -> Result<Solution, InputError> {
        runner.grant();
        let Begin {
            mut candidate,
            mut readings,
            elements,
        } = begin;
        // The last plan that the run went on from.
        let mut before: Option<Round> = None;
        let mut looked_at: Option<FinalTimes> = None;
        let mut moves = 0;
        loop {
            let centre = before.as_ref().map(|_| candidate.trajectory.horizon);
            let with = (readings, elements, centre);
            let mut round = self.round(runner, candidate, with, moves < MOVES)?;
            let all = looked_at.map_or(round.range, |looked_at| looked_at.with(round.range));
            looked_at = Some(all);
            let next = round.next.take();
            if let Some(next) = next.filter(|_| !runner.stopped()) {
                (candidate, readings) = (next, Readings::Own);
                before = Some(round);
                moves += 1;
                continue;
            }
            let allowed = all.allowed(self.model);
            return Ok(Solution {
                final_times: (allowed.shortest, allowed.longest),
                ..conclusion(round, before)
            });
        }
    }

    /// What a motion on a coarser grid leads to on this one; where that is worse, or there is none, the motion itself as far as this grid
    /// contains that one.
    pub(super) fn carry(
        &self,
        runner: &mut Runner,
        from: &Solution,
    ) -> Result<Solution, InputError> {
        let Some(previous) = &from.previous else {
            return failed(runner);
        };
        let trajectory = previous.trajectory(self.model, self.problem)?;
        let begin = Begin {
            candidate: previous.candidate(&trajectory, self.problem.intervals),
            readings: Readings::Own,
            elements: self.settings.elements,
        };
        let solution = self.conclude(runner, begin)?;
        Ok(match on_grid(from, self.problem.intervals) {
            Some(kept) if !is_as_good(&solution, &kept) => kept,
            _ => solution,
        })
    }

    /// One round of that, with final times around the motion and units of it; where the plan asks for others, and there may be another round, that
    /// plan as it is.
    fn round(
        &self,
        runner: &mut Runner,
        candidate: Candidate,
        (readings, elements, centre): (Readings, usize, Option<f64>),
        may_move: bool,
    ) -> Result<Round, InputError> {
        let (model, problem) = (self.model, self.problem);
        let (lower, upper) = bounds(model);
        let bounds = (&lower[..], &upper[..]);
        let motion = &candidate.trajectory;
        let units = Units::new(model, &Scale::of(model, problem), motion, bounds);
        let units = units.measured_by(model, motion, bounds);
        // A large unit of the objective weighs feasibility more, which is what a motion wants that is far from any.
        let units = match readings {
            Readings::Own => units.exact(),
            Readings::All => units,
        };
        let tableaus = tableaus(self.settings.stages);
        let first = tableaus.split_first();
        let (tableau, finer) = first.ok_or_else(|| self.settings.refuse_stages())?;
        let parabolas = parabolas(model, &problem.start());
        let scene = (model, problem);
        let setting = Setting::new(
            scene,
            self.settings,
            (tableau, &units),
            (bounds, &parabolas),
        );
        let elements = vec![elements; problem.intervals];
        let mut attempts = Attempts::new(setting, &elements);
        attempt_readings(runner, &mut attempts, candidate, readings)?;
        let range = setting.final_times();
        let moved = |plan: &Local| {
            let far = centre.map(|centre| plan.trajectory.horizon / centre);
            let off_centre = far.is_some_and(|far| !(1.0 / OFF_CENTRE..=OFF_CENTRE).contains(&far));
            let at_an_end = range.end_at(plan.trajectory.horizon).is_some();
            let fits = units.fit(plan.trajectory.controls.values(), bounds);
            (at_an_end, off_centre || !fits)
        };
        let mut stationarity = Stationarity::None;
        if attempts
            .best
            .as_ref()
            .is_some_and(|best| runner.effort.proves() && moved(best) == (false, false))
        {
            stationarity = certificate(runner, &mut attempts);
        }
        let outdone = attempts.outdone.take();
        let Some(best) = attempts.best.take() else {
            let solution = failed(runner)?;
            return Ok(Round {
                solution,
                range,
                at_an_end: false,
                off_units: false,
                next: None,
            });
        };
        let (at_an_end, off_units) = moved(&best);
        // A plan at an end of the final times is not the last one: it is not worth finer grids.
        let finer = if at_an_end { &[] } else { finer };
        let next = (may_move && (at_an_end || off_units)).then(|| Candidate {
            objective: best.cost,
            sequence: best.sequence.clone(),
            trajectory: best.trajectory.clone(),
        });
        let with = (&elements[..], finer);
        Ok(Round {
            solution: judged(runner, setting, with, (best, stationarity), outdone)?,
            range,
            at_an_end,
            off_units,
            next,
        })
    }
}

/// The judgement of a plan, or of the one before it where the re-simulation confirms that one alone.
fn judged<'a>(
    runner: &mut Runner,
    setting: Setting<'a>,
    with: (&[usize], &'a [ButcherTableau]),
    best: (Local<'a>, Stationarity),
    outdone: Option<Local<'a>>,
) -> Result<Solution, InputError> {
    let solution = judge(runner, setting, with, best, f64::INFINITY)?;
    let Some(outdone) = outdone.filter(|_| solution.status == Status::Unconfirmed) else {
        return Ok(solution);
    };
    let last = (outdone, Stationarity::None);
    let other = judge(runner, setting, with, last, f64::INFINITY)?;
    Ok(match other.status {
        Status::Unconfirmed => solution,
        _ => other,
    })
}

/// What one round comes to.
struct Round {
    solution: Solution,
    /// The final times that were looked at.
    range: FinalTimes,
    /// Whether the plan lies at an end of them; whether it is of another size than its units.
    at_an_end: bool,
    off_units: bool,
    /// The plan, where another round is to begin with it.
    next: Option<Candidate>,
}

/// What the last round, and the plan that it went on from, come to.
fn conclusion(last: Round, before: Option<Round>) -> Solution {
    let status = last.solution.status;
    let inside = !last.at_an_end && !last.off_units;
    match before.filter(|_| !is_found(&last.solution)) {
        // What was found at an end, and is not found any more beyond it, has no optimum there either.
        Some(before) if before.at_an_end => demoted(before.solution, status, Status::Unbounded),
        // In units of its own size it was not confirmed.
        Some(before) => demoted(before.solution, status, Status::Uncertified),
        None if is_found(&last.solution) && !inside => {
            demoted(last.solution, status, Status::Unbounded)
        }
        None => last.solution,
    }
}

/// Whether there is a motion, and not only a plan that the dynamics do not follow.
fn is_found(solution: &Solution) -> bool {
    solution.motion.is_some() && solution.status != Status::Unconfirmed
}

/// A plan without its certificate, of another status, unless the last round was interrupted or the plan is none.
pub(super) fn demoted(plan: Solution, last: Status, status: Status) -> Solution {
    Solution {
        status: match last {
            Status::Interrupted => Status::Interrupted,
            _ if plan.status == Status::Unconfirmed => Status::Unconfirmed,
            _ => status,
        },
        stationarity: Stationarity::None,
        ..plan
    }
}

/// The schemes of a plan, of growing order.
pub(super) fn tableaus(stages: usize) -> Vec<ButcherTableau> {
    let stages = (stages..=ButcherTableau::MAX_STAGES).step_by(MORE_STAGES);
    let tableaus = stages.filter_map(|stages| ButcherTableau::new(Scheme::RadauIia, stages));
    tableaus.collect()
}

/// A result without a motion; an error where no program could be started.
pub(super) fn failed(runner: &mut Runner) -> Result<Solution, InputError> {
    let (status, violations) = match (runner.take_failure(), runner.take_refusal()) {
        (Some(failure), _) => (failure.status, failure.violations),
        (None, Some(refusal)) => return Err(refusal),
        (None, None) => (nlp::Status::Infeasible, Vec::new()),
    };
    let status = match status {
        _ if runner.stopped() => Status::Interrupted,
        nlp::Status::Infeasible => Status::NotFound,
        nlp::Status::Interrupted => Status::Interrupted,
        status => Status::Failed(status),
    };
    Ok(Solution::without_motion(status, violations, runner.counts))
}

/// A motion on a coarser grid as one on a grid with that many intervals, where every one of these lies within one of the
/// coarser grid. What was proved about its sequence does not hold on the finer grid.
fn on_grid(solution: &Solution, intervals: usize) -> Option<Solution> {
    let previous = solution.previous.as_ref()?;
    if !intervals.is_multiple_of(previous.intervals()) {
        return None;
    }
    let factor = intervals / previous.intervals();
    let resampled = previous.resampled(intervals);
    let (status, stationarity) = match solution.status {
        _ if factor == 1 => (solution.status, solution.stationarity),
        Status::Solved => (Status::Uncertified, Stationarity::None),
        status => (status, Stationarity::None),
    };
    let elements = solution.elements.iter();
    Some(Solution {
        status,
        stationarity,
        elements: elements
            .flat_map(|&elements| std::iter::repeat_n(elements, factor))
            .collect(),
        controls: resampled.controls(),
        control_times: resampled.control_times(),
        previous: Some(resampled),
        ..solution.clone()
    })
}
