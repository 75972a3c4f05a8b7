//! Single runs on one grid: from a start, or from a motion on a coarser grid.

use hangtime_solver::Seconds;
use hangtime_solver::clock::ThreadTime;
use hangtime_solver::mpcc::Stationarity;

use super::final_times::solve_grid;
use super::one_grid::{Known, Start, Trace};
use super::optima::{Found, rank};
use super::shared_observer::SharedObserver;
use crate::Progress;
use crate::model::Model;
use crate::ocp::effort::Effort;
use crate::ocp::global::time_freezing_search::solve_exactly;
use crate::ocp::previous::Previous;
use crate::ocp::problem::Problem;
use crate::ocp::program::runner::Runner;
use crate::ocp::progress::Watch;
use crate::ocp::settings::{Formulation, Guess, Settings};
use crate::ocp::solution::{Counts, Solution, Source, Status};
use crate::ocp::tuning::equal::OPTIMUM;
use crate::simulation::InputError;

/// A problem on one grid.
#[derive(Clone, Copy)]
pub(super) struct Task<'a, 's> {
    pub(super) model: &'a dyn Model,
    pub(super) problem: &'a Problem,
    pub(super) settings: &'a Settings,
    pub(super) observer: &'a SharedObserver<'s, 's>,
}

impl Task<'_, '_> {
    /// Solves from a start with its settings.
    pub(super) fn solve_from(
        &self,
        start: usize,
        settings: &Settings,
        effort: Effort,
    ) -> Result<Found, InputError> {
        let known = Known::default().from(start);
        let (found, _) = self.solve_after(settings, effort, known)?;
        Ok(found)
    }

    /// The same where that is known from searches before.
    pub(super) fn solve_after(
        &self,
        settings: &Settings,
        effort: Effort,
        known: Known,
    ) -> Result<(Found, Trace), InputError> {
        let start = known.start;
        let source = match settings.guess {
            Guess::Sampled => Source::Samples,
            Guess::Stepping => Source::Gaits,
            _ => Source::Start(start),
        };
        let (solution, trace) = self.solve(settings, None, effort, known)?;
        let found = Found {
            start,
            source,
            solution,
        };
        Ok((found, trace))
    }

    /// Carries a motion on a coarser grid, or on this one, to this grid, where that is known from searches before. Where
    /// the motion that it leads to is worse, or none is found, the motion itself is kept as far as this grid contains it.
    pub(super) fn carry(
        &self,
        from: &Found,
        effort: Effort,
        known: Known,
    ) -> Result<(Found, Trace), InputError> {
        let previous = from.solution.previous.clone();
        let (solution, trace) = self.solve(self.settings, previous, effort, known)?;
        let kept = on_grid(&from.solution, self.problem.intervals);
        let solution = match kept {
            Some(kept) if !is_as_good(&solution, &kept) => Solution {
                counts: solution.counts,
                seconds: solution.seconds,
                ..kept
            },
            _ => solution,
        };
        let found = Found { solution, ..*from };
        Ok((found, trace))
    }

    /// Solves the complementarity problem of the time-freezing formulation, if that was asked for, with the contact sequence of the
    /// motion that it has led to.
    pub(super) fn solve_exactly(&self, solution: &mut Solution) -> Result<(), InputError> {
        let (Formulation::TimeFreezing(formulation), Some(report), Some(previous)) = (
            &self.settings.formulation,
            &mut solution.time_freezing,
            &solution.previous,
        ) else {
            return Ok(());
        };
        let trajectory = previous.trajectory(self.model, self.problem)?;
        let motion = previous.candidate(&trajectory, self.problem.intervals);
        let run = self.observer.begin();
        let mut observer = |progress: &Progress| self.observer.goes_on(run, progress);
        let mut runner = Runner::new(
            self.settings,
            Watch::new(&mut observer),
            (solution.counts, solution.seconds),
            Effort::Conclude,
        );
        let scene = (self.model, self.problem);
        solve_exactly(&mut runner, scene, formulation, &motion, report)?;
        (solution.counts, solution.seconds) = (runner.counts, runner.seconds);
        Ok(())
    }

    fn solve(
        &self,
        settings: &Settings,
        coarser: Option<Previous>,
        effort: Effort,
        known: Known,
    ) -> Result<(Solution, Trace), InputError> {
        let clock = ThreadTime::try_now();
        let run = self.observer.begin();
        let mut observer = |progress: &Progress| self.observer.goes_on(run, progress);
        let start = Start {
            watch: Watch::new(&mut observer),
            counts: Counts::default(),
            seconds: Seconds::default(),
            coarser,
            known,
            effort,
        };
        let (mut solution, trace) = solve_grid(self.model, self.problem, settings, start)?;
        if let Ok(elapsed) = clock.and_then(|clock| clock.try_elapsed()) {
            solution.seconds.total = elapsed.as_secs_f64();
        }
        Ok((solution, trace))
    }
}

/// Whether a solution came to as much as another one: to one that is confirmed sooner than to one that is not, else to an
/// objective that is not worse.
pub(super) fn is_as_good(solution: &Solution, kept: &Solution) -> bool {
    let (a, b) = (rank(solution), rank(kept));
    a.0 < b.0 || a.0 == b.0 && a.1 <= b.1 + kept.tolerated(OPTIMUM)
}

/// A motion on a coarser grid as one on a grid with that many intervals, where every one of these lies within one of the
/// coarser grid. What was proved about its sequence does not hold on the finer grid.
pub(super) fn on_grid(solution: &Solution, intervals: usize) -> Option<Solution> {
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
