//! One observer for runs side by side.

use std::sync::Mutex;

use crate::progress::BestMotion;
use crate::{Observer, Progress};

/// The caller's observer, and what it knows of all runs.
pub(super) struct SharedObserver<'a, 'o>(Mutex<Shared<'a, 'o>>);

struct Shared<'a, 'o> {
    observer: &'a mut Observer<'o>,
    stopped: bool,
    /// Iterations and programs of each run.
    runs: Vec<(usize, usize)>,
    /// The best objective of all runs, and the best motion.
    best: Option<f64>,
    motion: Option<BestMotion>,
}

impl<'a, 'o> SharedObserver<'a, 'o> {
    pub(super) fn new(observer: &'a mut Observer<'o>) -> Self {
        Self(Mutex::new(Shared {
            observer,
            stopped: false,
            runs: Vec::new(),
            best: None,
            motion: None,
        }))
    }

    /// The number of another run.
    pub(super) fn begin(&self) -> usize {
        let Ok(mut shared) = self.0.lock() else {
            return 0;
        };
        shared.runs.push((0, 0));
        shared.runs.len() - 1
    }

    /// Tells the observer of the progress of a run, with the work of all of them; `false` once it has asked to stop.
    pub(super) fn goes_on(&self, run: usize, progress: &Progress) -> bool {
        // A poisoned lock means that another run's observer panicked: stop.
        let Ok(mut shared) = self.0.lock() else {
            return false;
        };
        if shared.stopped {
            return false;
        }
        shared.runs[run] = (progress.iterations, progress.programs);
        shared.best = [shared.best, progress.best]
            .into_iter()
            .flatten()
            .reduce(f64::min);
        shared.motion = BestMotion::better(shared.motion, progress.motion);
        let mut all = *progress;
        all.iterations = shared.runs.iter().map(|run| run.0).sum();
        all.programs = shared.runs.iter().map(|run| run.1).sum();
        all.best = shared.best;
        all.motion = shared.motion;
        shared.stopped = !(shared.observer)(&all);
        !shared.stopped
    }

    /// Whether the observer has asked to stop.
    pub(super) fn stopped(&self) -> bool {
        self.0.lock().is_ok_and(|shared| shared.stopped)
    }
}
