//! What the solver tells whoever waits, and how it is stopped.

use std::time::Instant;

use super::solution::Counts;
use crate::nlp::IterationInfo;

/// What the solver is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Name of the step.
    pub step: &'static str,
    /// Programs solved so far.
    pub programs: usize,
    /// Interior point iterations so far, those of the program under way included.
    pub iterations: usize,
    /// Objective of the iterate; it may be infeasible.
    pub objective: f64,
    /// Scaled violation of the constraints of the iterate.
    pub primal_infeasibility: f64,
    /// Scaled gradient of the Lagrangian of the iterate.
    pub dual_infeasibility: f64,
    /// Largest complementarity of the iterate.
    pub complementarity: f64,
    /// Best objective of a motion with a consistent contact sequence so far.
    pub best: Option<f64>,
    /// Wall-clock time since the start \[s\].
    pub seconds: f64,
}

/// Sees the progress after every interior point iteration; `false` stops the solver, which then returns the best
/// motion found so far with the status [`Interrupted`](super::Status::Interrupted).
///
/// Solvers that run side by side share one observer, hence `Send`.
pub type Observer<'a> = dyn FnMut(&Progress) -> bool + Send + 'a;

/// The observer, and whether it has asked to stop.
pub(in crate::ocp) struct Watch<'o> {
    observer: &'o mut Observer<'o>,
    start: Instant,
    progress: Progress,
    /// Iterations of the programs before this one.
    before: usize,
    pub(in crate::ocp) stopped: bool,
}

impl<'o> Watch<'o> {
    pub(in crate::ocp) fn new(observer: &'o mut Observer<'o>) -> Self {
        Self {
            observer,
            start: Instant::now(),
            progress: Progress {
                step: "start",
                programs: 0,
                iterations: 0,
                objective: f64::NAN,
                primal_infeasibility: f64::NAN,
                dual_infeasibility: f64::NAN,
                complementarity: f64::NAN,
                best: None,
                seconds: 0.0,
            },
            before: 0,
            stopped: false,
        }
    }

    /// Says what the next iterations are for.
    pub(in crate::ocp) fn begin(&mut self, step: &'static str, counts: &Counts, best: Option<f64>) {
        self.before = counts.global_iterations + counts.iterations;
        self.progress.step = step;
        self.progress.programs = counts.programs;
        self.progress.best = best;
    }

    /// Reports an iteration of a program with the objective in that unit; `false` stops it.
    pub(in crate::ocp) fn iteration(&mut self, info: &IterationInfo, unit: f64) -> bool {
        self.progress.iterations = self.before + info.iteration;
        self.progress.objective = unit * info.objective;
        self.progress.primal_infeasibility = info.primal_infeasibility;
        self.progress.dual_infeasibility = info.dual_infeasibility;
        self.progress.complementarity = info.complementarity;
        self.progress.seconds = self.start.elapsed().as_secs_f64();
        self.stopped |= !(self.observer)(&self.progress);
        !self.stopped
    }
}
