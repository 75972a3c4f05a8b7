//! What the solver tells whoever waits, and how it is stopped.

use hangtime_solver::clock::Instant;
use hangtime_solver::nlp::IterationInfo;

use super::solution::Counts;
use crate::progress::BestMotion;
use crate::{Observer, Progress};

/// The observer, and whether it has asked to stop.
pub(in crate::ocp) struct Watch<'o> {
    observer: &'o mut Observer<'o>,
    start: Instant,
    progress: Progress,
    /// Iterations of the programs before this one.
    before: usize,
    /// Iterations of the restoration phase that are left to the present program.
    restores: usize,
    pub(in crate::ocp) stopped: bool,
}

impl<'o> Watch<'o> {
    pub(in crate::ocp) fn new(observer: &'o mut Observer<'o>) -> Self {
        Self {
            observer,
            start: Instant::now(),
            progress: Progress::new("start"),
            before: 0,
            restores: usize::MAX,
            stopped: false,
        }
    }

    /// Says what the next iterations are for, and how many of them may restore feasibility.
    pub(in crate::ocp) fn begin(
        &mut self,
        step: &'static str,
        counts: &Counts,
        best: Option<f64>,
        restores: usize,
    ) {
        self.restores = restores;
        self.before = counts.global_iterations + counts.iterations;
        self.progress.step = step;
        self.progress.programs = counts.programs;
        self.progress.best = best;
    }

    /// Takes note of a motion that may be the best.
    pub(in crate::ocp) fn found(&mut self, motion: BestMotion) {
        self.progress.motion = BestMotion::better(self.progress.motion, Some(motion));
    }

    /// Reports work on something other than a program; `false` stops it.
    pub(in crate::ocp) fn goes_on(&mut self, step: &'static str) -> bool {
        self.progress.step = step;
        self.progress.seconds = self.start.elapsed().as_secs_f64();
        self.stopped |= !(self.observer)(&self.progress);
        !self.stopped
    }

    /// Reports an iteration of a program with the objective in that unit; `false` stops it, where the observer asks to or no more of them
    /// may restore feasibility.
    pub(in crate::ocp) fn iteration(&mut self, info: &IterationInfo, unit: f64) -> bool {
        self.progress.iterations = self.before + info.iteration;
        self.progress.objective = unit * info.objective;
        self.progress.residuals.primal = info.primal_infeasibility;
        self.progress.residuals.dual = info.dual_infeasibility;
        self.progress.residuals.complementarity = info.complementarity;
        self.progress.seconds = self.start.elapsed().as_secs_f64();
        self.stopped |= !(self.observer)(&self.progress);
        let left = self.restores.checked_sub(usize::from(info.restoration));
        self.restores = left.unwrap_or(0);
        !self.stopped && left.is_some()
    }
}
