//! Progress of long runs: a bar on a terminal, nothing otherwise.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::ending::Stop;
use crate::failure::one_line;

/// Runs shorter than this show no bar, and a bar is redrawn no more often.
const PATIENCE: Duration = Duration::from_millis(150);

/// A progress bar over a physical quantity.
pub(crate) struct Progress {
    bar: ProgressBar,
    next: Instant,
    end: f64,
}

impl Progress {
    /// A bar that runs from 0 to `end`; drawn on the standard error stream if that is a terminal.
    pub(crate) fn new(title: &str, end: f64) -> Self {
        /// Cells of the bar's own scale.
        const CELLS: u64 = 1000;
        let bar = ProgressBar::new(CELLS).with_message(one_line(title));
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {eta}") {
            bar.set_style(style);
        }
        Self {
            bar,
            next: Instant::now() + PATIENCE,
            end,
        }
    }

    /// Says what is being done.
    pub(crate) fn say(&self, what: &str) {
        self.bar.set_message(what.to_owned());
        self.bar.tick();
    }

    /// Moves the bar to `reached`.
    pub(crate) fn reach(&mut self, reached: f64) {
        let now = Instant::now();
        if now >= self.next {
            self.next = now + PATIENCE;
            let share = (reached / self.end).clamp(0.0, 1.0);
            let length = self.bar.length().unwrap_or_default() as f64;
            self.bar.set_position((share * length) as u64);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What a long solve is doing, in one line on the standard error stream if that is a terminal.
pub(crate) struct SolveProgress {
    bar: ProgressBar,
    next: Instant,
}

impl SolveProgress {
    /// A line that begins with `title`.
    pub(crate) fn new(title: &str) -> Self {
        let bar = ProgressBar::new_spinner().with_prefix(one_line(title));
        if let Ok(style) = ProgressStyle::with_template("{prefix} {spinner} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(PATIENCE);
        Self {
            bar,
            next: Instant::now(),
        }
    }

    /// Shows the progress; `false` once there is a reason to stop.
    pub(crate) fn report(&mut self, progress: &hangtime::Progress, stop: Option<Stop>) -> bool {
        let now = Instant::now();
        if stop.is_some() {
            self.bar.set_message("stopping");
            return false;
        }
        if now >= self.next {
            self.next = now + PATIENCE;
            self.bar.set_message(progress.to_string());
        }
        true
    }
}

impl SolveProgress {
    /// Shows an iteration of a program from a file.
    pub(crate) fn iteration(&mut self, info: &hangtime::nlp::IterationInfo) {
        let now = Instant::now();
        if now >= self.next {
            self.next = now + PATIENCE;
            self.bar.set_message(format!(
                "iteration {}, objective {:.7e}, residuals primal {:.0e} dual {:.0e} complementarity {:.0e}",
                info.iteration,
                info.objective,
                info.primal_infeasibility,
                info.dual_infeasibility,
                info.complementarity,
            ));
        }
    }
}

impl Drop for SolveProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
